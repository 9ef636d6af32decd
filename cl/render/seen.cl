// What rays see besides the medium: the background behind it, and rectangles anywhere.
#include "render/paths.cl"

#ifdef RECTANGLES
// Adds the rectangles that the rays of `mask` meet: before the box of the medium, inside, or behind it, where `through`
// is what is left of the ray. A ray that looks for all or nothing sees those before its collision.
INLINE void see_rectangles(struct PathLanes *path, const struct FlightLanes *f, const struct RayLanes *ray,
    const struct MediumTables *m, const struct Surroundings *s, struct Tally *tally, uint sample, Ints mask,
    const Reals through[TRACKED]) {
    RealLanes dx = real_lanes(path->direction.x), dy = real_lanes(path->direction.y), dz = real_lanes(path->direction.z);
    RealLanes ox = real_lanes(ray->origin.x), oy = real_lanes(ray->origin.y), oz = real_lanes(ray->origin.z);
    RealLanes pdf = real_lanes(path->pdf), start = real_lanes(ray_start(path));
    IntLanes seeing = int_lanes(mask);
    Reals enters = start.all;
    Reals leaves = (Reals)(INFINITY);
    clip_rays(m->method, ray, &enters, &leaves);
    for (uint k = 0; k < m->frame->rectangle_count; ++k) {
        __global const struct Light *light = s->lights + k;
        RealLanes distance = real_lanes((Reals)(INFINITY));
        RealLanes seen[CHANNELS];
        for (int c = 0; c < CHANNELS; ++c) {
            seen[c] = real_lanes((Reals)(0.0f));
        }
        for (int i = 0; i < WIDTH; ++i) {
            if (!seeing.lane[i]) {
                continue;
            }
            float4 direction = (float4)(dx.lane[i], dy.lane[i], dz.lane[i], 0.0f);
            float4 origin = grid_to_local(m->volume, ox.lane[i], oy.lane[i], oz.lane[i]);
            float at = rectangle_distance(light, origin, direction, start.lane[i]);
            if (at < INFINITY) {
                float4 radiance = rectangle_radiance(light, direction, at, pdf.lane[i]);
                distance.lane[i] = at;
                for (int c = 0; c < CHANNELS; ++c) {
                    seen[c].lane[i] = channel_of(radiance, c);
                }
            }
        }
        Ints met = mask & (distance.all < INFINITY);
        if (!ANY(met)) {
            continue;
        }
        Ints before = (distance.all <= enters) | NOT(leaves > enters);
        Ints behind = NOT(before) & (distance.all >= leaves);
        Ints inside = met & NOT(before) & NOT(behind);
#if TRACKED == 1
        Ints whole = f->threshold >= 1.0f;
        Ints reached = NOT(f->taken > 0.0f) | (distance.all < f->distance);
        inside = inside & NOT(whole);
#endif
        Reals estimate[TRACKED];
        for (int c = 0; c < TRACKED; ++c) {
            estimate[c] = (Reals)(1.0f);
        }
        if (ANY(inside)) {
            estimate_lanes(path, ray, m, enters, distance.all, tally, sample, inside, estimate);
        }
        for (int c = 0; c < CHANNELS; ++c) {
            int tracked = TRACKED == 1 ? 0 : c;
            Reals left = PICK(PICK(estimate[tracked], through[tracked], behind), (Reals)(1.0f), before);
#if TRACKED == 1
            left = PICK(left, PICK((Reals)(0.0f), (Reals)(1.0f), reached), whole & NOT(before) & NOT(behind));
#endif
            path->light[c] += PICK((Reals)(0.0f), path->throughput[c] * left * seen[c].all, met);
        }
    }
}
#endif

// Adds what the lanes of `mask` see: rectangles, and what the background behind the medium differs by from the radiance
// that light is counted from.
INLINE void see_lights(struct PathLanes *path, const struct FlightLanes *f, const struct RayLanes *ray,
    const struct MediumTables *m, const struct Surroundings *s, struct Tally *tally, uint sample, Ints mask) {
    Reals through[TRACKED];
    for (int c = 0; c < TRACKED; ++c) {
        through[c] = f->through[c];
    }
#if !defined(ENVIRONMENT)
    float4 background = m->frame->background - m->method->control;
    bool bright = background.x != 0.0f || background.y != 0.0f || background.z != 0.0f;
#ifndef RECTANGLES
    if (!bright) {
        return;
    }
#endif
#endif
#ifdef ESTIMATED
    // Where flights leave fractions, estimates of their own tell better what is behind.
    Ints estimated = mask & (f->threshold < 1.0f);
    if (ANY(estimated)) {
        Reals from = ray_start(path);
        Reals to = (Reals)(INFINITY);
        clip_rays(m->method, ray, &from, &to);
        Reals estimate[TRACKED];
        estimate_lanes(path, ray, m, from, to, tally, sample, estimated, estimate);
        for (int c = 0; c < TRACKED; ++c) {
            through[c] = PICK(through[c], estimate[c], estimated);
        }
    }
#endif
#ifdef ENVIRONMENT
    Reals left = through[0];
    for (int c = 1; c < TRACKED; ++c) {
        left = max(left, fabs(through[c]));
    }
    IntLanes seeing = int_lanes(mask & (left != 0.0f));
    RealLanes dx = real_lanes(path->direction.x), dy = real_lanes(path->direction.y), dz = real_lanes(path->direction.z);
    RealLanes pdf = real_lanes(path->pdf);
    RealLanes seen[CHANNELS];
    for (int c = 0; c < CHANNELS; ++c) {
        seen[c] = real_lanes((Reals)(0.0f));
    }
    for (int i = 0; i < WIDTH; ++i) {
        if (!seeing.lane[i]) {
            continue;
        }
        float4 direction = (float4)(dx.lane[i], dy.lane[i], dz.lane[i], 0.0f);
        float4 radiance = (float4)(0.0f);
        radiance.xyz = (background_radiance(m->frame, s->environment, direction.xyz) - m->method->control.xyz)
            * balance(pdf.lane[i], environment_pdf(m->frame, s->environment_sums, direction));
        for (int c = 0; c < CHANNELS; ++c) {
            seen[c].lane[i] = channel_of(radiance, c);
        }
    }
    for (int c = 0; c < CHANNELS; ++c) {
        Reals light = path->throughput[c] * through[TRACKED == 1 ? 0 : c] * seen[c].all;
        path->light[c] += PICK((Reals)(0.0f), light, mask);
    }
#else
    if (bright) {
        for (int c = 0; c < CHANNELS; ++c) {
            Reals light = path->throughput[c] * through[TRACKED == 1 ? 0 : c] * channel_of(background, c);
            path->light[c] += PICK((Reals)(0.0f), light, mask);
        }
    }
#endif
#ifdef RECTANGLES
    see_rectangles(path, f, ray, m, s, tally, sample, mask, through);
#endif
}
