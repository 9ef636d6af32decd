// Scattered light by explicit diffusion (Zhang & Ma 2013, equation 9): each step, light flows between cells that are
// neighbours, in proportion to the difference of all light, direct and scattered.
//
// Boxes of float4 (rgb) with padding. Outside is dark: what would flow there is lost.
#include "irradiance/padded.cl"

// Each work-item's share of the largest extinction.
__kernel void spreading_largest(__global float *shares, __global const float4 *scattering,
    __global const float4 *absorption, uint count, uint items) {
    uint item = (uint)get_global_id(0);
    if (item >= items) return;
    float largest = 0.0f;
    for (uint i = item; i < count; i += items) {
        float4 sigma = scattering[i] + absorption[i];
        largest = max(largest, max(max(sigma.x, sigma.y), sigma.z));
    }
    shares[item] = largest;
}

// How readily light flows from a cell: `scale` times its scattering. The padding is as the cells next to it.
__kernel void spreading_weigh(__global float4 *weights, __global const float4 *scattering,
    __constant struct LightGrid *grid, float scale) {
    FIND_PADDED_CELL
    int near_x = clamp(x, 0, grid->dims.x - 1);
    int near_y = clamp(y, 0, grid->dims.y - 1);
    int near_z = clamp(z, 0, grid->dims.z - 1);
    weights[padded_at(grid, x, y, z)] = scale * scattering[plain_at(grid, near_x, near_y, near_z)];
}

// All light: direct and scattered. Where direct light has become less than what was taken from it, none.
__kernel void spreading_join(__global float4 *light, __global const float4 *direct, __global const float4 *scattered,
    __constant struct LightGrid *grid) {
    FIND_LIGHT_CELL
    long i = plain_at(grid, x, y, z);
    float4 sum = max(direct[i] + scattered[i], 0.0f);
    sum.w = 0.0f;
    light[padded_at(grid, x, y, z)] = sum;
}

// What of all light is not direct.
__kernel void spreading_part(__global float4 *scattered, __global const float4 *light, __global const float4 *direct,
    __constant struct LightGrid *grid) {
    FIND_LIGHT_CELL
    long i = plain_at(grid, x, y, z);
    float4 rest = light[padded_at(grid, x, y, z)] - direct[i];
    rest.w = 0.0f;
    scattered[i] = rest;
}

// What a neighbour brings.
#define FROM(distance) (weights[i + (distance)] * (now[i + (distance)] - here))

// A step: along_*: weight of an axis. At the largest weights, rounding could leave a little less than nothing.
__kernel void spreading_step(__global float4 *restrict next, __global const float4 *restrict now,
    __global const float4 *restrict weights, __constant struct LightGrid *grid, float along_x, float along_y, float along_z) {
    FIND_LIGHT_CELL
    long i = padded_at(grid, x, y, z);
    long row = padded_row(grid);
    long slice = padded_slice(grid);
    float4 here = now[i];
    next[i] = max(here + along_x * (FROM(1) + FROM(-1)) + along_y * (FROM(row) + FROM(-row))
            + along_z * (FROM(slice) + FROM(-slice)),
        0.0f);
}
