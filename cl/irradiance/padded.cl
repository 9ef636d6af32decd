// Boxes with one more cell on every side, which holds what comes in from outside: kernels read neighbours unasked.
//
// Elements are counted in `long`, from the work-item's number unshortened, and what steps write is `restrict`: compilers
// see then that work-items side by side read elements side by side, which makes CPUs three times as fast.
#include "irradiance/grid.cl"

INLINE long padded_row(__constant struct LightGrid *grid) {
    return grid->dims.x + 2;
}

INLINE long padded_slice(__constant struct LightGrid *grid) {
    return (long)(grid->dims.x + 2) * (grid->dims.y + 2);
}

// The element of a cell; coordinates from -1 to the number of cells.
INLINE long padded_at(__constant struct LightGrid *grid, long x, int y, int z) {
    return padded_slice(grid) * (z + 1) + padded_row(grid) * (y + 1) + 1 + x;
}

// The element of a cell in a box without padding.
INLINE long plain_at(__constant struct LightGrid *grid, long x, int y, int z) {
    return grid->dims.x * (y + (long)grid->dims.y * z) + x;
}

INLINE bool is_cell(__constant struct LightGrid *grid, int x, int y, int z) {
    return x >= 0 && x < grid->dims.x && y >= 0 && y < grid->dims.y && z >= 0 && z < grid->dims.z;
}

// The work-item's cell x, y, z; it ends where there is none. Not by `x >= grid->dims.x`: Intel's runtime for CPUs takes
// such a comparison of a number of the work-item with one from memory for a bound of its loop, gets that wrong, and does
// nothing at all.
#define FIND_LIGHT_CELL                                                                     \
    long x = (long)get_global_id(0);                                                        \
    int y = (int)get_global_id(1);                                                          \
    int z = (int)get_global_id(2);                                                          \
    if (max(max((int)x - grid->dims.x, y - grid->dims.y), z - grid->dims.z) >= 0) return;

// The work-item's element of the padded box, x, y, z from -1 on; it ends where there is none.
#define FIND_PADDED_CELL                                                                    \
    int x = (int)get_global_id(0) - 1;                                                      \
    int y = (int)get_global_id(1) - 1;                                                      \
    int z = (int)get_global_id(2) - 1;                                                      \
    if (x > grid->dims.x || y > grid->dims.y || z > grid->dims.z) return;
