// The vector flux of diffuse light, and diffusivities that keep it below the fluence.
#include "irradiance/grid.cl"

// What limits the equation.
// xyz: 2 A of the sides across each axis, negative at mirrors; w: largest diffusivity.
typedef float4 Limits;

INLINE float axis_of(float4 v, int axis) {
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

INLINE int axis_of_cell(int4 v, int axis) {
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

// Flux outward through one side of a cell. `last`: nothing but the boundary is beyond.
INLINE float outward(__global const float *phi, __global const float *diffusivity, uint here, uint there, bool last,
    float size, float outside, float limit) {
    float d = min(diffusivity[here], limit);
    if (last) {
        return outside < 0.0f ? 0.0f : phi[here] / (outside + 0.5f * size / d);
    }
    float other = min(diffusivity[there], limit);
    return 2.0f * d * other / (d + other) * (phi[here] - phi[there]) / size;
}

// The vector flux of each cell, mean of those through its two sides per axis; w: the length of their root mean squares,
// which does not vanish where light flows apart.
__kernel void irradiance_flux(__constant struct LightGrid *grid, __constant Limits *limits,
    __global const float *phi, __global const float *diffusivity, __global float4 *flux) {
    uint index = (uint)get_global_id(0);
    if (index >= cell_count(grid)) {
        return;
    }
    int4 cell = cell_of(grid, index);
    float limit = limits->w;
    uint stride = 1u;
    float mean[3];
    float sides[6];
    float largest = 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
        int at = axis_of_cell(cell, axis);
        int count = axis_of_cell(grid->dims, axis);
        float size = axis_of(grid->cell, axis);
        float outside = axis_of(*limits, axis);
        float low = outward(phi, diffusivity, index, index - stride, at == 0, size, outside, limit);
        float high = outward(phi, diffusivity, index, index + stride, at + 1 == count, size, outside, limit);
        mean[axis] = 0.5f * (high - low);
        sides[2 * axis] = low;
        sides[2 * axis + 1] = high;
        largest = max(largest, max(fabs(low), fabs(high)));
        stride *= (uint)count;
    }
    // Relative to the largest: squares of faint or bright light are no float32 numbers.
    float squares = 0.0f;
    float scale = largest > 0.0f ? 1.0f / largest : 0.0f;
    for (int side = 0; side < 6; ++side) {
        float part = sides[side] * scale;
        squares += 0.5f * part * part;
    }
    flux[index] = (float4)(mean[0], mean[1], mean[2], largest * sqrt(squares));
}

#define LIMITER_SUM 1u
#define LIMITER_MAX 2u
#define LIMITER_KERSHAW 3u
#define LIMITER_LEVERMORE_POMRANING 4u
#define LIMITER_RATIONAL 5u

// lambda(R) of a flux limiter, R = |grad phi| / (sigma_tr phi): 1/3 at 0, 1/R beyond.
INLINE float limiter_at(uint limiter, float r) {
    switch (limiter) {
    case LIMITER_SUM:
        return 1.0f / (3.0f + r);
    case LIMITER_MAX:
        return 1.0f / max(3.0f, r);
    case LIMITER_KERSHAW:
        return 2.0f / (3.0f + sqrt(9.0f + 4.0f * r * r));
    case LIMITER_RATIONAL:
        return (2.0f + r) / (6.0f + 3.0f * r + r * r);
    default: {
        // (coth R - 1 / R) / R; the series below 0.3 is right to 2e-7.
        float e = exp(-2.0f * r);
        float square = r * r;
        return r < 0.3f ? 1.0f / 3.0f - square * (1.0f / 45.0f) + square * square * (2.0f / 945.0f)
                        : ((1.0f + e) / (1.0f - e) - 1.0f / r) / r;
    }
    }
}

// What Anderson's iteration keeps, one field after the other: MIXED differences of the logarithms of diffusivities, as
// many of the steps that the limiter wants from them, and the last of both.
#define MIXED 3
#define PLACES(j, count) ((size_t)(j) * (count))
#define STEPS(j, count) ((size_t)(MIXED + (j)) * (count))
#define LAST_PLACE(count) ((size_t)(2 * MIXED) * (count))
#define LAST_STEP(count) ((size_t)(2 * MIXED + 1) * (count))

// Where each cell's diffusivity is and the step to lambda(R) / sigma_tr, where R is that of phi. The gradient inside a
// cell is its flux over its diffusivity, so once nothing moves any more no flux is beyond phi. `faint`: fluence below
// which the limiter lets go; `least`: the floor of sigma_tr; `slot`: where the differences to the last call go, none if
// negative.
__kernel void irradiance_limit(__global const float *phi, __global const float4 *flux, __global const float *transport,
    __global const float *diffusivity, __global float *memory, __constant Limits *limits, float least, float faint,
    uint limiter, int slot, uint count) {
    uint index = (uint)get_global_id(0);
    if (index >= count) {
        return;
    }
    float sigma = max(transport[index], least);
    float d = min(diffusivity[index], limits->w);
    float r = min(flux[index].w / d / (sigma * (phi[index] + faint)), 1e18f);
    float place = log(d);
    float step = log(limiter_at(limiter, r) / sigma) - place;
    __global float *cell = memory + index;
    if (slot >= 0) {
        cell[PLACES(slot, count)] = place - cell[LAST_PLACE(count)];
        cell[STEPS(slot, count)] = step - cell[LAST_STEP(count)];
    }
    cell[LAST_PLACE(count)] = place;
    cell[LAST_STEP(count)] = step;
}

// Each work-item's share of the products of the first `kept` differences of steps with the last step, then among each
// other.
__kernel void irradiance_products(__global const float *memory, __global float *shares, uint kept, uint count,
    uint items) {
    uint item = (uint)get_global_id(0);
    if (item >= items) {
        return;
    }
    float sums[MIXED * (MIXED + 1)];
    for (int k = 0; k < MIXED * (MIXED + 1); ++k) {
        sums[k] = 0.0f;
    }
    for (uint i = item; i < count; i += items) {
        float steps[MIXED + 1];
        steps[MIXED] = memory[LAST_STEP(count) + i];
        for (uint j = 0; j < MIXED; ++j) {
            steps[j] = j < kept ? memory[STEPS(j, count) + i] : 0.0f;
        }
        for (int j = 0; j < MIXED; ++j) {
            for (int k = 0; k <= MIXED; ++k) {
                sums[j * (MIXED + 1) + k] += steps[j] * steps[k];
            }
        }
    }
    for (int k = 0; k < MIXED * (MIXED + 1); ++k) {
        shares[(uint)k * items + item] = sums[k];
    }
}

// Diffusivities go one step on, less the combination of differences that leaves the least step, and at most a factor
// of e^3.
__kernel void irradiance_mix(__global const float *memory, __global float *diffusivity, __constant Limits *limits,
    float part_0, float part_1, float part_2, uint count) {
    uint index = (uint)get_global_id(0);
    if (index >= count) {
        return;
    }
    __global const float *cell = memory + index;
    float parts[MIXED] = {part_0, part_1, part_2};
    float step = cell[LAST_STEP(count)];
    for (int j = 0; j < MIXED; ++j) {
        // What is not kept yet is not a number.
        step -= parts[j] == 0.0f ? 0.0f : parts[j] * (cell[PLACES(j, count)] + cell[STEPS(j, count)]);
    }
    diffusivity[index] = min(exp(cell[LAST_PLACE(count)] + clamp(step, -3.0f, 3.0f)), limits->w);
}

// The length of a flux, whatever its unit.
INLINE float flux_length(float4 f) {
    float largest = max(max(fabs(f.x), fabs(f.y)), fabs(f.z));
    if (largest == 0.0f) {
        return 0.0f;
    }
    float4 relative = f / largest;
    relative.w = 0.0f;
    return largest * sqrt(dot(relative, relative));
}

// Fluxes beyond the fluence, of which the limiter's updates leave some, are cut to it.
__kernel void irradiance_cut(__global const float *phi, __global float4 *flux, uint count) {
    uint index = (uint)get_global_id(0);
    if (index >= count) {
        return;
    }
    float4 f = flux[index];
    float length = flux_length(f);
    float most = phi[index];
    // A little less, so that what is rounded is not beyond it.
    flux[index] = length > most ? f * (most / length * (1.0f - 4e-7f)) : f;
}

// Each work-item's share: the sum of phi, the largest flux (the mean through opposite sides) over phi, and how many cells
// are below the floor of sigma_tr.
__kernel void irradiance_measure(__global const float *phi, __global const float4 *flux,
    __global const float *transport, __global float *shares, float faint, float least, uint count, uint items) {
    uint item = (uint)get_global_id(0);
    if (item >= items) {
        return;
    }
    float sum = 0.0f;
    float largest = 0.0f;
    uint below = 0u;
    for (uint i = item; i < count; i += items) {
        float4 f = flux[i];
        float fluence = phi[i] + faint;
        sum += phi[i];
        largest = fluence > 0.0f ? max(largest, flux_length(f) / fluence) : largest;
        below += transport[i] < least;
    }
    shares[item] = sum;
    shares[items + item] = largest;
    shares[2u * items + item] = (float)below;
}
