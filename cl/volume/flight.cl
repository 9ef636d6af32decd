// Null-collision tracking (Woodcock 1965; Galtier et al. 2013) of many rays at once, over a grid of majorants.
//
// A ray walks from brick to brick and meets tentative collisions with the brick's majorant as their rate. One with
// extinction sigma takes the share sigma / majorant of what is left of the ray: as a part (ratio tracking) while more
// than `threshold` is left, and all or nothing (delta tracking) below. What is left at the end, `through`, is an
// unbiased estimate of the transmittance; the parts taken, of which one is kept at random in proportion, are one of the
// collision density. `taken` + `through` is 1 exactly, whatever the medium and its majorant.
#include "common/exponential.cl"
#include "common/random_lanes.cl"
#include "types/path.cl"
#include "volume/tables.cl"

// Bounds per brick: majorant and minorant; -k as majorant: all bricks less than k away are empty.
typedef float2 BrickBound;

// What the medium is made from.
struct MediumTables {
    __constant struct Frame *frame;
    __constant struct Volume *volume;
    __constant struct Scattering *method;
    __global const VOXEL *voxels;
    __global const BrickBound *bounds;
    __global const float *sigmas;
};

// Rays in grid coordinates; `t` counts local length.
struct RayLanes {
    struct Points origin;
    struct Points direction; // grid units per local length
    struct Points inverse;
    struct Points ahead;     // 1 towards larger coordinates, else 0: kept as floats beside the plane times they enter
};

// Directions this close to an axis plane count as this far from it: 1 / direction stays finite, and over any box the
// ray moves less than a rounding.
#define LEAST_SLOPE 1e-12f

INLINE Reals off_zero(Reals d) {
    return PICK(d, copysign((Reals)(LEAST_SLOPE), d), fabs(d) < LEAST_SLOPE);
}

INLINE struct RayLanes ray_lanes(struct Points origin, struct Points direction) {
    struct RayLanes ray;
    ray.origin = origin;
    ray.direction = points(off_zero(direction.x), off_zero(direction.y), off_zero(direction.z));
    ray.inverse = points(1.0f / ray.direction.x, 1.0f / ray.direction.y, 1.0f / ray.direction.z);
    Reals zero = (Reals)(0.0f);
    Reals one = (Reals)(1.0f);
    ray.ahead = points(PICK(zero, one, ray.direction.x > 0.0f), PICK(zero, one, ray.direction.y > 0.0f),
        PICK(zero, one, ray.direction.z > 0.0f));
    return ray;
}

INLINE struct RayLanes pick_rays(struct RayLanes no, struct RayLanes yes, Ints mask) {
    struct RayLanes ray;
    ray.origin = pick_points(no.origin, yes.origin, mask);
    ray.direction = pick_points(no.direction, yes.direction, mask);
    ray.inverse = pick_points(no.inverse, yes.inverse, mask);
    ray.ahead = pick_points(no.ahead, yes.ahead, mask);
    return ray;
}

// Times between which rays are inside the box of what can hold extinction; *from > *to for a miss.
INLINE void clip_rays(__constant struct Scattering *method, const struct RayLanes *ray, Reals *from, Reals *to) {
    Reals x0 = (method->low.x - ray->origin.x) * ray->inverse.x;
    Reals x1 = (method->high.x - ray->origin.x) * ray->inverse.x;
    Reals y0 = (method->low.y - ray->origin.y) * ray->inverse.y;
    Reals y1 = (method->high.y - ray->origin.y) * ray->inverse.y;
    Reals z0 = (method->low.z - ray->origin.z) * ray->inverse.z;
    Reals z1 = (method->high.z - ray->origin.z) * ray->inverse.z;
    *from = max(*from, max(max(min(x0, x1), min(y0, y1)), min(z0, z1)));
    *to = min(*to, min(min(max(x0, x1), max(y0, y1)), max(z0, z1)));
}

