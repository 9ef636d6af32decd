// Emission-absorption (Max 1995; Usher's ray caster): L = int T sigma_t c L0 dt + T(D) L_bg.
//
// Two quadratures. Per cell (default): the field along a ray is a cubic inside each trilinear cell, so where the
// transfer function is a straight line over the cell's values, two Gauss points give the optical depth exactly; a
// cell is cut where the field meets a kink of the function. STEP: the midpoint rule on a lattice of fixed steps that
// starts where the ray enters the box; empty bricks skip lattice points, never move them.
//
// Inputs: voxels, bricks (see BRICK_*), the transfer function's table; output: film.
#include "film/accumulate.cl"
#include "render/background.cl"
#include "render/camera.cl"
#include "render/frame.cl"
#include "types/method.cl"
#include "volume/bricks.cl"
#include "volume/transfer.cl"

// What the table does over the values of a brick: a straight line, or anything; below: no extinction, and the
// number is how many bricks the ray can stride over.
#define BRICK_STRAIGHT 254
#define BRICK_BENT 255

// What a ray has gathered so far.
struct Gathered {
#ifdef TRANSMITTANCE_ONLY
    float depth; // optical depth
#else
    float3 radiance;
    float transmittance;
    float opacity; // 1 - transmittance, without the cancellation where the medium is thin
#endif
    uint lookups;
};

INLINE float gathered_transmittance(const struct Gathered *g) {
#ifdef TRANSMITTANCE_ONLY
    return exp(-g->depth);
#else
    return g->transmittance;
#endif
}

INLINE float gathered_opacity(const struct Gathered *g) {
#ifdef TRANSMITTANCE_ONLY
    return g->depth * mean_transmittance(g->depth);
#else
    return g->opacity < 0.5f ? g->opacity : 1.0f - g->transmittance;
#endif
}

// Adds a segment of this length; `mean`: what the table averages to over it.
INLINE void gather(struct Gathered *g, float length, Medium mean) {
    float tau = length * medium_sigma(mean);
#ifdef TRANSMITTANCE_ONLY
    g->depth += tau;
#else
    if (tau == 0.0f) {
        return; // the commonest case by far in partly filled bricks
    }
#ifdef LINEAR_COMPOSITING
    // Usher's Taylor form: too opaque, first order in the step.
    float share = tau > 1.0f ? 1.0f / tau : 1.0f;
#else
    float share = mean_transmittance(tau);
#endif
    g->radiance += (g->transmittance * length * share) * mean.xyz;
    g->opacity += g->transmittance * tau * share;
    g->transmittance *= 1.0f - tau * share;
#endif
}

INLINE bool is_opaque(const struct Gathered *g, __constant struct EmissionAbsorption *method) {
#ifdef TRANSMITTANCE_ONLY
    return g->depth > method->max_depth;
#else
    return g->transmittance < method->min_transmittance;
#endif
}

#ifdef STEP

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
        gather(g, width.k, emission_and_extinction(table_row(table, index.k, fraction.k))); \
        if (is_opaque(g, method)) { \
            return true; \
        } \
    }

