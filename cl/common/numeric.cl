// Numeric helpers that stay right under `-cl-mad-enable`.
#include "common/inline.cl"

// Finite by its bits: compilers may assume away isnan().
INLINE bool is_finite_bits(float x) {
    return (as_uint(x) & 0x7f800000u) != 0x7f800000u;
}

// (*high, *low) += x, where *low keeps what *high cannot hold (Knuth's TwoSum; additions only, so nothing contracts).
INLINE void two_float_add(float4 *high, float4 *low, float4 x) {
    float4 y = x + *low;
    float4 sum = *high + y;
    float4 part = sum - *high;
    *low = (*high - (sum - part)) + (y - part);
    *high = sum;
}

// (1 - exp(-tau)) / tau for tau >= 0, without cancellation: the series below 1/4 (relative error < 2e-9), exp above.
INLINE float mean_transmittance(float tau) {
    if (tau < 0.25f) {
        return 1.0f - tau * (1.0f / 2.0f) * (1.0f - tau * (1.0f / 3.0f) * (1.0f - tau * (1.0f / 4.0f)
            * (1.0f - tau * (1.0f / 5.0f) * (1.0f - tau * (1.0f / 6.0f) * (1.0f - tau * (1.0f / 7.0f))))));
    }
    return (1.0f - exp(-tau)) / tau;
}

// exp(-tau) for tau >= 0.
INLINE float transmittance_of(float tau) {
    return 1.0f - tau * mean_transmittance(tau);
}
