// Direct light by upwind convection (Zhang & Ma 2013, equation 8; Courant et al. 1952): the share of a light's light
// that reaches each cell.
//
// Shares are boxes of REAL with padding that holds the light's own value, 1: what comes in. What goes out is not
// looked at. In the slab of cells that a point light lies in, light does not travel across the slab: the direction
// there is that without this axis, so every cell takes its light from cells nearer to the light. Lengths in local
// units.
#include "irradiance/padded.cl"
#include "types/convection.cl"

// One share of light for all channels, or one for each.
#ifdef COLOURED
#define REAL float4
#define CHANNELS(v) (v)
#else
#define REAL float
#define CHANNELS(v) ((v).x)
#endif

// How light travels at a cell.
struct Stream {
    float x; // u / h per axis
    float y;
    float z;
    bool held; // whether the cell has the light that convection_hold gives it
};

// From the light to the cell's centre, in cells, along an axis.
#define OFFSET(axis) ((float)axis + 0.5f - place.axis)

// place, source: the light's place and cell; edge: of cells.
INLINE struct Stream point_stream(float4 place, int4 source, float4 edge, int x, int y, int z) {
    float to_x = OFFSET(x);
    float to_y = OFFSET(y);
    float to_z = OFFSET(z);
    struct Stream stream;
    stream.held = to_x * to_x + to_y * to_y + to_z * to_z <= place.w;
    to_x = x == source.x ? 0.0f : to_x;
    to_y = y == source.y ? 0.0f : to_y;
    to_z = z == source.z ? 0.0f : to_z;
    float away_x = to_x * edge.x;
    float away_y = to_y * edge.y;
    float away_z = to_z * edge.z;
    float distance = sqrt(away_x * away_x + away_y * away_y + away_z * away_z);
    // In the light's own cell all offsets are 0.
    float scale = 1.0f / max(distance, 1e-18f);
    stream.x = to_x * scale;
    stream.y = to_y * scale;
    stream.z = to_z * scale;
    return stream;
}

INLINE struct Stream stream_at(__constant struct LightGrid *grid, __constant struct CarriedLight *light,
    int x, int y, int z) {
    if (light->cell.w != 0) {
        return point_stream(light->place, light->cell, grid->cell, x, y, z);
    }
    struct Stream stream;
    stream.held = false;
    stream.x = light->place.x / grid->cell.x;
    stream.y = light->place.y / grid->cell.y;
    stream.z = light->place.z / grid->cell.z;
    return stream;
}

// Lines through a cell near a point light: NEAR_POINTS cubed of them, or about twice as many directions from the light in
// its own cell. What lies before the cell is taken at NEAR_STEPS points.
#define NEAR_POINTS 6
#define NEAR_STEPS 16

// (1 - e^-depth) / depth.
INLINE REAL mean_left(REAL depth) {
    REAL near = 1.0f - 0.5f * depth + (1.0f / 6.0f) * depth * depth;
    return depth < 0.01f ? near : (1.0f - exp(-depth)) / max(depth, 1e-30f);
}

// What is left of light after a way from `from`, lengths in local units.
INLINE REAL left_after(__global const float4 *scattering, __global const float4 *absorption,
    __constant struct LightGrid *grid, float counted, float4 from, float4 direction, float way) {
    float step = way * (1.0f / NEAR_STEPS);
    float4 sum = (float4)(0.0f);
    for (int k = 0; k < NEAR_STEPS; ++k) {
        float4 place = (from + ((float)k + 0.5f) * step * direction) / (float4)(grid->cell.xyz, 1.0f);
        int4 cell = clamp(convert_int4(floor(place)), (int4)(0), max(grid->dims - 1, (int4)(0)));
        long i = plain_at(grid, cell.x, cell.y, cell.z);
        sum += counted * scattering[i] + absorption[i];
    }
    return exp(-step * CHANNELS(sum));
}

// The cell of a point light and its place, as lines through the cell see them.
struct NearCell {
    float4 from;
    float4 centre;
    float4 half_edges;
    bool inside;
};

INLINE struct NearCell near_cell(float4 place, int4 source, float4 edge, int x, int y, int z) {
    struct NearCell near;
    near.from = place * edge;
    near.from.w = 0.0f;
    near.half_edges = 0.5f * edge;
    near.centre = ((float4)((float)x, (float)y, (float)z, 0.0f) + 0.5f) * edge;
    near.centre.w = 0.0f;
    near.inside = x == source.x && y == source.y && z == source.z;
    return near;
}

INLINE int near_lines(const struct NearCell *near) {
    return (near->inside ? 2 : 1) * NEAR_POINTS * NEAR_POINTS * NEAR_POINTS;
}

