// The integral cell by cell: the field along a ray is a cubic inside each trilinear cell, so where the transfer
// function is a straight line over the cell's values, two Gauss points give the optical depth exactly; a cell is cut
// where the field meets a kink of the function.
//
// The entry file has included irradiance/light.cl (LIT) or irradiance/unlit.cl.
#include "render/gathered.cl"
#include "volume/bricks.cl"

// Gauss-Legendre points of two on [0, 1]: exact for cubics.
#define GAUSS_0 0.21132486540518711775f
#define GAUSS_1 0.78867513459481288225f

#ifdef LIT
// Light along a cell: radiance scattered towards the eye per sigma_s, where the ray enters and where it leaves.
struct CellLight {
    float4 enter;
    float4 leave;
};
#else
struct CellLight {
    uint none;
};
#endif

// What the medium sends to the eye at s = 0 to 1 along a cell.
INLINE Source source_at(Medium medium, struct CellLight light, float s) {
#ifdef LIT
    float4 radiance = light.enter + s * (light.leave - light.enter);
#ifdef EMISSION
    Source source = medium.s0123 * radiance + medium.s4567;
    source.w = medium.s3;
#else
    Source source = medium * radiance;
    source.w = medium.w;
#endif
    return source;
#else
    return medium;
#endif
}

// The light along the cursor's cell to `exit`.
INLINE struct CellLight cell_light(struct Gathered *g, const struct CellCursor *cursor, const struct GridRay *ray,
    float exit, struct Lit lit) {
    struct CellLight light;
#ifdef LIT
    light.enter = g->light_time == cursor->t ? g->light : light_towards_eye(lit, grid_point(ray, cursor->t));
    light.leave = light_towards_eye(lit, grid_point(ray, exit));
    g->light = light.leave;
    g->light_time = exit;
#else
    light.none = 0u;
#endif
    return light;
}

// Adds a segment by its sources at the two Gauss points.
INLINE void gather_gauss(struct Gathered *g, __constant struct EmissionAbsorption *method, Source first, Source second,
    float length) {
#if defined(TRANSMITTANCE_ONLY)
    gather(g, method, length, 0.5f * (first + second));
#else
    // The second point is seen through what lies between the two: its colour weighs less, the optical depth is the sum.
    float sigma = 0.5f * (first.w + second.w);
    if (sigma == 0.0f) {
        return;
    }
    // Not below 1e-6, where it decides nothing but whether 0 / 0 can happen.
    float depth = (GAUSS_1 - GAUSS_0) * length * sigma;
#ifdef CHROMATIC
    float4 between = max((float4)(transmittance_of(depth * method->extinction.x),
        transmittance_of(depth * method->extinction.y), transmittance_of(depth * method->extinction.z), 0.0f), 1e-6f);
    Source seen = (first + between * second) * (sigma / (first.w + between * second.w));
#else
    float between = max(transmittance_of(depth), 1e-6f);
    Source seen = first + between * second;
    seen *= sigma / seen.w;
#endif
    seen.w = sigma;
    gather(g, method, length, seen);
#endif
}

#ifdef TF_2D

// Value and gradient magnitude have no closed form along the ray: two Gauss points per half cell.
INLINE void gather_cell(struct Gathered *g, const struct CellCursor *cursor, const struct GridRay *ray, float exit,
    uchar brick, __constant struct Frame *frame, __constant struct Volume *volume,
    __constant struct EmissionAbsorption *method, __global const VOXEL *voxels, __global const Medium *table,
    __global const uint *kinks_before, __global const uint *kink_entries, struct Lit lit) {
    g->lookups += 1;
    struct Corners corners = fetch_cell(volume, voxels, cursor->cell);
    float a = window_value(volume, corners_least(corners));
    float b = window_value(volume, corners_largest(corners));
    if (max(a, b) < method->empty_value) {
        return;
    }
    float half_length = 0.5f * (exit - cursor->t);
    struct CellLight light = cell_light(g, cursor, ray, exit, lit);
    for (int part = 0; part < 2; ++part) {
        float start = cursor->t + (float)part * half_length;
        float4 p = grid_point(ray, start + GAUSS_0 * half_length);
        float4 q = grid_point(ray, start + GAUSS_1 * half_length);
        Source first = source_at(medium_at(frame, volume, voxels, table, p), light, 0.5f * ((float)part + GAUSS_0));
        Source second = source_at(medium_at(frame, volume, voxels, table, q), light, 0.5f * ((float)part + GAUSS_1));
        gather_gauss(g, method, first, second, half_length);
    }
    g->lookups += 4 * MEDIUM_LOOKUPS;
}

#else

