// Rays from the centres of cells towards what lights them, WIDTH of them side by side. Where a centre does not stand for
// its cell (SPREAD), they start anywhere in it, and bring the mean over the cell, weighted by the extinction: what cells
// take from the light adds up to what the light loses, however thick they are.
//
// A ray loses light by residual ratio tracking, whose control is the minorant of each brick (Novák et al. 2014): where
// the medium is the same all over a brick, there is nothing to look up. Russian roulette ends rays that little is left
// of. Light that is attenuated by sigma_a + (1 - g) sigma_s instead (REDUCED) is estimated from the same look-ups, with
// other weights.
#include "common/directions.cl"
#include "common/random_lanes.cl"
#include "irradiance/grid.cl"
#include "lights/sample.cl"
#include "render/background.cl"
#include "volume/tracking.cl"

// Kinds of rays.
#define TO_LIGHT 0 // a sample of the lights
#define TO_SKY 1   // in any direction, where the background is not among them

// The passes of a cell are stratified in groups of so many (STRATA, a power of two up to 64), by the place on a light or
// the direction, the choice of the light, and the first tentative collision. On the cloud, the last makes the light of
// the sun 1.8 times as efficient, and 5 times in thin media; all of them that of the sky 3 to 4 times.
#ifndef STRATA
#define STRATA 16u
#endif

// Rays of which less is left play Russian roulette. Measured on the cloud: 0.05 and 0.2 are as efficient.
#define ROULETTE_FROM 0.1f

// Minorants are taken into account, for roulette, where they add up to this.
#define WORN_DEPTH 1.0f

// Channels whose reduced attenuation differs.
#ifdef GREY
#define REDUCED_TRACKED 1
#else
#define REDUCED_TRACKED 3
#endif

#define FOUR_PI 12.5663706f

// What rays read besides the medium.
struct DirectScene {
    __constant struct LightGrid *grid;
    __constant struct DirectParameters *parameters;
    __global const float2 *extents; // of irradiance_extents (SPREAD)
    __global const float4 *colors;
    __global const struct Light *lights;
    __global const float *environment_sums;
    __global const float4 *environment;
};

struct DirectLanes {
    Ints slot;                // cell within the work-item
    Words cell;
    Words kind;
    Words draws;              // random numbers count from the ray's own start,
    Words stream[2];          // drawn when it begins
    Reals weight[3];          // fluence that it brings if nothing is in its way
    struct Points direction;  // towards the light, local
#ifdef SPREAD
    struct Points place;      // where in its cell it starts, from -1 to 1 along each axis
#endif
#ifdef REDUCED
    Reals reduced[REDUCED_TRACKED]; // as `through`, by the reduced extinction
#endif
};

struct DirectTally {
    uint lookups;
    uint above;
};

INLINE float component(float4 v, int channel) {
    return channel == 0 ? v.x : channel == 1 ? v.y : v.z;
}

INLINE struct DirectLanes idle_rays(void) {
    struct DirectLanes d;
    Reals zero = (Reals)(0.0f);
    d.slot = (Ints)(0);
    d.cell = d.kind = d.draws = d.stream[0] = d.stream[1] = (Words)(0u);
    d.direction = points((Reals)(1.0f), zero, zero);
#ifdef SPREAD
    d.place = points(zero, zero, zero);
#endif
    for (int c = 0; c < 3; ++c) {
        d.weight[c] = zero;
    }
#ifdef REDUCED
    for (int c = 0; c < REDUCED_TRACKED; ++c) {
        d.reduced[c] = zero;
    }
#endif
    return d;
}

INLINE struct FlightLanes idle_flights(void) {
    struct FlightLanes f;
    Reals zero = (Reals)(0.0f);
    f.state = (Ints)(RESTING);
    f.bx = f.by = f.bz = (Ints)(0);
    f.t = f.end = f.depth = f.taken = f.distance = f.value = f.row = f.minorant = f.control = zero;
    f.majorant = f.scale = f.threshold = (Reals)(1.0f);
    for (int c = 0; c < TRACKED; ++c) {
        f.through[c] = f.share[c] = zero;
    }
    f.place = points(zero, zero, zero);
    return f;
}

