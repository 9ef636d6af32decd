// Where photons and points lie among the cells of the map. One function for both, so that points find what was sorted
// in: the cells are wider than the radius by more than the rounding of this (see src/caustics/map_cells.rs).
#include "caustics/marks.cl"
#include "common/inline.cl"
#include "types/photon.cl"
#include "types/photon_map.cl"

// Key of what is not in the map: behind all others.
#define NO_PHOTON 0xffffffffu

// Whether a slot holds a photon, at a place that can be sorted.
INLINE bool is_stored(struct Photon photon) {
    return as_uint(photon.flux.w) != 0u
        && (as_uint(photon.position.x) & 0x7f800000u) != 0x7f800000u
        && (as_uint(photon.position.y) & 0x7f800000u) != 0x7f800000u
        && (as_uint(photon.position.z) & 0x7f800000u) != 0x7f800000u;
}

// A place in the space of the cells: in local units, or with MAP_PLANAR the place in the surface's plane.
INLINE float3 cell_space(__global const struct Receiver *receivers, float3 position, uint surface) {
#ifdef MAP_PLANAR
    __global const struct Receiver *receiver = receivers + surface;
    float3 offset = position - receiver->origin.xyz;
    return (float3)(dot(offset, receiver->u.xyz), dot(offset, receiver->v.xyz), 0.0f);
#else
    return position;
#endif
}

// Numbers of the cell of a place, which may lie outside: then as many as `margin` beyond the cells. With MAP_PLANAR z is the
// number of the plane.
INLINE int3 cell_of(struct MapFrame frame, __global const struct Receiver *receivers, float3 position, uint surface) {
    float3 place = cell_space(receivers, position, surface);
    float scale = frame.low.w;
    float x = clamp((place.x - frame.low.x) * scale, -frame.margin, (float)frame.nx - 1.0f + frame.margin);
    float y = clamp((place.y - frame.low.y) * scale, -frame.margin, (float)frame.ny - 1.0f + frame.margin);
#ifdef MAP_PLANAR
    return (int3)((int)floor(x), (int)floor(y), (int)receivers[surface].plane);
#else
    float z = clamp((place.z - frame.low.z) * scale, -frame.margin, (float)frame.nz - 1.0f + frame.margin);
    return (int3)((int)floor(x), (int)floor(y), (int)floor(z));
#endif
}

INLINE uint cell_key(struct MapFrame frame, int x, int y, int z) {
    return ((uint)z * frame.ny + (uint)y) * frame.nx + (uint)x;
}

// Unsigned numbers in the order of the floats.
INLINE uint ordered_bits(float x) {
    uint bits = as_uint(x);
    return bits ^ ((bits & 0x80000000u) != 0u ? 0xffffffffu : 0x80000000u);
}
