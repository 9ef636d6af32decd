// Following a ray from cell to cell of the grid, and the field along it.
//
// A cell is the cube between eight voxel centres. Inside it the trilinear field along a ray is a cubic.
// Cell (and brick) boundaries are crossed at `plane_time`, always recomputed from the integer plane: the
// sequence of cells, and every number derived from it, is the same whether empty bricks are walked or skipped.
#include "volume/sampling.cl"

struct CellCursor {
    int3 cell;
    int3 step;    // +1, -1, or 0 where the ray is parallel
    float3 exit;  // time at which each axis leaves the cell; +inf where parallel
    float t;      // where the ray enters the cell
};

inline float axis_exit(int cell, int step, float origin, float inverse) {
    return step == 0 ? INFINITY : plane_time((float)(cell + (step > 0)), origin, inverse);
}

// The cell of one axis at time t: the one whose entry plane is the last crossed at or before t.
inline int axis_cell(float t, int step, float origin, float direction, float inverse, int last) {
    int cell = clamp((int)(origin + t * direction), GRID_PAD - 1, last);
    if (step > 0) {
        while (cell < last && plane_time((float)(cell + 1), origin, inverse) <= t) cell += 1;
        while (cell > GRID_PAD - 1 && plane_time((float)cell, origin, inverse) > t) cell -= 1;
    } else if (step < 0) {
        while (cell > GRID_PAD - 1 && plane_time((float)cell, origin, inverse) <= t) cell -= 1;
        while (cell < last && plane_time((float)(cell + 1), origin, inverse) > t) cell += 1;
    }
    return cell;
}

// Places the cursor at time t of the ray.
inline void cursor_seek(struct CellCursor *cursor, __constant struct Volume *volume, const struct GridRay *ray, float t) {
    int3 last = volume->dims.xyz + (GRID_PAD - 1);
    int3 s = cursor->step;
    float3 o = ray->origin;
    float3 d = ray->direction;
    float3 inv = ray->inverse;
    int3 cell;
    cell.x = axis_cell(t, s.x, o.x, d.x, inv.x, last.x);
    cell.y = axis_cell(t, s.y, o.y, d.y, inv.y, last.y);
    cell.z = axis_cell(t, s.z, o.z, d.z, inv.z, last.z);
    cursor->cell = cell;
    cursor->exit = (float3)(
        axis_exit(cell.x, s.x, o.x, inv.x), axis_exit(cell.y, s.y, o.y, inv.y), axis_exit(cell.z, s.z, o.z, inv.z));
    cursor->t = t;
}

inline struct CellCursor cursor_start(__constant struct Volume *volume, const struct GridRay *ray) {
    struct CellCursor cursor;
    float3 d = ray->direction;
    cursor.step = (int3)((d.x > 0.0f) - (d.x < 0.0f), (d.y > 0.0f) - (d.y < 0.0f), (d.z > 0.0f) - (d.z < 0.0f));
    cursor_seek(&cursor, volume, ray, ray->t0);
    return cursor;
}

// Where the ray leaves the cell.
inline float cursor_exit(const struct CellCursor *cursor, const struct GridRay *ray) {
    return fmin(fmin(cursor->exit.x, cursor->exit.y), fmin(cursor->exit.z, ray->t1));
}

// Steps into the next cell along the axis that is left first.
inline void cursor_next(struct CellCursor *cursor, const struct GridRay *ray) {
    float3 exit = cursor->exit;
    if (exit.x <= exit.y && exit.x <= exit.z) {
        cursor->t = exit.x;
        cursor->cell.x += cursor->step.x;
        cursor->exit.x = axis_exit(cursor->cell.x, cursor->step.x, ray->origin.x, ray->inverse.x);
    } else if (exit.y <= exit.z) {
        cursor->t = exit.y;
        cursor->cell.y += cursor->step.y;
        cursor->exit.y = axis_exit(cursor->cell.y, cursor->step.y, ray->origin.y, ray->inverse.y);
    } else {
        cursor->t = exit.z;
        cursor->cell.z += cursor->step.z;
        cursor->exit.z = axis_exit(cursor->cell.z, cursor->step.z, ray->origin.z, ray->inverse.z);
    }
}

// The field along the ray inside a cell: value(s) = a + b s + c s^2 + d s^3, s in [0, 1] from entry to exit.
struct Cubic {
    float a, b, c, d;
};

inline float cubic_value(struct Cubic p, float s) {
    return p.a + s * (p.b + s * (p.c + s * p.d));
}

// `from`: position in the cell (0 to 1 per axis) where the segment starts; `along`: the segment.
inline struct Cubic cell_cubic(struct Corners c, float3 from, float3 along) {
    // Interpolating axis by axis raises the degree by one each time.
    float4 z0 = c.low + from.z * (c.high - c.low);
    float4 z1 = along.z * (c.high - c.low);
    float2 y0 = z0.xy + from.y * (z0.zw - z0.xy);
    float2 y1 = z1.xy + from.y * (z1.zw - z1.xy) + along.y * (z0.zw - z0.xy);
    float2 y2 = along.y * (z1.zw - z1.xy);
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

// The cubic of the cursor's cell between times t_in and t_out.
inline struct Cubic cursor_cubic(const struct CellCursor *cursor, const struct GridRay *ray, struct Corners corners,
    float t_in, float t_out) {
    float3 from = grid_point(ray, t_in) - convert_float3(cursor->cell);
    return cell_cubic(corners, from, (t_out - t_in) * ray->direction);
}