#define MAX_PARTS 24
#define MAX_KINKS 32

// The source at s along a cell.
INLINE Source source_of_cubic(struct Cubic p, float s, __constant struct Frame *frame, __global const Medium *table,
    struct CellLight light) {
    return source_at(medium_of_value(frame, table, cubic_value(p, s)), light, s);
}

// How much the source changes between two points, of its largest: 0 to about 1.
INLINE float source_change(Source first, Source second) {
#ifdef TRANSMITTANCE_ONLY
    return 0.0f;
#else
    float both = first.w + second.w;
    float4 change = fabs(first * second.w - second * first.w);
    float most = max(max(change.x, change.y), change.z) * (4.0f / (both * both));
#ifdef LIT
    // Colours are at most 1, light is anything.
    float4 mean = (first + second) / both;
    most /= max(max(max(mean.x, mean.y), mean.z), 1e-30f);
#endif
    return most;
#endif
}

// Adds the part of a cell from s = `from` to `to`, over whose values the table is smooth. `length`: of the whole cell.
INLINE void gather_smooth(struct Gathered *g, __constant struct EmissionAbsorption *method, struct Cubic p, float from,
    float to, float length, __constant struct Frame *frame, __global const Medium *table, struct CellLight light) {
    float width = to - from;
    Source first = source_of_cubic(p, from + GAUSS_0 * width, frame, table, light);
    Source second = source_of_cubic(p, from + GAUSS_1 * width, frame, table, light);
#ifndef TRANSMITTANCE_ONLY
    // The optical depth is exact; the radiance is not where the colour changes within a cell that is not thin. The
    // rule's error falls with the fourth power of the number of parts.
    float both = first.w + second.w;
    if (both == 0.0f) {
        return;
    }
    float tau = 0.5f * length * width * both;
    float most = source_change(first, second);
    float wanted = 1.0f + 3.0f * tau * sqrt(most) + 4.0f * most;
    int parts = (int)min(wanted, (float)MAX_PARTS);
    if (parts > 1) {
        // A thick cell is seen by its first few optical depths: parts stay as short as they must be there, and the
        // last takes what is left.
        width /= max(wanted, (float)parts);
        for (int part = 0; part < parts; ++part) {
            float start = from + (float)part * width;
            width = part + 1 < parts ? width : to - start;
            first = source_of_cubic(p, start + GAUSS_0 * width, frame, table, light);
            second = source_of_cubic(p, start + GAUSS_1 * width, frame, table, light);
            gather_gauss(g, method, first, second, length * width);
        }
        return;
    }
#endif
    gather_gauss(g, method, first, second, length * width);
}

// Adds the part of a cell from s = `from` to `to`, where the field is monotone, cut at the table's kinks.
inline void gather_monotone(struct Gathered *g, __constant struct EmissionAbsorption *method, struct Cubic p, float from,
    float to, float length, __constant struct Frame *frame, __global const Medium *table, struct Kinks kinks,
    struct CellLight light) {
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
        gather_smooth(g, method, p, from, s, length, frame, table, light);
        from = s;
    }
    gather_smooth(g, method, p, from, to, length, frame, table, light);
}

INLINE void gather_cell(struct Gathered *g, const struct CellCursor *cursor, const struct GridRay *ray, float exit,
    uchar brick, __constant struct Frame *frame, __constant struct Volume *volume,
    __constant struct EmissionAbsorption *method, __global const VOXEL *voxels, __global const Medium *table,
    __global const uint *kinks_before, __global const uint *kink_entries, struct Lit lit) {
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
    struct CellLight light = cell_light(g, cursor, ray, exit, lit);
    if (smooth) {
        gather_smooth(g, method, p, 0.0f, 1.0f, length, frame, table, light);
        return;
    }
    float2 extrema = cubic_extrema(p);
    float from = 0.0f;
    for (int piece = 0; piece < 3; ++piece) {
        float to = piece == 0 ? extrema.x : piece == 1 ? extrema.y : 1.0f;
        if (to > from) {
            gather_monotone(g, method, p, from, to, length, frame, table, kinks, light);
            from = to;
        }
    }
}

#endif

INLINE void march(struct Gathered *g, const struct GridRay *ray, __constant struct Frame *frame,
    __constant struct Volume *volume, __constant struct EmissionAbsorption *method, __global const VOXEL *voxels,
    __global const uchar *bricks, __global const Medium *table, __global const uint *kinks_before,
    __global const uint *kink_entries, struct Lit lit) {
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
            kink_entries, lit);
        if (exit >= ray->t1 || is_opaque(g, method)) {
            return;
        }
        cursor_next(&cursor, ray);
    }
}

