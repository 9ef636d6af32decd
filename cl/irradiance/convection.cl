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
    float x; // |u| / h per axis
    float y;
    float z;
    bool held; // whether the cell has the light's own value
};

// From the light to the cell's centre, in cells, along an axis.
#define OFFSET(axis) ((float)axis + 0.5f - light->place.axis)

INLINE struct Stream point_stream(__constant struct LightGrid *grid, __constant struct CarriedLight *light,
    int x, int y, int z) {
    float to_x = OFFSET(x);
    float to_y = OFFSET(y);
    float to_z = OFFSET(z);
    struct Stream stream;
    stream.held = to_x * to_x + to_y * to_y + to_z * to_z <= light->place.w;
    to_x = x == light->cell.x ? 0.0f : to_x;
    to_y = y == light->cell.y ? 0.0f : to_y;
    to_z = z == light->cell.z ? 0.0f : to_z;
    float away_x = to_x * grid->cell.x;
    float away_y = to_y * grid->cell.y;
    float away_z = to_z * grid->cell.z;
    float distance = sqrt(away_x * away_x + away_y * away_y + away_z * away_z);
    // In the light's own cell all offsets are 0.
    float scale = 1.0f / max(distance, 1e-18f);
    stream.x = fabs(to_x) * scale;
    stream.y = fabs(to_y) * scale;
    stream.z = fabs(to_z) * scale;
    return stream;
}

INLINE struct Stream stream_at(__constant struct LightGrid *grid, __constant struct CarriedLight *light,
    int x, int y, int z) {
    if (light->cell.w != 0) {
        return point_stream(grid, light, x, y, z);
    }
    struct Stream stream;
    stream.held = false;
    stream.x = fabs(light->place.x) / grid->cell.x;
    stream.y = fabs(light->place.y) / grid->cell.y;
    stream.z = fabs(light->place.z) / grid->cell.z;
    return stream;
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
    int i = plain_at(grid, x, y, z);
    decay[i] = exp(-time * CHANNELS(scattering[i] + absorption[i]));
}

// A step's end: at the largest step, rounding could leave a little less than nothing.
#define MOVED(here, stream, behind_x, behind_y, behind_z)                                                    \
    max((here) + (stream).x * ((behind_x) - (here)) + (stream).y * ((behind_y) - (here))                     \
            + (stream).z * ((behind_z) - (here)),                                                            \
        0.0f)

// A step of a directional light: moved_*: share of a cell that a step crosses, behind_*: where light comes from.
__kernel void convection_step(__global REAL *next, __global const REAL *now, __global const REAL *decay,
    __constant struct LightGrid *grid, float moved_x, float moved_y, float moved_z,
    int behind_x, int behind_y, int behind_z) {
    FIND_LIGHT_CELL
    int i = padded_at(grid, x, y, z);
    struct Stream stream;
    stream.x = moved_x;
    stream.y = moved_y;
    stream.z = moved_z;
    REAL here = now[i];
    next[i] = MOVED(here, stream, now[i + behind_x], now[i + behind_y], now[i + behind_z])
        * decay[plain_at(grid, x, y, z)];
}

// A step of a point light.
__kernel void convection_step_point(__global REAL *next, __global const REAL *now, __global const REAL *decay,
    __constant struct LightGrid *grid, __constant struct CarriedLight *light, float time) {
    FIND_LIGHT_CELL
    int i = padded_at(grid, x, y, z);
    int row = padded_row(grid);
    int slice = padded_slice(grid);
    struct Stream stream = point_stream(grid, light, x, y, z);
    stream.x *= time;
    stream.y *= time;
    stream.z *= time;
    REAL here = now[i];
    // Both neighbours are read: work-items side by side then read side by side.
    REAL behind_x = x > light->cell.x ? now[i - 1] : now[i + 1];
    REAL behind_y = y > light->cell.y ? now[i - row] : now[i + row];
    REAL behind_z = z > light->cell.z ? now[i - slice] : now[i + slice];
    REAL moved = MOVED(here, stream, behind_x, behind_y, behind_z) * decay[plain_at(grid, x, y, z)];
    next[i] = stream.held ? (REAL)(1.0f) : moved;
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
    int i = padded_at(grid, x, y, z);
    int row = padded_row(grid);
    int slice = padded_slice(grid);
    struct Stream stream = stream_at(grid, light, x, y, z);
    REAL arriving = stream.x * shares[x > light->cell.x ? i - 1 : i + 1]
        + stream.y * shares[y > light->cell.y ? i - row : i + row]
        + stream.z * shares[z > light->cell.z ? i - slice : i + slice];
    int own = plain_at(grid, x, y, z);
    REAL sigma = CHANNELS(counted * scattering[own] + absorption[own]);
    shares[i] = stream.held ? (REAL)(1.0f) : arriving / (stream.x + stream.y + stream.z + sigma);
}

// From the light to a cell's centre; w: squared distance from which the cell sees a point, 1 of directional lights.
INLINE float4 way_to(__constant struct LightGrid *grid, __constant struct CarriedLight *light, int x, int y, int z) {
    if (light->cell.w == 0) {
        return (float4)(light->place.xyz, 1.0f);
    }
    float to_x = OFFSET(x) * grid->cell.x;
    float to_y = OFFSET(y) * grid->cell.y;
    float to_z = OFFSET(z) * grid->cell.z;
    return (float4)(to_x, to_y, to_z, max(to_x * to_x + to_y * to_y + to_z * to_z, light->power.w));
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
    int i = plain_at(grid, x, y, z);
    float4 share = (float4)(shares[padded_at(grid, x, y, z)]);
    float4 own = fluence_of(light, share, way_to(grid, light, x, y, z).w);
    fluence[i] = first != 0u ? own : fluence[i] + own;
}

// Adds a light's flux of the channels' mean, w: its fluence; the first light's is set.
__kernel void convection_add_flux(__global float4 *flux, __global const REAL *shares,
    __constant struct LightGrid *grid, __constant struct CarriedLight *light, uint first) {
    FIND_LIGHT_CELL
    int i = plain_at(grid, x, y, z);
    float4 way = way_to(grid, light, x, y, z);
    float4 fluence = fluence_of(light, (float4)(shares[padded_at(grid, x, y, z)]), way.w);
    float mean = (fluence.x + fluence.y + fluence.z) * (1.0f / 3.0f);
    float4 own = (float4)(way.xyz * (mean / sqrt(way.w)), mean);
    flux[i] = first != 0u ? own : flux[i] + own;
}

// Flux to mean direction, of length 1 at most whatever was rounded.
__kernel void convection_flow(__global float4 *flux, __constant struct LightGrid *grid) {
    FIND_LIGHT_CELL
    int i = plain_at(grid, x, y, z);
    float4 own = flux[i];
    float fluence = own.w * (1.0f + 1e-6f);
    flux[i] = fluence > 0.0f ? (float4)(own.xyz / fluence, 0.0f) : (float4)(0.0f);
}
