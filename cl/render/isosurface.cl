// Isosurface: the first crossing of the trilinear field with a value, exactly, then local shading.
//
// Inside a cell the field minus the value is a cubic g. Its derivative's roots cut the cell into pieces where g is
// monotone, so a sign change brackets exactly one root: even numbers of roots are not missed. The sign is carried
// from cell to cell, so a crossing on a shared face is found even when rounding moves it. Where the ray enters the
// box inside the surface, the box's face is not a surface.
#include "film/accumulate.cl"
#include "render/background.cl"
#include "render/camera.cl"
#include "render/frame.cl"
#include "types/light.cl"
#include "types/method.cl"
#include "volume/bricks.cl"

// First s in [0, 1] where g changes sign, or -1. `*positive`: sign of g before; updated to the sign after.
INLINE float first_crossing(struct Cubic g, bool *positive) {
    float2 extrema = cubic_extrema(g);
    float lo = 0.0f;
    bool sign = *positive;
    if ((g.a >= 0.0f) != sign) {
        *positive = !sign;
        return 0.0f;
    }
    for (int piece = 0; piece < 3; ++piece) {
        float hi = piece == 0 ? extrema.x : piece == 1 ? extrema.y : 1.0f;
        if (hi > lo) {
            bool sign_hi = cubic_value(g, hi) >= 0.0f;
            if (sign_hi != sign) {
                *positive = sign_hi;
                return bracketed_root(g, lo, hi, sign);
            }
            lo = hi;
        }
    }
    return -1.0f;
}

// What is known of a brick: 0 when it contains the surface, else how many bricks the ray can stride over, with the
// top bit set where they are inside (at or above the value). Free bricks that touch share a face of voxels, so they
// are on the same side.
#define BRICK_INSIDE 0x80

// Distance along the ray to the first crossing, or -INFINITY.
INLINE float find_surface(__constant struct Volume *volume, const struct GridRay *ray, __global const VOXEL *voxels,
    __global const uchar *bricks, float iso, uint *lookups) {
    struct CellCursor cursor = cursor_start(volume, ray);
    bricks += stride_table(volume, ray);
    bool known = false; // whether `positive` is the sign where the cursor stands
    bool positive = false;
    for (;;) {
        uchar brick = bricks[brick_index(volume, cursor.cell)];
        struct Corners corners;
        bool inside = brick & BRICK_INSIDE;
        bool crossed = false; // whether the surface runs through the cell
        if (brick == 0) {
            corners = fetch_cell(volume, voxels, cursor.cell);
            *lookups += 1;
            inside = corners_least(corners) >= iso;
            crossed = !inside && corners_largest(corners) >= iso;
        }
        float exit = cursor_exit(&cursor, ray);
        if (crossed) {
            struct Cubic g = cursor_cubic(&cursor, ray, corners, exit);
            g.a -= iso;
            positive = known ? positive : g.a >= 0.0f;
            float s = first_crossing(g, &positive);
            if (s >= 0.0f) {
                return cursor.t + s * (exit - cursor.t);
            }
        } else {
            if (known && inside != positive) {
                return cursor.t; // the change of side happened on the face
            }
            positive = inside;
        }
        known = true;
        if (brick != 0) {
            if (!cursor_skip_bricks(&cursor, volume, ray, brick & ~BRICK_INSIDE)) {
                return -INFINITY;
            }
        } else if (exit >= ray->t1) {
            return -INFINITY;
        } else {
            cursor_next(&cursor, ray);
        }
    }
}

// Ambient + Lambert (albedo / pi) + Blinn-Phong (unnormalised lobe, as in the rasterisers it comes from).
INLINE float3 shade(__constant struct Isosurface *method, __constant struct Light *lights, uint light_count,
    float3 point, float3 normal, float3 view) {
    float3 albedo = method->albedo.xyz;
    float3 radiance = method->ambient * albedo;
    for (uint i = 0; i < light_count; ++i) {
        float4 position = lights[i].position;
        int kind = (int)position.w;
        bool placed = kind == LIGHT_POINT;
        float3 to_light = placed ? position.xyz - point : kind == LIGHT_HEADLIGHT ? view : -position.xyz;
        float distance2 = dot(to_light, to_light);
        to_light *= rsqrt(distance2);
        float3 irradiance = lights[i].power.xyz / (placed ? distance2 : 1.0f);
        float cosine = dot(normal, to_light);
        if (cosine > 0.0f) {
            float3 middle = normalize(to_light + view);
            float lobe = pow(max(dot(normal, middle), 0.0f), method->shininess);
            radiance += irradiance * (method->diffuse * cosine * M_1_PI_F * albedo + method->specular * lobe * M_1_PI_F);
        }
    }
    return radiance;
}

__kernel void render_isosurface(__constant struct Frame *frame, __constant struct Camera *camera,
    __constant struct Volume *volume, __constant struct Isosurface *method, __global const VOXEL *voxels,
    __global const uchar *bricks, __constant struct Light *lights, __global const float4 *environment,
    __global struct FilmPixel *film, uint first_tile, uint tile_count, uint first_sample, uint sample_count) {
    int pixel = frame_pixel(camera->width, camera->height, first_tile, tile_count);
    if (pixel < 0) {
        return;
    }
    uint4 keys = philox4x32((uint4)((uint)pixel, 0u, 0u, 0u), (uint2)(frame->seed_low, frame->seed_high));
    struct FilmPixel accumulated = film[pixel];
    for (uint turn = first_sample; turn < first_sample + sample_count; ++turn) {
        uint sample = frame_sample(frame, turn);
        struct CameraRay ray = camera_ray(camera, (uint)pixel, sample, keys);
        struct GridRay grid = grid_ray(volume, ray.origin, ray.direction, ray.t_min);
        uint lookups = 0;
        float t = -INFINITY;
        if (grid.t1 > grid.t0) {
            t = find_surface(volume, &grid, voxels, bricks, method->iso, &lookups);
        }
        if (t < grid.t0) {
            float3 behind = background_radiance(frame, environment, ray.direction);
            film_add(&accumulated, (float4)(behind, 0.0f), -1.0f, lookups);
            continue;
        }
        // Towards the viewer, whichever side is the inside.
        float3 gradient = gradient_raw(volume, voxels, grid_point(&grid, t));
        lookups += 6;
        float length2 = dot(gradient, gradient);
        float3 normal = length2 > 0.0f ? gradient * rsqrt(length2) : -ray.direction;
        normal = dot(normal, ray.direction) > 0.0f ? -normal : normal;
        float3 point = ray.origin + t * ray.direction;
        float3 radiance = shade(method, lights, frame->light_count, point, normal, -ray.direction);
        film_add(&accumulated, (float4)(radiance, 1.0f), t - ray.t_min, lookups);
    }
    film[pixel] = accumulated;
}
