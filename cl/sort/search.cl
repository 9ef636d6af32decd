// Binary search in sorted keys: which items lie in a cell where no table of cells is built, and how many items are valid.
#include "sort/words.cl"

// The first of the sorted keys that is at least key; count when none is.
INLINE uint sorted_first(__global const Key *keys, uint count, Key key) {
    uint first = 0, end = count;
    while (first < end) {
        uint middle = first + (end - first) / 2;
        if (keys[middle] < key) {
            first = middle + 1;
        } else {
            end = middle;
        }
    }
    return first;
}

// How many keys are of valid items.
__kernel void sorted_valid(__global uint *valid, __global const Key *keys, uint count) {
    if (get_global_id(0) == 0) {
        valid[0] = sorted_first(keys, count, KEY_NONE);
    }
}
