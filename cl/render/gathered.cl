// What rays gather of a medium that emits and absorbs: L = int T(t) S(t) dt, segment by segment.
//
// LIT: the medium scatters the light of a light volume (irradiance/light.cl) and may glow (EMISSION); else it shines by
// its colours. CHROMATIC (with LIT): the transmittance has channels.
#include "common/numeric.cl"
#include "types/method.cl"
#include "volume/transfer.cl"

// What the table does over the values of a brick: a straight line, or anything; below: no extinction, and the
// number is how many bricks the ray can stride over.
#define BRICK_STRAIGHT 254
#define BRICK_BENT 255

// What the medium sends towards the eye per length, and sigma_t.
#ifdef TRANSMITTANCE_ONLY
typedef float Source;
#define source_sigma(s) (s)
#else
typedef float4 Source;
#define source_sigma(s) ((s).w)
#endif

#ifdef CHROMATIC
typedef float4 Through;
#else
typedef float Through;
#endif

// What a ray has gathered so far.
struct Gathered {
#ifdef TRANSMITTANCE_ONLY
    float depth; // optical depth
#else
    float4 radiance;       // w = 0
    Through transmittance; // w = 0
    float opacity;         // 1 - transmittance (the channels' mean), without the cancellation where the medium is thin
#endif
#ifdef LIT
    float4 light;     // where the last cell ended
    float light_time; // when that was
#endif
    uint lookups;
};

INLINE struct Gathered gathered_nothing(void) {
    struct Gathered g;
    g.lookups = 0;
#ifdef TRANSMITTANCE_ONLY
    g.depth = 0.0f;
#else
    g.radiance = (float4)(0.0f);
    g.opacity = 0.0f;
#ifdef CHROMATIC
    g.transmittance = (float4)(1.0f, 1.0f, 1.0f, 0.0f);
#else
    g.transmittance = 1.0f;
#endif
#endif
#ifdef LIT
    g.light = (float4)(0.0f);
    g.light_time = -INFINITY;
#endif
    return g;
}

INLINE Through gathered_transmittance(const struct Gathered *g) {
#ifdef TRANSMITTANCE_ONLY
    return exp(-g->depth);
#else
    return g->transmittance;
#endif
}

INLINE float gathered_opacity(const struct Gathered *g) {
#if defined(TRANSMITTANCE_ONLY)
    return g->depth * mean_transmittance(g->depth);
#elif defined(CHROMATIC)
    return g->opacity;
#else
    return g->opacity < 0.5f ? g->opacity : 1.0f - g->transmittance;
#endif
}

// Adds a segment of this length; `mean`: what the sources average to over it.
INLINE void gather(struct Gathered *g, __constant struct EmissionAbsorption *method, float length, Source mean) {
    float tau = length * source_sigma(mean);
#ifdef TRANSMITTANCE_ONLY
    g->depth += tau;
#else
    if (tau == 0.0f) {
        return; // the commonest case by far in partly filled bricks
    }
#if defined(CHROMATIC)
    float4 depth = tau * method->extinction;
    float4 share = (float4)(mean_transmittance(depth.x), mean_transmittance(depth.y), mean_transmittance(depth.z), 0.0f);
    float4 taken = g->transmittance * depth * share;
    g->radiance += g->transmittance * (length * share) * mean;
    g->opacity += (taken.x + taken.y + taken.z) * (1.0f / 3.0f);
    g->transmittance -= taken;
#else
#ifdef LINEAR_COMPOSITING
    // Usher's Taylor form: too opaque, first order in the step.
    float share = tau > 1.0f ? 1.0f / tau : 1.0f;
#else
    float share = mean_transmittance(tau);
#endif
    mean.w = 0.0f;
    g->radiance += (g->transmittance * length * share) * mean;
    g->opacity += g->transmittance * tau * share;
    g->transmittance *= 1.0f - tau * share;
#endif
#endif
}

INLINE bool is_opaque(const struct Gathered *g, __constant struct EmissionAbsorption *method) {
#if defined(TRANSMITTANCE_ONLY)
    return g->depth > method->max_depth;
#elif defined(CHROMATIC)
    return max(max(g->transmittance.x, g->transmittance.y), g->transmittance.z) < method->min_transmittance;
#else
    return g->transmittance < method->min_transmittance;
#endif
}
