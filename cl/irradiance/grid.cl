// Cells of a light volume.
#include "common/inline.cl"
#include "types/irradiance.cl"

INLINE uint cell_count(__constant struct LightGrid *grid) {
    return (uint)grid->dims.x * (uint)grid->dims.y * (uint)grid->dims.z;
}

// The cell of an index; w = 0.
INLINE int4 cell_of(__constant struct LightGrid *grid, uint index) {
    uint nx = (uint)grid->dims.x;
    uint ny = (uint)grid->dims.y;
    return (int4)((int)(index % nx), (int)(index / nx % ny), (int)(index / (nx * ny)), 0);
}

// The index of a cell.
INLINE uint cell_index(__constant struct LightGrid *grid, int4 cell) {
    return ((uint)cell.z * (uint)grid->dims.y + (uint)cell.y) * (uint)grid->dims.x + (uint)cell.x;
}

// A cell's centre in local units; w = 0.
INLINE float4 cell_centre(__constant struct LightGrid *grid, int4 cell) {
    float4 centre = (convert_float4(cell) + 0.5f) * grid->cell;
    centre.w = 0.0f;
    return centre;
}

// Where the ray from `from` along `direction` is in a box: in and out; nowhere, they are the same. `half_edges`: of the box.
INLINE float2 way_in_box(float4 from, float4 direction, float4 centre, float4 half_edges) {
    float4 inverse = 1.0f / select(direction, (float4)(1e-20f), fabs(direction) < 1e-20f);
    float4 middle = (centre - from) * inverse;
    float4 reach = half_edges * fabs(inverse);
    float4 enter = middle - reach;
    float4 leave = middle + reach;
    float first = max(max(enter.x, 0.0f), max(enter.y, enter.z));
    return (float2)(first, max(first, min(leave.x, min(leave.y, leave.z))));
}