// One of the lines: where it is in the cell; returns its weight, of which the mean is that of 1 / r^2.
INLINE float near_line(const struct NearCell *near, int index, float4 *direction, float2 *way) {
    int i = index / (NEAR_POINTS * NEAR_POINTS);
    int j = index / NEAR_POINTS % NEAR_POINTS;
    int k = index % NEAR_POINTS;
    float4 u = ((float4)((float)i, (float)j, (float)k, 0.0f) + 0.5f) * (1.0f / NEAR_POINTS);
    float4 along = near->centre + near->half_edges * (2.0f * u - 1.0f) - near->from;
    if (near->inside) {
        // A lattice of latitudes, all different, and longitudes.
        float height = 1.0f - ((float)i + ((float)j + u.z) * (1.0f / NEAR_POINTS)) * (1.0f / NEAR_POINTS);
        float radius = sqrt(max(1.0f - height * height, 0.0f));
        float angle = 6.28318531f * (((float)k + u.y) * (1.0f / NEAR_POINTS) + (float)i * 0.38196601f);
        along = (float4)(radius * cos(angle), radius * sin(angle), height, 0.0f);
    }
    along.w = 0.0f;
    *direction = along / sqrt(max(dot(along, along), 1e-30f));
    float2 reach = way_in_box(near->from, *direction, near->centre, near->half_edges);
    *way = reach;
    // As in lamp_of_box of direct_rays.cl.
    float4 h = near->half_edges;
    return near->inside ? (reach.y - reach.x) * (1.57079633f / (h.x * h.y * h.z))
                        : 3.0f / max(reach.x * reach.x + reach.x * reach.y + reach.y * reach.y, 1e-30f);
}

// The cells that are held about a point light get the share of its light that is left, the mean over the cell: what they
// take adds up to no more than the light sends.
__kernel void convection_hold(__global REAL *shares, __global const float4 *scattering,
    __global const float4 *absorption, __constant struct LightGrid *grid, __constant struct CarriedLight *light,
    float counted) {
    FIND_LIGHT_CELL
    struct Stream stream = point_stream(light->place, light->cell, grid->cell, (int)x, y, z);
    if (light->cell.w == 0 || !stream.held) return;
    long own = plain_at(grid, x, y, z);
    REAL sigma = CHANNELS(counted * scattering[own] + absorption[own]);
    struct NearCell near = near_cell(light->place, light->cell, grid->cell, (int)x, y, z);
    REAL sum = (REAL)(0.0f);
    float weights = 0.0f;
    for (int index = 0; index < near_lines(&near); ++index) {
        float4 direction;
        float2 way;
        float weight = near_line(&near, index, &direction, &way);
        sum += weight * mean_left(sigma * (way.y - way.x))
            * left_after(scattering, absorption, grid, counted, near.from, direction, way.x);
        weights += weight;
    }
    shares[padded_at(grid, x, y, z)] = sum / weights;
}

// Darkness, with light all around.
__kernel void convection_begin(__global REAL *shares, __constant struct LightGrid *grid) {
    FIND_PADDED_CELL
    shares[padded_at(grid, x, y, z)] = (REAL)(is_cell(grid, x, y, z) ? 0.0f : 1.0f);
}

// What a step of length `time` (the way of light) leaves.
__kernel void convection_decay(__global REAL *decay, __global const float4 *scattering,
    __global const float4 *absorption, __constant struct LightGrid *grid, float time) {
    FIND_LIGHT_CELL
    long i = plain_at(grid, x, y, z);
    decay[i] = exp(-time * CHANNELS(scattering[i] + absorption[i]));
}

// A step of a directional light: moved_*: share of a cell that a step crosses, behind_*: where light comes from.
__kernel void convection_step(__global REAL *restrict next, __global const REAL *restrict now,
    __global const REAL *restrict decay, __constant struct LightGrid *grid,
    float moved_x, float moved_y, float moved_z, int behind_x, int behind_y, int behind_z) {
    FIND_LIGHT_CELL
    long i = padded_at(grid, x, y, z);
    REAL here = now[i];
    REAL moved = here + moved_x * (now[i + behind_x] - here) + moved_y * (now[i + behind_y] - here)
        + moved_z * (now[i + behind_z] - here);
    // At the largest step, rounding could leave a little less than nothing.
    next[i] = max(moved, 0.0f) * decay[plain_at(grid, x, y, z)];
}

// What moves into a cell along an axis, of the neighbour that light comes from.
#define MOVES(moved, distance)                                                                  \
    (max(moved, 0.0f) * (now[i - (distance)] - here) + max(-(moved), 0.0f) * (now[i + (distance)] - here))

// A step of a point light. Its place and cell (as in struct CarriedLight) and the edges of cells come as numbers: where
// they are read from memory, CPUs do not join work-items.
__kernel void convection_step_point(__global REAL *restrict next, __global const REAL *restrict now,
    __global const REAL *restrict decay, __constant struct LightGrid *grid, float time,
    float place_x, float place_y, float place_z, float held2, int source_x, int source_y, int source_z,
    float edge_x, float edge_y, float edge_z) {
    FIND_LIGHT_CELL
    long i = padded_at(grid, x, y, z);
    long row = padded_row(grid);
    long slice = padded_slice(grid);
    struct Stream stream = point_stream((float4)(place_x, place_y, place_z, held2),
        (int4)(source_x, source_y, source_z, 1), (float4)(edge_x, edge_y, edge_z, 0.0f), (int)x, y, z);
    REAL here = now[i];
    REAL moved = here + MOVES(time * stream.x, 1) + MOVES(time * stream.y, row) + MOVES(time * stream.z, slice);
    moved = max(moved, 0.0f) * decay[plain_at(grid, x, y, z)];
    next[i] = stream.held ? here : moved;
}

