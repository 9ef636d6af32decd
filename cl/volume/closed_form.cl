// Rays through a medium of constant extinction, without look-ups.
#include "volume/flight.cl"

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