// Channels whose transmittance differs.
#ifdef CHROMATIC
#define TRACKED 3
#else
#define TRACKED 1
#endif

// States: their sum over the lanes counts each (STATE_COUNT).
#define TRAVELLING 0     // on its way to the next tentative collision
#define TENTATIVE 1      // at one
#define ARRIVED 0x100    // at the end of the ray, or nothing left of it
#define RESTING 0x10000  // no ray
#define STATE_COUNT(sum, state) (((sum) / (state)) & 0xff)

struct FlightLanes {
    Ints state;
    Ints bx, by, bz;         // the brick
    Reals t;
    Reals end;               // where the ray ends
    Reals depth;             // optical depth (of the majorant) left to the next tentative collision
    Reals majorant;          // of the brick of the tentative collision
    Reals scale;             // factor of the majorants
    Reals threshold;
    Reals through[TRACKED];
    Reals taken;             // mean over the channels
    Reals share[TRACKED];    // weights of the kept collision relative to their mean
    struct Points place;     // of the kept collision, grid coordinates
    Reals distance;          // its t
    Reals value;             // its place in the transfer function: window value in entries of the table
    Reals row;               // ... and row of a 2-D one
};

// What is left of a ray, in a channel of light.
INLINE Reals through_of(const struct FlightLanes *f, int channel) {
    return f->through[TRACKED == 1 ? 0 : channel];
}

// The weight of the kept collision in a channel of light.
INLINE Reals collided_of(const struct FlightLanes *f, int channel) {
    return f->taken * f->share[TRACKED == 1 ? 0 : channel];
}

// The extinction of a tracked channel relative to sigma_t.
INLINE float channel_extinction(const struct MediumTables *m, int channel) {
#ifdef CHROMATIC
    return channel == 0 ? m->method->extinction.x : channel == 1 ? m->method->extinction.y : m->method->extinction.z;
#else
    return 1.0f;
#endif
}

#ifndef CONSTANT_SIGMA

INLINE Reals plane_time(Reals plane, Reals origin, Reals inverse) {
    return (plane - origin) * inverse;
}

// When a ray leaves the cube of 2 * reach - 1 bricks per edge around brick b, along one axis.
INLINE Reals leave_time(Ints b, Reals reach, Reals ahead, Reals origin, Reals inverse, float brick) {
    Reals plane = TO_REALS(b) + 1.0f - reach + ahead * (2.0f * reach - 1.0f);
    return plane_time(plane * brick, origin, inverse);
}

// The brick along one axis at time t. Truncation finds it up to one brick, plane times decide.
INLINE Ints seek_brick(Reals t, Reals ahead, Reals origin, Reals direction, Reals inverse, float brick, int count) {
    Reals position = max(origin + t * direction, (Reals)(0.0f)) * (1.0f / brick);
    Reals b = TO_REALS(min(TO_INTS(min(position, (Reals)(count - 1))), (Ints)(count - 1)));
    Reals step = 2.0f * ahead - 1.0f;
    Reals zero = (Reals)(0.0f);
    b -= PICK(zero, step, plane_time((b + 1.0f - ahead) * brick, origin, inverse) > t);
    b += PICK(zero, step, plane_time((b + ahead) * brick, origin, inverse) <= t);
    return TO_INTS(clamp(b, zero, (Reals)(count - 1)));
}

INLINE void seek_bricks(struct FlightLanes *f, const struct RayLanes *ray, __constant struct Volume *volume, Ints mask) {
    float brick = (float)(1 << volume->bricks.w);
    int4 n = volume->brick_counts;
    f->bx = PICK(f->bx, seek_brick(f->t, ray->ahead.x, ray->origin.x, ray->direction.x, ray->inverse.x, brick, n.x), mask);
    f->by = PICK(f->by, seek_brick(f->t, ray->ahead.y, ray->origin.y, ray->direction.y, ray->inverse.y, brick, n.y), mask);
    f->bz = PICK(f->bz, seek_brick(f->t, ray->ahead.z, ray->origin.z, ray->direction.z, ray->inverse.z, brick, n.z), mask);
}

