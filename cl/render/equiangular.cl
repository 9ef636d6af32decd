// Light of point lights near a ray, by places along the ray instead of collisions (Kulla and Fajardo 2012).
//
// Scattered light of a point light rises as 1 / r^2 near it; places drawn at equal angles as the light sees them follow
// that, collisions do not. Both sample the same integral along the ray. Their weights depend on the ray, the place and
// the light alone and add up to 1, so any shares leave the mean as it is; they are those of the balance heuristic with
// the density of collisions in a medium of the mean extinction.
#include "render/colors.cl"

#ifdef EQUIANGULAR

// A part of a ray as a light sees it.
struct Angles {
    float nearest; // where the ray is nearest to the light
    float height;  // how near it is there
    float first;   // angle from there to where the part begins
    float span;    // the angle that it covers
    float start;
    float length;
};

INLINE struct Angles angles_from(float4 light, float4 origin, float4 direction, float from, float to) {
    struct Angles a;
    float4 towards = light - origin;
    towards.w = 0.0f;
    a.nearest = dot(towards, direction);
    float4 across = towards - a.nearest * direction;
    a.start = from;
    a.length = to - from;
    // A light on the ray would have all places in itself.
    a.height = max(sqrt(dot(across, across)), 1e-6f * a.length);
    float low = from - a.nearest;
    float high = to - a.nearest;
    a.first = atan(low / a.height);
    a.span = atan2(a.height * a.length, a.height * a.height + low * high);
    return a;
}

// Whether places at equal angles are worth their cost: the light is much nearer than the part is long. Elsewhere
// collisions do as well, by measurement.
INLINE bool angles_matter(const struct Angles *a) {
    float aside = max(max(a->start - a->nearest, a->nearest - a->start - a->length), 0.0f);
    return a->length > 0.0f && aside * aside + a->height * a->height < a->length * a->length * (1.0f / 16.0f);
}

INLINE float place_of_angle(const struct Angles *a, float u) {
    return clamp(a->nearest + a->height * tan(a->first + u * a->span), a->start, a->start + a->length);
}

INLINE float angle_pdf(const struct Angles *a, float t) {
    float aside = t - a->nearest;
    return a->height / (a->span * (a->height * a->height + aside * aside));
}

// The density of collisions along the part in a medium of the mean extinction.
INLINE float reference_pdf(const struct Angles *a, float t, float mean_sigma) {
    return mean_sigma * exp(-mean_sigma * (t - a->start));
}

// The share of collisions at distance t in the light of a point light.
INLINE float share_of_collisions(const struct Angles *a, float t, float mean_sigma) {
    if (!angles_matter(a)) {
        return 1.0f;
    }
    float reference = reference_pdf(a, t, mean_sigma);
    return reference / (reference + angle_pdf(a, t));
}

INLINE bool is_point_light(const struct MediumTables *m, const struct Surroundings *s, uint index) {
    return index < m->frame->light_count && (int)s->lights[index].position.w == LIGHT_POINT;
}

// Adds the light of a point light to the lanes of `mask`, scattered at one place of their rays.
INLINE void scatter_from_angles(struct PathLanes *path, const struct FlightLanes *f, const struct RayLanes *ray,
    const struct MediumTables *m, const struct Surroundings *s, struct Tally *tally, uint sample, Ints mask) {
    Reals enters = ray_start(path);
    Reals leaves = (Reals)(INFINITY);
    clip_rays(m->method, ray, &enters, &leaves);
    mask &= leaves > enters;
    if (!ANY(mask)) {
        return;
    }
    Words random[4];
    path_block(path, m, sample, mask, random);
    IntLanes wanted = int_lanes(mask);
    RealLanes dx = real_lanes(path->direction.x), dy = real_lanes(path->direction.y), dz = real_lanes(path->direction.z);
    RealLanes ox = real_lanes(ray->origin.x), oy = real_lanes(ray->origin.y), oz = real_lanes(ray->origin.z);
    RealLanes from = real_lanes(enters), to = real_lanes(leaves);
    RealLanes u = real_lanes(uniform_lanes(random[0])), v = real_lanes(uniform_lanes(random[1]));
    RealLanes place = from, far = from, weight = real_lanes((Reals)(0.0f));
    RealLanes x = dx, y = dy, z = dz; // towards the light
    RealLanes power[CHANNELS];
    for (int c = 0; c < CHANNELS; ++c) {
        power[c] = weight;
    }
    for (int i = 0; i < WIDTH; ++i) {
        if (!wanted.lane[i]) {
            continue;
        }
        uint index = pick_light(s->lights, m->frame->light_count, u.lane[i]);
        if (!is_point_light(m, s, index)) {
            continue;
        }
        float4 origin = grid_to_local(m->volume, ox.lane[i], oy.lane[i], oz.lane[i]);
        float4 direction = (float4)(dx.lane[i], dy.lane[i], dz.lane[i], 0.0f);
        float4 position = s->lights[index].position;
        float4 intensity = s->lights[index].power;
        struct Angles a = angles_from(position, origin, direction, from.lane[i], to.lane[i]);
        if (!angles_matter(&a)) {
            continue;
        }
        float t = place_of_angle(&a, v.lane[i]);
        float4 towards = position - (origin + t * direction);
        towards.w = 0.0f;
        float distance2 = dot(towards, towards);
        if (!(distance2 > LIGHT_NEAREST2)) {
            continue;
        }
        place.lane[i] = t;
        far.lane[i] = sqrt(distance2);
        towards /= far.lane[i];
        x.lane[i] = towards.x;
        y.lane[i] = towards.y;
        z.lane[i] = towards.z;
        float shared = angle_pdf(&a, t) + reference_pdf(&a, t, m->method->mean_sigma);
        weight.lane[i] = 1.0f / (shared * distance2 * intensity.w);
        for (int c = 0; c < CHANNELS; ++c) {
            power[c].lane[i] = channel_of(intensity, c);
        }
    }
    mask &= weight.all > 0.0f;
    if (!ANY(mask)) {
        return;
    }
    // What scatters there.
    struct FlightLanes there = *f;
    there.place = points_in_box(m->method, points(ray->origin.x + place.all * ray->direction.x,
        ray->origin.y + place.all * ray->direction.y, ray->origin.z + place.all * ray->direction.z));
    Reals sigma = sigma_lanes(m, there.place, &there.value, &there.row);
    tally->lookups += (uint)count_lanes(mask);
    mask &= sigma > 0.0f;
    if (!ANY(mask)) {
        return;
    }
    Reals albedo[CHANNELS], emission[CHANNELS];
    look_up_colors(&there, m, s, mask, albedo, emission);
    struct Points direction = points(x.all, y.all, z.all);
    Reals phase = phase_between(phase_parameters(m), path->direction, direction);
    struct RayLanes shadow = ray_lanes(m->method, there.place, scaled_direction(m->volume, direction));
    Reals begins = (Reals)(0.0f);
    Reals ends = far.all;
    clip_rays(m->method, &shadow, &begins, &ends);
    Reals before[TRACKED], after[TRACKED];
    estimate_lanes(path, ray, m, enters, place.all, tally, sample, mask, before);
    estimate_lanes(path, &shadow, m, begins, ends, tally, sample, mask, after);
    for (int c = 0; c < CHANNELS; ++c) {
        int tracked = TRACKED == 1 ? 0 : c;
        Reals scattered = path->throughput[c] * before[tracked] * after[tracked] * sigma * albedo[c] * phase;
        Reals light = scattered * channel_extinction(m, c) * power[c].all * weight.all;
        path->light[c] += PICK((Reals)(0.0f), light, mask);
    }
}

#endif
