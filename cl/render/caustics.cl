// Pictures of surfaces: Whitted's ray tracing (1980) of mirrors and glass, direct light by shadow rays, and the light of
// photons (the rest of `cl/caustics/`). Radiance of a diffuse surface is albedo / pi times its irradiance.
//
// At glass a ray goes on both ways, as long as it carries enough; a fainter one takes either way by chance, with the
// probability of the light that goes there. Radiance that enters a medium of index n grows by n^2, and so for the ray.
//
// MEDIUM: the scene has a volume that absorbs and scatters (render/caustics_medium.cl). BOUNCED: there are photons that
// diffuse surfaces reflect, in a map of their own with a larger radius.
//
// Inputs: the surfaces as arrays, lights, the environment map, the maps of photons of this sample's pass; output: film.
#include "caustics/gather.cl"
#include "film/accumulate.cl"
#include "render/background.cl"
#include "render/camera.cl"
#include "render/frame.cl"
#ifdef DISPERSION
#include "caustics/spectrum.cl"
#endif
#include "surfaces/direct.cl"
#include "surfaces/optics.cl"
#include "surfaces/within.cl"
#include "types/caustics.cl"
#ifdef MEDIUM
#include "caustics/medium.cl"
#endif

// Rays that wait for their turn: each boundary adds one at most.
#define BRANCHES 12

#ifdef BOUNCED
#define MAPS 2u
#else
#define MAPS 1u
#endif

// A ray on its way from the camera.
struct Branch {
    float3 origin;
    float3 direction;
    float3 weight; // of its radiance in the pixel
    uint bounces;  // reflections and refractions so far
    struct Within within;
#ifdef DISPERSION
    float wavelength; // in micrometres, once glass has parted the colours; 0 before
#endif
};

// What a sample reads, and what it has found.
struct Sample {
    struct Surfaces surfaces;
    struct PhotonMap maps[MAPS];
    __constant struct Frame *frame;
    __constant struct Caustics *method;
#ifdef MEDIUM
    struct Medium medium;
#endif
    __global const struct Light *lights;
    __global const float4 *environment;
    uint2 seed;
    uint pixel;
    uint index;
    uint draws;    // random numbers used
    uint looked_at;
    float3 radiance;
};

INLINE float4 sample_random(struct Sample *sample) {
    uint purpose = RNG_SURFACES | (sample->draws++ << 8);
    return random4(sample->seed, sample->pixel, sample->index, purpose);
}

#ifdef MEDIUM
#include "render/caustics_medium.cl"
#endif

// Irradiance on a diffuse surface, on the side of the viewer, where it lies in `body` (see surfaces/within.cl).
INLINE float3 surface_irradiance(struct Sample *sample, const struct Hit *hit, uint body) {
    float3 irradiance = (float3)(0.0f);
    float3 normal = hit->inside ? -hit->normal : hit->normal;
#ifdef DIRECT_RAYS
    for (uint i = 0; i < sample->frame->light_count; ++i) {
        float2 u = (float2)(0.5f);
#ifdef RECTANGLES
        if (i < sample->frame->rectangle_count) {
            u = sample_random(sample).xy;
        }
#endif
        struct Arrival arrival = direct_light(&sample->surfaces, sample->lights + i, hit, normal, u);
        arrival.irradiance *= body_leaves(&sample->surfaces, body, arrival.distance);
#ifdef MEDIUM
        float3 e = arrival.irradiance;
        if (body == 0u && e.x + e.y + e.z > 0.0f) {
            arrival.irradiance *=
                medium_transmittance(&sample->medium, hit->point, arrival.direction, arrival.distance);
        }
#endif
        irradiance += arrival.irradiance;
    }
#endif
    float scale = sample->method->photon_scale;
    if (scale > 0.0f) {
        float3 face = hit->inside ? -hit->face : hit->face;
        // A loop, so that its body stands once in the kernel.
        for (uint i = 0; i < MAPS; ++i) {
            irradiance += scale
                * gathered_irradiance(&sample->maps[i], hit->point, face, hit->surface, hit->inside, &sample->looked_at);
        }
    }
    return irradiance;
}

// What the ray sees of what blocks nothing: the fronts of rectangles.
INLINE float3 seen_lights(struct Sample *sample, const struct Branch *ray, float distance, uint body) {
    float3 radiance = (float3)(0.0f);
#ifdef RECTANGLES
    for (uint i = 0; i < sample->frame->rectangle_count; ++i) {
        float4 origin = (float4)(ray->origin, 0.0f);
        float4 direction = (float4)(ray->direction, 0.0f);
        float away = rectangle_distance(sample->lights + i, origin, direction, 0.0f);
        if (away < distance) {
            float3 seen = sample->lights[i].power.xyz * body_leaves(&sample->surfaces, body, away);
#ifdef MEDIUM
            if (body == 0u) {
                seen *= medium_transmittance(&sample->medium, ray->origin, ray->direction, away);
            }
#endif
            radiance += seen;
        }
    }
#endif
    return radiance;
}

