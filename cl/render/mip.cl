// Maximum intensity projection: the largest value of the trilinear field along the ray, exactly.
//
// Inside a cell the field is a cubic: its maximum lies at an end or where the derivative vanishes. Cells and
// bricks whose bound does not exceed the maximum so far are not looked into. Output: the maximum through the
// window and the colour map; depth: where the maximum is.
#include "film/accumulate.cl"
#include "render/background.cl"
#include "render/camera.cl"
#include "render/frame.cl"
#include "types/method.cl"
#include "volume/bricks.cl"

struct Maximum {
    float value; // stored value, negated when the file's slope is negative
    float t;
};

INLINE void consider(struct Maximum *maximum, float value, float t) {
    if (value > maximum->value) {
        maximum->value = value;
        maximum->t = t;
    }
}

// Largest value of the cubic on [0, 1]; `upper` bounds the cell's field and keeps rounding from exceeding it.
INLINE void cell_maximum(struct Maximum *maximum, struct Cubic p, float upper, float t, float length) {
    struct Maximum found = *maximum;
    consider(&found, p.a, t);
    consider(&found, p.a + p.b + p.c + p.d, t + length);
    float2 extrema = cubic_extrema(p);
    if (extrema.x < 1.0f) {
        consider(&found, cubic_value(p, extrema.x), t + extrema.x * length);
        consider(&found, cubic_value(p, extrema.y), t + extrema.y * length);
    }
    found.value = min(found.value, upper);
    consider(maximum, found.value, found.t);
}

__kernel void render_mip(__constant struct Frame *frame, __constant struct Camera *camera,
    __constant struct Volume *volume, __constant struct Mip *method, __global const VOXEL *voxels,
    __global const float *bricks, __global const float4 *colormap, __global const float4 *environment,
    __global struct FilmPixel *film, uint first_tile, uint tile_count, uint first_sample, uint sample_count) {
    int pixel = frame_pixel(camera->width, camera->height, first_tile, tile_count);
    if (pixel < 0) {
        return;
    }
    uint4 keys = philox4x32((uint4)((uint)pixel, 0u, 0u, 0u), (uint2)(frame->seed_low, frame->seed_high));
    struct FilmPixel accumulated = film[pixel];
    // The file's slope may be negative: then the largest value is the smallest stored one, and everything is negated.
    bool turned = volume->value_scale < 0.0f;
    for (uint turn = first_sample; turn < first_sample + sample_count; ++turn) {
        uint sample = frame_sample(frame, turn);
        struct CameraRay ray = camera_ray(camera, (uint)pixel, sample, keys);
        struct GridRay grid = grid_ray(volume, ray.origin, ray.direction, ray.t_min);
        uint lookups = 0;
        if (!(grid.t1 > grid.t0)) {
            film_add(&accumulated, (float4)(background_radiance(frame, environment, ray.direction), 0.0f), -1.0f, 0);
            continue;
        }
        struct Maximum maximum = {-INFINITY, 0.0f};
        struct CellCursor cursor = cursor_start(volume, &grid);
        for (;;) {
            if (bricks[brick_index(volume, cursor.cell)] <= maximum.value) {
                if (!cursor_skip_bricks(&cursor, volume, &grid, 1)) {
                    break;
                }
                continue;
            }
            float exit = cursor_exit(&cursor, &grid);
            struct Corners corners = fetch_cell(volume, voxels, cursor.cell);
            if (turned) {
                corners.low = -corners.low;
                corners.high = -corners.high;
            }
            float upper = corners_largest(corners);
            lookups += 1;
            if (upper > maximum.value) {
                struct Cubic p = cursor_cubic(&cursor, &grid, corners, exit);
                cell_maximum(&maximum, p, upper, cursor.t, exit - cursor.t);
            }
            if (exit >= grid.t1) {
                break;
            }
            cursor_next(&cursor, &grid);
        }
        float value = clamp(window_value(volume, turned ? -maximum.value : maximum.value), 0.0f, 1.0f);
        float3 color = (float3)(value);
        if (method->table_size > 0) {
            float x = value * (float)(method->table_size - 1);
            int i = min((int)x, (int)method->table_size - 2);
            color = mix(colormap[i].xyz, colormap[i + 1].xyz, x - (float)i);
        }
        film_add(&accumulated, (float4)(color * method->color.xyz, 1.0f), maximum.t - ray.t_min, lookups);
    }
    film[pixel] = accumulated;
}