#ifdef SAMPLE_LIGHTS
#ifdef SPREAD
// A point light as a box about `centre` sees it: from a point that is drawn in proportion to 1 / r^2 along a line through
// the light, so that weights are bounded wherever the light is. *place: where the ray starts.
INLINE struct LightSample lamp_of_box(__global const struct Light *lamp, float4 centre, float4 half_edges, float4 random,
    float4 *place) {
    float4 position = lamp->position;
    position.w = 0.0f;
    float4 off = position - centre;
    off.w = 0.0f;
    // Beyond 1 from outside, about 1 on a side.
    float4 from_sides = fabs(off) / (float4)(half_edges.xyz, 1.0f);
    bool inside = max(max(from_sides.x, from_sides.y), from_sides.z) < 1.00001f;
    float solid = FOUR_PI;
    float4 direction;
    if (inside) {
        float z = 1.0f - 2.0f * random.x;
        float radius = sqrt(max(1.0f - z * z, 0.0f));
        float angle = 6.28318531f * random.y;
        direction = (float4)(radius * cos(angle), radius * sin(angle), z, 0.0f);
        // From sides, all of them inwards.
        int4 aside = from_sides > 0.99999f;
        direction = select(direction, copysign(direction, -off), aside);
        solid *= (aside.x ? 0.5f : 1.0f) * (aside.y ? 0.5f : 1.0f) * (aside.z ? 0.5f : 1.0f);
    } else {
        direction = centre + half_edges * (2.0f * (float4)(random.xyz, 0.5f) - 1.0f) - position;
        direction.w = 0.0f;
        direction *= 1.0f / sqrt(max(dot(direction, direction), 1e-30f));
    }
    float2 way = way_in_box(position, direction, centre, half_edges);
    float t = mix(way.x, way.y, random.w);
    *place = position + t * direction;
    struct LightSample light;
    light.direction = -direction;
    light.distance = t;
    light.pdf = 0.0f;
    // 1 / r^2 times the volume of an element of solid angle and length is that element. Lines of length l inside come
    // with the density 1 / (4 pi l), those through points that are drawn evenly with (t1^3 - t0^3) / (3 V (t1 - t0)).
    float volume = 8.0f * half_edges.x * half_edges.y * half_edges.z;
    float share = inside ? solid * way.y / volume
                         : 3.0f / max(way.x * way.x + way.x * way.y + way.y * way.y, 1e-30f);
    float4 power = lamp->power;
    light.weight = power * (share / power.w);
    light.weight.w = 0.0f;
    return light;
}
#endif

// The sample of a light as a cell sees it, from *place, or, where the mean over a box about *centre is wanted, from a place
// for points of light.
INLINE struct LightSample light_of_cell(const struct MediumTables *m, const struct DirectScene *s, float4 *place,
    float4 u, float4 centre, float4 half_edges, float4 random) {
#ifdef SPREAD
    uint index = pick_light(s->lights, m->frame->light_count, u.x);
    if (half_edges.x > 0.0f && index < m->frame->light_count
        && (int)s->lights[index].position.w == LIGHT_POINT) {
        return lamp_of_box(s->lights + index, centre, half_edges, random, place);
    }
#endif
    return light_sample(m->frame, s->lights, s->environment_sums, s->environment, *place, u);
}
#endif

#ifdef SKY
// The background in a direction drawn from all over the sphere.
INLINE struct LightSample sky_of_cell(const struct MediumTables *m, const struct DirectScene *s, float4 direction) {
    struct LightSample light;
    light.direction = direction;
    light.weight = FOUR_PI * (float4)(background_radiance(m->frame, s->environment, direction.xyz), 0.0f);
    light.distance = INFINITY;
    light.pdf = 1.0f / FOUR_PI;
    return light;
}
#endif