// The steady state of the cells `level` cells from the light's (the sum over the axes), once those of the level before
// have theirs. A work-item per column along x: its cell on one side of the light's, or on the other. `counted`: the
// share of scattering that takes light away.
__kernel void convection_settle(__global REAL *shares, __global const float4 *scattering,
    __global const float4 *absorption, __constant struct LightGrid *grid, __constant struct CarriedLight *light,
    float counted, uint level) {
    int y = (int)get_global_id(0);
    int z = (int)get_global_id(1);
    int side = (int)get_global_id(2);
    int rest = (int)level - (int)abs(y - light->cell.y) - (int)abs(z - light->cell.z);
    if (side > 1 || rest < 0 || (side == 1 && rest == 0)) return;
    bool below = side == 1 || light->cell.x >= grid->dims.x;
    int x = light->cell.x + (below ? -rest : rest);
    if (!is_cell(grid, x, y, z)) return;
    long i = padded_at(grid, x, y, z);
    long row = padded_row(grid);
    long slice = padded_slice(grid);
    struct Stream stream = stream_at(grid, light, x, y, z);
    REAL arriving = fabs(stream.x) * shares[stream.x > 0.0f ? i - 1 : i + 1]
        + fabs(stream.y) * shares[stream.y > 0.0f ? i - row : i + row]
        + fabs(stream.z) * shares[stream.z > 0.0f ? i - slice : i + slice];
    float leaving = fabs(stream.x) + fabs(stream.y) + fabs(stream.z);
    long own = plain_at(grid, x, y, z);
    REAL sigma = CHANNELS(counted * scattering[own] + absorption[own]);
    if (!stream.held) {
        shares[i] = arriving / (leaving + sigma);
    }
}

// From the light to a cell's centre; w: squared distance from which the cell sees a point, 1 of directional lights.
INLINE float4 way_to(__constant struct LightGrid *grid, __constant struct CarriedLight *light, int x, int y, int z) {
    if (light->cell.w == 0) {
        return (float4)(light->place.xyz, 1.0f);
    }
    float4 place = light->place;
    float to_x = OFFSET(x) * grid->cell.x;
    float to_y = OFFSET(y) * grid->cell.y;
    float to_z = OFFSET(z) * grid->cell.z;
    float distance2 = max(to_x * to_x + to_y * to_y + to_z * to_z, light->power.w);
    if (point_stream(place, light->cell, grid->cell, x, y, z).held) {
        // Such that 1 / r^2 is its mean over the cell.
        struct NearCell near = near_cell(place, light->cell, grid->cell, x, y, z);
        float weights = 0.0f;
        for (int index = 0; index < near_lines(&near); ++index) {
            float4 direction;
            float2 way;
            weights += near_line(&near, index, &direction, &way);
        }
        distance2 = (float)near_lines(&near) / weights;
    }
    return (float4)(to_x, to_y, to_z, distance2);
}

INLINE float4 fluence_of(__constant struct CarriedLight *light, float4 share, float distance2) {
    float4 fluence = share * light->power / distance2;
    fluence.w = 0.0f;
    return fluence;
}

// Adds a light's fluence; the first light's is set.
__kernel void convection_add(__global float4 *fluence, __global const REAL *shares,
    __constant struct LightGrid *grid, __constant struct CarriedLight *light, uint first) {
    FIND_LIGHT_CELL
    long i = plain_at(grid, x, y, z);
    float4 share = (float4)(shares[padded_at(grid, x, y, z)]);
    float4 own = fluence_of(light, share, way_to(grid, light, (int)x, y, z).w);
    fluence[i] = first != 0u ? own : fluence[i] + own;
}

// Adds a light's flux of the channels' mean, w: its fluence; the first light's is set.
__kernel void convection_add_flux(__global float4 *flux, __global const REAL *shares,
    __constant struct LightGrid *grid, __constant struct CarriedLight *light, uint first) {
    FIND_LIGHT_CELL
    long i = plain_at(grid, x, y, z);
    float4 way = way_to(grid, light, (int)x, y, z);
    float4 fluence = fluence_of(light, (float4)(shares[padded_at(grid, x, y, z)]), way.w);
    float mean = (fluence.x + fluence.y + fluence.z) * (1.0f / 3.0f);
    float4 towards = way;
    towards.w = 0.0f;
    float4 own = (float4)(way.xyz * (mean / sqrt(max(way.w, dot(towards, towards)))), mean);
    flux[i] = first != 0u ? own : flux[i] + own;
}

// Flux to mean direction, of length 1 at most whatever was rounded.
__kernel void convection_flow(__global float4 *flux, __constant struct LightGrid *grid) {
    FIND_LIGHT_CELL
    long i = plain_at(grid, x, y, z);
    float4 own = flux[i];
    float fluence = own.w * (1.0f + 1e-6f);
    flux[i] = fluence > 0.0f ? (float4)(own.xyz / fluence, 0.0f) : (float4)(0.0f);
}
