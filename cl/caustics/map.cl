// Photons as they were stored -> photons in the order of the map. Of the slots, those from `from` on: the map's numbers
// begin there.
#include "caustics/cells.cl"

// Each work-item's share of the photons: their bounds in the space of the cells; as bits in w: how many photons, and with
// MAP_PLANAR how many of them lie on a surface that is not flat.
__kernel void map_bounds(__global const struct Photon *photons, __global const struct Receiver *receivers,
    __global float4 *low_corners, __global float4 *high_corners, uint from, uint count, uint share, uint items) {
    uint item = (uint)get_global_id(0);
    if (item >= items) return;
    float3 low = (float3)(INFINITY);
    float3 high = (float3)(-INFINITY);
    uint stored = 0u;
    uint stray = 0u;
    uint first = item * share;
    uint end = min(first + share, count);
    for (uint i = first; i < end; ++i) {
        struct Photon photon = photons[from + i];
        if (!is_stored(photon)) continue;
        uint surface = marked_surface(as_uint(photon.flux.w));
#ifdef MAP_PLANAR
        if (receivers[surface].plane == NO_PLANE) {
            ++stray;
            continue;
        }
#endif
        ++stored;
        float3 place = cell_space(receivers, photon.position.xyz, surface);
        low = min(low, place);
        high = max(high, place);
    }
    low_corners[item] = (float4)(low, as_float(stored));
    high_corners[item] = (float4)(high, as_float(stray));
}

// What to sort by: cells; with MAP_LEXICOGRAPHIC x alone, for that is all that is searched for.
__kernel void map_keys(__global const struct Photon *photons, __global const struct Receiver *receivers,
    __global const struct MapFrame *map_frame, __global uint *keys, uint from, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    struct Photon photon = photons[from + i];
    uint key = NO_PHOTON;
    if (is_stored(photon)) {
#ifdef MAP_LEXICOGRAPHIC
        key = ordered_bits(photon.position.x);
#else
        struct MapFrame frame = map_frame[0];
        int3 last = (int3)((int)frame.nx, (int)frame.ny, (int)frame.nz) - 1;
        int3 cell = cell_of(frame, receivers, photon.position.xyz, marked_surface(as_uint(photon.flux.w)));
        cell = clamp(cell, (int3)(0), last);
        key = cell_key(frame, cell.x, cell.y, cell.z);
#endif
    }
    keys[i] = key;
}

// The photons in order, one array for each of: x, y, z, red, green, blue, direction, mark.
INLINE void put_photon(__global float *ordered, uint stride, uint i, struct Photon photon) {
    ordered[i] = photon.position.x;
    ordered[stride + i] = photon.position.y;
    ordered[2u * stride + i] = photon.position.z;
    ordered[3u * stride + i] = photon.flux.x;
    ordered[4u * stride + i] = photon.flux.y;
    ordered[5u * stride + i] = photon.flux.z;
    ordered[6u * stride + i] = photon.position.w;
    ordered[7u * stride + i] = photon.flux.w;
}

__kernel void map_order(__global const struct Photon *photons, __global const uint *order, __global float *ordered,
    uint stride, uint from, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    put_photon(ordered, stride, i, photons[from + order[i]]);
}

// As map_order in the order in which they are stored. What holds nothing stays in place, as no surface's.
__kernel void map_copy(__global const struct Photon *photons, __global float *ordered, uint stride, uint from, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    struct Photon photon = photons[from + i];
    if (!is_stored(photon)) {
        photon.position = (float4)(0.0f);
        photon.flux = (float4)(0.0f);
    }
    put_photon(ordered, stride, i, photon);
}
