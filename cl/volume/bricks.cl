// Bricks: cubes of cells with known bounds of the field, to skip what cannot matter.
#include "volume/cell.cl"

INLINE int brick_index(__constant struct Volume *volume, int4 cell) {
    int4 offset = (cell >> volume->bricks.w) * volume->bricks;
    return offset.x + offset.y + offset.z;
}

// Where the strides of a ray's octant start in a table of strides: bit 0 is set for rays towards larger x, and so on.
INLINE int stride_table(__constant struct Volume *volume, const struct GridRay *ray) {
    return (ray->ahead.x + 2 * ray->ahead.y + 4 * ray->ahead.z) * volume->octant;
}

// Where a ray that is in `cell` leaves the cube of `reach` bricks per edge that starts at the cell's brick and extends
// along the ray. Not clipped to the box.
INLINE float brick_exit(__constant struct Volume *volume, const struct GridRay *ray, int4 cell, int reach) {
    int shift = volume->bricks.w;
    int4 plane = ((cell >> shift) + (1 - reach) + ray->ahead * (2 * reach - 1)) << shift;
    return least3(plane_times(ray, convert_float4(plane)));
}

// Moves the cursor behind that cube. Returns false when that leaves the box.
INLINE bool cursor_skip_bricks(struct CellCursor *cursor, __constant struct Volume *volume, const struct GridRay *ray,
    int reach) {
    float t = brick_exit(volume, ray, cursor->cell, reach);
    if (!(t < ray->t1)) {
        return false;
    }
    cursor_seek(cursor, volume, ray, t);
    return true;
}
