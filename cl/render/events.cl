// What happens to paths where their rays end.
#include "render/auxiliary.cl"
#include "render/colors.cl"
#include "render/equiangular.cl"
#include "render/seen.cl"

INLINE Reals mean_channels(const Reals x[CHANNELS]) {
    Reals sum = x[0];
    for (int c = 1; c < CHANNELS; ++c) {
        sum += x[c];
    }
    return sum * (1.0f / CHANNELS);
}

// Adds the ended paths' light to their pixels.
INLINE void add_up(float4 *sums, const struct PathLanes *path, Ints ended) {
    IntLanes end = int_lanes(ended);
    IntLanes slot = int_lanes(path->slot);
    RealLanes opacity = real_lanes(path->opacity);
    RealLanes light[CHANNELS];
    for (int c = 0; c < CHANNELS; ++c) {
        light[c] = real_lanes(path->light[c]);
    }
    for (int i = 0; i < WIDTH; ++i) {
        if (end.lane[i]) {
            sums[slot.lane[i]] += (float4)(light[0].lane[i], light[CHANNELS / 2].lane[i], light[CHANNELS - 1].lane[i],
                opacity.lane[i]);
        }
    }
}

#ifndef CLOSED_FORM
// Looks the medium up where lanes wait at tentative collisions.
INLINE void look_up(struct PathLanes *path, struct FlightLanes *f, const struct RayLanes *ray,
    const struct MediumTables *m, struct Tally *tally) {
    Ints waiting = f->state == TENTATIVE;
    Words words[2];
    words[0] = path->lookups;
    words[1] = path->stream[1];
    philox2_lanes(words, path->stream[0]);
    path->lookups += PICK((Words)(0u), (Words)(1u), waiting);
    Ints above, collided;
    collide(f, ray, m, waiting, words, &above, &collided);
    tally->lookups += (uint)count_lanes(waiting);
    tally->collisions += (uint)count_lanes(collided);
    if (ANY(above)) {
        tally->above += (uint)count_lanes(above);
    }
}
#endif

#ifdef SAMPLE_LIGHTS
// Sends the lanes of `mask` on shadow rays from their vertices: towards a light, chosen and sampled by three numbers.
INLINE void seek_lights(struct PathLanes *path, struct FlightLanes *f, struct RayLanes *ray,
    const struct MediumTables *m, const struct Surroundings *s, struct Tally *tally, uint sample, const Words random[3],
    Words first, Ints mask) {
    IntLanes seeking = int_lanes(mask);
#ifdef EQUIANGULAR
    Reals enters = ray_start(path);
    Reals leaves = (Reals)(INFINITY);
    clip_rays(m->method, ray, &enters, &leaves);
    RayTable came;
    came.all = *ray;
    RealLanes from_x = real_lanes(path->direction.x), from_y = real_lanes(path->direction.y);
    RealLanes from_z = real_lanes(path->direction.z), collided = real_lanes(f->distance);
    RealLanes entered = real_lanes(enters), left = real_lanes(leaves);
#endif
    RealLanes x = real_lanes(path->vertex.x), y = real_lanes(path->vertex.y), z = real_lanes(path->vertex.z);
    RealLanes u = real_lanes(uniform_lanes(random[0]));
    RealLanes v = real_lanes(uniform_lanes(random[1])), w = real_lanes(uniform_lanes(random[2]));
    RealLanes dx = real_lanes((Reals)(1.0f)), dy = real_lanes((Reals)(0.0f)), dz = dy, far = dy, pdf = dy;
    RealLanes weight[CHANNELS];
    for (int c = 0; c < CHANNELS; ++c) {
        weight[c] = dy;
    }
    for (int i = 0; i < WIDTH; ++i) {
        if (!seeking.lane[i]) {
            continue;
        }
        struct LightSample light = light_sample(m->frame, s->lights, s->environment_sums, s->environment,
            grid_to_local(m->volume, x.lane[i], y.lane[i], z.lane[i]), (float4)(u.lane[i], v.lane[i], w.lane[i], 0.0f));
#ifdef EQUIANGULAR
        uint index = pick_light(s->lights, m->frame->light_count, u.lane[i]);
        if (is_point_light(m, s, index)) {
            struct Angles angles = angles_from(s->lights[index].position,
                grid_to_local(m->volume, came.lane[0][i], came.lane[1][i], came.lane[2][i]),
                (float4)(from_x.lane[i], from_y.lane[i], from_z.lane[i], 0.0f), entered.lane[i], left.lane[i]);
            light.weight *= share_of_collisions(&angles, collided.lane[i], m->method->mean_sigma);
        }
#endif
        dx.lane[i] = light.direction.x;
        dy.lane[i] = light.direction.y;
        dz.lane[i] = light.direction.z;
        far.lane[i] = light.distance;
        pdf.lane[i] = light.pdf;
        for (int c = 0; c < CHANNELS; ++c) {
            weight[c].lane[i] = channel_of(light.weight, c);
        }
    }
    struct Points direction = points(dx.all, dy.all, dz.all);
    Reals phase = phase_between(phase_parameters(m), path->direction, direction);
    // The flight that follows may meet the same light: the balance heuristic shares it between the two.
    Reals balanced = PICK((Reals)(1.0f), pdf.all / (pdf.all + phase), pdf.all > 0.0f);
    for (int c = 0; c < CHANNELS; ++c) {
        path->pending[c] = PICK(path->pending[c], path->throughput[c] * phase * balanced * weight[c].all, mask);
    }
    path->ray = PICK(path->ray, (Ints)(SHADOW_RAY), mask);
#ifdef ESTIMATED
    struct RayLanes shadow = ray_lanes(m->method, path->vertex, scaled_direction(m->volume, direction));
    Reals from = (Reals)(0.0f);
    clip_rays(m->method, &shadow, &from, &far.all);
    Reals estimate[TRACKED];
    estimate_lanes(path, &shadow, m, from, far.all, tally, sample, mask, estimate);
    for (int c = 0; c < TRACKED; ++c) {
        f->through[c] = PICK(f->through[c], estimate[c], mask);
    }
    f->state = PICK(f->state, (Ints)(ARRIVED), mask);
#else
    f->threshold = PICK(f->threshold, (Reals)(m->method->shadow_threshold), mask);
    f->scale = PICK(f->scale, (Reals)(m->method->majorant_scale), mask);
    start_rays(f, ray, m, path->vertex, direction, (Reals)(0.0f), far.all, first, mask);
#endif
}
#endif