// Gathers eight lattice points from `first` on (fewer at the end). Returns whether the ray is opaque.
INLINE bool gather_points(struct Gathered *g, const struct GridRay *ray, struct Lattice lattice, int first, int end,
    __constant struct Frame *frame, __constant struct Volume *volume, __constant struct EmissionAbsorption *method,
    __global const VOXEL *voxels, __global const Medium *table) {
    int8 i = min(first + (int8)(0, 1, 2, 3, 4, 5, 6, 7), lattice.count - 1);
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
    int8 index = min(convert_int8(position), (int)frame->table_size - 2);
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
        gather(g, lattice_width(lattice, i), medium_at(frame, volume, voxels, table, point));
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

#else

// Gauss-Legendre points of two on [0, 1]: exact for cubics.
#define GAUSS_0 0.21132486540518711775f
#define GAUSS_1 0.78867513459481288225f

// Adds a segment by the medium at its two Gauss points.
INLINE void gather_gauss(struct Gathered *g, Medium first, Medium second, float length) {
#ifdef TRANSMITTANCE_ONLY
    gather(g, length, 0.5f * (first + second));
#else
    // The second point is seen through what lies between the two: its colour weighs less, the optical depth is the sum.
    float sigma = 0.5f * (first.w + second.w);
    if (sigma == 0.0f) {
        return;
    }
    // Not below 1e-6, where it decides nothing but whether 0 / 0 can happen.
    float between = max(transmittance_of((GAUSS_1 - GAUSS_0) * length * sigma), 1e-6f);
    Medium seen = first + between * second;
    seen.xyz *= sigma / seen.w;
    seen.w = sigma;
    gather(g, length, seen);
#endif
}

#ifdef TF_2D

// Value and gradient magnitude have no closed form along the ray: two Gauss points per half cell.
INLINE void gather_cell(struct Gathered *g, const struct CellCursor *cursor, const struct GridRay *ray, float exit,
    uchar brick, __constant struct Frame *frame, __constant struct Volume *volume,
    __constant struct EmissionAbsorption *method, __global const VOXEL *voxels, __global const Medium *table,
    __global const uint *kinks_before, __global const uint *kink_entries) {
    g->lookups += 1;
    struct Corners corners = fetch_cell(volume, voxels, cursor->cell);
    float a = window_value(volume, corners_least(corners));
    float b = window_value(volume, corners_largest(corners));
    if (max(a, b) < method->empty_value) {
        return;
    }
    float half_length = 0.5f * (exit - cursor->t);
    for (int part = 0; part < 2; ++part) {
        float start = cursor->t + (float)part * half_length;
        float4 p = grid_point(ray, start + GAUSS_0 * half_length);
        float4 q = grid_point(ray, start + GAUSS_1 * half_length);
        gather_gauss(g, medium_at(frame, volume, voxels, table, p), medium_at(frame, volume, voxels, table, q), half_length);
    }
    g->lookups += 4 * MEDIUM_LOOKUPS;
}

#else

#define MAX_PARTS 24
#define MAX_KINKS 32

// Adds the part of a cell from s = `from` to `to`, over whose values the table is smooth. `length`: of the whole cell.
INLINE void gather_smooth(struct Gathered *g, struct Cubic p, float from, float to, float length,
    __constant struct Frame *frame, __global const Medium *table) {
    float width = to - from;
    Medium first = medium_of_value(frame, table, cubic_value(p, from + GAUSS_0 * width));
    Medium second = medium_of_value(frame, table, cubic_value(p, from + GAUSS_1 * width));
#ifndef TRANSMITTANCE_ONLY
    // The optical depth is exact; the radiance is not where the colour changes within a cell that is not thin. The
    // rule's error falls with the fourth power of the number of parts.
    float both = first.w + second.w;
    if (both == 0.0f) {
        return;
    }
    float tau = 0.5f * length * width * both;
    float4 change = fabs(first * second.w - second * first.w) * (4.0f / (both * both));
    float most = max(max(change.x, change.y), change.z);
    float wanted = 1.0f + 3.0f * tau * sqrt(most) + 4.0f * most;
    int parts = (int)min(wanted, (float)MAX_PARTS);
    if (parts > 1) {
        // A thick cell is seen by its first few optical depths: parts stay as short as they must be there, and the
        // last takes what is left.
        width /= max(wanted, (float)parts);
        for (int part = 0; part < parts; ++part) {
            float start = from + (float)part * width;
            width = part + 1 < parts ? width : to - start;
            first = medium_of_value(frame, table, cubic_value(p, start + GAUSS_0 * width));
            second = medium_of_value(frame, table, cubic_value(p, start + GAUSS_1 * width));
            gather_gauss(g, first, second, length * width);
        }
        return;
    }
#endif
    gather_gauss(g, first, second, length * width);
}

// Adds the part of a cell from s = `from` to `to`, where the field is monotone, cut at the table's kinks.
inline void gather_monotone(struct Gathered *g, struct Cubic p, float from, float to, float length,
    __constant struct Frame *frame, __global const Medium *table, struct Kinks kinks) {
    float a = cubic_value(p, from);
    float b = cubic_value(p, to);
    bool rising = b >= a;
    int2 range = kinks_between(frame, kinks, min(a, b), max(a, b));
    // So many kinks within a voxel are noise; equal parts then do as well.
    int count = range.y - range.x;
    int cuts = count > MAX_KINKS ? MAX_PARTS - 1 : count;
    for (int cut = 0; cut < cuts; ++cut) {
        float s;
        if (count > MAX_KINKS) {
            s = from + (to - from) / (float)(cuts + 1 - cut);
        } else {
            uint entry = kinks.entries[rising ? range.x + cut : range.y - 1 - cut];
            struct Cubic q = p;
            q.a -= (float)entry;
            s = bracketed_root(q, from, to, !rising);
        }
        gather_smooth(g, p, from, s, length, frame, table);
        from = s;
    }
    gather_smooth(g, p, from, to, length, frame, table);
}

INLINE void gather_cell(struct Gathered *g, const struct CellCursor *cursor, const struct GridRay *ray, float exit,
    uchar brick, __constant struct Frame *frame, __constant struct Volume *volume,
    __constant struct EmissionAbsorption *method, __global const VOXEL *voxels, __global const Medium *table,
    __global const uint *kinks_before, __global const uint *kink_entries) {
    float length = exit - cursor->t;
    struct Corners corners = fetch_cell(volume, voxels, cursor->cell);
    g->lookups += 1;
    bool smooth = brick == BRICK_STRAIGHT;
    struct Kinks kinks;
    kinks.before = kinks_before;
    kinks.entries = kink_entries;
    if (!smooth) {
        float a = window_value(volume, corners_least(corners));
        float b = window_value(volume, corners_largest(corners));
        if (max(a, b) < method->empty_value) {
            return;
        }
        int2 range = kinks_between(frame, kinks, min(a, b), max(a, b));
        smooth = range.x == range.y;
    }
    struct Cubic p = cubic_window(volume, cursor_cubic(cursor, ray, corners, exit));
    if (smooth) {
        gather_smooth(g, p, 0.0f, 1.0f, length, frame, table);
        return;
    }
    float2 extrema = cubic_extrema(p);
    float from = 0.0f;
    for (int piece = 0; piece < 3; ++piece) {
        float to = piece == 0 ? extrema.x : piece == 1 ? extrema.y : 1.0f;
        if (to > from) {
            gather_monotone(g, p, from, to, length, frame, table, kinks);
            from = to;
        }
    }
}

#endif

INLINE void march(struct Gathered *g, const struct GridRay *ray, __constant struct Frame *frame,
    __constant struct Volume *volume, __constant struct EmissionAbsorption *method, __global const VOXEL *voxels,
    __global const uchar *bricks, __global const Medium *table, __global const uint *kinks_before,
    __global const uint *kink_entries) {
    struct CellCursor cursor = cursor_start(volume, ray);
    bricks += stride_table(volume, ray);
    for (;;) {
        uchar brick = bricks[brick_index(volume, cursor.cell)];
        if (brick < BRICK_STRAIGHT) {
            if (!cursor_skip_bricks(&cursor, volume, ray, brick)) {
                return;
            }
            continue;
        }
        float exit = cursor_exit(&cursor, ray);
        gather_cell(g, &cursor, ray, exit, brick, frame, volume, method, voxels, table, kinks_before,
            kink_entries);
        if (exit >= ray->t1 || is_opaque(g, method)) {
            return;
        }
        cursor_next(&cursor, ray);
    }
}

#endif

__kernel void render_emission_absorption(__constant struct Frame *frame, __constant struct Camera *camera,
    __constant struct Volume *volume, __constant struct EmissionAbsorption *method, __global const VOXEL *voxels,
    __global const uchar *bricks, __global const Medium *table, __global const uint *kinks_before,
    __global const uint *kink_entries, __global const float4 *environment,
    __global struct FilmPixel *film, uint first_tile, uint tile_count, uint first_sample, uint sample_count) {
    int pixel = frame_pixel(camera->width, camera->height, first_tile, tile_count);
    if (pixel < 0) {
        return;
    }
    uint2 seed = (uint2)(frame->seed_low, frame->seed_high);
    uint4 keys = philox4x32((uint4)((uint)pixel, 0u, 0u, 0u), seed);
    struct FilmPixel accumulated = film[pixel];
    for (uint sample = first_sample; sample < first_sample + sample_count; ++sample) {
        struct Ray ray = camera_ray(camera, (uint)pixel, sample, keys);
        struct GridRay grid = grid_ray(volume, ray.origin, ray.direction, ray.t_min);
        struct Gathered g;
        g.lookups = 0;
#ifdef TRANSMITTANCE_ONLY
        g.depth = 0.0f;
#else
        g.radiance = (float3)(0.0f);
        g.transmittance = 1.0f;
        g.opacity = 0.0f;
#endif
        if (grid.t1 > grid.t0) {
#ifdef STEP
#ifdef JITTER
            float phase = random4(seed, (uint)pixel, sample, RNG_STEP_PHASE).x;
#else
            float phase = 0.5f;
#endif
            march(&g, &grid, phase, frame, volume, method, voxels, bricks, table);
#else
            march(&g, &grid, frame, volume, method, voxels, bricks, table, kinks_before, kink_entries);
#endif
        }
        float transmittance = gathered_transmittance(&g);
        float3 radiance = transmittance * background_radiance(frame, environment, ray.direction);
#ifndef TRANSMITTANCE_ONLY
        radiance += method->radiance * g.radiance;
#endif
        film_add(&accumulated, (float4)(radiance, gathered_opacity(&g)), -1.0f, g.lookups);
    }
    film[pixel] = accumulated;
}
