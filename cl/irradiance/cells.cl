// Volume averages of the medium over the cells of a light volume, and how much of a cell its direct light has to know.
#include "irradiance/points.cl"
#include "types/light.cl"

#define FOUR_PI 12.566370614f

// Scattering and absorption per local unit; glow: 4 pi sigma_a L_e, the power that a volume emits.
__kernel void irradiance_cells(__constant struct Frame *frame, __constant struct Volume *volume,
    __constant struct Scattering *method, __global const VOXEL *voxels, __global const float2 *bounds,
    __global const float *sigmas, __global const float4 *colors, __global const float4 *emissions,
    __constant struct LightGrid *grid, __global float4 *scattering, __global float4 *absorption,
    __global float4 *glow) {
    uint index = (uint)get_global_id(0);
    if (index >= cell_count(grid)) {
        return;
    }
    struct CellPoints points = cell_points(volume, grid, cell_of(grid, index));
    float4 scattered = (float4)(0.0f);
    float4 absorbed = (float4)(0.0f);
    float4 emitted = (float4)(0.0f);
    for (int k = 0; k < points.count.z; ++k) {
        for (int j = 0; j < points.count.y; ++j) {
            for (int i = 0; i < points.count.x; ++i) {
                float4 point = points.first + points.step * (float4)((float)i, (float)j, (float)k, 0.0f);
                struct PointMedium medium =
                    medium_at_point(frame, volume, method, voxels, sigmas, colors, emissions, point);
                scattered += medium.scattering;
                absorbed += medium.absorption;
                emitted += medium.absorption * medium.emission;
            }
        }
    }
    float share = point_share(points);
    scattering[index] = share * scattered;
    absorption[index] = share * absorbed;
#ifdef EMISSION
    glow[index] = FOUR_PI * share * emitted;
#endif
}

// Optical thickness of a cell from which its centre stands no longer for all of it, and by how much more only the mean
// over the cell will do.
#define THIN 0.5f
#define FADE 0.25f
// The same for the distance of a point light, in the longest edge of a cell, towards it.
#define FAR 2.5f

// Per cell of direct light: over what share of each edge, about the centre, light has to be a mean, 0 where the value at
// the centre will do and 1 where cells are thick or a point light is near; and the mean extinction there, per local unit.
__kernel void irradiance_extents(__constant struct Frame *frame, __constant struct Volume *volume,
    __constant struct Scattering *method, __global const VOXEL *voxels, __global const float2 *bounds,
    __global const float *sigmas, __global const float4 *colors, __global const float4 *emissions,
    __global const struct Light *lights, __constant struct LightGrid *grid, __global float2 *extents) {
    uint index = (uint)get_global_id(0);
    if (index >= cell_count(grid)) {
        return;
    }
    int4 cell = cell_of(grid, index);
    struct CellPoints points = cell_points(volume, grid, cell);
    float4 centre = cell_centre(grid, cell);
    float edge = max(max(grid->cell.x, grid->cell.y), grid->cell.z);
    float near = 0.0f;
    for (uint i = 0; i < frame->light_count; ++i) {
        if ((int)lights[i].position.w == LIGHT_POINT) {
            float4 way = lights[i].position - centre;
            way.w = 0.0f;
            near = max(near, clamp(FAR - sqrt(dot(way, way)) / edge, 0.0f, 1.0f));
        }
    }
    // Over the whole cell, then over the share of it that is wanted.
    float share = 1.0f;
    float mean = 0.0f;
    for (int turn = 0; turn < 2; ++turn) {
        float sum = 0.0f;
        for (int k = 0; k < points.count.z; ++k) {
            for (int j = 0; j < points.count.y; ++j) {
                for (int i = 0; i < points.count.x; ++i) {
                    float4 point = points.first + points.step * (float4)((float)i, (float)j, (float)k, 0.0f);
                    point = centre + share * (point - centre);
                    sum += extinction_at_point(frame, volume, method, voxels, sigmas, point);
                }
            }
        }
        mean = point_share(points) * sum;
        if (turn == 0) {
            share = max(near, clamp((mean * edge - THIN) / FADE, 0.0f, 1.0f));
        }
    }
    extents[index] = (float2)(share, mean);
}
