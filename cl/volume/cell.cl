// Following a ray from cell to cell of the grid, and the field along it.
//
// A cell is the cube between eight voxel centres. Inside it the trilinear field along a ray is a cubic.
// Cell and brick boundaries are crossed at `plane_times`: the sequence of cells, and every number derived from it,
// is the same whether empty bricks are walked or skipped.
#include "volume/sampling.cl"

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

// The field along the ray inside a cell: value(s) = a + b s + c s^2 + d s^3, s in [0, 1] from entry to exit.
struct Cubic {
    float a, b, c, d;
};

INLINE float cubic_value(struct Cubic p, float s) {
    return p.a + s * (p.b + s * (p.c + s * p.d));
}

// `from`: position in the cell (0 to 1 per axis) where the segment starts; `along`: the segment.
INLINE struct Cubic cell_cubic(struct Corners c, float4 from, float4 along) {
    // Interpolating axis by axis raises the degree by one each time.
    float4 slope = c.high - c.low;
    float4 z0 = c.low + from.z * slope;
    float4 z1 = along.z * slope;
    float2 slope0 = z0.zw - z0.xy;
    float2 slope1 = z1.zw - z1.xy;
    float2 y0 = z0.xy + from.y * slope0;
    float2 y1 = z1.xy + from.y * slope1 + along.y * slope0;
    float2 y2 = along.y * slope1;
    float e0 = y0.y - y0.x;
    float e1 = y1.y - y1.x;
    float e2 = y2.y - y2.x;
    struct Cubic p;
    p.a = y0.x + from.x * e0;
    p.b = y1.x + from.x * e1 + along.x * e0;
    p.c = y2.x + from.x * e2 + along.x * e1;
    p.d = along.x * e2;
    return p;
}

// The cubic of the cursor's cell from its entry to `exit`.
INLINE struct Cubic cursor_cubic(const struct CellCursor *cursor, const struct GridRay *ray, struct Corners corners,
    float exit) {
    float4 from = grid_point(ray, cursor->t) - convert_float4(cursor->cell);
    return cell_cubic(corners, from, (exit - cursor->t) * ray->direction);
}
