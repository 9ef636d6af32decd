// Scattered light on a light volume: each channel's diffusion equation, its flux, and the way to another grid.
#include "irradiance/between.cl"
#include "irradiance/limiter.cl"

// The equation of one channel. `forward`: g of the phase function; transport: sigma_a + (1 - g) sigma_s; `most`: largest
// diffusivity to begin with, may be infinite.
__kernel void irradiance_channel(__constant struct LightGrid *grid, __global const float *scattering,
    __global const float *absorption, __global const float *source, __global float *absorbed,
    __global float *transport, __global float *diffusivity, __global float *power, float forward, float most,
    uint channel) {
    uint index = (uint)get_global_id(0);
    if (index >= cell_count(grid)) {
        return;
    }
    uint from = 4u * index + channel;
    float sigma = absorption[from] + (1.0f - forward) * scattering[from];
    absorbed[index] = absorption[from];
    transport[index] = sigma;
    diffusivity[index] = min(1.0f / (3.0f * sigma), most);
    power[index] = source[from];
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
