// Which bodies of glass a ray is within, from the boundaries that it has crossed: what lies in a body is met from outside,
// so the hit does not tell. Two bodies are known, one in the other.
//
// BEGINS_WITHIN: some rays may begin in glass; where they do is then looked for.
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

#ifdef BEGINS_WITHIN
// Surfaces that are met on the way out, and bodies of glass among them that are in each other, at most.
#define MOST_MET 256u
#define MOST_ENTERED 8u

INLINE bool is_glass(const struct Surfaces *s, uint surface) {
    return s->materials[s->materials_of[surface]].kind == MATERIAL_DIELECTRIC;
}

#ifdef SHAPE_PLANE
// The half-space of glass that a point is the least deep in but for `other`, as surface + 1.
INLINE uint shallowest(const struct Surfaces *s, float3 point, uint other) {
    uint found = 0u;
    float least = INFINITY;
    for (uint i = 0; i < s->plane_count; ++i) {
        float4 plane = s->shapes[i].b;
        uint surface = s->shapes[i].surface;
        float below = plane.w - dot(plane.xyz, point);
        if (below > 0.0f && below < least && surface + 1u != other && is_glass(s, surface)) {
            least = below;
            found = surface + 1u;
        }
    }
    return found;
}
#endif
#endif

// The bodies in which a ray begins: those that it leaves before it enters them, whatever else it meets, the inner one first;
// around them half-spaces, which it need not leave.
INLINE struct Within within_at(const struct Surfaces *s, float3 origin, float3 direction) {
    struct Within within = within_none();
#ifdef BEGINS_WITHIN
    // Bodies that were entered since, a bit for each that was not left: those that were make room when there is none.
    uint entered[MOST_ENTERED];
    for (uint i = 0; i < MOST_ENTERED; ++i) {
        entered[i] = 0u;
    }
    uint in = 0u;
    uint oldest = 0u;
    float3 from = origin;
    for (uint met = 0; met < MOST_MET && within.around == 0u; ++met) {
        struct Hit hit;
        if (!surfaces_hit(s, from, direction, INFINITY, &hit)) {
            break;
        }
        from = surface_offset(&hit, direction);
        uint body = hit.surface + 1u;
        if (within.body == body || !is_glass(s, hit.surface)) {
            continue;
        }
        uint place = 0u;
        while (place < MOST_ENTERED && entered[place] != body) {
            ++place;
        }
        if (place < MOST_ENTERED) {
            in = hit.inside ? in & ~(1u << place) : in | 1u << place;
        } else if (!hit.inside) {
            if (in == (1u << MOST_ENTERED) - 1u) {
                break;
            }
            while (in >> oldest & 1u) {
                oldest = (oldest + 1u) % MOST_ENTERED;
            }
            entered[oldest] = body;
            in |= 1u << oldest;
            oldest = (oldest + 1u) % MOST_ENTERED;
        } else if (within.body == 0u) {
            within.body = body;
        } else {
            within.around = body;
        }
    }
#ifdef SHAPE_PLANE
    if (within.body == 0u) {
        within.body = shallowest(s, origin, 0u);
    }
    if (within.around == 0u && within.body != 0u) {
        within.around = shallowest(s, origin, within.body);
    }
#endif
#endif
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
