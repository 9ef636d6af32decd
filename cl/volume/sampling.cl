// Voxels and their trilinear interpolation.
//
// The buffer is padded by GRID_PAD copies of the border voxels, so nothing here clamps an index.
#include "volume/grid.cl"

#ifndef VOXEL
#define VOXEL uchar
#endif

// The eight stored values around a cell: c[0..3] for z, c[4..7] for z + 1; x changes fastest.
struct Corners {
    float4 low;  // (x0 y0), (x1 y0), (x0 y1), (x1 y1) at z
    float4 high; // ... at z + 1
};

inline struct Corners fetch_cell(__constant struct Volume *volume, __global const VOXEL *voxels, int3 cell) {
    size_t row = volume->row;
    size_t slice = volume->slice;
    __global const VOXEL *p = voxels + ((size_t)cell.z * slice + (size_t)cell.y * row + (size_t)cell.x);
    struct Corners c;
    c.low = (float4)((float)p[0], (float)p[1], (float)p[row], (float)p[row + 1]);
    p += slice;
    c.high = (float4)((float)p[0], (float)p[1], (float)p[row], (float)p[row + 1]);
    return c;
}

inline float trilinear(struct Corners c, float3 f) {
    float4 z = c.low + f.z * (c.high - c.low);
    float2 y = z.xy + f.y * (z.zw - z.xy);
    return y.x + f.x * (y.y - y.x);
}

// The interpolated stored value at a point in grid coordinates inside the padded box.
inline float sample_raw(__constant struct Volume *volume, __global const VOXEL *voxels, float3 point) {
    int3 cell = convert_int3(point);
    return trilinear(fetch_cell(volume, voxels, cell), point - convert_float3(cell));
}

// Window value in [0, 1] before clamping.
inline float window_value(__constant struct Volume *volume, float raw) {
    return (raw - volume->value_zero) * volume->value_scale;
}

// Gradient of the stored value per local unit: central differences of one voxel on the trilinear field.
inline float3 gradient_raw(__constant struct Volume *volume, __global const VOXEL *voxels, float3 point) {
    float3 x = (float3)(1.0f, 0.0f, 0.0f);
    float3 y = (float3)(0.0f, 1.0f, 0.0f);
    float3 z = (float3)(0.0f, 0.0f, 1.0f);
    float3 difference = (float3)(
        sample_raw(volume, voxels, point + x) - sample_raw(volume, voxels, point - x),
        sample_raw(volume, voxels, point + y) - sample_raw(volume, voxels, point - y),
        sample_raw(volume, voxels, point + z) - sample_raw(volume, voxels, point - z));
    return 0.5f * difference * volume->scale.xyz;
}