INLINE Reals brick_majorants(const struct MediumTables *m, const struct FlightLanes *f) {
    Ints index = f->bx + f->by * m->volume->bricks.y + f->bz * m->volume->bricks.z;
    return gather_lanes((__global const float *)m->bounds, 2 * index);
}

// Moves every travelling ray to its next tentative collision in this brick, or to the next brick, or to its end.
INLINE void travel(struct FlightLanes *f, const struct RayLanes *ray, const struct MediumTables *m) {
    Ints travelling = f->state == TRAVELLING;
    Reals bound = brick_majorants(m, f);
    Ints empty = bound < 0.0f;
    Reals reach = PICK((Reals)(1.0f), -bound, empty);
    float brick = (float)(1 << m->volume->bricks.w);
    Reals tx = leave_time(f->bx, reach, ray->ahead.x, ray->origin.x, ray->inverse.x, brick);
    Reals ty = leave_time(f->by, reach, ray->ahead.y, ray->origin.y, ray->inverse.y, brick);
    Reals tz = leave_time(f->bz, reach, ray->ahead.z, ray->origin.z, ray->inverse.z, brick);
    Reals leave = min(min(tx, ty), tz);
    Reals next = max(min(leave, f->end), f->t);
    Reals rate = bound * f->scale;
    Reals depth = PICK(rate * (next - f->t), (Reals)(0.0f), empty);
    Ints hit = travelling & (f->depth < depth);
    Ints arrived = travelling & NOT(hit) & (next >= f->end);
    Ints on = travelling & NOT(hit) & NOT(arrived);
    f->t = PICK(f->t, min(f->t + f->depth / rate, next), hit);
    f->majorant = PICK(f->majorant, rate, hit);
    f->depth = PICK(f->depth, f->depth - depth, on);
    f->t = PICK(f->t, next, on);
    Ints far = on & (reach > 1.0f);
    Ints near = on & NOT(far);
    Ints zero = (Ints)(0);
    f->bx += PICK(zero, TO_INTS(2.0f * ray->ahead.x - 1.0f), near & (tx <= leave));
    f->by += PICK(zero, TO_INTS(2.0f * ray->ahead.y - 1.0f), near & (ty <= leave));
    f->bz += PICK(zero, TO_INTS(2.0f * ray->ahead.z - 1.0f), near & (tz <= leave));
    if (ANY(far)) {
        seek_bricks(f, ray, m->volume, far);
    }
    f->state = PICK(PICK(f->state, (Ints)(ARRIVED), arrived), (Ints)(TENTATIVE), hit);
}

#elif !defined(CLOSED_FORM)

// The same where the medium is one brick.
INLINE void travel(struct FlightLanes *f, const struct RayLanes *ray, const struct MediumTables *m) {
    Ints travelling = f->state == TRAVELLING;
    Reals rate = m->method->sigma * f->scale;
    Reals t = f->t + f->depth / rate;
    Ints hit = travelling & (t < f->end);
    f->t = PICK(f->t, t, hit);
    f->majorant = PICK(f->majorant, rate, hit);
    f->state = PICK(PICK(f->state, (Ints)(ARRIVED), travelling), (Ints)(TENTATIVE), hit);
}

#endif