// Goes on from the collisions of `hit`: emission, absorption, and whether the path ends there. Returns the lanes that
// scatter.
INLINE Ints scatter(struct PathLanes *path, struct FlightLanes *f, const struct MediumTables *m,
    const struct Surroundings *s, struct Tally *tally, Ints hit) {
    Reals zero = (Reals)(0.0f);
    // Camera rays through thin media go on with the probability of a collision (times `split`).
    Reals one = (Reals)(1.0f);
    Reals chance = PICK(one, min(one, m->method->split * f->taken), path->ray == CAMERA_RAY);
    Reals before[CHANNELS];
    for (int c = 0; c < CHANNELS; ++c) {
        before[c] = path->throughput[c] * collided_of(f, c);
    }
    Ints on = hit & (uniform_lanes(path->strata[1]) < chance);
    Reals reached = mean_channels(before);
    tally->gained += PICK(zero, PICK(-reached, reached / chance - reached, on), hit);
    Reals albedo[CHANNELS], emission[CHANNELS], absorbed[CHANNELS], after[CHANNELS];
    look_up_colors(f, m, s, on, albedo, emission);
    Ints cut = on & (path->order >= m->method->max_order);
    Reals largest = zero;
    for (int c = 0; c < CHANNELS; ++c) {
        Reals throughput = before[c] / chance;
        absorbed[c] = throughput * (1.0f - albedo[c]);
        Reals scattered = throughput * albedo[c];
        float control = channel_of(m->method->control, c);
        Reals lost = PICK(zero, scattered * control, cut);
        path->light[c] += PICK(zero, absorbed[c] * (emission[c] - control) - lost, on);
        after[c] = scattered;
        largest = max(largest, scattered);
    }
    tally->absorbed += PICK(zero, mean_channels(absorbed), on);
    tally->cut += PICK(zero, mean_channels(after), cut);
    // A path that is cut may have other flights to come from its last collision.
    Ints further = on & NOT(cut);
    for (int c = 0; c < CHANNELS; ++c) {
        path->throughput[c] = PICK(path->throughput[c], after[c], further);
    }
    path->order = PICK(path->order, path->order + 1, further);
    path->vertex = pick_points(path->vertex, points_in_box(m->method, f->place), further);
    path->incoming = pick_points(path->incoming, path->direction, further);
    path->flights = PICK(path->flights, (Ints)(m->method->flights), further);
    return further & (largest > 0.0f);
}

// Russian roulette: ends paths of small throughput at random. Returns the lanes that go on.
INLINE Ints play_roulette(struct PathLanes *path, const struct MediumTables *m, struct Tally *tally, Words random,
    Ints mask) {
    Reals largest = path->throughput[0];
    for (int c = 1; c < CHANNELS; ++c) {
        largest = max(largest, path->throughput[c]);
    }
    Reals zero = (Reals)(0.0f);
    Reals chance = clamp(largest / m->method->roulette_start, 0.05f, 1.0f);
    Ints on = mask & (uniform_lanes(random) < chance);
    Reals before = mean_channels(path->throughput);
    tally->gained += PICK(zero, PICK(-before, before / chance - before, on), mask);
    for (int c = 0; c < CHANNELS; ++c) {
        path->throughput[c] = PICK(path->throughput[c], path->throughput[c] / chance, on);
    }
    return on;
}