// Puts the lanes of `begun` on new rays.
INLINE void begin_rays(struct DirectLanes *d, struct FlightLanes *f, struct RayLanes *ray, const struct MediumTables *m,
    const struct DirectScene *s, uint pass, Ints begun, struct DirectTally *tally) {
    uint2 seed = (uint2)(m->frame->seed_low, m->frame->seed_high);
    Words words[4], keys[4], strata[4];
    words[0] = keys[0] = d->cell;
    words[1] = (Words)(pass);
    keys[1] = (Words)(pass / STRATA);
    words[2] = keys[2] = (Words)(0u);
    words[3] = d->kind << 8 | RNG_DIRECT;
    keys[3] = d->kind << 8 | RNG_DIRECT_STRATA;
    philox_lanes(words, seed);
    philox_lanes(keys, seed);
    sobol_lanes((Words)(pass % STRATA), keys, strata);
    d->stream[0] = PICK(d->stream[0], words[0], begun);
    d->stream[1] = PICK(d->stream[1], words[1], begun);
    d->draws = PICK(d->draws, (Words)(0u), begun);
    Reals zero = (Reals)(0.0f);
#ifdef SPREAD
    // Where in their cells rays start, stratified, too.
    Words more[4], begins_at[4];
    more[0] = d->cell;
    more[1] = (Words)(pass / STRATA);
    more[2] = (Words)(1u);
    more[3] = d->kind << 8 | RNG_DIRECT_STRATA;
    philox_lanes(more, seed);
    sobol_lanes((Words)(pass % STRATA), more, begins_at);
    RealLanes place_x = real_lanes(uniform_lanes(begins_at[0])), place_y = real_lanes(uniform_lanes(begins_at[1]));
    RealLanes place_z = real_lanes(uniform_lanes(begins_at[2])), place_t = real_lanes(uniform_lanes(begins_at[3]));
#endif
    RealLanes u = real_lanes(uniform_lanes(strata[2]));
    RealLanes v = real_lanes(uniform_lanes(strata[0])), w = real_lanes(uniform_lanes(strata[1]));
#ifdef SKY
    struct Points sky = uniform_directions(v.all, w.all);
    RealLanes dx = real_lanes(sky.x), dy = real_lanes(sky.y), dz = real_lanes(sky.z);
#else
    RealLanes dx = real_lanes((Reals)(1.0f)), dy = real_lanes(zero), dz = dy;
#endif
    RealLanes x = real_lanes(zero), y = x, z = x, far = x;
#ifdef SPREAD
    RealLanes in_x = x, in_y = x, in_z = x;
#endif
    RealLanes weight[3];
    weight[0] = weight[1] = weight[2] = x;
    IntLanes begins = int_lanes(begun);
    WordLanes cell, kind;
    cell.all = d->cell;
    kind.all = d->kind;
    for (int i = 0; i < WIDTH; ++i) {
        if (!begins.lane[i]) {
            continue;
        }
        float4 centre = cell_centre(s->grid, cell_of(s->grid, cell.lane[i]));
        float4 place = centre;
        float4 half_edges = (float4)(0.0f);
        float4 random = half_edges;
#ifdef SPREAD
        float2 extent = s->extents[cell.lane[i]];
        half_edges = 0.5f * extent.x * s->grid->cell;
        random = (float4)(place_x.lane[i], place_y.lane[i], place_z.lane[i], place_t.lane[i]);
        place += half_edges * (2.0f * random - 1.0f);
#endif
        float4 choice = (float4)(u.lane[i], v.lane[i], w.lane[i], 0.0f);
        struct LightSample light;
#if defined(SKY) && defined(SAMPLE_LIGHTS)
        if (kind.lane[i] == TO_SKY) {
            light = sky_of_cell(m, s, (float4)(dx.lane[i], dy.lane[i], dz.lane[i], 0.0f));
        } else {
            light = light_of_cell(m, s, &place, choice, centre, half_edges, random);
        }
#elif defined(SKY)
        light = sky_of_cell(m, s, (float4)(dx.lane[i], dy.lane[i], dz.lane[i], 0.0f));
#else
        light = light_of_cell(m, s, &place, choice, centre, half_edges, random);
#endif
#ifdef SPREAD
        float4 in_cell = 2.0f * (place - centre) / (float4)(s->grid->cell.xyz, 1.0f);
        in_x.lane[i] = in_cell.x;
        in_y.lane[i] = in_cell.y;
        in_z.lane[i] = in_cell.z;
#endif
        place = place * m->volume->scale + GRID_LOW;
#if defined(SPREAD) && !defined(CONSTANT_SIGMA)
        if (extent.x > 0.0f && extent.y > 0.0f) {
            float value, row;
            light.weight *= sigma_at(m->frame, m->volume, m->voxels, m->sigmas, place, &value, &row) / extent.y;
            tally->lookups += 1u;
        }
#endif
        x.lane[i] = place.x;
        y.lane[i] = place.y;
        z.lane[i] = place.z;
        dx.lane[i] = light.direction.x;
        dy.lane[i] = light.direction.y;
        dz.lane[i] = light.direction.z;
        // What brings nothing need not travel.
        far.lane[i] = light.weight.x + light.weight.y + light.weight.z > 0.0f ? light.distance : -1.0f;
        for (int c = 0; c < 3; ++c) {
            weight[c].lane[i] = component(light.weight, c);
        }
    }
    for (int c = 0; c < 3; ++c) {
        d->weight[c] = PICK(d->weight[c], weight[c].all, begun);
    }
    struct Points direction = points(dx.all, dy.all, dz.all);
    d->direction = pick_points(d->direction, direction, begun);
#ifdef SPREAD
    d->place = pick_points(d->place, points(in_x.all, in_y.all, in_z.all), begun);
#endif
    float4 scale = m->volume->scale;
    struct RayLanes fresh = ray_lanes(m->method, points(x.all, y.all, z.all),
        points(direction.x * scale.x, direction.y * scale.y, direction.z * scale.z));
    Reals from = zero;
    Reals to = far.all;
    clip_rays(m->method, &fresh, &from, &to);
    *ray = pick_rays(*ray, fresh, begun);
#ifdef REDUCED
    for (int c = 0; c < REDUCED_TRACKED; ++c) {
        d->reduced[c] = PICK(d->reduced[c], (Reals)(1.0f), begun);
    }
#endif
#ifdef CONSTANT_SIGMA
    // All of the extinction is known.
    for (int c = 0; c < TRACKED; ++c) {
        f->through[c] = PICK(f->through[c], (Reals)(1.0f), begun);
    }
    f->control = PICK(f->control, m->method->sigma * max(to - from, zero), begun);
    f->state = PICK(f->state, (Ints)(ARRIVED), begun);
#else
    f->control = PICK(f->control, zero, begun);
    start_flights(f, ray, m, from, to, strata[3], begun);
#endif
}

