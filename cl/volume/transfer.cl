// The transfer function as a table over the window value (and the gradient magnitude, TF_2D).
//
// An entry holds a colour and sigma_t per local unit, each linear between entries. A look-up gives
// (sigma_t r, sigma_t g, sigma_t b, sigma_t): emission and extinction of the emission-absorption model.
// TRANSMITTANCE_ONLY: the colours are all black, so an entry is sigma_t alone. LIT: the colours are albedos (relative to
// sigma_t, per channel), so a look-up gives sigma_s; with EMISSION, sigma_a L_e comes after it.
//
// With a table, `value_scale` makes window values count entries (0 to size - 1): one rounding less, and values that
// fall on an entry, as whole numbers often do, fall on it exactly.
#include "types/frame.cl"
#include "volume/sampling.cl"

#if defined(TRANSMITTANCE_ONLY)
typedef float Medium;
#elif defined(LIT) && defined(EMISSION)
typedef float8 Medium; // and what glows: sigma_a L_e
#else
typedef float4 Medium;
#endif

// A value as a place in the table: whole part in *index (at most size - 2), fraction returned.
INLINE float table_position(float value, uint size, int *index) {
    float x = clamp(value, 0.0f, (float)(size - 1));
    *index = min((int)x, (int)size - 2);
    return x - (float)*index;
}

// Between two entries, still colour and sigma_t.
INLINE Medium table_row(__global const Medium *row, int index, float fraction) {
    return row[index] + fraction * (row[index + 1] - row[index]);
}

INLINE Medium emission_and_extinction(Medium m) {
#if defined(LIT) && defined(EMISSION)
    m.s012 *= m.s3;
#elif !defined(TRANSMITTANCE_ONLY)
    m.xyz *= m.w;
#endif
    return m;
}

#ifdef TF_2D
// The stored value at a point in grid coordinates, and its gradient per local unit.
INLINE float value_and_gradient(__constant struct Volume *volume, __global const VOXEL *voxels, float4 point,
    float4 *gradient) {
#ifdef LANES
    float8 x = point.x + (float8)(0.0f, 1.0f, -1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f);
    float8 y = point.y + (float8)(0.0f, 0.0f, 0.0f, 1.0f, -1.0f, 0.0f, 0.0f, 0.0f);
    float8 z = point.z + (float8)(0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, -1.0f, 0.0f);
    float8 raw = sample_raw8(volume, voxels, x, y, z);
    float4 difference = (float4)(raw.s1 - raw.s2, raw.s3 - raw.s4, raw.s5 - raw.s6, 0.0f);
    *gradient = 0.5f * difference * volume->scale;
    return raw.s0;
#else
    *gradient = (float4)(gradient_raw(volume, voxels, point), 0.0f);
    return sample_raw(volume, voxels, point);
#endif
}

// Value and gradient magnitude at a point in grid coordinates.
INLINE Medium medium_at(__constant struct Frame *frame, __constant struct Volume *volume, __global const VOXEL *voxels,
    __global const Medium *table, float4 point) {
    float4 gradient;
    float value = window_value(volume, value_and_gradient(volume, voxels, point, &gradient));
    float magnitude = sqrt(dot(gradient, gradient)) * fabs(volume->value_scale);
    int i, j;
    float fx = table_position(value, frame->table_size, &i);
    float fy = table_position(magnitude * frame->gradient_scale, frame->table_rows, &j);
    __global const Medium *row = table + (size_t)j * frame->table_size;
    Medium low = table_row(row, i, fx);
    Medium high = table_row(row + frame->table_size, i, fx);
    return emission_and_extinction(low + fy * (high - low));
}
#define MEDIUM_LOOKUPS 7
#else
INLINE Medium medium_of_value(__constant struct Frame *frame, __global const Medium *table, float value) {
    int i;
    float f = table_position(value, frame->table_size, &i);
    return emission_and_extinction(table_row(table, i, f));
}

INLINE Medium medium_at(__constant struct Frame *frame, __constant struct Volume *volume, __global const VOXEL *voxels,
    __global const Medium *table, float4 point) {
    return medium_of_value(frame, table, window_value(volume, sample_raw(volume, voxels, point)));
}
#define MEDIUM_LOOKUPS 1
#endif

#ifndef TF_2D
// Where the table's slope jumps; between such entries a smooth field meets a smooth table. The first and the last
// entry always count: beyond them the table is constant.
struct Kinks {
    __global const uint *before;  // per entry, how many kinks lie at or before it
    __global const uint *entries; // the kinks, ascending
};

// The kinks between two values: indices first <= k < last into `entries`.
INLINE int2 kinks_between(__constant struct Frame *frame, struct Kinks kinks, float lo, float hi) {
    int i, j;
    table_position(lo, frame->table_size, &i);
    table_position(hi, frame->table_size, &j);
    int first = lo < 0.0f ? 0 : (int)kinks.before[i];
    int last = hi < 0.0f ? 0 : (int)kinks.before[hi >= (float)(frame->table_size - 1) ? (int)frame->table_size - 1 : j];
    return (int2)(first, last);
}
#endif
