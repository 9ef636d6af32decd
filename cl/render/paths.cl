// The state of the paths that a work-item follows side by side, and what happens to them at the ends of their rays.
//
// A path is a camera ray, then turns of a shadow ray towards a light and a flight to the next collision. Light is
// collected on the way: radiance = sum of throughput * (source seen by that part).
#include "common/phase.cl"
#include "common/random_lanes.cl"
#include "lights/sample.cl"
#include "render/background.cl"
#include "volume/transmittance.cl"

// Channels of throughput and light: one when nothing in the scene is coloured.
#ifdef GREY
#define CHANNELS 1
#else
#define CHANNELS 3
#endif

// What a ray is for.
#define CAMERA_RAY 0
#define SHADOW_RAY 1
#define FLIGHT 2
#define NO_RAY 3

struct PathLanes {
    Ints ray;                  // what the ray is for
    Ints slot;                 // pixel within the work-item's pixels
    Words pixel;
    Words path;                // number of the path within the sample
    Words block;               // random blocks used so far, by events
    Words lookups;             // ... and by tentative collisions, which count in a stream of their own:
    Words stream[2];           // drawn at the path's start
    Ints order;                // scatterings so far
    Ints flights;              // flights still to come from the last collision
    struct Points direction;   // of propagation, local
    struct Points incoming;    // the direction with which it reached the last collision
    struct Points vertex;      // the last collision, grid coordinates
    Reals throughput[CHANNELS];
    Reals light[CHANNELS];     // collected
    Reals pending[CHANNELS];   // what the shadow ray brings if nothing is in its way
    Reals opacity;             // what the medium took of the camera ray
    Reals pdf;                 // of the flight's direction, 1/sr; -1 for camera rays
    Reals eye;                 // the time at which the camera ray left the eye
    Words strata[6];           // stratified over the paths of a sample: the camera ray's first collision and whether
                               // the path goes on there, then the first turn and the first place on a light
};

// What is counted for the ledger.
struct Tally {
    Reals escaped;
    Reals absorbed;
    Reals cut;
    Reals gained;
    uint lookups;
    uint collisions;
    uint above;
#ifdef AUXILIARY
    struct Auxiliary *notes; // sums of the sample, per pixel of the work-item
#endif
};

// What paths read besides the medium.
struct Surroundings {
    __global const float4 *colors;
    __global const float4 *emissions;
    __global const struct Light *lights;
    __global const float *environment_sums;
    __global const float4 *environment;
};

INLINE float channel_of(float4 color, int channel) {
    return channel == 0 ? color.x : channel == 1 ? color.y : color.z;
}

// The next random blocks of the lanes in `mask`: four words each. Counter: pixel, sample, block, purpose and path.
INLINE void path_block(struct PathLanes *path, const struct MediumTables *m, uint sample, Ints mask, Words words[4]) {
    words[0] = path->pixel;
    words[1] = (Words)(sample);
    words[2] = path->block;
    words[3] = (path->path << 8) | RNG_PATH;
    philox_lanes(words, (uint2)(m->frame->seed_low, m->frame->seed_high));
    path->block += PICK((Words)(0u), (Words)(1u), mask);
}

INLINE struct Phase phase_parameters(const struct MediumTables *m) {
    struct Phase phase;
    phase.g0 = m->method->phase.x;
    phase.g1 = m->method->phase.y;
    phase.weight = m->method->phase.z;
    phase.pad = 0.0f;
    return phase;
}

INLINE struct Points to_grid(__constant struct Volume *volume, struct Points p) {
    return points(p.x * volume->scale.x + GRID_LOW, p.y * volume->scale.y + GRID_LOW, p.z * volume->scale.z + GRID_LOW);
}

INLINE float4 grid_to_local(__constant struct Volume *volume, float x, float y, float z) {
    return (float4)((x - GRID_LOW) / volume->scale.x, (y - GRID_LOW) / volume->scale.y, (z - GRID_LOW) / volume->scale.z,
        0.0f);
}

INLINE struct Points scaled_direction(__constant struct Volume *volume, struct Points d) {
    return points(d.x * volume->scale.x, d.y * volume->scale.y, d.z * volume->scale.z);
}

// Points in the box, whatever rounding did. On a face they stay there: in media of 10^5 free paths and more a last place
// is a part of one, and light that starts deeper is returned less.
INLINE struct Points points_in_box(__constant struct Scattering *method, struct Points p) {
    float4 low = method->low;
    float4 high = method->high;
    return points(clamp(p.x, low.x, high.x), clamp(p.y, low.y, high.y), clamp(p.z, low.z, high.z));
}

// Puts the lanes of `mask` on new rays from `origin` (grid coordinates) along `direction` (local units), between two
// times. `random`: for the first tentative collision.
INLINE void start_rays(struct FlightLanes *f, struct RayLanes *ray, const struct MediumTables *m, struct Points origin,
    struct Points direction, Reals from, Reals to, Words random, Ints mask) {
    struct RayLanes fresh = ray_lanes(m->method, origin, scaled_direction(m->volume, direction));
    clip_rays(m->method, &fresh, &from, &to);
    *ray = pick_rays(*ray, fresh, mask);
    start_flights(f, ray, m, from, to, random, mask);
}

// Where the rays that see light start: camera rays at the eye, flights at their vertices.
INLINE Reals ray_start(const struct PathLanes *path) {
    return PICK((Reals)(0.0f), path->eye, path->ray == CAMERA_RAY);
}

#if defined(ESTIMATED) || defined(RECTANGLES) || defined(EQUIANGULAR)
// Estimates the transmittance of rays between two times in the lanes of `mask`; 1 where there is nothing between.
INLINE void estimate_lanes(struct PathLanes *path, const struct RayLanes *ray, const struct MediumTables *m, Reals from,
    Reals to, struct Tally *tally, uint sample, Ints mask, Reals estimate[TRACKED]) {
#ifdef CONSTANT_SIGMA
    for (int c = 0; c < TRACKED; ++c) {
        estimate[c] = exp(-m->method->sigma * channel_extinction(m, c) * max(to - from, (Reals)(0.0f)));
    }
#else
    RayTable rays;
    rays.all = *ray;
    IntLanes wanted = int_lanes(mask & (to > from));
    RealLanes start = real_lanes(from), end = real_lanes(to);
    WordLanes pixel, number, block;
    pixel.all = path->pixel;
    number.all = path->path;
    block.all = path->block;
    RealLanes found[TRACKED];
    for (int c = 0; c < TRACKED; ++c) {
        found[c] = real_lanes((Reals)(1.0f));
    }
    struct Cost cost;
    cost.lookups = cost.above = 0u;
    for (int i = 0; i < WIDTH; ++i) {
        if (!wanted.lane[i]) {
            continue;
        }
        struct TrackedRay tracked = ray_of_lane(&rays, i);
        // The path's own numbers, from where it is to where the estimate ends.
        struct Numbers numbers;
        numbers.stream = stream_start((uint2)(m->frame->seed_low, m->frame->seed_high), pixel.lane[i], sample,
            number.lane[i]);
        numbers.stream.counter.z = block.lane[i];
        numbers.used = 0u;
        float4 t = transmittance(m, &tracked, start.lane[i], end.lane[i], &numbers, &cost);
        block.lane[i] = numbers.stream.counter.z;
        for (int c = 0; c < TRACKED; ++c) {
            found[c].lane[i] = channel_of(t, c);
        }
    }
    path->block = block.all;
    for (int c = 0; c < TRACKED; ++c) {
        estimate[c] = found[c].all;
    }
    tally->lookups += cost.lookups;
    tally->above += cost.above;
#endif
}
#endif
