// What direct light becomes where it is scattered for the first time: the source of the diffusion equation.
#include "irradiance/between.cl"
#include "irradiance/points.cl"

// A field of another grid over the same box, known at the centres of its cells, at one of the points that are spread
// evenly over them; `place`: in its cells. The mean over a cell is to be that of a smooth field, which is the value at the
// centre and 1/24 of the second difference along each axis. Linear between the centres, that is three times as much: so
// the points count a third as far from the centre as they are. Beyond the outermost centres the slope goes on. `known`:
// share of each edge over which the field is a mean already, whose square is not missing.
INLINE float4 light_between(__constant struct LightGrid *grid, __global const float4 *field, float4 place, float4 cell,
    float known) {
    int4 last = max(grid->dims - 1, (int4)(0));
    float4 position = cell + (place - 0.5f - cell) * ((1.0f - known * known) * (1.0f / 3.0f));
    int4 low = clamp(convert_int4(floor(position)), (int4)(0), max(last - 1, (int4)(0)));
    return between_cells(field, grid->dims, low, min(low + 1, last), position - convert_float4(low));
}

// The power that each cell's volume sends into scattered light: the mean of sigma_s (1 - g) times the fluence of direct
// light, 0 or more, and what the medium emits. `forward`: g. `spread`: whether direct light is that of parts of its cells, as
// `extents` tells, instead of that of their centres; then `places` is where in its cell the light is scattered, on
// average: from -1 to 1 along each axis, as far as light at centres does not stand for all of a cell.
__kernel void irradiance_source(__constant struct Frame *frame, __constant struct Volume *volume,
    __constant struct Scattering *method, __global const VOXEL *voxels, __global const float2 *bounds,
    __global const float *sigmas, __global const float4 *colors, __global const float4 *emissions,
    __constant struct LightGrid *grid, __constant struct LightGrid *direct_grid, __global const float4 *direct,
    __global const float4 *glow, __global const float4 *extents,
    __global float4 *source, __global float4 *places, float forward, uint spread) {
    uint index = (uint)get_global_id(0);
    if (index >= cell_count(grid)) {
        return;
    }
    struct CellPoints points = cell_points(volume, grid, cell_of(grid, index));
    float4 cells = 1.0f / (float4)(direct_grid->cell.xyz, 1.0f);
    // Where only the centres of direct light's cells are known and do not resolve the medium, a dense one could scatter
    // more of it than meets the cell: twice that is allowed, as about half of such centres are in the dark.
    float4 edges = direct_grid->cell;
    float most = 2.0f / min(min(edges.x, edges.y), edges.z);
    float4 sum = (float4)(0.0f);
    float4 moment = (float4)(0.0f);
    float4 coarse = 2.0f / (float4)(grid->cell.xyz, 1.0f);
    float4 centre = cell_centre(grid, cell_of(grid, index));
    for (int k = 0; k < points.count.z; ++k) {
        for (int j = 0; j < points.count.y; ++j) {
            for (int i = 0; i < points.count.x; ++i) {
                float4 point = points.first + points.step * (float4)((float)i, (float)j, (float)k, 0.0f);
                struct PointMedium medium =
                    medium_at_point(frame, volume, method, voxels, sigmas, colors, emissions, point);
                float4 transport = medium.absorption + (1.0f - forward) * medium.scattering;
                float4 place = point * cells;
                float4 cell = clamp(floor(place), (float4)(0.0f), convert_float4(max(direct_grid->dims - 1, (int4)(0))));
                float4 known = (float4)(0.0f);
                if (spread != 0u) {
                    known = extents[cell_index(direct_grid, convert_int4(cell))];
                }
                float4 light = light_between(direct_grid, direct, place, cell, known.w);
                float4 capped = min(medium.scattering, medium.scattering * (most / max(transport, 1e-30f)));
                float4 power = (known.w > 0.0f ? medium.scattering : capped) * light;
                sum += power;
                // All of a direct light's cell is scattered at its own place.
                float4 from_centre = (cell + 0.5f + 0.5f * known) * edges - centre;
                moment += (power.x + power.y + power.z) * known.w * clamp(from_centre * coarse, -1.0f, 1.0f);
            }
        }
    }
    float4 power = (1.0f - forward) * point_share(points) * sum;
#ifdef EMISSION
    power += glow[index];
#endif
    float total = sum.x + sum.y + sum.z;
    if (spread != 0u) {
        places[index] = total > 0.0f ? clamp(moment / total, -1.0f, 1.0f) : (float4)(0.0f);
    }
    // Estimates may be below 0; what is not a number stays so, and is refused later.
    source[index] = select(power, (float4)(0.0f), power < 0.0f);
}
