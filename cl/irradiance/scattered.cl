// Scattered light on a light volume: each channel's diffusion equation, its flux, and the way to another grid.
#include "irradiance/between.cl"

// The equation of one channel. `forward`: g of the phase function; transport: sigma_a + (1 - g) sigma_s.
__kernel void irradiance_channel(__constant struct LightGrid *grid, __global const float *scattering,
    __global const float *absorption, __global const float *source, __global float *absorbed,
    __global float *transport, __global float *diffusivity, __global float *power, float forward, uint channel) {
    uint index = (uint)get_global_id(0);
    if (index >= cell_count(grid)) {
        return;
    }
    uint from = 4u * index + channel;
    float sigma = absorption[from] + (1.0f - forward) * scattering[from];
    absorbed[index] = absorption[from];
    transport[index] = sigma;
    diffusivity[index] = 1.0f / (3.0f * sigma);
    power[index] = source[from];
}

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
    float squares = 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
        int at = axis_of_cell(cell, axis);
        int count = axis_of_cell(grid->dims, axis);
        float size = axis_of(grid->cell, axis);
        float outside = axis_of(*limits, axis);
        float low = outward(phi, diffusivity, index, index - stride, at == 0, size, outside, limit);
        float high = outward(phi, diffusivity, index, index + stride, at + 1 == count, size, outside, limit);
        mean[axis] = 0.5f * (high - low);
        squares += 0.5f * (high * high + low * low);
        stride *= (uint)count;
    }
    flux[index] = (float4)(mean[0], mean[1], mean[2], sqrt(squares));
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

// Moves each cell's diffusivity towards lambda(R) / sigma_tr, where R is that of phi. The gradient inside a cell is its
// flux over its diffusivity, so once nothing moves any more no flux is beyond phi. `faint`: fluence below which the
// limiter lets go; `least`: the floor of sigma_tr; `relaxation`: share of the way, of the logarithm.
__kernel void irradiance_limit(__global const float *phi, __global const float4 *flux, __global const float *transport,
    __global float *diffusivity, __constant Limits *limits, float least, float faint, float relaxation, uint limiter,
    uint count) {
    uint index = (uint)get_global_id(0);
    if (index >= count) {
        return;
    }
    float sigma = max(transport[index], least);
    float d = min(diffusivity[index], limits->w);
    float r = min(flux[index].w / d / (sigma * (phi[index] + faint)), 1e18f);
    float wanted = limiter_at(limiter, r) / sigma;
    diffusivity[index] = d * exp(relaxation * log(wanted / d));
}

// Each work-item's share: the sum of phi, and the largest flux (the mean through opposite sides) over phi.
__kernel void irradiance_measure(__global const float *phi, __global const float4 *flux, __global float *shares,
    float faint, uint count, uint items) {
    uint item = (uint)get_global_id(0);
    if (item >= items) {
        return;
    }
    float sum = 0.0f;
    float largest = 0.0f;
    for (uint i = item; i < count; i += items) {
        float4 f = flux[i];
        sum += phi[i];
        largest = max(largest, sqrt(f.x * f.x + f.y * f.y + f.z * f.z) / (phi[i] + faint));
    }
    shares[item] = sum;
    shares[items + item] = largest;
}

// A channel's fluence into a box with a border of one cell: there stands what makes a straight line through the cell's
// centre meet the boundary with the fluence that it has. Written to `copies` channels from `channel` on.
__kernel void irradiance_border(__constant struct LightGrid *grid, __constant Limits *limits,
    __global const float *phi, __global const float *diffusivity, __global float *bordered, uint channel,
    uint copies) {
    int4 place = (int4)((int)get_global_id(0), (int)get_global_id(1), (int)get_global_id(2), 0);
    int4 dims = grid->dims;
    if (place.x >= dims.x + 2 || place.y >= dims.y + 2 || place.z >= dims.z + 2) {
        return;
    }
    int4 cell = min(max(place - 1, 0), dims - 1);
    uint index = (uint)cell.x + (uint)dims.x * ((uint)cell.y + (uint)dims.y * (uint)cell.z);
    float half_depth = 0.5f / min(diffusivity[index], limits->w);
    float value = phi[index];
    for (int axis = 0; axis < 3; ++axis) {
        float outside = axis_of(*limits, axis);
        int at = axis_of_cell(place, axis);
        if ((at == 0 || at > axis_of_cell(dims, axis)) && outside >= 0.0f) {
            value *= 2.0f * outside / (outside + half_depth * axis_of(grid->cell, axis)) - 1.0f;
        }
    }
    size_t out = (size_t)place.x + (size_t)(dims.x + 2) * ((size_t)place.y + (size_t)(dims.y + 2) * (size_t)place.z);
    for (uint c = channel; c < channel + copies; ++c) {
        bordered[4 * out + c] = value;
    }
}

// total += share * flux.
__kernel void irradiance_add_flux(__global const float4 *flux, __global float4 *total, float share, uint count) {
    uint index = (uint)get_global_id(0);
    if (index >= count) {
        return;
    }
    total[index] += share * flux[index];
}

// The centre of a cell of one grid in cells of another over the same box, from 0 at the low boundary.
INLINE float4 place_in(__constant struct LightGrid *other, __constant struct LightGrid *grid, int4 cell) {
    return (convert_float4(cell) + 0.5f) * (convert_float4(other->dims) / convert_float4(max(grid->dims, 1)));
}

// The bordered fluence at the centres of another grid's cells.
__kernel void irradiance_prolong(__constant struct LightGrid *grid, __constant struct LightGrid *fine,
    __global const float4 *bordered, __global float4 *fluence) {
    uint index = (uint)get_global_id(0);
    if (index >= cell_count(fine)) {
        return;
    }
    float4 position = place_in(grid, fine, cell_of(fine, index)) + 0.5f;
    int4 low = min(convert_int4(position), grid->dims);
    float4 f = position - convert_float4(low);
    float4 value = between_cells(bordered, grid->dims + 2, low, low + 1, f);
    fluence[index] = max(value, 0.0f);
}

// What is not scattered once: the difference that narrowing forward scattering makes to direct light, along its flow,
// and diffuse light: flux over fluence of the channels' mean, at most 1 long.
__kernel void irradiance_drift(__constant struct LightGrid *grid, __constant struct LightGrid *fine,
    __global const float4 *flux, __global const float4 *fluence, __global const float4 *direct,
    __global const float4 *reduced, __global const float4 *flow, __global float4 *drift) {
    uint index = (uint)get_global_id(0);
    if (index >= cell_count(fine)) {
        return;
    }
    int4 last = max(grid->dims - 1, 0);
    float4 position = clamp(place_in(grid, fine, cell_of(fine, index)) - 0.5f, (float4)(0.0f), convert_float4(last));
    int4 low = convert_int4(position);
    float4 diffuse = between_cells(flux, grid->dims, low, min(low + 1, last), position - convert_float4(low));
    float4 more = reduced[index] - direct[index];
    float ahead = (more.x + more.y + more.z) * (1.0f / 3.0f);
    float4 scattered = fluence[index];
    float total = (scattered.x + scattered.y + scattered.z) * (1.0f / 3.0f) + ahead;
    float4 sum = ahead * flow[index] + diffuse;
    float size = sqrt(sum.x * sum.x + sum.y * sum.y + sum.z * sum.z);
    sum = size > 0.0f && total > 0.0f ? sum / max(total, size) : (float4)(0.0f);
    sum.w = 0.0f;
    drift[index] = sum;
}
