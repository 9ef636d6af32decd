// Photons side by side: CPU compilers leave the loop over photons scalar, so there GATHER_LANES looks at eight at once.
#include "common/inline.cl"

#ifdef GATHER_LANES
#define BATCH 8u
typedef float8 Batch;
typedef int8 BatchMask;
typedef uint8 BatchWords;
#define BATCH_FLOATS(array, i) vload8(0, (array) + (i))
#define BATCH_WORDS(array, i) as_uint8(vload8(0, (array) + (i)))
#define BATCH_ANY(mask) any_of_eight(mask)
#define BATCH_PICK(no, yes, mask) select(no, yes, mask)
#define BATCH_REALS(words) convert_float8(words)
#define BATCH_LANES ((int8)(0, 1, 2, 3, 4, 5, 6, 7))
#else
#define BATCH 1u
typedef float Batch;
typedef int BatchMask;
typedef uint BatchWords;
#define BATCH_FLOATS(array, i) ((array)[i])
#define BATCH_WORDS(array, i) as_uint((array)[i])
#define BATCH_ANY(mask) (mask)
#define BATCH_PICK(no, yes, mask) ((mask) ? (yes) : (no))
#define BATCH_REALS(words) ((float)(words))
#define BATCH_LANES 0
#endif

#ifdef GATHER_LANES
// As any(), which PoCL tests element by element.
INLINE bool any_of_eight(int8 mask) {
    ulong4 pairs = as_ulong4(mask);
    ulong2 both = pairs.lo | pairs.hi;
    return (both.x | both.y) != 0;
}
#endif

INLINE float batch_sum(Batch x) {
#ifdef GATHER_LANES
    float4 sum = x.lo + x.hi;
    return (sum.x + sum.z) + (sum.y + sum.w);
#else
    return x;
#endif
}
