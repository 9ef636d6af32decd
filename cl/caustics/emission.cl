// Photons as they leave the lights: one from each cell of a grid, at the same place of all cells in a pass.
#include "common/inline.cl"
#include "common/rng.cl"
#include "surfaces/within.cl"
#include "types/emission.cl"

// A place of a grid: the cell and its sides, 0 to 1 across the grid, and the pass's place in cells.
struct Cell {
    uint column;
    uint row;
    float2 low;
    float2 high;
    float2 within;
};

// A photon on its way.
struct Flight {
    float3 origin;
    float3 direction;
    float3 flux;
    struct Cell cell;
    uint4 place;  // of the pass: in cells (x, y) and among wavelengths (z), in units of 2^-32
    uint4 shifts; // of its lattices
    struct Within within;
    bool white; // not of its wavelength's colour yet
};

// A place of a pass. Passes fill the cube evenly: after the powers of the root of x^4 = x + 1 (Roberts 2018, the sequence
// R3).
INLINE uint4 pass_place(uint2 seed, uint pass) {
    uint4 start = philox4x32((uint4)(0u, 0u, 0u, RNG_PHOTON_PASS), seed);
    return start + pass * (uint4)(0xD1B54A33u, 0xABC98389u, 0x8CB92BA7u, 0u);
}

// What a column and a row add to the numbers of a lattice over the cells of a grid, in units of 2^-32: the fractions of roots
// of primes, and of powers of the plastic number. Cells that are near to each other differ evenly.
#define LATTICE_FIRST (uint2)(0x6A09E668u, 0xBB67AE85u)
#define LATTICE_SECOND (uint2)(0x3C6EF373u, 0xA54FF53Bu)
#define LATTICE_LIGHT_U (uint2)(0x510E527Fu, 0x9B05688Cu)
#define LATTICE_LIGHT_V (uint2)(0x1F83D9ABu, 0x5BE0CD19u)
#define LATTICE_WAVELENGTH (uint2)(0xC13FA9A9u, 0x91E10DA5u)

// A cell's number in [0, 1) of a lattice.
INLINE float lattice_number(struct Cell cell, uint2 lattice, uint shift) {
    return uniform_float(cell.column * lattice.x + cell.row * lattice.y + shift);
}

// Cell `index` of a grid. With q columns and r cells more than q columns fill, the first r rows have q + 1; rows are as
// high as they have columns, so that all cells have the same area.
INLINE struct Cell grid_cell(uint index, uint count, uint rows, float2 within) {
    uint columns = count / rows;
    uint longer = count - columns * rows;
    uint in_longer = longer * (columns + 1u);
    bool after = index >= in_longer;
    uint rest = after ? index - in_longer : index;
    columns += after ? 0u : 1u;
    struct Cell cell;
    cell.row = rest / columns;
    cell.column = rest - cell.row * columns;
    uint before = cell.row * columns + (after ? in_longer : 0u);
    cell.row += after ? longer : 0u;
    cell.low = (float2)((float)cell.column / (float)columns, (float)before / (float)count);
    cell.high = (float2)((float)(cell.column + 1u) / (float)columns, (float)(before + columns) / (float)count);
    cell.within = within;
    return cell;
}

INLINE float2 place_in(struct Cell cell) {
    return cell.low + cell.within * (cell.high - cell.low);
}

// A direction for a place of the unit square, equal solid angles for equal areas: the octahedron of Clarberg 2008 ("Fast
// Equal-Area Mapping of the (Hemi)Sphere using SIMD"), whose cells are nowhere much longer than wide. It is turned so
// that no direction along an axis is near its corners or the seams between them, where neighbours do not continue the grid.
INLINE float3 sphere_direction(float2 place) {
    float2 p = 2.0f * place - 1.0f;
    float2 size = fabs(p);
    float above = 1.0f - size.x - size.y;
    float r = 1.0f - fabs(above);
    float turn = r > 0.0f ? 0.25f * ((size.y - size.x) / r + 1.0f) : 0.25f;
    float sine = r * sqrt(2.0f - r * r);
    float x = copysign(sine * cospi(turn), p.x);
    float y = copysign(sine * sinpi(turn), p.y);
    float z = copysign(1.0f - r * r, above);
    // Corners meet at (1, 1, 1), and the seams from there are half a right angle from the nearest axis or 15 degrees.
    return normalize(x * (float3)(0.78867513f, -0.21132487f, -0.57735027f) + y * (float3)(-0.21132487f, 0.78867513f, -0.57735027f) - 0.57735027f * z);
}

