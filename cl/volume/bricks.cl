// Bricks: cubes of cells with known bounds of the field, to skip what cannot matter.
#include "volume/cell.cl"

inline int brick_index(__constant struct Volume *volume, int3 cell) {
    int shift = volume->bricks.w;
    return ((cell.z >> shift) * volume->bricks.y + (cell.y >> shift)) * volume->bricks.x + (cell.x >> shift);
}

inline float axis_brick_exit(int cell, int step, int shift, float origin, float inverse) {
    int brick = cell >> shift;
    return step == 0 ? INFINITY : plane_time((float)((brick + (step > 0)) << shift), origin, inverse);
}

// Where a ray that is in `cell` leaves that cell's brick (not clipped to the box).
inline float brick_exit(__constant struct Volume *volume, const struct GridRay *ray, int3 cell, int3 step) {
    int shift = volume->bricks.w;
    float x = axis_brick_exit(cell.x, step.x, shift, ray->origin.x, ray->inverse.x);
    float y = axis_brick_exit(cell.y, step.y, shift, ray->origin.y, ray->inverse.y);
    float z = axis_brick_exit(cell.z, step.z, shift, ray->origin.z, ray->inverse.z);
    return fmin(fmin(x, y), z);
}

// Moves the cursor behind its brick. Returns false when that leaves the box.
inline bool cursor_skip_brick(struct CellCursor *cursor, __constant struct Volume *volume, const struct GridRay *ray) {
    float t = brick_exit(volume, ray, cursor->cell, cursor->step);
    if (!(t < ray->t1)) {
        return false;
    }
    cursor_seek(cursor, volume, ray, t);
    return true;
}
