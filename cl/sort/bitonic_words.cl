// Bitonic sort: what it compares, a word and below it the item's number in one ulong, so that no two are equal.
//
// For the upper words of keys, the number is the item's place in the order of the lower words.
#include "sort/words.cl"

// What fills up the items to a power of two.
#define BITONIC_NONE 0xfffffffffffffffful

INLINE ulong bitonic_load(uint source, __global const Key *keys, __global const uint *order, uint i, uint count) {
    if (i >= count) {
        return BITONIC_NONE;
    }
    uint word = source == SOURCE_KEYS ? LOWER_WORD(keys[i]) : UPPER_WORD(keys[order[i]]);
    return ((ulong)word << 32) | i;
}

INLINE void bitonic_finish(__global Key *sorted, __global uint *indices, uint source, __global const Key *keys,
    __global const uint *order, uint i, ulong element) {
    uint index = (uint)element;
    if (source == SOURCE_UPPER) {
        index = order[index];
    }
#if KEY_BITS == 64
    sorted[i] = keys[index];
#else
    sorted[i] = (uint)(element >> 32);
#endif
    indices[i] = index;
}
