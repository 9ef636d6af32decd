// Exponentially distributed numbers.
#include "common/lanes.cl"

// -ln w with w = (bits + 1) 2^-32 in (0, 1]: mean 1, at most 22.2. Relative error < 3e-7 even where w is nearly 1.
//
// w = 2^-k (1 + f) with 1 + f in [sqrt(1/2), sqrt(2)). f comes from integers, so it keeps its relative precision; then
// ln(1 + f) = 2 artanh(s), s = f / (2 + f), by a minimax polynomial with relative error 8e-10.
INLINE Reals exponential_lanes(Words bits) {
    Words n = bits + 1u;                // 0 stands for 2^32
    Words zeros = clz(n) & 31u;         // clz(0) = 32
    Ints top = AS_INTS(n << zeros);     // 2^32 (w 2^zeros - 1), negative or 0
    Ints high = top >= -1257966796;     // w 2^zeros >= sqrt(1/2)
    Reals f = PICK(TO_REALS(top & 0x7fffffff) * 0x1p-31f, TO_REALS(top) * 0x1p-32f, high);
    Reals k = TO_REALS(AS_INTS(PICK(zeros + 1u, zeros, high)));
    Reals s = f / (2.0f + f);
    Reals z = s * s;
    return k * M_LN2_F - 2.0f * s * (1.0f + z * (0.333333876f + z * (0.199888264f + z * 0.149346011f)));
}

// The same number for a single path, by the library's logarithms.
INLINE float exponential_float(uint bits) {
    uint rest = ~bits; // 1 - w, in units of 2^-32
    return rest < 0x80000000u ? -log1p((float)rest * -0x1p-32f) : -log((float)(bits + 1u) * 0x1p-32f);
}
