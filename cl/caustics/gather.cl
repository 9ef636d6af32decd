// What photons around a point give there: irradiance on a surface, or their density in a medium.
//
// Defines: MEDIUM where photons in a medium are weighed by one of PHASE_*; one of MAP_BRUTE_FORCE, MAP_LEXICOGRAPHIC, MAP_VOXELS, MAP_PLANAR; one of KERNEL_CONSTANT, KERNEL_CONE,
// KERNEL_SMOOTHSTEP; EDGE_CORRECTION; GATHER_LANES on CPUs. Kernels take PHOTON_MAP_ARGUMENTS, which come in the order of
// `PhotonMap::arguments`, and make a struct PhotonMap of them by PHOTON_MAP; those of several maps have a name for each.
//
// Distances are those in space, not in the tangent plane: on a sphere the area within a chord r of a point is pi r^2
// exactly, as in the plane, so the kernels keep their norm there; projected, photons would lie too close.
#include "caustics/cells.cl"
#include "caustics/edges.cl"
#include "caustics/marks.cl"
#include "caustics/weights.cl"
#include "sort/search.cl"
#ifdef MEDIUM
#include "common/octahedron.cl"
#include "common/phase.cl"
#endif

struct PhotonMap {
    __global const struct MapFrame *frame;
    __global const float *photons;            // in order, an array each of x, y, z, r, g, b, direction, mark
    __global const uint *keys;                // of the photons in order
    __global const uint2 *ranges;             // by cell: its first photon and the one behind its last, or twice 0
    __global const struct Receiver *receivers; // by surface
};
#define PHOTON_MAP_ARGUMENTS(map) __global const struct MapFrame *map##_frame, __global const float *map##_photons, \
    __global const uint *map##_keys, __global const uint2 *map##_ranges, __global const struct Receiver *map##_receivers
#define PHOTON_MAP(map) {map##_frame, map##_photons, map##_keys, map##_ranges, map##_receivers}

// Whose photons are gathered.
struct Query {
    float3 point;
    float3 normal;   // towards the viewer: photons came from that side
    uint surface;
    uint mark;       // of its photons on that side
    uint marked;     // the bits of it that count
    bool bent;       // the surface faces several ways
    float radius;
    float square;    // radius^2
    float inverse;   // 1 / radius
    float thickness; // photons lie at most so far out of the tangent plane
    bool medium;     // photons in a medium: of no surface and no side
#ifdef MEDIUM
    struct Phase phase;
    float3 leaving;  // where light goes that is scattered
#endif
};

struct Gathered {
    Batch red;
    Batch green;
    Batch blue;
    uint looked_at;
};

#if defined(MEDIUM) && !defined(PHASE_ISOTROPIC)
typedef union {
    Batch all;
    float lane[BATCH];
} BatchLanes;

typedef union {
    BatchWords all;
    uint lane[BATCH];
} BatchWordLanes;

// The phase function between the ways of photons and where their light leaves.
INLINE Batch scattered_shares(BatchWords packed, const struct Query *query) {
    BatchLanes shares;
    BatchWordLanes words;
    words.all = packed;
    struct Points leaving = points(query->leaving.x, query->leaving.y, query->leaving.z);
    for (uint i = 0; i < BATCH; ++i) {
        float3 way = unpack_direction(words.lane[i]);
        shares.lane[i] = phase_between(query->phase, points(way.x, way.y, way.z), leaving);
    }
    return shares.all;
}
#endif

// Among eight photons of neighbouring cells one is nearly always near: going on without a look at them costs less.
#if defined(MAP_BRUTE_FORCE) || defined(MAP_LEXICOGRAPHIC) || !defined(GATHER_LANES)
#define MOST_ARE_FAR
#endif

