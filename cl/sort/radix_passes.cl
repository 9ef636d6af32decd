// Radix sort from the lowest digit: what its passes read and leave, a (word, number) pair per item.
#include "sort/words.cl"

INLINE uint2 radix_load(uint source, __global const Key *keys, __global const uint2 *pairs, uint i) {
    if (source == SOURCE_KEYS) {
        return (uint2)(LOWER_WORD(keys[i]), i);
    }
    uint2 pair = pairs[i];
    if (source == SOURCE_UPPER) {
        pair.x = UPPER_WORD(keys[pair.y]);
    }
    return pair;
}

// What the last pass leaves in place of pairs.
INLINE void radix_finish(__global Key *sorted, __global uint *indices, __global const Key *keys, uint at, uint2 pair) {
#if KEY_BITS == 64
    sorted[at] = keys[pair.y];
#else
    sorted[at] = pair.x;
#endif
    indices[at] = pair.y;
}
