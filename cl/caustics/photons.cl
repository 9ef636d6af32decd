// Photons from the lights over mirrors and glass to the first diffuse surface (Jensen 2001).
//
// Defines: SHAPE_* as cl/surfaces/intersect.cl has them; DISPERSION where an index depends on the wavelength;
// STORE_DIRECT to keep photons that meet a diffuse surface first, too; MEDIUM and what cl/caustics/medium.cl has besides.
//
// The medium stops photons that met a mirror or glass before, stores and scatters them on; those that come from a light
// end where it scatters them, as cameras see their light by other means (with STORE_DIRECT they do not).
#include "caustics/emission.cl"
#include "caustics/marks.cl"
#include "caustics/spectrum.cl"
#include "common/numeric.cl"
#include "common/octahedron.cl"
#include "surfaces/optics.cl"
#include "types/photon.cl"
#ifdef MEDIUM
#include "caustics/collisions.cl"
#define MEDIUM_OF_PHOTON , struct Medium *medium, struct Kept *kept
#else
#define MEDIUM_OF_PHOTON
#endif

#ifdef STORE_DIRECT
#define IS_STORED(turns) true
#else
#define IS_STORED(turns) ((turns) > 0u)
#endif

INLINE float mean_channel(float3 flux) {
    return (flux.x + flux.y + flux.z) * (1.0f / 3.0f);
}

// Where a photon went. Two float4, as an account has them.
struct Fate {
    float4 met;
    float4 lost;
    bool stored;
};

// The number that decides whether glass reflects a photon. The first two times, which make most caustics, by a lattice over
// the cells: of neighbours, as many are reflected as should be, not so many on average.
INLINE float choice_of(__global const struct PhotonFrame *frame, const struct Flight *flight, uint index, uint pass,
    uint turn) {
    if (turn < 2u) {
        return lattice_number(flight->cell, turn == 0u ? LATTICE_FIRST : LATTICE_SECOND,
            turn == 0u ? flight->shifts.x : flight->shifts.y);
    }
    uint4 counter = (uint4)(index, pass, turn, RNG_PHOTON);
    return uniform_float(philox4x32(counter, (uint2)(frame->seed_low, frame->seed_high)).x);
}

// A mirror or glass turns the photon; what is absorbed is taken off its flux. `u`: uniform in [0, 1).
INLINE void turn_photon(const struct Surfaces *surfaces, const struct Hit *hit, __global const struct Material *material,
    float wavelength, float u, struct Flight *flight) {
    float3 facing = hit->inside ? -hit->normal : hit->normal;
    float cosine = -dot(flight->direction, facing);
    // Normals for shading may face away from a ray that grazes; that of the surface does not.
    if (!(cosine > 0.0f)) {
        facing = hit->inside ? -hit->face : hit->face;
        cosine = fabs(dot(flight->direction, facing));
    }
    cosine = min(cosine, 1.0f);
    float3 direction = mirrored(flight->direction, facing);
    if (material->kind == MATERIAL_MIRROR) {
        flight->flux *= material->color.xyz;
    } else {
#ifdef DISPERSION
        float index = index_at(material->cauchy, wavelength);
#else
        float index = material->cauchy.w;
#endif
        struct Boundary at = boundary(index, hit->inside, cosine);
        if (u >= at.reflectance) {
            direction = refracted(at, flight->direction, facing);
            flight->within = crossed(flight->within, hit);
        }
    }
    flight->direction = direction;
    flight->origin = surface_offset(hit, direction);
}

// Glass that parts the colours makes a white photon one of its wavelength. Returns what that adds to its flux, which is
// counted as emitted: for all wavelengths together it is nothing.
INLINE float part_colors(__global const struct PhotonFrame *frame, __global const struct Material *material,
    float wavelength, struct Flight *flight) {
#ifdef DISPERSION
    bool parts = material->kind == MATERIAL_DIELECTRIC && (material->cauchy.y != 0.0f || material->cauchy.z != 0.0f);
    if (parts && flight->white) {
        float before = mean_channel(flight->flux);
        flight->flux *= color_of(1000.0f * wavelength) * frame->white.xyz;
        flight->white = false;
        return mean_channel(flight->flux) - before;
    }
#endif
    return 0.0f;
}

INLINE bool is_dark(const struct Flight *flight) {
    return flight->flux.x == 0.0f && flight->flux.y == 0.0f && flight->flux.z == 0.0f;
}

INLINE struct Photon no_photon(void) {
    struct Photon photon;
    photon.position = (float4)(0.0f);
    photon.flux = (float4)(0.0f);
    return photon;
}

INLINE uint hit_mark(const struct Hit *hit) {
    return mark_of(hit->surface, hit->inside, hit->inside ? -hit->face : hit->face);
}

