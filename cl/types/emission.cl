// How a light emits photons, in local units; fluxes are over the square of the local unit.

// What `way` of an Emitter says.
#define EMIT_POINT 0       // a point, through a target rectangle
#define EMIT_SPHERE 1      // a point, in all directions
#define EMIT_DIRECTIONAL 2 // parallel light, through a target
#define EMIT_RECTANGLE 3   // a rectangle, from anywhere on it through a target
#define EMIT_HEMISPHERE 4  // a rectangle, in all directions of its front

// What `role` of an Emitter says: which paths are its photons'. Those of the first end where they meet a diffuse surface,
// those of the others go on from there.
#define ROLE_CAUSTIC 0
#define ROLE_AFTER_CAUSTIC 1 // met mirrors or glass before they met a diffuse surface
#define ROLE_AFTER_DIRECT 2  // met a diffuse surface first

// The target of parallel light everywhere but near is so much wider than the one that is near, which is its middle.
#define FAR_ALONG 16.0f

// A light's share of the photons: one for each cell of a grid.
struct Emitter {
    float4 place;        // of a point, or of a rectangle's middle; parallel light: unit direction of travel, w: how far
                         // along it the scene begins
    float4 power;        // of each photon; EMIT_POINT: over the solid angle of its cell; EMIT_RECTANGLE: over cosines and
                         // the inverse square of the distance; w: not 0 if each photon has the same
    float4 corner;       // of the target; EMIT_POINT: relative to the point, along its edges and across them
    float4 edge_u;       // of the target; EMIT_POINT: unit length, w: how long it is
    float4 edge_v;       // the other edge, at a right angle
    float4 normal;       // of the target, unit length
    float4 light_u;      // rectangle: one of its edges
    float4 light_v;      // the other one
    float4 light_normal; // unit, of the side that shines
    uint way;
    uint first; // of its photons
    uint count; // photons, and cells
    uint rows;  // of cells, along edge_v; the first ones may have a column more than the others
    uint role;
    uint except; // 1: photons in all directions, but for those through the target; parallel light: but for its middle
    uint pad_0;
    uint pad_1;
};

// What all photons of a render share.
struct PhotonFrame {
    float4 white; // 1 / the mean of each channel over all wavelengths
    float4 guide; // a ball to which diffuse surfaces send half of the photons; w: its radius, 0 without one
    uint seed_low;
    uint seed_high;
    uint emitters;
    uint depth; // reflections and refractions, at most
    uint plane_count;
    uint node_count;
    uint bounces; // diffuse reflections, at most
    uint pad_0;
};
