// How many of the sorted keys are of valid items.
#include "sort/search.cl"

__kernel void sorted_valid(__global uint *valid, __global const Key *keys, uint count) {
    if (get_global_id(0) == 0) {
        valid[0] = sorted_first(keys, count, KEY_NONE);
    }
}