// Adds the photons of [first, end).
INLINE void gather_range(__global const float *photons, const struct MapFrame *frame, const struct Query *query,
    uint first, uint end, struct Gathered *sums) {
    uint stride = frame->stride;
    float inverse_square = query->inverse * query->inverse;
    for (uint i = first; i < end; i += BATCH) {
        Batch x = BATCH_FLOATS(photons, i) - query->point.x;
        Batch y = BATCH_FLOATS(photons, stride + i) - query->point.y;
        Batch z = BATCH_FLOATS(photons, 2u * stride + i) - query->point.z;
        Batch r2 = x * x + y * y + z * z;
        BatchMask near = (r2 < query->square) & (BATCH_LANES < (int)(end - i));
        if (!query->medium) {
            Batch above = x * query->normal.x + y * query->normal.y + z * query->normal.z;
            near &= fabs(above) <= query->thickness;
        }
#ifdef MOST_ARE_FAR
        if (!BATCH_ANY(near)) continue;
#endif
        BatchWords marks = BATCH_WORDS(photons, 7u * stride + i);
        near &= (marks & query->marked) == query->mark;
        if (query->bent) near &= faces_alike(marks, query->normal);
        Batch weight = kernel_weight(r2 * inverse_square);
#if defined(MEDIUM) && !defined(PHASE_ISOTROPIC)
        if (query->medium) weight *= scattered_shares(BATCH_WORDS(photons, 6u * stride + i), query);
#endif
        Batch none = (Batch)(0.0f);
        sums->red += BATCH_PICK(none, weight * BATCH_FLOATS(photons, 3u * stride + i), near);
        sums->green += BATCH_PICK(none, weight * BATCH_FLOATS(photons, 4u * stride + i), near);
        sums->blue += BATCH_PICK(none, weight * BATCH_FLOATS(photons, 5u * stride + i), near);
    }
    sums->looked_at += end - first;
}

#ifndef MAP_BRUTE_FORCE
// The first photon in order, of those from `from` on, whose key is at least `key`.
INLINE uint first_from(const struct PhotonMap *map, const struct MapFrame *frame, uint from, uint key) {
    return from + sorted_first(map->keys + from, frame->count - from, key);
}
#endif

#ifdef MAP_LEXICOGRAPHIC
// The photons within the radius along x; all of them are looked at.
INLINE void gather_photons(const struct PhotonMap *map, const struct MapFrame *frame, const struct Query *query,
    struct Gathered *sums) {
    float x = query->point.x;
    // Rounding of the bounds.
    float reach = query->radius * (1.0f + 1e-6f) + 2e-7f * fabs(x);
    uint first = first_from(map, frame, 0u, ordered_bits(x - reach));
    uint end = first_from(map, frame, first, ordered_bits(x + reach));
    gather_range(map->photons, frame, query, first, end, sums);
}

#elif defined(MAP_BRUTE_FORCE)
INLINE void gather_photons(const struct PhotonMap *map, const struct MapFrame *frame, const struct Query *query,
    struct Gathered *sums) {
    gather_range(map->photons, frame, query, 0u, frame->count, sums);
}

#else
// The photons of the cell of the point and of those around it: cells along x follow each other, so that they are one
// range per row of cells.
INLINE void gather_photons(const struct PhotonMap *map, const struct MapFrame *frame, const struct Query *query,
    struct Gathered *sums) {
    int3 cell = cell_of(*frame, map->receivers, query->point, query->surface);
#ifdef MAP_PLANAR
    // No turn for NO_PLANE.
    int z_low = max(cell.z, 0);
    int z_high = cell.z;
#else
    int z_low = max(cell.z - 1, 0);
    int z_high = min(cell.z + 1, (int)frame->nz - 1);
#endif
    int y_low = max(cell.y - 1, 0);
    int y_high = min(cell.y + 1, (int)frame->ny - 1);
    int x_low = max(cell.x - 1, 0);
    int x_high = min(cell.x + 1, (int)frame->nx - 1);
    if (x_low > x_high) return;
    uint behind = 0u;
    for (int z = z_low; z <= z_high; ++z) {
        for (int y = y_low; y <= y_high; ++y) {
            uint key = cell_key(*frame, x_low, y, z);
            uint last = key + (uint)(x_high - x_low);
            uint first = NO_PHOTON;
            uint end = 0u;
            if (frame->tabled != 0u) {
                for (uint k = key; k <= last; ++k) {
                    uint2 range = map->ranges[k];
                    first = range.y != 0u ? min(first, range.x) : first;
                    end = max(end, range.y);
                }
            } else {
                first = first_from(map, frame, behind, key);
                end = first_from(map, frame, first, last + 1u);
                behind = end;
            }
            if (first < end) gather_range(map->photons, frame, query, first, end, sums);
        }
    }
}
#endif

