// What direct light becomes where it is scattered for the first time: the source of the diffusion equation.
#include "irradiance/between.cl"
#include "irradiance/points.cl"

// A field of another grid over the same box, known at the centres of its cells, at one of the points that are spread
// evenly over them; `place`: in its cells. The mean over a cell is to be that of a smooth field, which is the value at the
// centre and 1/24 of the second difference along each axis. Linear between the centres, that is three times as much: so
// the points count a third as far from the centre as they are. Beyond the outermost centres the slope goes on.
INLINE float4 light_between(__constant struct LightGrid *grid, __global const float4 *field, float4 place) {
    int4 last = max(grid->dims - 1, 0);
    float4 centre = clamp(floor(place), (float4)(0.0f), convert_float4(last));
    float4 position = centre + (place - 0.5f - centre) * (1.0f / 3.0f);
    int4 low = clamp(convert_int4(floor(position)), (int4)(0), max(last - 1, 0));
    return between_cells(field, grid->dims, low, min(low + 1, last), position - convert_float4(low));
}

// The power that each cell's volume sends into scattered light: the mean of sigma_s (1 - g) times the fluence of direct
// light, 0 or more, and what the medium emits. `forward`: g.
__kernel void irradiance_source(__constant struct Frame *frame, __constant struct Volume *volume,
    __constant struct Scattering *method, __global const VOXEL *voxels, __global const float2 *bounds,
    __global const float *sigmas, __global const float4 *colors, __global const float4 *emissions,
    __constant struct LightGrid *grid, __constant struct LightGrid *direct_grid, __global const float4 *direct,
    __global const float4 *glow, __global float4 *source, float forward) {
    uint index = (uint)get_global_id(0);
    if (index >= cell_count(grid)) {
        return;
    }
    struct CellPoints points = cell_points(volume, grid, cell_of(grid, index));
    float4 cells = 1.0f / (float4)(direct_grid->cell.xyz, 1.0f);
    float4 sum = (float4)(0.0f);
    for (int k = 0; k < points.count.z; ++k) {
        for (int j = 0; j < points.count.y; ++j) {
            for (int i = 0; i < points.count.x; ++i) {
                float4 point = points.first + points.step * (float4)((float)i, (float)j, (float)k, 0.0f);
                struct PointMedium medium =
                    medium_at_point(frame, volume, method, voxels, sigmas, colors, emissions, point);
                sum += medium.scattering * light_between(direct_grid, direct, point * cells);
            }
        }
    }
    float4 power = (1.0f - forward) * point_share(points) * sum;
#ifdef EMISSION
    power += glow[index];
#endif
    // Estimates may be below 0; what is not a number stays so, and is refused later.
    source[index] = select(power, (float4)(0.0f), power < 0.0f);
}
