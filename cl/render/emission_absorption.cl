// Emission-absorption (Max 1995; Usher's ray caster): L = int T sigma_t c L0 dt + T(D) L_bg.
//
// Two quadratures. Per cell (default): the field along a ray is a cubic inside each trilinear cell, so the optical
// depth of a transfer function that is linear over the cell's values is exact by two Gauss points; where the
// function bends, the cell is cut and the function is averaged by its integral. STEP: the midpoint rule on a
// lattice of fixed steps that starts where the ray enters the box; empty bricks skip lattice points, never move them.
//
// Inputs: voxels, bricks (1 where the medium may be non-zero), the transfer function's table; output: film.
#include "film/accumulate.cl"
#include "render/background.cl"
#include "render/camera.cl"
#include "render/frame.cl"
#include "types/method.cl"
#include "volume/bricks.cl"
#include "volume/transfer.cl"

// What a ray has gathered so far.
struct Gathered {
#ifdef TRANSMITTANCE_ONLY
    float depth; // optical depth
#else
    float3 radiance;
    float transmittance;
#endif
    uint lookups;
};

inline float gathered_transmittance(const struct Gathered *g) {
#ifdef TRANSMITTANCE_ONLY
    return exp(-g->depth);
#else
    return g->transmittance;
#endif
}

// Adds a segment of optical depth `tau` whose source radiance is emission / extinction.
inline void gather(struct Gathered *g, float tau, Medium medium) {
#ifdef TRANSMITTANCE_ONLY
    g->depth += tau;
#else
    if (tau > 0.0f) {
#ifdef LINEAR_COMPOSITING
        float opacity = fmin(tau, 1.0f); // Usher's Taylor form: too opaque, first order in the step
#else
        float opacity = one_minus_exp(tau);
#endif
        g->radiance += (g->transmittance * opacity / medium.w) * medium.xyz;
        g->transmittance *= 1.0f - opacity;
    }
#endif
}

inline bool is_opaque(const struct Gathered *g, __constant struct EmissionAbsorption *method) {
#ifdef TRANSMITTANCE_ONLY
    return exp(-g->depth) < method->min_transmittance;
#else
    return g->transmittance < method->min_transmittance;
#endif
}

#ifdef STEP

inline void march(struct Gathered *g, const struct GridRay *ray, float phase, __constant struct Frame *frame,
    __constant struct Volume *volume, __constant struct EmissionAbsorption *method, __global const VOXEL *voxels,
    __global const uchar *bricks, __global const Medium *table) {
    float length = ray->t1 - ray->t0;
    float step = method->step;
    int3 direction = cursor_start(volume, ray).step;
    int count = (int)ceil(length / step);
    int i = 0;
    while (i < count) {
        // The last step is shorter; its sample sits at the same fraction of it.
        float width = fmin(step, length - (float)i * step);
        int3 cell = convert_int3(grid_point(ray, ray->t0 + (float)i * step + phase * width));
        float leave = (brick_exit(volume, ray, cell, direction) - ray->t0) / step - phase;
        // Every lattice point before `end` - 1 lies in this brick; the margin covers rounding.
        int end = (int)fmin(leave - 0.01f, (float)count);
        if (!bricks[brick_index(volume, cell)]) {
            i = max(end, i + 1);
            continue;
        }
        end = min(max(end, i) + 1, count);
        for (; i < end; ++i) {
            width = fmin(step, length - (float)i * step);
            float3 point = grid_point(ray, ray->t0 + (float)i * step + phase * width);
            Medium medium = medium_at(frame, volume, voxels, table, point);
            g->lookups += MEDIUM_LOOKUPS;
            gather(g, medium_sigma(medium) * width, medium);
            if (is_opaque(g, method)) {
                return;
            }
        }
    }
}

#else

// Gauss-Legendre points of two on [0, 1]: exact for cubics.
#define GAUSS_0 0.21132486540518711775f
#define GAUSS_1 0.78867513459481288225f

// Adds a segment by the medium at its two Gauss points.
inline void gather_gauss(struct Gathered *g, Medium first, Medium second, float length) {
    float tau = 0.5f * length * (medium_sigma(first) + medium_sigma(second));
#ifdef TRANSMITTANCE_ONLY
    gather(g, tau, 0.0f);
#else
    // The second point is seen through what lies between the two.
    gather(g, tau, first + exp(-(GAUSS_1 - GAUSS_0) * tau) * second);
#endif
}

#ifdef TF_2D

// Value and gradient magnitude have no closed form along the ray: two Gauss points per half cell.
inline void gather_cell(struct Gathered *g, const struct CellCursor *cursor, const struct GridRay *ray, float exit,
    __constant struct Frame *frame, __constant struct Volume *volume, __global const VOXEL *voxels,
    __global const Medium *table) {
    float half_length = 0.5f * (exit - cursor->t);
    for (int part = 0; part < 2; ++part) {
        float start = cursor->t + (float)part * half_length;
        float3 p = grid_point(ray, start + GAUSS_0 * half_length);
        float3 q = grid_point(ray, start + GAUSS_1 * half_length);
        gather_gauss(g, medium_at(frame, volume, voxels, table, p), medium_at(frame, volume, voxels, table, q), half_length);
    }
    g->lookups += 4 * MEDIUM_LOOKUPS;
}

#else

#define MAX_PARTS 16