INLINE float3 gathered(const struct PhotonMap *map, const struct MapFrame *frame, const struct Query *query,
    float scale, uint *looked_at) {
    struct Gathered sums = {(Batch)(0.0f), (Batch)(0.0f), (Batch)(0.0f), 0u};
    gather_photons(map, frame, query, &sums);
    *looked_at += sums.looked_at;
    return scale * (float3)(batch_sum(sums.red), batch_sum(sums.green), batch_sum(sums.blue));
}

// Photons count that lie at most so far out of the tangent plane: on curved surfaces a quarter of the radius; where
// surfaces are flat, what rounding does to them, so that a box's other faces do not count.
INLINE float query_thickness(uint kind, float3 point, float radius) {
    if (kind == RECEIVER_CURVED || kind == RECEIVER_MESH) return 0.25f * radius;
    float size = max(max(fabs(point.x), fabs(point.y)), fabs(point.z));
    return min(0.25f * radius, 0.004f * radius + 4e-6f * size);
}

// Irradiance at a point of a surface, on the side that the normal (of unit length, of the geometry) points to; `inside`:
// this is not its outward one; per channel. Adds to *looked_at the photons whose distance was computed.
INLINE float3 gathered_irradiance(const struct PhotonMap *map, float3 point, float3 normal, uint surface, bool inside,
    uint *looked_at) {
    struct MapFrame frame = map->frame[0];
    __global const struct Receiver *receiver = map->receivers + surface;
    struct Query query;
    query.point = point;
    query.normal = normal;
    query.radius = frame.radius;
    query.square = frame.scale.w;
    query.inverse = frame.scale.z;
    float scale = frame.scale.x;
    if (receiver->reach < frame.radius) {
        float over = frame.radius / receiver->reach;
        query.radius = receiver->reach;
        query.square = query.radius * query.radius;
        query.inverse *= over;
        scale *= over * over;
    }
    query.thickness = query_thickness(receiver->kind, point, query.radius);
    query.surface = surface;
    query.mark = surface + 1u;
    query.marked = MARK_SURFACE;
    if (receiver->kind != RECEIVER_MESH) {
        query.mark |= inside ? MARK_INSIDE : 0u;
        query.marked |= MARK_INSIDE;
    }
    query.bent = receiver->plane == NO_PLANE;
    query.medium = false;
#ifdef EDGE_CORRECTION
    scale /= kernel_mass(receiver, point, normal, query.inverse);
#endif
    return gathered(map, &frame, &query, scale, looked_at);
}

#ifndef MAP_PLANAR
INLINE struct Query medium_query(const struct MapFrame *frame, float3 point) {
    struct Query query;
    query.point = point;
    query.normal = (float3)(0.0f);
    query.radius = frame->radius;
    query.square = frame->scale.w;
    query.inverse = frame->scale.z;
    query.thickness = 0.0f;
    query.surface = 0u;
    query.mark = IN_MEDIUM;
    query.marked = 0xffffffffu;
    query.bent = false;
    query.medium = true;
    return query;
}

#ifdef MEDIUM
// Flux that photons in the medium scatter into a direction, per volume and solid angle, per channel.
INLINE float3 photon_scattering(const struct PhotonMap *map, float3 point, struct Phase phase, float3 leaving,
    uint *looked_at) {
    struct MapFrame frame = map->frame[0];
    struct Query query = medium_query(&frame, point);
    query.phase = phase;
    query.leaving = leaving;
    float scale = frame.scale.y;
#ifdef PHASE_ISOTROPIC
    scale *= INV_4PI;
#endif
    return gathered(map, &frame, &query, scale, looked_at);
}
#else
// Flux of photons in a medium over volume, per channel.
INLINE float3 photon_density(const struct PhotonMap *map, float3 point, uint *looked_at) {
    struct MapFrame frame = map->frame[0];
    struct Query query = medium_query(&frame, point);
    return gathered(map, &frame, &query, frame.scale.y, looked_at);
}
#endif
#endif