#ifdef DISPERSION
// The wavelength of what enters glass that parts the colours: one for each sample, evenly spread over samples.
INLINE float choose_wavelength(struct Sample *sample, struct Branch *on) {
    float start = random4(sample->seed, sample->pixel, 0u, RNG_WAVELENGTH).x;
    // Multiples of the golden ratio.
    float u = start + uniform_float(sample->index * 0x9E3779B9u);
    float wavelength = mix(SHORTEST_WAVELENGTH, LONGEST_WAVELENGTH, u - floor(u));
    on->weight *= color_of(1000.0f * wavelength) * sample->method->white.xyz;
    on->wavelength = wavelength;
    return wavelength;
}
#endif

// Sends a ray on over a boundary: both ways, or one of them by chance. Returns the number of rays that it added.
INLINE uint cross_boundary(struct Sample *sample, const struct Branch *ray, const struct Hit *hit, float4 cauchy,
    struct Branch *branches, uint room) {
    float3 facing = hit->inside ? -hit->normal : hit->normal;
    float cosine = max(-dot(ray->direction, facing), 0.0f);
    float index = cauchy.w;
    struct Branch back = *ray;
#ifdef DISPERSION
    bool parts = ray->wavelength == 0.0f && (cauchy.y != 0.0f || cauchy.z != 0.0f);
    // From the denser side, some colours may be reflected totally, and others not.
    if (parts && hit->inside == (index > 1.0f)) {
        choose_wavelength(sample, &back);
        parts = false;
    }
    if (back.wavelength > 0.0f) {
        index = index_at(cauchy, back.wavelength);
    }
#endif
    struct Boundary at = boundary(index, hit->inside, cosine);
    float passing = 1.0f - at.reflectance;
    // Of radiance that comes the other way.
    float density = hit->inside ? index * index : 1.0f / (index * index);
    back.direction = mirrored(ray->direction, facing);
    back.origin = surface_offset(hit, back.direction);
    back.bounces += 1u;
    struct Branch on = back;
    if (passing > 0.0f) {
#ifdef DISPERSION
        if (parts) {
            // What is reflected keeps its colours together: its share hardly depends on them.
            float own = index_at(cauchy, choose_wavelength(sample, &on));
            struct Boundary colored = boundary(own, hit->inside, cosine);
            // By the index with which it leaves again.
            density = hit->inside ? own * own : 1.0f / (own * own);
            if (colored.scale > 0.0f) {
                at.scale = colored.scale;
                at.shift = colored.shift;
            }
        }
#endif
        on.direction = refracted(at, ray->direction, facing);
        on.origin = surface_offset(hit, on.direction);
        on.weight *= density;
        on.within = crossed(ray->within, hit);
    }
    // As it would be outside: inside, radiance counts less and is more.
    float most = max(max(back.weight.x, back.weight.y), back.weight.z) * (hit->inside ? density : 1.0f);
    float carried = most * min(at.reflectance, passing);
    if (passing <= 0.0f || room < 2u || carried < sample->method->split) {
        bool reflect = passing <= 0.0f || sample_random(sample).x < at.reflectance;
        branches[0] = reflect ? back : on;
        return 1u;
    }
    back.weight *= at.reflectance;
    on.weight *= passing;
    branches[0] = back;
    branches[1] = on;
    return 2u;
}

