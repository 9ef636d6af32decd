// Exponentially distributed numbers.
#include "common/lanes.cl"

// -ln w with w = (bits + 1) 2^-32 in (0, 1]: mean 1, at most 22.2. Relative error < 3e-7 even where w is nearly 1.
//
// w = 2^-k (1 + f) with 1 + f in [sqrt(1/2), sqrt(2)). f comes from integers, so it keeps its relative precision; the
// minimax polynomial for (ln(1 + f) - f) / f^2 makes ln(1 + f) right to 3e-8.
INLINE Reals exponential_lanes(Words bits) {
    Words n = bits + 1u;                // 0 stands for 2^32
    Words zeros = clz(n) & 31u;         // clz(0) = 32
    Ints top = AS_INTS(n << zeros);     // 2^32 (w 2^zeros - 1), negative or 0
    Ints high = top >= -1257966796;     // w 2^zeros >= sqrt(1/2)
    Reals f = PICK(TO_REALS(top & 0x7fffffff) * 0x1p-31f, TO_REALS(top) * 0x1p-32f, high);
    Reals k = TO_REALS(AS_INTS(PICK(zeros + 1u, zeros, high)));
    Reals f2 = f * f;
    // By pairs, which shortens the chain of operations that wait for each other.
    Reals low = (-0.499999832f + 0.333339316f * f) + f2 * (-0.250025804f + 0.199635335f * f);
    Reals rest = (-0.16551856f + 0.148831931f * f) + f2 * (-0.144263868f + 0.0898034604f * f);
    return k * M_LN2_F - (f + f2 * (low + f2 * f2 * rest));
}

// The same number for a single path, by the library's logarithms.
INLINE float exponential_float(uint bits) {
    uint rest = ~bits; // 1 - w, in units of 2^-32
    return rest < 0x80000000u ? -log1p((float)rest * -0x1p-32f) : -log((float)(bits + 1u) * 0x1p-32f);
}
