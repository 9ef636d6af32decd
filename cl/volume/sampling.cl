// Voxels and their trilinear interpolation.
//
// The buffer is padded by GRID_PAD copies of the border voxels, so nothing here clamps an index.
#include "common/lanes.cl"
#include "volume/grid.cl"

#ifndef VOXEL
#define VOXEL uchar
#endif
#define VOXEL_VECTOR_(type, n) type##n
#define VOXEL_VECTOR(type, n) VOXEL_VECTOR_(type, n)
#define VOXEL_OCTET VOXEL_VECTOR(VOXEL, 8)
#define VOXEL_SIXTEEN VOXEL_VECTOR(VOXEL, 16)

// The eight stored values around a cell; x changes fastest, then y.
struct Corners {
    float4 low;  // at z
    float4 high; // at z + 1
};

INLINE struct Corners fetch_cell(__constant struct Volume *volume, __global const VOXEL *voxels, int4 cell) {
    size_t row = volume->row;
    size_t slice = volume->slice;
    __global const VOXEL *p = voxels + ((size_t)cell.z * slice + (size_t)cell.y * row + (size_t)cell.x);
    struct Corners c;
    c.low = (float4)((float)p[0], (float)p[1], (float)p[row], (float)p[row + 1]);
    p += slice;
    c.high = (float4)((float)p[0], (float)p[1], (float)p[row], (float)p[row + 1]);
    return c;
}

INLINE float trilinear(struct Corners c, float4 f) {
    float4 z = c.low + f.z * (c.high - c.low);
    float2 y = z.xy + f.y * (z.zw - z.xy);
    return y.x + f.x * (y.y - y.x);
}

INLINE float corners_least(struct Corners c) {
    float4 m = min(c.low, c.high);
    return min(min(m.x, m.y), min(m.z, m.w));
}

INLINE float corners_largest(struct Corners c) {
    float4 m = max(c.low, c.high);
    return max(max(m.x, m.y), max(m.z, m.w));
}

// The interpolated stored value at a point in grid coordinates inside the padded box.
INLINE float sample_raw(__constant struct Volume *volume, __global const VOXEL *voxels, float4 point) {
    int4 cell = convert_int4(point);
    return trilinear(fetch_cell(volume, voxels, cell), point - convert_float4(cell));
}

#ifdef LANES
// Eight points at a time, for CPUs: a loop over single samples leaves their vector units idle.
#define CONCAT_(a, b) a##b
#define CONCAT(a, b) CONCAT_(a, b)
#define VOXEL_PAIRS CONCAT(VOXEL, 16)
#define FETCH_PAIRS(offset) \
    (VOXEL_PAIRS)(vload2(0, voxels + (i.s0 + (offset))), vload2(0, voxels + (i.s1 + (offset))), \
        vload2(0, voxels + (i.s2 + (offset))), vload2(0, voxels + (i.s3 + (offset))), \
        vload2(0, voxels + (i.s4 + (offset))), vload2(0, voxels + (i.s5 + (offset))), \
        vload2(0, voxels + (i.s6 + (offset))), vload2(0, voxels + (i.s7 + (offset))))

INLINE float8 lerp_pairs(VOXEL_PAIRS pairs, float8 f) {
    float8 a = convert_float8(pairs.even);
    return a + f * (convert_float8(pairs.odd) - a);
}

// As sample_raw, per lane. Indices are 32-bit: for buffers of less than 2^31 voxels.
INLINE float8 sample_raw8(__constant struct Volume *volume, __global const VOXEL *voxels, float8 x, float8 y, float8 z) {
    int8 cx = convert_int8(x);
    int8 cy = convert_int8(y);
    int8 cz = convert_int8(z);
    int row = (int)volume->row;
    int slice = (int)volume->slice;
    int8 i = cz * slice + cy * row + cx;
    float8 fx = x - convert_float8(cx);
    float8 fy = y - convert_float8(cy);
    float8 fz = z - convert_float8(cz);
    float8 low = lerp_pairs(FETCH_PAIRS(0), fx);
    low += fy * (lerp_pairs(FETCH_PAIRS(row), fx) - low);
    float8 high = lerp_pairs(FETCH_PAIRS(slice), fx);
    high += fy * (lerp_pairs(FETCH_PAIRS(slice + row), fx) - high);
    return low + fz * (high - low);
}
#endif

