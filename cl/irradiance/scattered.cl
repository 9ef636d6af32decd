// Scattered light on a light volume: each channel's diffusion equation, its flux, and the way to another grid.
#include "irradiance/between.cl"
#include "irradiance/limiter.cl"

// Transport coefficient of a channel in a cell.
INLINE float transport_of(__global const float *scattering, __global const float *absorption, uint from, float forward) {
    return absorption[from] + (1.0f - forward) * scattering[from];
}

// The share of a cell's source that belongs to its neighbour beyond one side: where light is scattered nearer to that
// side than the centre is, it gets there as through resistances to both centres (and, where nothing but the boundary is
// beyond, out). As it should be in one dimension, where fluences at centres are right then. `place`: of the source, towards
// the side, from -1 to 1; `here`, `there`: depth of half a cell, in units of the boundary's.
INLINE float share_beyond(float place, float here, float there) {
    return place > 0.0f && here > 0.0f ? place * here / (here + there) : 0.0f;
}

// How a cell's source goes to all sides: low and high per axis.
struct Shares {
    float beyond[6];
};

INLINE struct Shares shares_of(__constant struct LightGrid *grid, __constant Limits *limits,
    __global const float *scattering, __global const float *absorption, __global const float4 *places, float forward,
    uint channel, uint index) {
    int4 cell = cell_of(grid, index);
    float4 place = places[index];
    float least = 1.0f / (3.0f * limits->w);
    float own = max(transport_of(scattering, absorption, 4u * index + channel, forward), least);
    struct Shares shares;
    float sum = 0.0f;
    uint stride = 1u;
    for (int side = 0; side < 6; ++side) {
        int axis = side / 2;
        bool high = side & 1;
        int at = axis_of_cell(cell, axis);
        int count = axis_of_cell(grid->dims, axis);
        float depth = 1.5f * axis_of(grid->cell, axis);
        float there = axis_of(*limits, axis);
        if (high ? at + 1 < count : at > 0) {
            uint next = high ? index + stride : index - stride;
            there = depth * max(transport_of(scattering, absorption, 4u * next + channel, forward), least);
        }
        float towards = axis_of(place, axis);
        shares.beyond[side] = there < 0.0f ? 0.0f : share_beyond(high ? towards : -towards, depth * own, there);
        sum += shares.beyond[side];
        stride *= high ? (uint)count : 1u;
    }
    // No more than all: sources in the corners of cells would go three ways.
    for (int side = 0; side < 6; ++side) {
        shares.beyond[side] /= max(sum, 1.0f);
    }
    return shares;
}

// The source of a cell once sources are where they belong: less what goes beyond its sides, and what comes from beyond.
INLINE float placed_source(__constant struct LightGrid *grid, __constant Limits *limits,
    __global const float *scattering, __global const float *absorption, __global const float *source,
    __global const float4 *places, float forward, uint channel, uint index) {
    int4 cell = cell_of(grid, index);
    struct Shares own = shares_of(grid, limits, scattering, absorption, places, forward, channel, index);
    float kept = 1.0f;
    float come = 0.0f;
    uint stride = 1u;
    for (int side = 0; side < 6; ++side) {
        bool high = side & 1;
        int at = axis_of_cell(cell, side / 2);
        int count = axis_of_cell(grid->dims, side / 2);
        kept -= own.beyond[side];
        if (high ? at + 1 < count : at > 0) {
            uint next = high ? index + stride : index - stride;
            struct Shares theirs =
                shares_of(grid, limits, scattering, absorption, places, forward, channel, next);
            come += theirs.beyond[side ^ 1] * source[4u * next + channel];
        }
        stride *= high ? (uint)count : 1u;
    }
    return max(kept, 0.0f) * source[4u * index + channel] + come;
}

// The equation of one channel. `spread`: whether `places` tells where in its cell a source is. `forward`: g of the phase function; transport: sigma_a + (1 - g) sigma_s; `most`: largest
// diffusivity to begin with, may be infinite; `scale`: of the source, so that squares of light are float32 numbers whatever
// its unit.
__kernel void irradiance_channel(__constant struct LightGrid *grid, __global const float *scattering,
    __global const float *absorption, __global const float *source, __global const float4 *places,
    __constant Limits *limits, __global float *absorbed,
    __global float *transport, __global float *diffusivity, __global float *power, float forward, float most,
    float scale, uint channel, uint spread) {
    uint index = (uint)get_global_id(0);
    if (index >= cell_count(grid)) {
        return;
    }
    uint from = 4u * index + channel;
    float sigma = transport_of(scattering, absorption, from, forward);
    absorbed[index] = absorption[from];
    transport[index] = sigma;
    diffusivity[index] = min(1.0f / (3.0f * sigma), most);
    float own = source[from];
    if (spread != 0u) {
        own = placed_source(grid, limits, scattering, absorption, source, places, forward, channel, index);
    }
    power[index] = own * scale;
}

// A channel's fluence into a box with a border of one cell: there stands what makes a straight line through the cell's
// centre meet the boundary with the fluence that it has. Written to `copies` channels from `channel` on, times `scale`.
__kernel void irradiance_border(__constant struct LightGrid *grid, __constant Limits *limits,
    __global const float *phi, __global const float *diffusivity, __global float *bordered, float scale,
    uint channel, uint copies) {
    int4 place = (int4)((int)get_global_id(0), (int)get_global_id(1), (int)get_global_id(2), 0);
    int4 dims = grid->dims;
    if (place.x >= dims.x + 2 || place.y >= dims.y + 2 || place.z >= dims.z + 2) {
        return;
    }
    int4 cell = clamp(place - 1, (int4)(0), dims - 1);
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
        bordered[4 * out + c] = value * scale;
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
    return (convert_float4(cell) + 0.5f) * (convert_float4(other->dims) / convert_float4(max(grid->dims, (int4)(1))));
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
    int4 last = max(grid->dims - 1, (int4)(0));
    float4 position = clamp(place_in(grid, fine, cell_of(fine, index)) - 0.5f, (float4)(0.0f), convert_float4(last));
    int4 low = convert_int4(position);
    float4 diffuse = between_cells(flux, grid->dims, low, min(low + 1, last), position - convert_float4(low));
    float4 more = reduced[index] - direct[index];
    float ahead = (more.x + more.y + more.z) * (1.0f / 3.0f);
    float4 scattered = fluence[index];
    float total = (scattered.x + scattered.y + scattered.z) * (1.0f / 3.0f) + ahead;
    float4 sum = ahead * flow[index] + diffuse;
    float size = flux_length(sum);
    sum = size > 0.0f && total > 0.0f ? sum / max(total, size) : (float4)(0.0f);
    sum.w = 0.0f;
    drift[index] = sum;
}
