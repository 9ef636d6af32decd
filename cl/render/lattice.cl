// The midpoint rule on a lattice of fixed steps that starts where the ray enters the box; empty bricks skip lattice
// points, never move them.
#include "render/gathered.cl"
#include "volume/bricks.cl"

// The lattice of a ray.
struct Lattice {
    float start;
    float length;
    float step;
    float phase; // where in its step a sample sits, 0 to 1
    int count;
};

// The last step is shorter.
INLINE float lattice_width(struct Lattice lattice, int i) {
    return min(lattice.step, lattice.length - (float)i * lattice.step);
}

INLINE float lattice_time(struct Lattice lattice, int i) {
    return lattice.start + (float)i * lattice.step + lattice.phase * lattice_width(lattice, i);
}

#if defined(LANES) && !defined(TF_2D)

// One lane of eight: samples are composited one by one, so the picture does not depend on how they are grouped.
#define GATHER_LANE(k) \
    if (value.k >= method->empty_value) { \
        gather(g, method, width.k, emission_and_extinction(table_row(table, index.k, fraction.k))); \
        if (is_opaque(g, method)) { \
            return true; \
        } \
    }

// Gathers eight lattice points from `first` on (fewer at the end). Returns whether the ray is opaque.
INLINE bool gather_points(struct Gathered *g, const struct GridRay *ray, struct Lattice lattice, int first, int end,
    __constant struct Frame *frame, __constant struct Volume *volume, __constant struct EmissionAbsorption *method,
    __global const VOXEL *voxels, __global const Medium *table) {
    int8 i = min(first + (int8)(0, 1, 2, 3, 4, 5, 6, 7), (int8)(lattice.count - 1));
    float8 start = convert_float8(i) * lattice.step;
    float8 width = min((float8)(lattice.step), lattice.length - start);
    float8 t = lattice.start + start + lattice.phase * width;
    float8 raw = sample_raw8(volume, voxels, ray->origin.x + t * ray->direction.x,
        ray->origin.y + t * ray->direction.y, ray->origin.z + t * ray->direction.z);
    float8 value = (raw - volume->value_zero) * volume->value_scale;
    int valid = min(8, lattice.count - first);
    g->lookups += (uint)valid;
    if (!any(value >= method->empty_value)) {
        return false;
    }
    width = select((float8)(0.0f), width, (int8)(0, 1, 2, 3, 4, 5, 6, 7) < valid);
    float8 position = clamp(value, 0.0f, (float)(frame->table_size - 1));
    int8 index = min(convert_int8(position), (int8)((int)frame->table_size - 2));
    float8 fraction = position - convert_float8(index);
    GATHER_LANE(s0) GATHER_LANE(s1) GATHER_LANE(s2) GATHER_LANE(s3)
    GATHER_LANE(s4) GATHER_LANE(s5) GATHER_LANE(s6) GATHER_LANE(s7)
    return false;
}
#define POINTS_AT_LEAST 8

#else

// Gathers the lattice points from `first` up to `end`. Returns whether the ray is opaque.
INLINE bool gather_points(struct Gathered *g, const struct GridRay *ray, struct Lattice lattice, int first, int end,
    __constant struct Frame *frame, __constant struct Volume *volume, __constant struct EmissionAbsorption *method,
    __global const VOXEL *voxels, __global const Medium *table) {
    for (int i = first; i < end; ++i) {
        float4 point = grid_point(ray, lattice_time(lattice, i));
        g->lookups += MEDIUM_LOOKUPS;
        gather(g, method, lattice_width(lattice, i), medium_at(frame, volume, voxels, table, point));
        if (is_opaque(g, method)) {
            return true;
        }
    }
    return false;
}
#define POINTS_AT_LEAST 1

#endif

INLINE void march(struct Gathered *g, const struct GridRay *ray, float phase, __constant struct Frame *frame,
    __constant struct Volume *volume, __constant struct EmissionAbsorption *method, __global const VOXEL *voxels,
    __global const uchar *bricks, __global const Medium *table) {
    struct Lattice lattice;
    lattice.start = ray->t0;
    lattice.length = ray->t1 - ray->t0;
    lattice.step = method->step;
    lattice.phase = phase;
    lattice.count = (int)ceil(lattice.length / method->step);
    float inverse_step = 1.0f / method->step;
    bricks += stride_table(volume, ray);
    int i = 0;
    while (i < lattice.count) {
        int4 cell = convert_int4(grid_point(ray, lattice_time(lattice, i)));
        uchar brick = bricks[brick_index(volume, cell)];
        bool empty = brick < BRICK_STRAIGHT;
        float leave = (brick_exit(volume, ray, cell, empty ? brick : 1) - ray->t0) * inverse_step - phase;
        // Every lattice point before `end` lies in these bricks; the margin covers rounding.
        int end = max((int)min(leave - 0.01f, (float)lattice.count), i + 1);
        if (!empty) {
            end = max(end, min(i + POINTS_AT_LEAST, lattice.count));
            for (; i < end; i += POINTS_AT_LEAST > 1 ? POINTS_AT_LEAST : end - i) {
                if (gather_points(g, ray, lattice, i, end, frame, volume, method, voxels, table)) {
                    return;
                }
            }
            continue;
        }
        i = end;
    }
}
