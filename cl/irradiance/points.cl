// The medium at evenly spaced points of a light volume's cells: two per voxel and axis, between which the field is
// smooth.
#include "irradiance/grid.cl"
#include "types/path.cl"
#include "volume/tables.cl"

// A cell's points: first + step * (i, j, k), local units; i, j, k < count per axis.
struct CellPoints {
    float4 first;
    float4 step;
    int4 count;
};

INLINE struct CellPoints cell_points(__constant struct Volume *volume, __constant struct LightGrid *grid, int4 cell) {
    struct CellPoints points;
    int4 dims = max(grid->dims, (int4)(1));
    points.count = 2 * ((volume->dims + dims - 1) / dims);
    points.step = grid->cell / convert_float4(max(points.count, (int4)(1)));
    points.first = convert_float4(cell) * grid->cell + 0.5f * points.step;
    return points;
}

// One over the number of points.
INLINE float point_share(struct CellPoints points) {
    return 1.0f / (float)(points.count.x * points.count.y * points.count.z);
}

// The extinction at a point, per local unit.
INLINE float extinction_at_point(__constant struct Frame *frame, __constant struct Volume *volume,
    __constant struct Scattering *method, __global const VOXEL *voxels, __global const float *sigmas, float4 point) {
#ifdef CONSTANT_SIGMA
    return method->sigma;
#else
    float value, row;
    return sigma_at(frame, volume, voxels, sigmas, point * volume->scale + GRID_LOW, &value, &row);
#endif
}

// The medium at a point: coefficients per local unit, and the radiance it emits.
struct PointMedium {
    float4 scattering;
    float4 absorption;
    float4 emission;
};

INLINE struct PointMedium medium_at_point(__constant struct Frame *frame, __constant struct Volume *volume,
    __constant struct Scattering *method, __global const VOXEL *voxels, __global const float *sigmas,
    __global const float4 *colors, __global const float4 *emissions, float4 point) {
    struct PointMedium medium;
    float4 albedo = method->albedo;
    medium.emission = (float4)(0.0f);
#ifdef CONSTANT_SIGMA
    float sigma = method->sigma;
#else
    float value, row;
    float sigma = sigma_at(frame, volume, voxels, sigmas, point * volume->scale + GRID_LOW, &value, &row);
#if !defined(CONSTANT_ALBEDO) || defined(EMISSION)
    struct TablePlace place = table_place(frame, value, row);
#endif
#ifndef CONSTANT_ALBEDO
    albedo = table_color(frame, colors, place);
#endif
#ifdef EMISSION
    medium.emission = table_color(frame, emissions, place);
#endif
#endif
    float4 extinction = (float4)(sigma, sigma, sigma, 0.0f);
#ifdef CHROMATIC
    extinction *= method->extinction;
#endif
    medium.scattering = albedo * extinction;
    medium.absorption = (1.0f - albedo) * extinction;
    return medium;
}
