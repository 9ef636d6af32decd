// Fields between the centres of cells.
#include "irradiance/grid.cl"

// Between eight numbers of a box; `low`, `high`: the cells around, `f`: the way between them.
INLINE float4 between_cells(__global const float4 *box, int4 dims, int4 low, int4 high, float4 f) {
    size_t row = (size_t)dims.x;
    size_t slice = row * (size_t)dims.y;
    __global const float4 *p00 = box + ((size_t)low.z * slice + (size_t)low.y * row);
    __global const float4 *p10 = box + ((size_t)low.z * slice + (size_t)high.y * row);
    __global const float4 *p01 = box + ((size_t)high.z * slice + (size_t)low.y * row);
    __global const float4 *p11 = box + ((size_t)high.z * slice + (size_t)high.y * row);
    float4 a = mix(mix(p00[low.x], p00[high.x], f.x), mix(p10[low.x], p10[high.x], f.x), f.y);
    float4 b = mix(mix(p01[low.x], p01[high.x], f.x), mix(p11[low.x], p11[high.x], f.x), f.y);
    return mix(a, b, f.z);
}
