// The transfer function of scattering media: extinction, albedo and emission as tables of their own, linear between
// entries.
#include "volume/transfer.cl"

// A place in the tables.
struct TablePlace {
    int column;
    float fraction;
#ifdef TF_2D
    int row;
    float row_fraction;
#endif
};

// `row`: of a 2-D function.
INLINE struct TablePlace table_place(__constant struct Frame *frame, float value, float row) {
    struct TablePlace place;
    place.fraction = table_position(value, frame->table_size, &place.column);
#ifdef TF_2D
    place.row_fraction = table_position(row, frame->table_rows, &place.row);
#endif
    return place;
}

INLINE float table_sigma(__constant struct Frame *frame, __global const float *sigmas, struct TablePlace place) {
#ifdef TF_2D
    sigmas += (size_t)place.row * frame->table_size;
    __global const float *above = sigmas + frame->table_size;
    float high = above[place.column] + place.fraction * (above[place.column + 1] - above[place.column]);
#endif
    float low = sigmas[place.column] + place.fraction * (sigmas[place.column + 1] - sigmas[place.column]);
#ifdef TF_2D
    low += place.row_fraction * (high - low);
#endif
    return low;
}

INLINE float4 table_color(__constant struct Frame *frame, __global const float4 *colors, struct TablePlace place) {
#ifdef TF_2D
    colors += (size_t)place.row * frame->table_size;
    __global const float4 *above = colors + frame->table_size;
    float4 high = above[place.column] + place.fraction * (above[place.column + 1] - above[place.column]);
#endif
    float4 low = colors[place.column] + place.fraction * (colors[place.column + 1] - colors[place.column]);
#ifdef TF_2D
    low += place.row_fraction * (high - low);
#endif
    return low;
}

// Extinction at a point in grid coordinates, and the value (in entries) and row there.
INLINE float sigma_at(__constant struct Frame *frame, __constant struct Volume *volume, __global const VOXEL *voxels,
    __global const float *sigmas, float4 point, float *value, float *row) {
#ifdef TF_2D
    float4 gradient;
    *value = window_value(volume, value_and_gradient(volume, voxels, point, &gradient));
    *row = sqrt(dot(gradient, gradient)) * fabs(volume->value_scale) * frame->gradient_scale;
#else
    *value = window_value(volume, sample_raw(volume, voxels, point));
    *row = 0.0f;
#endif
    return table_sigma(frame, sigmas, table_place(frame, *value, *row));
}
