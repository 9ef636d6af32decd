// Surfaces, in local units: the shapes that rays meet, and what they are made of.

// What `kind` of a Shape says. Each holds what its test needs: `offset` is the distance of its plane from the origin
// along the normal.
#define SURFACE_PLANE 0      // b: unit normal, w: offset
#define SURFACE_SPHERE 1     // a: centre, w: radius; b: the point of it that is nearest to the scene, w: 1 / radius;
                             // c: unit normal there
#define SURFACE_RECTANGLE 2  // a: a corner; b, c: (point - a) . b and . c are 0..1 along the edges; d: unit normal
                             // along edge_u x edge_v, w: offset
#define SURFACE_DISK 3       // a: centre, w: radius; b: unit normal, w: offset
#define SURFACE_BOX 4        // a, b: low and high corner, axis-aligned
#define SURFACE_METABALLS 5  // a, b: low and high corner of its bounds; c.x: threshold; the field is above it inside
#define SURFACE_TRIANGLE 6   // a, b, c: the corners; d: unit normal along (b - a) x (c - a), w: offset

// A geometric primitive. The normal points outward: out of closed shapes.
struct Shape {
    float4 a;
    float4 b;
    float4 c;
    float4 d;
    uint kind;
    uint surface; // the surface of the scene it is part of
    uint first;   // metaballs: the first of its balls; triangle: the first of its three normals, NO_NORMALS without
    uint count;   // metaballs: number of balls
};
#define NO_NORMALS 0xffffffffu

// A ball of metaballs: adds weight (1 - s^2)^2 to the field, s = distance from the centre over the radius, s < 1.
struct Ball {
    float4 place; // centre, w: radius
    float weight;
    float slope; // 1 / radius^2
    uint pad_0;
    uint pad_1;
};

// A box of the hierarchy over the shapes with bounds.
struct Node {
    float4 low;  // w, as bits: the left child (the right one follows it), or the first shape of a leaf
    float4 high; // w, as bits: the number of shapes of a leaf, 0 for an inner node
};

#define MATERIAL_DIFFUSE 0
#define MATERIAL_MIRROR 1
#define MATERIAL_DIELECTRIC 2

struct Material {
    float4 color;      // diffuse: albedo; mirror: reflectance; per channel
    float4 absorption; // dielectric: per channel and local unit, inside
    float4 cauchy;     // dielectric: index x + y / l^2 + z / l^4 at the wavelength l in micrometres, relative to the
                       // surroundings; w: at 587.6 nm
    uint kind;
    uint pad_0;
    uint pad_1;
    uint pad_2;
};
