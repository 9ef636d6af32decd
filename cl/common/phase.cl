// Phase functions, in 1/sr, normalised to 1 over the sphere; mu is the cosine between the directions of propagation
// before and after. One is compiled in: PHASE_ISOTROPIC, PHASE_HG (Henyey and Greenstein 1941, parameter g0),
// PHASE_RAYLEIGH, or PHASE_TWO_LOBE (two Henyey-Greenstein lobes: g0 with `weight`, g1 with the rest).
//
// Narrow lobes depend on 1 - mu, which mu near 1 has lost: inside, cosines are pairs (1 - mu, 1 + mu).
#include "common/directions.cl"
#include "types/phase.cl"

#define INV_4PI 0.0795774715f

#if defined(PHASE_HG) || defined(PHASE_TWO_LOBE)
// (1 - g^2) / (4 pi (1 + g^2 - 2 g mu)^(3/2)), whose bracket is a sum of two positive terms here.
INLINE float henyey_greenstein(float g, float2 cosine) {
    float h = fabs(g);
    float narrow = 1.0f - h;
    float bracket = narrow * narrow + 2.0f * h * (g < 0.0f ? cosine.y : cosine.x);
    return INV_4PI * narrow * (1.0f + h) / (bracket * sqrt(bracket));
}

// The inverse of the distribution function, without a division by g: with h = |g| and q = 1 - h + 2 h u,
// 1 - mu = 2 ((1 - h) / q)^2 (1 - u) (1 + h u) and 1 + mu = 2 ((1 + h) / q)^2 u (1 - h + h u).
INLINE float2 henyey_greenstein_cosine(float g, float u) {
    float h = fabs(g);
    float narrow = 1.0f - h;
    float inverse = 1.0f / (narrow + 2.0f * h * u);
    float a = narrow * inverse;
    float b = (1.0f + h) * inverse;
    float2 cosine = (float2)(2.0f * a * a * (1.0f - u) * (1.0f + h * u), 2.0f * b * b * u * (narrow + h * u));
    return g < 0.0f ? cosine.yx : cosine;
}
#endif

// The phase function at (1 - mu, 1 + mu).
INLINE float phase_at(struct Phase p, float2 cosine) {
#if defined(PHASE_ISOTROPIC)
    return INV_4PI;
#elif defined(PHASE_HG)
    return henyey_greenstein(p.g0, cosine);
#elif defined(PHASE_RAYLEIGH)
    float mu = 0.5f * (cosine.y - cosine.x);
    return 0.75f * INV_4PI * (1.0f + mu * mu);
#elif defined(PHASE_TWO_LOBE)
    return p.weight * henyey_greenstein(p.g0, cosine) + (1.0f - p.weight) * henyey_greenstein(p.g1, cosine);
#else
#error "no phase function is defined"
#endif
}

INLINE float phase_value(struct Phase p, float mu) {
    return phase_at(p, (float2)(1.0f - mu, 1.0f + mu));
}

// The phase function between two unit directions, right to rounding at any angle.
INLINE float phase_between(struct Phase p, float4 a, float4 b) {
    float4 minus = a - b;
    float4 plus = a + b;
    return phase_at(p, 0.5f * (float2)(dot(minus, minus), dot(plus, plus)));
}

// A direction that follows the phase function after `direction`, and its density in 1/sr; u in [0, 1)^2.
INLINE float4 phase_sample(struct Phase p, float4 direction, float2 u, float *pdf) {
#if defined(PHASE_ISOTROPIC)
    *pdf = INV_4PI;
    return uniform_direction(u);
#else
#if defined(PHASE_RAYLEIGH)
    // mu^3 + 3 mu = 2 h = 8 u - 4: a minimax polynomial, right to 2.8e-3, and one step of Halley's method, which leaves
    // 1e-8. The cube roots of Cardano's formula take several times as long.
    float h = 4.0f * u.x - 2.0f;
    float z = h * h;
    float mu = h * (0.654841706f + z * (-0.0623711604f + z * 0.00600199587f));
    float q = mu * mu + 1.0f;
    float miss = mu * (q + 2.0f) - 2.0f * h;
    mu -= miss * q / (3.0f * q * q - mu * miss);
    mu = clamp(mu, -1.0f, 1.0f);
    float2 cosine = (float2)(1.0f - mu, 1.0f + mu);
#elif defined(PHASE_TWO_LOBE)
    // u.x chooses the lobe, and where it lies in the lobe's share is uniform again.
    bool first = u.x < p.weight;
    float share = first ? p.weight : 1.0f - p.weight;
    float rest = min((first ? u.x : u.x - p.weight) / share, 1.0f);
    float2 cosine = henyey_greenstein_cosine(first ? p.g0 : p.g1, rest);
#else
    float2 cosine = henyey_greenstein_cosine(p.g0, u.x);
#endif
    *pdf = phase_at(p, cosine);
    return turned(direction, 0.5f * (cosine.y - cosine.x), sqrt(cosine.x * cosine.y), u.y);
#endif
}
