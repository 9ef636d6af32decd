// Phase functions, in 1/sr, normalised to 1 over the sphere; mu is the cosine between the directions of propagation
// before and after. One is compiled in: PHASE_ISOTROPIC, PHASE_HG (Henyey and Greenstein 1941, parameter g0),
// PHASE_RAYLEIGH, or PHASE_TWO_LOBE (two Henyey-Greenstein lobes: g0 with `weight`, g1 with the rest).
//
// Narrow lobes depend on 1 - mu, which mu near 1 has lost: inside, cosines are pairs (1 - mu, 1 + mu).
#include "common/directions.cl"
#include "types/phase.cl"

#define INV_4PI 0.0795774715f

struct Cosines {
    Reals minus; // 1 - mu
    Reals plus;  // 1 + mu
};

INLINE struct Cosines cosines(Reals minus, Reals plus) {
    struct Cosines c;
    c.minus = minus;
    c.plus = plus;
    return c;
}

#if defined(PHASE_HG) || defined(PHASE_TWO_LOBE)
// (1 - g^2) / (4 pi (1 + g^2 - 2 g mu)^(3/2)), whose bracket is a sum of two positive terms here.
INLINE Reals henyey_greenstein(Reals g, struct Cosines cosine) {
    Reals h = fabs(g);
    Reals narrow = 1.0f - h;
    Reals bracket = narrow * narrow + 2.0f * h * PICK(cosine.minus, cosine.plus, g < 0.0f);
    return INV_4PI * narrow * (1.0f + h) / (bracket * sqrt(bracket));
}

// The inverse of the distribution function, without a division by g: with h = |g| and q = 1 - h + 2 h u,
// 1 - mu = 2 ((1 - h) / q)^2 (1 - u) (1 + h u) and 1 + mu = 2 ((1 + h) / q)^2 u (1 - h + h u).
INLINE struct Cosines henyey_greenstein_cosines(Reals g, Reals u) {
    Reals h = fabs(g);
    Reals narrow = 1.0f - h;
    Reals inverse = 1.0f / (narrow + 2.0f * h * u);
    Reals a = narrow * inverse;
    Reals b = (1.0f + h) * inverse;
    Reals minus = 2.0f * a * a * (1.0f - u) * (1.0f + h * u);
    Reals plus = 2.0f * b * b * u * (narrow + h * u);
    Ints backwards = g < 0.0f;
    return cosines(PICK(minus, plus, backwards), PICK(plus, minus, backwards));
}
#endif

// The phase function at a cosine.
INLINE Reals phase_at(struct Phase p, struct Cosines cosine) {
#if defined(PHASE_ISOTROPIC)
    return (Reals)(INV_4PI);
#elif defined(PHASE_HG)
    return henyey_greenstein((Reals)(p.g0), cosine);
#elif defined(PHASE_RAYLEIGH)
    Reals mu = 0.5f * (cosine.plus - cosine.minus);
    return 0.75f * INV_4PI * (1.0f + mu * mu);
#elif defined(PHASE_TWO_LOBE)
    return p.weight * henyey_greenstein((Reals)(p.g0), cosine)
        + (1.0f - p.weight) * henyey_greenstein((Reals)(p.g1), cosine);
#else
#error "no phase function is defined"
#endif
}

// The phase function between unit directions, right to rounding at any angle.
INLINE Reals phase_between(struct Phase p, struct Points a, struct Points b) {
    struct Points minus = points(a.x - b.x, a.y - b.y, a.z - b.z);
    struct Points plus = points(a.x + b.x, a.y + b.y, a.z + b.z);
    return phase_at(p, cosines(0.5f * (minus.x * minus.x + minus.y * minus.y + minus.z * minus.z),
        0.5f * (plus.x * plus.x + plus.y * plus.y + plus.z * plus.z)));
}

// Directions that follow the phase function after `direction`, and their densities in 1/sr; u, v in [0, 1).
INLINE struct Points phase_sample(struct Phase p, struct Points direction, Reals u, Reals v, Reals *pdf) {
#if defined(PHASE_ISOTROPIC)
    *pdf = (Reals)(INV_4PI);
    return uniform_directions(u, v);
#else
#if defined(PHASE_RAYLEIGH)
    // mu^3 + 3 mu = 2 h = 8 u - 4: a minimax polynomial, right to 2.8e-3, and one step of Halley's method, which leaves
    // 1e-8. The cube roots of Cardano's formula take several times as long.
    Reals h = 4.0f * u - 2.0f;
    Reals z = h * h;
    Reals mu = h * (0.654841706f + z * (-0.0623711604f + z * 0.00600199587f));
    Reals q = mu * mu + 1.0f;
    Reals miss = mu * (q + 2.0f) - 2.0f * h;
    mu -= miss * q / (3.0f * q * q - mu * miss);
    mu = clamp(mu, -1.0f, 1.0f);
    struct Cosines cosine = cosines(1.0f - mu, 1.0f + mu);
#elif defined(PHASE_TWO_LOBE)
    // u chooses the lobe, and where it lies in the lobe's share is uniform again.
    Ints first = u < p.weight;
    Reals share = PICK((Reals)(1.0f - p.weight), (Reals)(p.weight), first);
    Reals rest = min(PICK(u - p.weight, u, first) / share, 1.0f);
    struct Cosines cosine = henyey_greenstein_cosines(PICK((Reals)(p.g1), (Reals)(p.g0), first), rest);
#else
    struct Cosines cosine = henyey_greenstein_cosines((Reals)(p.g0), u);
#endif
    *pdf = phase_at(p, cosine);
    return turned(direction, 0.5f * (cosine.plus - cosine.minus), sqrt(cosine.minus * cosine.plus), v);
#endif
}
