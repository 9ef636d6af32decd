// Light that the medium among surfaces scatters towards the camera. The photons of the map have that of mirrors and glass;
// direct light that is scattered once comes by shadow rays. One place in each of many stretches of a ray, at most a
// radius of gathering apart where it counts, each time others: the mean over the samples has no error of the steps.
//
// Included by render/caustics.cl, after struct Sample.

// Shadow rays of a stretch of a ray: places for them are a random one of so many that at least these are left.
#define LIT_PLACES 16u
#define MOST_PLACES 4096.0f

#ifdef DIRECT_RAYS
// Radiance that direct light gains per length by being scattered into a direction, over the scattering coefficient.
INLINE float3 scattered_direct(struct Sample *sample, float3 point, float3 leaving) {
    float3 sum = (float3)(0.0f);
    for (uint i = 0; i < sample->frame->light_count; ++i) {
        float2 u = (float2)(0.5f);
#ifdef RECTANGLES
        if (i < sample->frame->rectangle_count) {
            u = (float2)(medium_random(&sample->medium), medium_random(&sample->medium));
        }
#endif
        struct Arrival arrival = light_arrival_across(sample->lights + i, point, u);
        if (!light_arrives(&sample->surfaces, &arrival, point)) {
            continue;
        }
        float3 to = arrival.direction;
        float share = phase_between(medium_phase(&sample->medium), points(-to.x, -to.y, -to.z),
            points(leaving.x, leaving.y, leaving.z));
        share *= medium_transmittance(&sample->medium, point, to, arrival.distance);
        sum += share * arrival.irradiance;
    }
    return sum;
}
#endif

// How the places of a ray are spread: evenly, or where the extinction is the same everywhere as the light is lost on the
// way from them, so that thick media are looked at where they are seen.
struct Spread {
    float length; // over which the places would be even
    float sigma;  // 0: they are
    float taken;  // of the light
};

INLINE struct Spread spread_of(const struct Medium *medium, float length) {
    struct Spread spread = {length, 0.0f, 0.0f};
#ifdef CONSTANT_SIGMA
    float sigma = medium->tables.method->sigma;
    if (sigma * length > 1e-3f) {
        spread.sigma = sigma;
        spread.taken = -expm1(-sigma * length);
        spread.length = spread.taken / sigma;
    }
#endif
    return spread;
}

// How far along the ray the part `u` of the places is.
INLINE float spread_place(struct Spread spread, float u) {
    return spread.sigma > 0.0f ? -log1p(-u * spread.taken) / spread.sigma : u * spread.length;
}

// What one over the density of places is, over that of even ones; `left`: of the light.
INLINE float spread_weight(struct Spread spread, float left) {
    return spread.sigma > 0.0f ? 1.0f / left : 1.0f;
}

// Adds what the medium scatters towards the viewer before `end`; returns what it leaves of what comes from there.
INLINE float scattered_on_the_way(struct Sample *sample, const struct Branch *ray, float end) {
    struct Medium *medium = &sample->medium;
    struct MediumRay through = medium_ray(medium, ray->origin, ray->direction, end);
    float length = through.to - through.from;
    if (!(length > 0.0f)) {
        return 1.0f;
    }
    float photon_scale = sample->method->photon_scale;
    struct Spread spread = spread_of(medium, length);
    float count = photon_scale > 0.0f ? ceil(spread.length / sample->maps[0].frame->radius) : 0.0f;
    uint places = (uint)clamp(count, (float)LIT_PLACES, MOST_PLACES);
    uint apart = places / LIT_PLACES;
    uint lit = min((uint)(medium_random(medium) * (float)apart), apart - 1u);
    float part = 1.0f / (float)places;
    float left = 1.0f;
    float t = through.from;
    float3 light = (float3)(0.0f);
    for (uint i = 0; i < places; ++i) {
        float u = ((float)i + medium_random(medium)) * part;
        float next = min(through.from + spread_place(spread, u), through.to);
        left *= medium_leaves(medium, &through, t, next);
        if (!(left > 0.0f)) {
            break;
        }
        t = next;
        float3 point = ray->origin + t * ray->direction;
        float3 gained = (float3)(0.0f);
#ifdef DIRECT_RAYS
        if (i % apart == lit) {
            struct Scatterer at = scatterer_at(medium, point);
            float3 scattering = at.sigma * at.albedo;
            if (scattering.x + scattering.y + scattering.z > 0.0f) {
                gained = (float)apart * scattering * scattered_direct(sample, point, -ray->direction);
            }
        }
#endif
        if (photon_scale > 0.0f) {
            gained += photon_scale
                * photon_scattering(&sample->maps[0], point, medium_phase(medium), -ray->direction, &sample->looked_at);
        }
        light += left * spread_weight(spread, left) * gained;
    }
    sample->radiance += spread.length * part * ray->weight * light;
    return left > 0.0f ? left * medium_leaves(medium, &through, t, through.to) : 0.0f;
}