// Where a tentative collision is: inside its brick, whatever rounding does, so that the majorant holds. The other lanes
// are inside the box of what can hold extinction too, wherever their rays went: they read voxels all the same.
INLINE struct Points flight_points(const struct FlightLanes *f, const struct RayLanes *ray,
    const struct MediumTables *m) {
    struct Points p = points(ray->origin.x + f->t * ray->direction.x, ray->origin.y + f->t * ray->direction.y,
        ray->origin.z + f->t * ray->direction.z);
#ifndef CONSTANT_SIGMA
    float brick = (float)(1 << m->volume->bricks.w);
    float4 high = m->method->high;
    Reals x = TO_REALS(f->bx) * brick;
    Reals y = TO_REALS(f->by) * brick;
    Reals z = TO_REALS(f->bz) * brick;
    // The last bricks reach beyond the voxels.
    p = points(min(max(p.x, x), min(x + brick, high.x)), min(max(p.y, y), min(y + brick, high.y)),
        min(max(p.z, z), min(z + brick, high.z)));
#endif
    return p;
}

// Extinction at points in grid coordinates, and the window values (in entries of the table) there.
INLINE Reals sigma_lanes(const struct MediumTables *m, struct Points p, Reals *value,
    Reals *row) {
    *row = (Reals)(0.0f);
#if defined(CONSTANT_SIGMA)
    *value = (Reals)(0.0f);
    return (Reals)(m->method->sigma);
#elif defined(TF_2D) || (WIDTH == 1 && !defined(SIGMA_RAMP))
    RealLanes x = real_lanes(p.x);
    RealLanes y = real_lanes(p.y);
    RealLanes z = real_lanes(p.z);
    RealLanes sigma, values, rows;
    for (int i = 0; i < WIDTH; ++i) {
        sigma.lane[i] = sigma_at(m->frame, m->volume, m->voxels, m->sigmas,
            (float4)(x.lane[i], y.lane[i], z.lane[i], 0.0f), &values.lane[i], &rows.lane[i]);
    }
    *value = values.all;
    *row = rows.all;
    return sigma.all;
#else
    *value = (sample_raw_lanes(m->volume, m->voxels, p) - m->volume->value_zero) * m->volume->value_scale;
#ifdef SIGMA_RAMP
    float last = (float)(m->frame->table_size - 1);
    return m->method->ramp_offset + m->method->ramp_slope * clamp(*value, 0.0f, last);
#else
    Reals position = clamp(*value, 0.0f, (float)(m->frame->table_size - 1));
    Ints index = min(TO_INTS(position), (Ints)((int)m->frame->table_size - 2));
    Reals low = gather_lanes(m->sigmas, index);
    Reals high = gather_lanes(m->sigmas + 1, index);
    return low + (position - TO_REALS(index)) * (high - low);
#endif
#endif
}

