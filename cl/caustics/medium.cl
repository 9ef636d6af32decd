// The medium of a scene of surfaces (MEDIUM): how much of a ray's light it leaves, where it stops photons, and what it is
// there. Glass displaces it: rays within bodies of glass meet no medium.
//
// Transmittances are estimates, unbiased and without bounds on the step: ratio tracking over the grid of majorants, and
// exact where the extinction is the same everywhere (CONSTANT_SIGMA). Photons are stopped by delta tracking (Woodcock 1965).
//
// Defines besides: VOXEL, one of PHASE_*, CONSTANT_SIGMA or SIGMA_RAMP or none, CONSTANT_ALBEDO, TF_2D; WIDTH is 1.
#include "common/phase.cl"
#include "surfaces/intersect.cl"
#include "volume/transmittance.cl"

#define MEDIUM_ARGUMENTS __constant struct Volume *volume, __constant struct Scattering *scattering, \
    __global const VOXEL *voxels, __global const BrickBound *majorants, __global const float *sigmas, \
    __global const float4 *albedos

struct Medium {
    struct MediumTables tables;
    __global const float4 *albedos;
    struct Numbers numbers; // of what is looked up
};

INLINE struct Medium medium_of(__constant struct Frame *frame, __constant struct Volume *volume,
    __constant struct Scattering *scattering, __global const VOXEL *voxels, __global const BrickBound *majorants,
    __global const float *sigmas, __global const float4 *albedos) {
    struct Medium medium;
    medium.tables.frame = frame;
    medium.tables.volume = volume;
    medium.tables.method = scattering;
    medium.tables.voxels = voxels;
    medium.tables.bounds = majorants;
    medium.tables.sigmas = sigmas;
    medium.albedos = albedos;
    return medium;
}

// The numbers of one photon of a pass, or of one pixel of a sample.
INLINE void medium_numbers(struct Medium *medium, uint index, uint pass, uint purpose) {
    __constant struct Frame *frame = medium->tables.frame;
    medium->numbers.stream.counter = (uint4)(index, pass, 0u, purpose);
    medium->numbers.stream.key = (uint2)(frame->seed_low, frame->seed_high);
    medium->numbers.used = 0u;
}

INLINE float medium_random(struct Medium *medium) {
    return uniform_float(next_number(&medium->numbers));
}

// A ray and the times between which it is in the medium; to <= from where it misses it.
struct MediumRay {
    struct RayLanes ray; // grid coordinates
    float from;
    float to;
};

INLINE struct MediumRay medium_ray(const struct Medium *medium, float3 origin, float3 direction, float end) {
    struct MediumRay through;
    float3 scale = medium->tables.volume->scale.xyz;
    float3 start = origin * scale + GRID_LOW;
    float3 way = direction * scale;
    through.ray = ray_lanes(medium->tables.method, points(start.x, start.y, start.z), points(way.x, way.y, way.z));
    through.from = 0.0f;
    through.to = end;
    clip_rays(medium->tables.method, &through.ray, &through.from, &through.to);
    return through;
}

#ifndef CONSTANT_SIGMA
INLINE struct TrackedRay tracked_ray(const struct MediumRay *through) {
    RayTable table;
    table.all = through->ray;
    return ray_of_lane(&table, 0);
}
#endif

// What is left of light between two times of a ray, within those of the medium.
INLINE float medium_leaves(struct Medium *medium, const struct MediumRay *through, float from, float to) {
    if (!(to > from)) {
        return 1.0f;
    }
#ifdef CONSTANT_SIGMA
    return exp(-medium->tables.method->sigma * (to - from));
#else
    struct TrackedRay ray = tracked_ray(through);
    struct Cost cost = {0u, 0u};
    return transmittance(&medium->tables, &ray, from, to, &medium->numbers, &cost).x;
#endif
}

// What is left of light from `origin` to `end`.
INLINE float medium_transmittance(struct Medium *medium, float3 origin, float3 direction, float end) {
    struct MediumRay through = medium_ray(medium, origin, direction, end);
    return medium_leaves(medium, &through, through.from, through.to);
}

// What the medium does at a place.
struct Scatterer {
    float sigma;    // extinction, per local unit
    float3 albedo;
};

INLINE struct Scatterer scatterer_at(const struct Medium *medium, float3 point) {
    __constant struct Scattering *method = medium->tables.method;
    struct Scatterer at;
    at.albedo = method->albedo.xyz;
#ifdef CONSTANT_SIGMA
    at.sigma = method->sigma;
#else
    __constant struct Volume *volume = medium->tables.volume;
    float4 place = (float4)(point * volume->scale.xyz + GRID_LOW, 0.0f);
    place = clamp(place, method->low, method->high);
    float value, row;
    at.sigma = sigma_at(medium->tables.frame, volume, medium->tables.voxels, medium->tables.sigmas, place, &value, &row);
#ifndef CONSTANT_ALBEDO
    at.albedo = table_color(medium->tables.frame, medium->albedos, table_place(medium->tables.frame, value, row)).xyz;
#endif
#endif
    return at;
}

// Where the medium stops a photon, as time along its ray; INFINITY where it does not.
INLINE float medium_stop(struct Medium *medium, const struct MediumRay *through) {
    if (!(through->to > through->from)) {
        return INFINITY;
    }
    const struct MediumTables *m = &medium->tables;
    float depth = exponential_float(next_number(&medium->numbers));
#ifdef CONSTANT_SIGMA
    float t = through->from + depth / m->method->sigma;
    return t < through->to ? t : INFINITY;
#else
    struct TrackedRay ray = tracked_ray(through);
    struct Cost cost = {0u, 0u};
    struct BrickWalk walk = walk_start(m, &ray, through->from, through->to);
    do {
        float rate = walk.bound.x;
        float t = walk.t;
        float ahead = rate * (walk.next - t);
        while (depth < ahead) {
            t = min(t + depth / rate, walk.next);
            if (medium_random(medium) * rate < walk_sigma(&walk, m, &ray, t, &cost)) {
                return t;
            }
            depth = exponential_float(next_number(&medium->numbers));
            ahead = rate * (walk.next - t);
        }
        depth -= ahead;
    } while (walk_on(&walk, m, &ray, through->to));
    return INFINITY;
#endif
}

INLINE struct Phase medium_phase(const struct Medium *medium) {
    float4 parameters = medium->tables.method->phase;
    struct Phase phase;
    phase.g0 = parameters.x;
    phase.g1 = parameters.y;
    phase.weight = parameters.z;
    phase.pad = 0.0f;
    return phase;
}

// A direction after scattering.
INLINE float3 medium_scatters(struct Medium *medium, float3 direction) {
    float u = medium_random(medium);
    float v = medium_random(medium);
    float pdf;
    struct Points way = phase_sample(medium_phase(medium), points(direction.x, direction.y, direction.z), u, v, &pdf);
    return (float3)(way.x, way.y, way.z);
}