#if WIDTH > 1
// The voxels at and after each index. Written out with whole pairs, so that compilers load pairs into vectors instead of
// gathering single voxels.
#define PAIR_AT(i) vload2(0, voxels + index.s##i)
INLINE void fetch_pairs(__global const VOXEL *voxels, Ints index, Reals *first, Reals *second) {
#if WIDTH == 4
    VOXEL_OCTET pairs = (VOXEL_OCTET)(PAIR_AT(0), PAIR_AT(1), PAIR_AT(2), PAIR_AT(3));
    *first = TO_REALS(pairs.even);
    *second = TO_REALS(pairs.odd);
#else
    VOXEL_SIXTEEN low = (VOXEL_SIXTEEN)(PAIR_AT(0), PAIR_AT(1), PAIR_AT(2), PAIR_AT(3), PAIR_AT(4), PAIR_AT(5), PAIR_AT(6),
        PAIR_AT(7));
#if WIDTH == 8
    *first = TO_REALS(low.even);
    *second = TO_REALS(low.odd);
#else
    VOXEL_SIXTEEN high = (VOXEL_SIXTEEN)(PAIR_AT(8), PAIR_AT(9), PAIR_AT(a), PAIR_AT(b), PAIR_AT(c), PAIR_AT(d), PAIR_AT(e),
        PAIR_AT(f));
    *first = TO_REALS((VOXEL_SIXTEEN)(low.even, high.even));
    *second = TO_REALS((VOXEL_SIXTEEN)(low.odd, high.odd));
#endif
#endif
}
#endif

// The interpolated stored values at points in grid coordinates inside the padded box. With more than one lane indices
// are 32-bit: for buffers of less than 2^31 voxels.
INLINE Reals sample_raw_lanes(__constant struct Volume *volume, __global const VOXEL *voxels, struct Points p) {
#if WIDTH == 1
    return sample_raw(volume, voxels, (float4)(p.x, p.y, p.z, 0.0f));
#else
    Ints cx = TO_INTS(p.x);
    Ints cy = TO_INTS(p.y);
    Ints cz = TO_INTS(p.z);
    Reals fx = p.x - TO_REALS(cx);
    Reals fy = p.y - TO_REALS(cy);
    Reals fz = p.z - TO_REALS(cz);
    Ints index = cz * (int)volume->slice + cy * (int)volume->row + cx;
    Reals c000, c100, c010, c110, c001, c101, c011, c111;
    fetch_pairs(voxels, index, &c000, &c100);
    fetch_pairs(voxels + volume->row, index, &c010, &c110);
    fetch_pairs(voxels + volume->slice, index, &c001, &c101);
    fetch_pairs(voxels + volume->slice + volume->row, index, &c011, &c111);
    // z first, as trilinear() does.
    Reals a = c000 + fz * (c001 - c000);
    Reals b = c100 + fz * (c101 - c100);
    Reals c = c010 + fz * (c011 - c010);
    Reals d = c110 + fz * (c111 - c110);
    a += fy * (c - a);
    b += fy * (d - b);
    return a + fx * (b - a);
#endif
}

// Window value, not clamped.
INLINE float window_value(__constant struct Volume *volume, float raw) {
    return (raw - volume->value_zero) * volume->value_scale;
}

// Gradient of the stored value per local unit: central differences of one voxel on the trilinear field.
inline float3 gradient_raw(__constant struct Volume *volume, __global const VOXEL *voxels, float4 point) {
    float4 x = (float4)(1.0f, 0.0f, 0.0f, 0.0f);
    float4 y = x.yxzw;
    float4 z = x.yzxw;
    float3 difference = (float3)(
        sample_raw(volume, voxels, point + x) - sample_raw(volume, voxels, point - x),
        sample_raw(volume, voxels, point + y) - sample_raw(volume, voxels, point - y),
        sample_raw(volume, voxels, point + z) - sample_raw(volume, voxels, point - z));
    return 0.5f * difference * volume->scale.xyz;
}
