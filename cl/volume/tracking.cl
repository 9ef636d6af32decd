// Null-collision tracking (Woodcock 1965; Galtier et al. 2013) of many rays at once, over a grid of majorants.
//
// A ray walks from brick to brick and meets tentative collisions with the brick's majorant as their rate. One with
// extinction sigma takes the share sigma / majorant of what is left of the ray: as a part (ratio tracking) while more
// than `threshold` is left, and all or nothing (delta tracking) below. What is left at the end, `through`, is an
// unbiased estimate of the transmittance; the parts taken, of which one is kept at random in proportion, are one of the
// collision density. `taken` + `through` is 1 exactly, whatever the medium and its majorant.
//
// CONTROLLED: tentative collisions are those of the extinction above the brick's minorant alone (residual tracking, Novák
// et al. 2014), and `control` sums the minorant's optical depth up. `collide` does not know of that.
#include "common/exponential.cl"
#include "volume/closed_form.cl"
#include "volume/flight.cl"

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

// Majorants (which = 0) or minorants (1).
INLINE Reals brick_bounds(const struct MediumTables *m, const struct FlightLanes *f, int which) {
    Ints index = f->bx + f->by * m->volume->bricks.y + f->bz * m->volume->bricks.z;
    return gather_lanes((__global const float *)m->bounds, 2 * index + which);
}

// Moves every travelling ray to its next tentative collision in this brick, or to the next brick, or to its end.
INLINE void travel(struct FlightLanes *f, const struct RayLanes *ray, const struct MediumTables *m) {
    Ints travelling = f->state == TRAVELLING;
    Reals bound = brick_bounds(m, f, 0);
    Ints empty = bound < 0.0f;
    Reals reach = PICK((Reals)(1.0f), -bound, empty);
    float brick = (float)(1 << m->volume->bricks.w);
    Reals tx = leave_time(f->bx, reach, ray->ahead.x, ray->origin.x, ray->inverse.x, brick);
    Reals ty = leave_time(f->by, reach, ray->ahead.y, ray->origin.y, ray->inverse.y, brick);
    Reals tz = leave_time(f->bz, reach, ray->ahead.z, ray->origin.z, ray->inverse.z, brick);
    Reals leave = min(min(tx, ty), tz);
    Reals next = max(min(leave, f->end), f->t);
#ifdef CONTROLLED
    Reals minorant = brick_bounds(m, f, 1);
    Reals rate = m->over * bound - m->under * minorant;
#else
    Reals rate = bound * f->scale;
#endif
    Reals depth = PICK(rate * (next - f->t), (Reals)(0.0f), empty);
    Ints hit = travelling & (f->depth < depth);
    Ints arrived = travelling & NOT(hit) & (next >= f->end);
    Ints on = travelling & NOT(hit) & NOT(arrived);
#ifdef CONTROLLED
    Reals way = PICK(next, min(f->t + f->depth / rate, next), hit) - f->t;
    f->control += PICK((Reals)(0.0f), minorant * way, travelling);
    f->minorant = PICK(f->minorant, minorant, hit);
#endif
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
