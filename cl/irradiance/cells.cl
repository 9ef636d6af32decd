// Volume averages of the medium over the cells of a light volume.
#include "irradiance/points.cl"

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