// A number in [0, 1] of a density that goes from a to b, both > 0.
INLINE float linear_sample(float u, float a, float b) {
    return u * (a + b) / (a + sqrt(a * a + u * (b - a) * (b + a)));
}

// The solid angle of a triangle with corners at distances a, b, c, by their scalar products and six times the volume
// below it (Van Oosterom and Strackee 1983). With the volume known, nothing cancels, however small the triangle.
INLINE float triangle_angle(float volume, float a, float b, float c, float ab, float bc, float ca) {
    return 2.0f * atan2(volume, a * b * c + ab * c + bc * a + ca * b);
}

// From a point through a cell of the target: the flux by the solid angle of the cell, and within it, where what the
// point sends is denser, more often (by its density at the corners).
INLINE void emit_from_point(__global const struct Emitter *emitter, struct Flight *flight) {
    float3 corner = emitter->corner.xyz;
    float2 size = (float2)(emitter->edge_u.w, emitter->edge_v.w);
    float2 low = corner.xy + flight->cell.low * size;
    float2 high = corner.xy + flight->cell.high * size;
    float2 across = (flight->cell.high - flight->cell.low) * size;
    float2 within = flight->cell.within;
    bool equal = emitter->power.w != 0.0f;
    flight->flux = emitter->power.xyz;
    if (!equal) {
        float4 x = (float4)(low.x, high.x, high.x, low.x);
        float4 y = (float4)(low.y, low.y, high.y, high.y);
        float z2 = corner.z * corner.z;
        float4 l2 = x * x + y * y + z2;
        float4 l = sqrt(l2);
        float4 next = x * x.yzwx + y * y.yzwx + z2;
        float diagonal = x.x * x.z + y.x * y.z + z2;
        float volume = fabs(corner.z) * across.x * across.y;
        flight->flux *= triangle_angle(volume, l.x, l.y, l.z, next.x, next.y, diagonal)
            + triangle_angle(volume, l.x, l.z, l.w, diagonal, next.z, next.w);
        // Relative to the first corner: cubes of lengths would leave the range.
        float4 density = l.x / l;
        density *= density * density;
        within.y = linear_sample(within.y, density.x + density.y, density.w + density.z);
        within.x = linear_sample(within.x, mix(density.x, density.w, within.y), mix(density.y, density.z, within.y));
    }
    float2 at = low + within * across;
    float3 to = at.x * emitter->edge_u.xyz + at.y * emitter->edge_v.xyz + corner.z * emitter->normal.xyz;
    flight->origin = emitter->place.xyz;
    flight->direction = normalize(to);
}

// A direction about `axis` with this cosine to it (given with its sine), at `turn` turns.
INLINE float3 around(float3 axis, float cosine, float sine, float turn) {
    // The frame of Duff et al. 2017 ("Building an Orthonormal Basis, Revisited").
    float sign = copysign(1.0f, axis.z);
    float a = -1.0f / (sign + axis.z);
    float b = axis.x * axis.y * a;
    float3 u = (float3)(1.0f + sign * axis.x * axis.x * a, sign * b, -sign * axis.x);
    float3 v = (float3)(b, sign + axis.y * axis.y * a, -axis.y);
    return normalize(sine * (cospi(2.0f * turn) * u + sinpi(2.0f * turn) * v) + cosine * axis);
}

// Parallel light begins outside of all that has bounds, and before every plane on its way to the target.
INLINE void emit_along(__global const struct Emitter *emitter, const struct Surfaces *surfaces, struct Flight *flight) {
    float2 at = place_in(flight->cell);
    float3 direction = emitter->place.xyz;
    float3 target = emitter->corner.xyz + at.x * emitter->edge_u.xyz + at.y * emitter->edge_v.xyz;
    float back = max(dot(target, direction) - emitter->place.w, 0.0f);
#ifdef SHAPE_PLANE
    for (uint i = 0; i < surfaces->plane_count; ++i) {
        float4 plane = surfaces->shapes[i].b;
        float approach = dot(plane.xyz, direction);
        float height = dot(plane.xyz, target) - plane.w;
        float margin = 64.0f * SURFACE_MARGIN * (largest_component(target) + fabs(plane.w));
        // Planes all but parallel to the light would be far away, and change nothing.
        if (fabs(approach) > 1e-3f) {
            back = max(back, (height + copysign(margin, approach)) / approach);
        }
    }
#endif
    flight->origin = target - back * direction;
    flight->direction = direction;
    flight->flux = emitter->power.xyz;
}

