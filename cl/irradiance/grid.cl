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
