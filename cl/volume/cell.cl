// Following a ray from cell to cell of the grid.
//
// A cell is the cube between eight voxel centres. Cell and brick boundaries are crossed at `plane_times`: the sequence of cells, and every number derived from it,
// is the same whether empty bricks are walked or skipped.
#include "volume/cubic.cl"

struct CellCursor {
    int4 cell;
    float4 exit; // time at which each axis leaves the cell
    float t;     // where the ray enters the cell
};

// Places the cursor at time t of the ray: on each axis in the cell whose entry plane is the last crossed at or
// before t. Truncation finds it up to one cell, plane times decide.
INLINE void cursor_seek(struct CellCursor *cursor, __constant struct Volume *volume, const struct GridRay *ray, float t) {
    int4 cell = clamp(convert_int4(grid_point(ray, t)), GRID_PAD - 1, volume->dims + (GRID_PAD - 1));
    float4 entry = plane_times(ray, convert_float4(cell + (1 - ray->ahead))) - ray->never;
    cell -= (entry > t) & ray->step;
    cell += (exit_times(ray, cell) <= t) & ray->step;
    cursor->cell = cell;
    cursor->exit = exit_times(ray, cell);
    cursor->t = t;
}

INLINE struct CellCursor cursor_start(__constant struct Volume *volume, const struct GridRay *ray) {
    struct CellCursor cursor;
    cursor_seek(&cursor, volume, ray, ray->t0);
    return cursor;
}

// Where the ray leaves the cell.
INLINE float cursor_exit(const struct CellCursor *cursor, const struct GridRay *ray) {
    return min(least3(cursor->exit), ray->t1);
}

// Steps into the next cell: across every face that the ray reaches first. No branches, they would be unpredictable.
INLINE void cursor_next(struct CellCursor *cursor, const struct GridRay *ray) {
    float t = least3(cursor->exit);
    cursor->cell += (cursor->exit <= t) & ray->step;
    cursor->exit = exit_times(ray, cursor->cell);
    cursor->t = t;
}

// The cubic of the cursor's cell from its entry to `exit`.
INLINE struct Cubic cursor_cubic(const struct CellCursor *cursor, const struct GridRay *ray, struct Corners corners,
    float exit) {
    float4 from = grid_point(ray, cursor->t) - convert_float4(cursor->cell);
    return cell_cubic(corners, from, (exit - cursor->t) * ray->direction);
}