// Takes part in the tentative collisions of `mask`; two random words each. *above: lanes with extinction above the
// majorant.
INLINE void collide(struct FlightLanes *f, const struct RayLanes *ray, const struct MediumTables *m, Ints mask,
    const Words random[2], Ints *above, Ints *collided) {
    struct Points p = flight_points(f, ray, m);
    Reals value, row;
    Reals part = sigma_lanes(m, p, &value, &row) / f->majorant;
    *above = mask & (part > 1.0f);
    // What would be taken of each channel, and of their mean.
    Reals left = (Reals)(0.0f);
    Reals wanted = (Reals)(0.0f);
    Reals parts[TRACKED];
    for (int c = 0; c < TRACKED; ++c) {
        parts[c] = f->through[c] * part * channel_extinction(m, c);
        left += f->through[c] * (1.0f / TRACKED);
        wanted += parts[c] * (1.0f / TRACKED);
    }
    Reals u = uniform_lanes(random[1]);
    Ints fraction = left > f->threshold;
    Reals probability = wanted / left;
    Ints all = NOT(fraction) & (u < probability);
    Ints takes = mask & (fraction | all) & (wanted > 0.0f);
    Reals zero = (Reals)(0.0f);
    Reals mean = zero;
    Reals amounts[TRACKED];
    for (int c = 0; c < TRACKED; ++c) {
#if TRACKED == 1
        amounts[c] = PICK(f->through[c], parts[c], fraction);
        Reals rest = PICK(zero, f->through[c] - parts[c], fraction);
        f->through[c] = PICK(f->through[c], rest, takes);
#else
        // Delta tracking by the mean over channels: each channel divides by what the decision's probability was.
        amounts[c] = PICK(parts[c] / probability, parts[c], fraction);
        Reals missed = (f->through[c] - parts[c]) / (1.0f - probability);
        Reals rest = PICK(PICK(missed, zero, all), f->through[c] - parts[c], fraction);
        f->through[c] = PICK(f->through[c], rest, mask);
#endif
        mean += amounts[c] * (1.0f / TRACKED);
    }
    f->taken += PICK(zero, mean, takes);
    // A collision replaces the kept one with probability amount / taken so far. Where u was below the probability of
    // taking all, it is uniform below that.
    Reals again = PICK(u / probability, u, fraction);
    Ints keeps = takes & (again * f->taken < mean);
    for (int c = 0; c < TRACKED; ++c) {
        f->share[c] = PICK(f->share[c], amounts[c] / mean, keeps);
    }
    f->place = pick_points(f->place, p, keeps);
    f->distance = PICK(f->distance, f->t, keeps);
    f->value = PICK(f->value, value, keeps);
    f->row = PICK(f->row, row, keeps);
    f->depth = PICK(f->depth, exponential_lanes(random[0]), mask);
    left = zero;
    for (int c = 0; c < TRACKED; ++c) {
        left += f->through[c];
    }
    f->state = PICK(f->state, PICK((Ints)(ARRIVED), (Ints)(TRAVELLING), left > 0.0f), mask);
    *collided = takes;
}

#ifdef CLOSED_FORM

// (1 - exp(-tau)) / tau for tau >= 0: see mean_transmittance.
INLINE Reals mean_transmittance_lanes(Reals tau) {
    Reals series = 1.0f - tau * (1.0f / 2.0f) * (1.0f - tau * (1.0f / 3.0f) * (1.0f - tau * (1.0f / 4.0f)
        * (1.0f - tau * (1.0f / 5.0f) * (1.0f - tau * (1.0f / 6.0f) * (1.0f - tau * (1.0f / 7.0f))))));
    return PICK((1.0f - exp(-tau)) / tau, series, tau < 0.25f);
}

// -ln(1 - x) for 0 <= x < 1, precise for small x, by the exponential numbers' polynomial.
INLINE Reals minus_log_of_rest(Reals x) {
    Reals series = x * (1.0f + x * (1.0f / 2.0f + x * (1.0f / 3.0f + x * (1.0f / 4.0f + x * (1.0f / 5.0f
        + x * (1.0f / 6.0f))))));
    return PICK(-log(max(1.0f - x, 1e-30f)), series, x < 0.06f);
}

