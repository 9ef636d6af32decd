// The parameters of each method.

// Emission-absorption, and the projection of light volumes.
struct EmissionAbsorption {
    float4 extinction;       // extinction per channel relative to sigma_t (CHROMATIC), largest 1; w = 0
    float4 phase;            // mean cosines of the lobes, share of the first one, mean cosine of all (DIRECTED)
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
