// The map of photons: cells over the photons' bounds, and what estimates need of the radius. Local units.
struct MapFrame {
    float4 low;          // low corner of the cells; w: cells per local unit
    float4 scale;        // x, y: sums of weighted flux to flux per area, per volume; z: 1 / radius; w: radius^2
    uint nx;             // cells
    uint ny;
    uint nz;
    uint count;          // photons in the map
    uint stride;         // elements of each of the map's arrays of photons
    uint tabled;         // whether each cell has its range in the table; otherwise cells are searched for
    float radius;
    float margin;        // cells beyond the box in which places are told apart: 0 where photons may lie there
};

// What gathering knows of a surface of the scene.
#define RECEIVER_CURVED 0        // and closed: without edges
#define RECEIVER_PLANE 1         // origin: a point; u, v: orthonormal in the plane
#define RECEIVER_PARALLELOGRAM 2 // origin: a corner, w: length of the edge along u; u, v: orthonormal in the plane, v.w: the
                                 // other edge along v, u.w: along u
#define RECEIVER_DISK 3          // origin: centre, w: radius; u, v: orthonormal in the plane
#define RECEIVER_BOX 4           // origin: low corner; u: size
#define RECEIVER_MESH 5          // no edges are known, and triangles need not agree which side is outside
struct Receiver {
    float4 origin;
    float4 u;
    float4 v;
    uint kind;
    uint plane; // number among the flat ones, from 0; NO_PLANE
    float reach; // photons farther away do not count, whatever the radius: the surface is too curved
    uint pad_1;
};
#define NO_PLANE 0xffffffffu