// Takes the minorants on the way into account.
INLINE void wear(struct DirectLanes *d, struct FlightLanes *f, const struct MediumTables *m, const struct DirectScene *s,
    Ints mask) {
    for (int c = 0; c < TRACKED; ++c) {
        Reals left = f->through[c] * exp(-channel_extinction(m, c) * f->control);
        f->through[c] = PICK(f->through[c], left, mask);
    }
#ifdef REDUCED
    for (int c = 0; c < REDUCED_TRACKED; ++c) {
        float known = channel_extinction(m, c) * component(s->parameters->control, c);
        d->reduced[c] = PICK(d->reduced[c], d->reduced[c] * exp(-known * f->control), mask);
    }
#endif
    f->control = PICK(f->control, (Reals)(0.0f), mask);
}

#ifndef CONSTANT_SIGMA

// The next random words of the rays of `mask`.
INLINE void ray_words(struct DirectLanes *d, Ints mask, Words words[2]) {
    words[0] = d->draws;
    words[1] = d->stream[1];
    philox2_lanes(words, d->stream[0]);
    d->draws += PICK((Words)(0u), (Words)(1u), mask);
}

// Ends rays at random of which little is left, in all channels; the others stand for them.
INLINE void play_roulette(struct DirectLanes *d, struct FlightLanes *f, Words random, Ints mask) {
    Reals left = f->through[0];
    for (int c = 1; c < TRACKED; ++c) {
        left = max(left, f->through[c]);
    }
#ifdef REDUCED
    for (int c = 0; c < REDUCED_TRACKED; ++c) {
        left = max(left, d->reduced[c]);
    }
#endif
    Reals zero = (Reals)(0.0f);
    Reals chance = left * (1.0f / ROULETTE_FROM);
    Ints weak = mask & (chance < 1.0f);
    Ints lives = uniform_lanes(random) < chance;
    Reals factor = PICK(zero, 1.0f / chance, lives);
    for (int c = 0; c < TRACKED; ++c) {
        f->through[c] = PICK(f->through[c], f->through[c] * factor, weak);
    }
#ifdef REDUCED
    for (int c = 0; c < REDUCED_TRACKED; ++c) {
        d->reduced[c] = PICK(d->reduced[c], d->reduced[c] * factor, weak);
    }
#endif
    f->state = PICK(f->state, (Ints)(ARRIVED), weak & NOT(lives));
}