// The inverse of the golden ratio: its multiples spread evenly over a turn.
#define GOLDEN_TURN 0.618033989f

// Takes the paths whose rays have ended to their next rays. Returns the lanes whose paths have ended.
INLINE Ints take_turns(struct PathLanes *path, struct FlightLanes *f, struct RayLanes *ray, const struct MediumTables *m,
    const struct Surroundings *s, struct Tally *tally, uint sample) {
    Reals zero = (Reals)(0.0f);
    Ints arrived = f->state == ARRIVED;
    Ints shadow = arrived & (path->ray == SHADOW_RAY);
    Ints other = arrived & NOT(shadow);
    Words random[4];
    path_block(path, m, sample, arrived, random);

#ifdef SAMPLE_LIGHTS
    for (int c = 0; c < CHANNELS; ++c) {
        path->light[c] += PICK(zero, path->pending[c] * through_of(f, c), shadow);
    }
#endif
    Reals escaping[CHANNELS];
    for (int c = 0; c < CHANNELS; ++c) {
        escaping[c] = path->throughput[c] * through_of(f, c);
    }
    Reals escaped = mean_channels(escaping);
    tally->escaped += PICK(zero, escaped, other);
    see_lights(path, f, ray, m, s, tally, sample, other);
#ifdef EQUIANGULAR
    scatter_from_angles(path, f, ray, m, s, tally, sample, other & (path->order < m->method->max_order));
#endif
    Ints camera = other & (path->ray == CAMERA_RAY);
    path->opacity = PICK(path->opacity, f->taken, camera);
#ifdef AUXILIARY
    if (ANY(camera)) {
        Reals albedo[CHANNELS], emission[CHANNELS];
        look_up_colors(f, m, s, camera & (f->taken > 0.0f), albedo, emission);
        note_first_collisions(tally->notes, path, f, m, albedo, camera);
    }
#endif

    Ints scattered = scatter(path, f, m, s, tally, other & (f->taken > 0.0f));
    Ints turning = scattered;
#ifdef SAMPLE_LIGHTS
    Words to_light[3];
    Ints first = path->order == 1;
    to_light[0] = random[0];
    to_light[1] = PICK(random[1], path->strata[4], first);
    to_light[2] = PICK(random[2], path->strata[5], first);
    if (ANY(scattered)) {
        seek_lights(path, f, ray, m, s, tally, sample, to_light, random[3], scattered);
    }
    turning = shadow;
#endif
    Ints flying = play_roulette(path, m, tally, random[2], turning);
    if (m->method->flights == 0) {
        // A flight would see nothing.
        tally->cut += PICK(zero, mean_channels(path->throughput), flying);
        flying = (Ints)(0);
    }
    float share = 1.0f / (float)max(m->method->flights, 1);
    for (int c = 0; c < CHANNELS; ++c) {
        path->throughput[c] = PICK(path->throughput[c], share * path->throughput[c], flying);
    }
    flying = flying | (other & NOT(scattered) & (path->ray == FLIGHT) & (path->flights > 0));
    if (ANY(flying)) {
        // Several flights from one collision are spread evenly, from a random start.
        path->flights -= PICK((Ints)(0), (Ints)(1), flying);
        Reals turned = TO_REALS(path->flights);
        Ints once = path->order == 1;
        Reals u = uniform_lanes(PICK(random[0], path->strata[2], once)) + share * turned;
        Reals v = uniform_lanes(PICK(random[1], path->strata[3], once)) + turned * GOLDEN_TURN;
        u = min(u - floor(u), 1.0f - 0x1p-24f);
        v = min(v - floor(v), 1.0f - 0x1p-24f);
        Reals pdf;
        struct Points direction = phase_sample(phase_parameters(m), path->incoming, u, v, &pdf);
        path->direction = pick_points(path->direction, direction, flying);
        path->pdf = PICK(path->pdf, pdf, flying);
        path->ray = PICK(path->ray, (Ints)(FLIGHT), flying);
        f->threshold = PICK(f->threshold, (Reals)(m->method->flight_threshold), flying);
        f->scale = PICK(f->scale, (Reals)(m->method->majorant_scale), flying);
        start_rays(f, ray, m, path->vertex, direction, zero, (Reals)(INFINITY), random[3], flying);
    }
    // What turned has gone on, or roulette ended it; with lights, what scattered has gone to them first.
    Ints ended = arrived & NOT(flying) & (turning | NOT(scattered));
    f->state = PICK(f->state, (Ints)(RESTING), ended);
    path->ray = PICK(path->ray, (Ints)(NO_RAY), ended);
    return ended;
}
