// Which bodies of glass a ray is within, from the boundaries that it has crossed: what lies in a body is met from outside,
// so the hit does not tell. Two bodies are known, one in the other; rays begin outside of all until a hit tells better.
#include "surfaces/intersect.cl"

// Surfaces + 1, 0: none.
struct Within {
    uint body;
    uint around; // what body is in
};

INLINE struct Within within_none(void) {
    struct Within within = {0u, 0u};
    return within;
}

// The body of a stretch that ends at a hit, as surface + 1.
INLINE uint body_of_stretch(const struct Surfaces *s, struct Within within, const struct Hit *hit) {
    bool glass = s->materials[s->materials_of[hit->surface]].kind == MATERIAL_DIELECTRIC;
    return hit->inside && glass ? hit->surface + 1u : within.body;
}

// What a body leaves of light over a distance, which may be infinite; per channel.
INLINE float3 body_leaves(const struct Surfaces *s, uint body, float distance) {
    if (body == 0u) {
        return (float3)(1.0f);
    }
    return exp(-s->materials[s->materials_of[body - 1u]].absorption.xyz * min(distance, 1e30f));
}

// Refraction at a hit: into the body, or out of it. Bodies that overlap are left in any order.
INLINE struct Within crossed(struct Within within, const struct Hit *hit) {
    uint body = hit->surface + 1u;
    if (!hit->inside) {
        within.around = within.body == body ? within.around : within.body;
        within.body = body;
    } else if (within.around == body) {
        within.around = 0u;
    } else if (within.body == body) {
        within.body = within.around;
        within.around = 0u;
    }
    return within;
}