// Whether the table is one straight line over the window values between lo and hi.
inline bool is_straight(__constant struct Frame *frame, __global const uint *kinks, float lo, float hi) {
    int i, j;
    table_position(lo, frame->table_size, &i);
    table_position(hi, frame->table_size, &j);
    return (kinks[i] == kinks[j] && lo >= 0.0f && hi <= 1.0f) || hi <= 0.0f || lo >= 1.0f;
}

inline void gather_cell(struct Gathered *g, const struct CellCursor *cursor, const struct GridRay *ray, float exit,
    __constant struct Frame *frame, __constant struct Volume *volume, __global const VOXEL *voxels,
    __global const Medium *table, struct TableIntegral integral) {
    float length = exit - cursor->t;
    struct Cubic p = cursor_cubic(cursor, ray, fetch_cell(volume, voxels, cursor->cell), cursor->t, exit);
    g->lookups += 1;
    p.a = window_value(volume, p.a);
    p.b *= volume->value_scale;
    p.c *= volume->value_scale;
    p.d *= volume->value_scale;
    float first = cubic_value(p, GAUSS_0);
    float second = cubic_value(p, GAUSS_1);
    float end = p.a + p.b + p.c + p.d;
    float lo = fmin(fmin(p.a, end), fmin(first, second));
    float hi = fmax(fmax(p.a, end), fmax(first, second));
    if (is_straight(frame, integral.kinks, lo, hi)) {
        gather_gauss(g, medium_of_value(frame, table, first), medium_of_value(frame, table, second), length);
        return;
    }
    // Cut the cell so that the field departs from a straight line by less than half a table interval in each part
    // and no part is optically thick.
    float bend = (fabs(p.c) + 3.0f * fabs(p.d)) * (float)frame->table_size * 0.5f;
    float tau = medium_sigma(table_mean(frame, table, integral, lo, hi)) * length;
    float wanted = fmax(sqrt(bend), 4.0f * tau);
    int parts = (int)fmin(wanted, (float)(MAX_PARTS - 1)) + 1;
    float width = 1.0f / (float)parts;
    float from = p.a;
    for (int part = 1; part <= parts; ++part) {
        float to = cubic_value(p, (float)part * width);
        Medium mean = table_mean(frame, table, integral, from, to);
        gather(g, medium_sigma(mean) * length * width, mean);
        from = to;
    }
}

#endif

inline void march(struct Gathered *g, const struct GridRay *ray, __constant struct Frame *frame,
    __constant struct Volume *volume, __constant struct EmissionAbsorption *method, __global const VOXEL *voxels,
    __global const uchar *bricks, __global const Medium *table
#ifndef TF_2D
    , struct TableIntegral integral
#endif
) {
    struct CellCursor cursor = cursor_start(volume, ray);
    int brick = -1;
    for (;;) {
        int next_brick = brick_index(volume, cursor.cell);
        if (next_brick != brick) {
            brick = next_brick;
            if (!bricks[brick]) {
                if (!cursor_skip_brick(&cursor, volume, ray)) {
                    return;
                }
                continue;
            }
        }
        float exit = cursor_exit(&cursor, ray);
#ifdef TF_2D
        gather_cell(g, &cursor, ray, exit, frame, volume, voxels, table);
#else
        gather_cell(g, &cursor, ray, exit, frame, volume, voxels, table, integral);
#endif
        if (exit >= ray->t1 || is_opaque(g, method)) {
            return;
        }
        cursor_next(&cursor, ray);
    }
}

#endif

__kernel void render_emission_absorption(__constant struct Frame *frame, __constant struct Camera *camera,
    __constant struct Volume *volume, __constant struct EmissionAbsorption *method, __global const VOXEL *voxels,
    __global const uchar *bricks, __global const Medium *table, __global const Medium *table_high,
    __global const Medium *table_low, __global const uint *table_kinks, __global const float4 *environment,
    __global struct FilmPixel *film, uint first_tile, uint tile_count, uint first_sample, uint sample_count) {
    int pixel = frame_pixel(camera->width, camera->height, first_tile, tile_count);
    if (pixel < 0) {
        return;
    }
    uint2 seed = (uint2)(frame->seed_low, frame->seed_high);
    uint4 keys = philox4x32((uint4)((uint)pixel, 0u, 0u, 0u), seed);
    struct FilmPixel accumulated = film[pixel];
#ifndef TF_2D
    struct TableIntegral integral;
    integral.high = table_high;
    integral.low = table_low;
    integral.kinks = table_kinks;
#endif
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
#endif
        if (grid.t1 > grid.t0) {
#ifdef STEP
#ifdef JITTER
            float phase = random4(seed, (uint)pixel, sample, RNG_STEP_PHASE).x;
#else
            float phase = 0.5f;
#endif
            march(&g, &grid, phase, frame, volume, method, voxels, bricks, table);
#elif defined(TF_2D)
            march(&g, &grid, frame, volume, method, voxels, bricks, table);
#else
            march(&g, &grid, frame, volume, method, voxels, bricks, table, integral);
#endif
        }
        float transmittance = gathered_transmittance(&g);
        float3 radiance = transmittance * background_radiance(frame, environment, ray.direction);
#ifndef TRANSMITTANCE_ONLY
        radiance += method->radiance * g.radiance;
#endif
        film_add(&accumulated, (float4)(radiance, 1.0f - transmittance), -1.0f, g.lookups);
    }
    film[pixel] = accumulated;
}
