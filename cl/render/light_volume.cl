// Projection of a light volume: L = int T (sigma_s L_s + sigma_a L_e) dt + T(D) L_bg, where L_s is the light that the
// volume holds for the place (physics: Zhang & Ma 2013; Lesar, Bohak and Marolt), cell by cell as emission-absorption.
//
// Inputs: voxels, bricks (see BRICK_*), the transfer function's table, the light; output: film.
#define LIT 1
#include "film/accumulate.cl"
#include "irradiance/light.cl"
#include "render/background.cl"
#include "render/camera.cl"
#include "render/cells.cl"
#include "render/frame.cl"

__kernel void render_light_volume(__constant struct Frame *frame, __constant struct Camera *camera,
    __constant struct Volume *volume, __constant struct EmissionAbsorption *method, __global const VOXEL *voxels,
    __global const uchar *bricks, __global const Medium *table, __global const uint *kinks_before,
    __global const uint *kink_entries, __global const float4 *environment, __constant struct LightGrid *light_grid,
    __global const float4 *light, __global const float4 *drift, __global const float4 *direct, __global const float4 *flow,
    __global struct FilmPixel *film, uint first_tile, uint tile_count, uint first_sample, uint sample_count) {
    int pixel = frame_pixel(camera->width, camera->height, first_tile, tile_count);
    if (pixel < 0) {
        return;
    }
    uint2 seed = (uint2)(frame->seed_low, frame->seed_high);
    uint4 keys = philox4x32((uint4)((uint)pixel, 0u, 0u, 0u), seed);
    struct Lit lit;
    lit.grid = light_grid;
    lit.volume = volume;
    lit.light = light;
#ifdef DIRECTED
    lit.method = method;
    lit.drift = drift;
    lit.direct = direct;
    lit.flow = flow;
#endif
    struct FilmPixel accumulated = film[pixel];
    for (uint turn = first_sample; turn < first_sample + sample_count; ++turn) {
        uint sample = frame_sample(frame, turn);
        struct CameraRay ray = camera_ray(camera, (uint)pixel, sample, keys);
        struct GridRay grid = grid_ray(volume, ray.origin, ray.direction, ray.t_min);
        struct Gathered g = gathered_nothing();
        if (grid.t1 > grid.t0) {
#ifdef DIRECTED
            lit.towards = (float4)(-ray.direction, 0.0f);
#endif
            march(&g, &grid, frame, volume, method, voxels, bricks, table, kinks_before, kink_entries, lit);
        }
        Through through = gathered_transmittance(&g);
        float4 behind = (float4)(background_radiance(frame, environment, ray.direction), 0.0f);
        float4 radiance = g.radiance + through * behind;
        radiance.w = gathered_opacity(&g);
        film_add(&accumulated, radiance, -1.0f, g.lookups);
    }
    film[pixel] = accumulated;
}