// Follows a ray to where it ends or divides; returns the number of rays that it goes on as.
INLINE uint follow(struct Sample *sample, struct Branch ray, struct Hit *hit, struct Branch *branches, uint room) {
    bool met = surfaces_hit(&sample->surfaces, ray.origin, ray.direction, INFINITY, hit);
    if (!met) {
        hit->t = INFINITY;
    }
    uint body = met ? body_of_stretch(&sample->surfaces, ray.within, hit) : ray.within.body;
    sample->radiance += ray.weight * seen_lights(sample, &ray, hit->t, body);
#ifdef MEDIUM
    if (body == 0u) {
        ray.weight *= scattered_on_the_way(sample, &ray, hit->t);
    }
#endif
    if (!met) {
        sample->radiance += ray.weight * background_radiance(sample->frame, sample->environment, ray.direction);
        return 0u;
    }
    ray.weight *= body_leaves(&sample->surfaces, body, hit->t);
    __global const struct Material *material =
        sample->surfaces.materials + sample->surfaces.materials_of[hit->surface];
    if (material->kind == MATERIAL_DIFFUSE) {
        float3 albedo = material->color.xyz;
        sample->radiance += ray.weight * albedo * M_1_PI_F * surface_irradiance(sample, hit, body);
        return 0u;
    }
    if (ray.bounces >= sample->method->depth) {
        return 0u;
    }
    if (material->kind == MATERIAL_DIELECTRIC) {
        return cross_boundary(sample, &ray, hit, material->cauchy, branches, room);
    }
    float3 facing = hit->inside ? -hit->normal : hit->normal;
    ray.direction = mirrored(ray.direction, facing);
    ray.origin = surface_offset(hit, ray.direction);
    ray.weight *= material->color.xyz;
    ray.bounces += 1u;
    branches[0] = ray;
    return 1u;
}

__kernel void render_caustics(__constant struct Frame *frame, __constant struct Camera *camera,
#ifdef MEDIUM
    __constant struct Volume *volume, __constant struct Caustics *method, __global const VOXEL *voxels,
    __constant struct Scattering *scattering, __global const BrickBound *majorants, __global const float *sigmas,
    __global const float4 *albedos,
#else
    __constant struct Caustics *method,
#endif
    __global const struct Light *lights, __global const float4 *environment,
    __global const struct Shape *shapes, __global const struct Node *nodes, __global const struct Ball *balls,
    __global const float4 *normals, __global const uint *materials_of, __global const struct Material *materials,
    PHOTON_MAP_ARGUMENTS(map),
#ifdef BOUNCED
    PHOTON_MAP_ARGUMENTS(bounced),
#endif
    __global struct FilmPixel *film, uint first_tile, uint tile_count, uint first_sample,
    uint sample_count) {
    int pixel = frame_pixel(camera->width, camera->height, first_tile, tile_count);
    if (pixel < 0) {
        return;
    }
    struct PhotonMap map = PHOTON_MAP(map);
    struct Sample s;
    s.surfaces.shapes = shapes;
    s.surfaces.plane_count = method->plane_count;
    s.surfaces.nodes = nodes;
    s.surfaces.node_count = method->node_count;
    s.surfaces.balls = balls;
    s.surfaces.normals = normals;
    s.surfaces.materials_of = materials_of;
    s.surfaces.materials = materials;
    s.maps[0] = map;
#ifdef BOUNCED
    struct PhotonMap bounced = PHOTON_MAP(bounced);
    s.maps[1] = bounced;
#endif
    s.frame = frame;
    s.method = method;
    s.lights = lights;
    s.environment = environment;
    s.seed = (uint2)(frame->seed_low, frame->seed_high);
    s.pixel = (uint)pixel;
#ifdef MEDIUM
    s.medium = medium_of(frame, volume, scattering, voxels, majorants, sigmas, albedos);
#endif
    uint4 keys = philox4x32((uint4)((uint)pixel, 0u, 0u, 0u), s.seed);
    struct FilmPixel accumulated = film[pixel];
    for (uint turn = first_sample; turn < first_sample + sample_count; ++turn) {
        uint index = frame_sample(frame, turn);
        s.index = index;
        s.draws = 0u;
        s.looked_at = 0u;
        s.radiance = (float3)(0.0f);
#ifdef MEDIUM
        medium_numbers(&s.medium, (uint)pixel, index, RNG_MEDIUM);
#endif
        struct CameraRay ray = camera_ray(camera, (uint)pixel, index, keys);
        struct Branch branches[BRANCHES];
        branches[0].origin = ray.origin + ray.t_min * ray.direction;
        branches[0].direction = ray.direction;
        branches[0].weight = (float3)(1.0f);
        branches[0].bounces = 0u;
        branches[0].within = within_at(&s.surfaces, branches[0].origin, ray.direction);
#ifdef DISPERSION
        branches[0].wavelength = 0.0f;
#endif
        uint count = 1u;
        float depth = -1.0f;
        bool first = true;
        while (count > 0u) {
            --count;
            struct Hit hit;
            count += follow(&s, branches[count], &hit, branches + count, BRANCHES - count);
            if (first) {
                depth = hit.t < INFINITY ? hit.t : -1.0f;
                first = false;
            }
        }
        film_add(&accumulated, (float4)(s.radiance, depth >= 0.0f ? 1.0f : 0.0f), depth, s.looked_at);
    }
    film[pixel] = accumulated;
}
