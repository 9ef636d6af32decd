// The parameters of each method.
struct EmissionAbsorption {
    float step;              // step size, local units
    float min_transmittance; // rays stop below it; 0 = never
    float max_depth;         // the same as an optical depth; infinite = never
    float radiance;          // L0: the transfer function's colours times this
    float empty_value;       // values (in entries of the table) below this one have no extinction; may be infinite
    uint pad_0;
    uint pad_1;
    uint pad_2;
};

struct Isosurface {
    float4 albedo;
    float iso;             // raw value of the surface
    float ambient;
    float diffuse;
    float specular;
    float shininess;
    uint pad_0;
    uint pad_1;
    uint pad_2;
};

struct Mip {
    float4 color;          // factor of the displayed value
    uint table_size;       // entries of the colour map, 0 = grey
    uint pad_0;
    uint pad_1;
    uint pad_2;
};
