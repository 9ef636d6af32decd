// Emission-absorption (Max 1995; Usher's ray caster): L = int T sigma_t c L0 dt + T(D) L_bg.
//
// Two quadratures: per cell (default), and STEP, at fixed steps.
//
// Inputs: voxels, bricks (see BRICK_*), the transfer function's table; output: film.
#include "film/accumulate.cl"
#include "irradiance/unlit.cl"
#include "render/background.cl"
#include "render/camera.cl"
#include "render/frame.cl"
#include "render/gathered.cl"
#include "volume/bricks.cl"
#ifdef STEP
#include "render/lattice.cl"
#else
#include "render/cells.cl"
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
    for (uint turn = first_sample; turn < first_sample + sample_count; ++turn) {
        uint sample = frame_sample(frame, turn);
        struct CameraRay ray = camera_ray(camera, (uint)pixel, sample, keys);
        struct GridRay grid = grid_ray(volume, ray.origin, ray.direction, ray.t_min);
        struct Gathered g = gathered_nothing();
        if (grid.t1 > grid.t0) {
#ifdef STEP
#ifdef JITTER
            float phase = random4(seed, (uint)pixel, sample, RNG_STEP_PHASE).x;
#else
            float phase = 0.5f;
#endif
            march(&g, &grid, phase, frame, volume, method, voxels, bricks, table);
#else
            march(&g, &grid, frame, volume, method, voxels, bricks, table, kinks_before, kink_entries, no_light());
#endif
        }
        float transmittance = gathered_transmittance(&g);
        float3 radiance = transmittance * background_radiance(frame, environment, ray.direction);
#ifndef TRANSMITTANCE_ONLY
        radiance += method->radiance * g.radiance.xyz;
#endif
        film_add(&accumulated, (float4)(radiance, gathered_opacity(&g)), -1.0f, g.lookups);
    }
    film[pixel] = accumulated;
}