#ifdef REDUCED
// Extinction of light that is attenuated by sigma_a + (1 - g) sigma_s, relative to sigma_t, at the lanes' collisions.
INLINE void reduced_extinctions(const struct MediumTables *m, const struct DirectScene *s, Reals value, Reals row,
    Ints mask, Reals relative[REDUCED_TRACKED]) {
#ifdef CONSTANT_ALBEDO
    for (int c = 0; c < REDUCED_TRACKED; ++c) {
        relative[c] = (Reals)(component(s->parameters->control, c));
    }
#else
    IntLanes wanted = int_lanes(mask);
    RealLanes values = real_lanes(value), rows = real_lanes(row);
    RealLanes found[REDUCED_TRACKED];
    for (int c = 0; c < REDUCED_TRACKED; ++c) {
        found[c] = real_lanes((Reals)(1.0f));
    }
    for (int i = 0; i < WIDTH; ++i) {
        if (!wanted.lane[i]) {
            continue;
        }
        float4 albedo = table_color(m->frame, s->colors, table_place(m->frame, values.lane[i], rows.lane[i]));
        for (int c = 0; c < REDUCED_TRACKED; ++c) {
            found[c].lane[i] = 1.0f - s->parameters->mean_cosine * component(albedo, c);
        }
    }
    for (int c = 0; c < REDUCED_TRACKED; ++c) {
        relative[c] = found[c].all;
    }
#endif
}
#endif

// Looks the medium up where rays wait at tentative collisions.
INLINE void attenuate(struct DirectLanes *d, struct FlightLanes *f, const struct RayLanes *ray,
    const struct MediumTables *m, const struct DirectScene *s, struct DirectTally *tally) {
    Ints waiting = f->state == TENTATIVE;
    wear(d, f, m, s, waiting);
    Reals value, row;
    Reals sigma = sigma_lanes(m, flight_points(f, ray, m), &value, &row);
    Reals inverse = 1.0f / f->majorant;
    Reals part = (sigma - f->minorant) * inverse;
    Ints above = waiting & ((part > 1.0f) | (part < 0.0f));
    for (int c = 0; c < TRACKED; ++c) {
        Reals left = f->through[c] * (1.0f - channel_extinction(m, c) * part);
        f->through[c] = PICK(f->through[c], left, waiting);
    }
#ifdef REDUCED
    Reals relative[REDUCED_TRACKED];
    reduced_extinctions(m, s, value, row, waiting, relative);
    for (int c = 0; c < REDUCED_TRACKED; ++c) {
        Reals rest = (sigma * relative[c] - f->minorant * component(s->parameters->control, c)) * inverse;
        Reals left = d->reduced[c] * (1.0f - channel_extinction(m, c) * rest);
        d->reduced[c] = PICK(d->reduced[c], left, waiting);
    }
#endif
    Words words[2];
    ray_words(d, waiting, words);
    f->depth = PICK(f->depth, exponential_lanes(words[0]), waiting);
    f->state = PICK(f->state, (Ints)(TRAVELLING), waiting);
    play_roulette(d, f, words[1], waiting);
    tally->lookups += (uint)count_lanes(waiting);
    if (ANY(above)) {
        tally->above += (uint)count_lanes(above);
    }
}

// Rays that the minorants alone have worn down.
INLINE void wear_down(struct DirectLanes *d, struct FlightLanes *f, const struct MediumTables *m,
    const struct DirectScene *s, Ints worn) {
    wear(d, f, m, s, worn);
    Words words[2];
    ray_words(d, worn, words);
    play_roulette(d, f, words[1], worn);
}

#endif