INLINE void emit_from_rectangle(__global const struct Emitter *emitter, struct Flight *flight) {
    float2 at = place_in(flight->cell);
    float3 normal = emitter->light_normal.xyz;
    float3 centre = emitter->place.xyz;
    float2 u = (float2)(lattice_number(flight->cell, LATTICE_LIGHT_U, flight->shifts.z),
        lattice_number(flight->cell, LATTICE_LIGHT_V, flight->shifts.w));
    flight->flux = emitter->power.xyz;
    if (emitter->way == EMIT_HEMISPHERE) {
        flight->origin = centre + (at.x - 0.5f) * emitter->light_u.xyz + (at.y - 0.5f) * emitter->light_v.xyz;
        flight->direction = around(normal, sqrt(u.x), sqrt(1.0f - u.x), u.y);
        return;
    }
    flight->origin = centre + (u.x - 0.5f) * emitter->light_u.xyz + (u.y - 0.5f) * emitter->light_v.xyz;
    float3 target = emitter->corner.xyz + at.x * emitter->edge_u.xyz + at.y * emitter->edge_v.xyz;
    float3 to = target - flight->origin;
    float square = dot(to, to);
    flight->direction = square > 0.0f ? to * rsqrt(square) : normal;
    if (emitter->power.w == 0.0f) {
        float cosines = max(dot(flight->direction, normal), 0.0f) * fabs(dot(flight->direction, emitter->normal.xyz));
        flight->flux *= square > 0.0f ? cosines / square : 0.0f;
    }
}

// The emitter of photon `index`.
INLINE __global const struct Emitter *emitter_of(__global const struct PhotonFrame *frame,
    __global const struct Emitter *emitters, uint index) {
    uint which = 0;
    while (which + 1 < frame->emitters && index >= emitters[which + 1].first) {
        ++which;
    }
    return emitters + which;
}

// Whether a photon that may go anywhere goes through the target all the same: others are sent there.
INLINE bool crosses_target(__global const struct Emitter *emitter, const struct Flight *flight) {
    if (emitter->way == EMIT_DIRECTIONAL) {
        float2 aside = fabs(place_in(flight->cell) - 0.5f);
        return max(aside.x, aside.y) < 0.5f / FAR_ALONG;
    }
    float3 u = emitter->edge_u.xyz;
    float3 v = emitter->edge_v.xyz;
    float3 normal = emitter->normal.xyz;
    float approach = dot(flight->direction, normal);
    if (emitter->way == EMIT_SPHERE) {
        float3 corner = emitter->corner.xyz;
        float3 to = corner.z / approach * flight->direction;
        float2 at = (float2)(dot(to, u), dot(to, v)) - corner.xy;
        return corner.z * approach > 0.0f && at.x >= 0.0f && at.y >= 0.0f && at.x < emitter->edge_u.w
            && at.y < emitter->edge_v.w;
    }
    float3 corner = emitter->corner.xyz - flight->origin;
    float height = dot(corner, normal);
    float3 to = height / approach * flight->direction - corner;
    float2 at = (float2)(dot(to, u) / dot(u, u), dot(to, v) / dot(v, v));
    return height * approach > 0.0f && at.x >= 0.0f && at.y >= 0.0f && at.x < 1.0f && at.y < 1.0f;
}

// Photon `index` of a pass.
INLINE struct Flight emit(__global const struct PhotonFrame *frame, __global const struct Emitter *emitters,
    const struct Surfaces *surfaces, uint index, uint pass) {
    __global const struct Emitter *emitter = emitter_of(frame, emitters, index);
    struct Flight flight;
    uint2 seed = (uint2)(frame->seed_low, frame->seed_high);
    flight.place = pass_place(seed, pass);
    flight.shifts = philox4x32((uint4)(pass, 0u, 0u, RNG_PHOTON_SHIFT), seed);
    float2 within = (float2)(uniform_float(flight.place.x), uniform_float(flight.place.y));
    flight.cell = grid_cell(index - emitter->first, emitter->count, emitter->rows, within);
    switch (emitter->way) {
    case EMIT_POINT:
        emit_from_point(emitter, &flight);
        break;
    case EMIT_SPHERE:
        flight.origin = emitter->place.xyz;
        flight.direction = sphere_direction(place_in(flight.cell));
        flight.flux = emitter->power.xyz;
        break;
    case EMIT_DIRECTIONAL:
        emit_along(emitter, surfaces, &flight);
        break;
    default:
        emit_from_rectangle(emitter, &flight);
        break;
    }
    // Parallel light begins outside of everything.
    bool outside = emitter->way == EMIT_DIRECTIONAL;
    flight.white = true;
    flight.within = outside ? within_none() : within_at(surfaces, flight.origin, flight.direction);
    return flight;
}