// Follows a photon to its end.
INLINE struct Photon follow(__global const struct PhotonFrame *frame, const struct Surfaces *surfaces,
    struct Flight *flight, float wavelength, uint index, uint pass, struct Fate *fate MEDIUM_OF_PHOTON) {
    struct Photon photon = no_photon();
    float flux = mean_channel(flight->flux);
    fate->met = (float4)(flux, 0.0f, 0.0f, 0.0f);
    fate->lost = (float4)(0.0f);
    fate->stored = false;
    // Such as a rectangular light sends behind it.
    if (is_dark(flight)) {
        return photon;
    }
    for (uint turns = 0;; ++turns) {
        struct Hit hit;
        bool met = surfaces_hit(surfaces, flight->origin, flight->direction, INFINITY, &hit);
#ifdef MEDIUM
        if ((met ? body_of_stretch(surfaces, flight->within, &hit) : flight->within.body) == 0u) {
            struct Collision at = meet_medium(medium, &flight->origin, &flight->direction, &flight->flux,
                met ? hit.t : INFINITY, IS_STORED(turns), kept);
            if (at.outcome != PASSES) {
                fate->lost.z += at.absorbed;
                flux = at.scattered;
                if (at.outcome == ENDS) {
                    fate->met.z = flux;
                    return photon;
                }
                fate->lost.w += flux;
                fate->stored = true;
                if (turns < frame->depth) {
                    continue;
                }
                fate->lost.y = flux;
                return photon;
            }
        }
#endif
        if (!met) {
            fate->lost.x = flux;
            return photon;
        }
        __global const struct Material *material = surfaces->materials + surfaces->materials_of[hit.surface];
        bool diffuse = material->kind == MATERIAL_DIFFUSE;
        flight->flux *= body_leaves(surfaces, body_of_stretch(surfaces, flight->within, &hit), hit.t);
        if (diffuse) {
            float arrives = mean_channel(flight->flux);
            fate->met.w += flux - arrives;
            flux = arrives;
            if (IS_STORED(turns)) {
#ifdef MEDIUM
                offer_place(kept, medium, hit.point, flight->direction, flight->flux, hit_mark(&hit));
#else
                photon.position = (float4)(hit.point, as_float(pack_direction(flight->direction)));
                photon.flux = (float4)(flight->flux, as_float(hit_mark(&hit)));
#endif
                fate->met.y = flux;
                fate->stored = true;
            } else {
                fate->met.z = flux;
            }
            return photon;
        }
        if (turns < frame->depth) {
            float gained = part_colors(frame, material, wavelength, flight);
            fate->met.x += gained;
            flux += gained;
            float u = choice_of(frame, flight, index, pass, turns);
            turn_photon(surfaces, &hit, material, wavelength, u, flight);
        }
        float left = mean_channel(flight->flux);
        fate->met.w += flux - left;
        flux = left;
        if (turns >= frame->depth) {
            fate->lost.y = flux;
            return photon;
        }
    }
}

// Photon `index` of a pass as it leaves its light, and its wavelength, 0 where none matters.
INLINE struct Flight depart(__global const struct PhotonFrame *frame, __global const struct Emitter *emitters,
    const struct Surfaces *surfaces, uint index, uint pass, float *wavelength) {
    struct Flight flight = emit(frame, emitters, surfaces, index, pass);
    *wavelength = 0.0f;
#ifdef DISPERSION
    float u = lattice_number(flight.cell, LATTICE_WAVELENGTH, flight.place.z);
    *wavelength = mix(SHORTEST_WAVELENGTH, LONGEST_WAVELENGTH, u);
#endif
    return flight;
}

INLINE void settle(__global struct PhotonAccount *account, const struct Fate *fate) {
    float4 high = account->met;
    float4 low = account->met_low;
    two_float_add(&high, &low, fate->met);
    account->met = high;
    account->met_low = low;
    high = account->lost;
    low = account->lost_low;
    two_float_add(&high, &low, fate->lost);
    account->lost = high;
    account->lost_low = low;
    account->photons += 1u;
    account->stored += fate->stored ? 1u : 0u;
}

// Photons [first, first + count) of a pass into their slots. `accounts` has `account_count` >= count entries; photon i
// is entered in that of i modulo their number, so that sums are the same however the launches are cut.
__kernel void photons_trace(__global const struct PhotonFrame *frame, __global const struct Emitter *emitters,
    __global const struct Shape *shapes, __global const struct Node *nodes, __global const struct Ball *balls,
    __global const float4 *normals, __global const uint *materials_of, __global const struct Material *materials,
    __global struct Photon *photons, __global struct PhotonAccount *accounts,
#ifdef MEDIUM
    __constant struct Frame *medium_frame, MEDIUM_ARGUMENTS,
#endif
    uint account_count, uint pass, uint first, uint count) {
    uint item = get_global_id(0);
    if (item >= count) {
        return;
    }
    uint index = first + item;
    struct Surfaces surfaces = {
        shapes, frame->plane_count, nodes, frame->node_count, balls, normals, materials_of, materials};
    float wavelength;
    struct Flight flight = depart(frame, emitters, &surfaces, index, pass, &wavelength);
    struct Fate fate;
#ifdef MEDIUM
    struct Medium medium = medium_of(medium_frame, volume, scattering, voxels, majorants, sigmas, albedos);
    medium_numbers(&medium, index, pass, RNG_MEDIUM_PHOTON);
    struct Kept kept = kept_none();
    follow(frame, &surfaces, &flight, wavelength, index, pass, &fate, &medium, &kept);
    photons[index] = kept_photon(&kept);
#else
    photons[index] = follow(frame, &surfaces, &flight, wavelength, index, pass, &fate);
#endif
    settle(&accounts[index % account_count], &fate);
}