// Follows rays through a medium of constant extinction to their ends at once.
//
// Rays that look for all or nothing collide with the exponential distribution; the others take all that the medium
// takes, at one place of the truncated distribution. With extinction per channel, distances follow the mean of the
// channels' distributions and each channel divides by it.
INLINE void settle(struct FlightLanes *f, const struct RayLanes *ray, const struct MediumTables *m, Reals u, Ints mask) {
    Reals length = f->end - f->t;
    Reals sigma[TRACKED];
    Reals taken[TRACKED]; // 1 - transmittance
    Reals rest[TRACKED];  // transmittance, to its own precision
    Reals sum = (Reals)(0.0f);
    for (int c = 0; c < TRACKED; ++c) {
        sigma[c] = (Reals)(m->method->sigma * channel_extinction(m, c));
        Reals tau = sigma[c] * length;
        taken[c] = tau * mean_transmittance_lanes(tau);
        rest[c] = PICK(exp(-tau), 1.0f - taken[c], tau < 0.25f);
        sum += taken[c];
    }
    Reals zero = (Reals)(0.0f);
    Ints analog = f->threshold >= 1.0f;
    // The channel whose distribution the distance follows, and u as a number of its own.
    Reals chosen_sigma = sigma[0];
    Reals chosen_taken = taken[0];
#if TRACKED > 1
    Reals weights[TRACKED];
    Reals total = zero;
    for (int c = 0; c < TRACKED; ++c) {
        weights[c] = PICK(taken[c], (Reals)(1.0f), analog);
        total += weights[c];
    }
    u *= total;
    for (int c = 1; c < TRACKED; ++c) {
        Ints beyond = u >= weights[c - 1];
        chosen_sigma = PICK(chosen_sigma, sigma[c], beyond);
        chosen_taken = PICK(chosen_taken, taken[c], beyond);
        u = PICK(u, u - weights[c - 1], beyond);
        // Once a channel is chosen, the later comparisons must fail.
        weights[c] = PICK((Reals)(INFINITY), weights[c], beyond);
    }
    u = min(u / PICK(chosen_taken, (Reals)(1.0f), analog), 1.0f - 0x1p-24f);
#endif
    Reals distance = minus_log_of_rest(u * PICK(chosen_taken, (Reals)(1.0f), analog)) / max(chosen_sigma, 1e-30f);
    Ints through = mask & analog & (distance >= length);
    Ints collides = mask & NOT(through) & (sum > 0.0f);
    distance = min(distance, length);
    Reals density[TRACKED];
    Reals mean_density = zero;
    Reals mean_through = zero;
    for (int c = 0; c < TRACKED; ++c) {
        density[c] = sigma[c] * (1.0f - sigma[c] * distance * mean_transmittance_lanes(sigma[c] * distance));
        mean_density += density[c] * (1.0f / TRACKED);
        mean_through += rest[c] * (1.0f / TRACKED);
    }
    for (int c = 0; c < TRACKED; ++c) {
        Reals left = PICK(rest[c], PICK(zero, rest[c] / mean_through, through), analog);
#if TRACKED == 1
        left = PICK(rest[c], PICK(zero, (Reals)(1.0f), through), analog);
#endif
        f->through[c] = PICK(f->through[c], left, mask);
        f->share[c] = PICK(f->share[c], TRACKED == 1 ? (Reals)(1.0f) : density[c] / mean_density, collides);
    }
    f->taken = PICK(f->taken, PICK(sum * (1.0f / TRACKED), (Reals)(1.0f), analog), collides);
    Reals t = f->t + distance;
    f->distance = PICK(f->distance, t, collides);
    f->place = pick_points(f->place, points(ray->origin.x + t * ray->direction.x, ray->origin.y + t * ray->direction.y,
        ray->origin.z + t * ray->direction.z), collides);
    f->state = PICK(f->state, (Ints)(ARRIVED), mask);
}

#endif

// Readies the flights of `mask` for their rays, between two times and by their threshold and scale. `random`: for the
// first tentative collision.
INLINE void start_flights(struct FlightLanes *f, const struct RayLanes *ray, const struct MediumTables *m, Reals from,
    Reals to, Words random, Ints mask) {
    f->t = PICK(f->t, from, mask);
    f->end = PICK(f->end, to, mask);
    for (int c = 0; c < TRACKED; ++c) {
        f->through[c] = PICK(f->through[c], (Reals)(1.0f), mask);
    }
    f->taken = PICK(f->taken, (Reals)(0.0f), mask);
    Ints misses = mask & NOT(to > from);
    f->state = PICK(f->state, PICK((Ints)(TRAVELLING), (Ints)(ARRIVED), misses), mask);
#ifdef CLOSED_FORM
    settle(f, ray, m, uniform_lanes(random), mask & NOT(misses));
#else
    f->depth = PICK(f->depth, exponential_lanes(random), mask);
#ifndef CONSTANT_SIGMA
    seek_bricks(f, ray, m->volume, mask);
#endif
#endif
}
