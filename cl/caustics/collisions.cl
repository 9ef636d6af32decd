// Photons that the medium stops on their way: it absorbs a part of them, and scatters the rest.
//
// A photon has one slot, but may be scattered several times: of the places where it could be stored one is kept at random
// in proportion to its flux, with the flux of all (a reservoir of one). The light of each place is right in the mean.
#include "caustics/medium.cl"
#include "common/numeric.cl"
#include "common/octahedron.cl"
#include "types/photon.cl"

// The place that is kept so far.
struct Kept {
    struct Photon photon;
    float weight; // its own
    float sum;    // of all
};

INLINE struct Kept kept_none(void) {
    struct Kept kept;
    kept.photon.position = (float4)(0.0f);
    kept.photon.flux = (float4)(0.0f);
    kept.weight = 1.0f;
    kept.sum = 0.0f;
    return kept;
}

// Offers a place; `mark`: of a surface, or IN_MEDIUM.
INLINE void offer_place(struct Kept *kept, struct Medium *medium, float3 point, float3 direction, float3 flux,
    uint mark) {
    // Channels may be negative.
    float weight = fabs(flux.x) + fabs(flux.y) + fabs(flux.z);
    kept->sum += weight;
    if (weight > 0.0f && medium_random(medium) * kept->sum < weight) {
        kept->photon.position = (float4)(point, as_float(pack_direction(direction)));
        kept->photon.flux = (float4)(flux, as_float(mark));
        kept->weight = weight;
    }
}

INLINE struct Photon kept_photon(const struct Kept *kept) {
    struct Photon photon = kept->photon;
    photon.flux.xyz *= kept->sum / kept->weight;
    return photon;
}

// What a stretch of a photon's way through the medium ends with.
#define PASSES 0   // nothing
#define SCATTERS 1 // another direction
#define ENDS 2

// What happened to the mean channel of its flux.
struct Collision {
    int outcome;
    float absorbed;
    float scattered;
};

// Takes a photon on, up to `end`. `stores`: whether it is stored where it is scattered; otherwise it ends there.
INLINE struct Collision meet_medium(struct Medium *medium, float3 *origin, float3 *direction, float3 *flux, float end,
    bool stores, struct Kept *kept) {
    struct Collision collision = {PASSES, 0.0f, 0.0f};
    struct MediumRay through = medium_ray(medium, *origin, *direction, end);
    float t = medium_stop(medium, &through);
    if (!(t < INFINITY)) {
        return collision;
    }
    float3 point = *origin + t * *direction;
    float before = (flux->x + flux->y + flux->z) * (1.0f / 3.0f);
    *flux *= scatterer_at(medium, point).albedo;
    collision.scattered = (flux->x + flux->y + flux->z) * (1.0f / 3.0f);
    collision.absorbed = before - collision.scattered;
    bool dark = flux->x == 0.0f && flux->y == 0.0f && flux->z == 0.0f;
    collision.outcome = stores && !dark ? SCATTERS : ENDS;
    if (collision.outcome == SCATTERS) {
        offer_place(kept, medium, point, *direction, *flux, IN_MEDIUM);
        *direction = medium_scatters(medium, *direction);
        *origin = point;
    }
    return collision;
}
