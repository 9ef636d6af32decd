// Numeric helpers that stay right under `-cl-mad-enable`.

// Finite by its bits: compilers may assume away isnan().
inline bool is_finite_bits(float x) {
    return (as_uint(x) & 0x7f800000u) != 0x7f800000u;
}

// (*high, *low) += x, where *low keeps what *high cannot hold (Knuth's TwoSum; additions only, so nothing contracts).
inline void two_float_add(float4 *high, float4 *low, float4 x) {
    float4 y = x + *low;
    float4 sum = *high + y;
    float4 part = sum - *high;
    *low = (*high - (sum - part)) + (y - part);
    *high = sum;
}

// 1 - exp(-tau) for tau >= 0 without cancellation: the series below 1/8 (relative error < 1e-8), exp above.
inline float one_minus_exp(float tau) {
    if (tau < 0.125f) {
        return tau * (1.0f - tau * 0.5f * (1.0f - tau * (1.0f / 3.0f) * (1.0f - tau * 0.25f * (1.0f - tau * 0.2f))));
    }
    return 1.0f - exp(-tau);
}
