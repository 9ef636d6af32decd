// Bitonic sort with work-groups that put blocks in order in local memory: for GPUs (Bogolepov, Sopin and Turlapov).
//
// Elements i and i + stride of runs of 2 stride are put in order, ascending where i & run is 0. Any power of two will do
// as size of a work-group.
#include "sort/bitonic_words.cl"

#define TILE 2048u

// Element i of the lower halves of runs of 2 stride.
INLINE uint bitonic_lower(uint i, uint stride) {
    return 2 * (i & ~(stride - 1)) | (i & (stride - 1));
}

INLINE void bitonic_order(ulong *a, ulong *b, bool ascending) {
    ulong smaller = min(*a, *b), larger = max(*a, *b);
    *a = ascending ? smaller : larger;
    *b = ascending ? larger : smaller;
}

// All strides of a run within a block that begins at begin.
INLINE void bitonic_run(__local ulong *tile, uint begin, uint block, uint run, uint stride) {
    uint item = (uint)get_local_id(0), items = (uint)get_local_size(0);
    for (; stride > 0; stride >>= 1) {
        for (uint k = item; k < block / 2; k += items) {
            uint i = bitonic_lower(k, stride);
            ulong a = tile[i], b = tile[i + stride];
            bool ascending = ((begin + i) & run) == 0;
            if ((a > b) == ascending) {
                tile[i] = b;
                tile[i + stride] = a;
            }
        }
        barrier(CLK_LOCAL_MEM_FENCE);
    }
}

// A block leaves local memory; last: sorted, as keys and numbers.
INLINE void bitonic_leave(__global ulong *elements, __global Key *sorted, __global uint *indices, uint source,
    __global const Key *keys, __global const uint *order, uint last, __local const ulong *tile, uint begin,
    uint block, uint count) {
    for (uint k = (uint)get_local_id(0); k < block; k += (uint)get_local_size(0)) {
        if (!last) {
            elements[begin + k] = tile[k];
        } else if (begin + k < count) {
            bitonic_finish(sorted, indices, source, keys, order, begin + k, tile[k]);
        }
    }
}

// Loads and sorts blocks; last: they are all there is.
__kernel void bitonic_sort(__global ulong *elements, __global Key *sorted, __global uint *indices, uint source,
    __global const Key *keys, __global const uint *order, uint last, uint block, uint blocks, uint count) {
    __local ulong tile[TILE];
    uint begin = (uint)get_group_id(0) * block;
    for (uint k = (uint)get_local_id(0); k < block; k += (uint)get_local_size(0)) {
        tile[k] = bitonic_load(source, keys, order, begin + k, count);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint run = 2; run <= block; run <<= 1) {
        bitonic_run(tile, begin, block, run, run / 2);
    }
    bitonic_leave(elements, sorted, indices, source, keys, order, last, tile, begin, block, count);
}

// All strides within blocks, for runs that are longer.
__kernel void bitonic_merge(__global ulong *elements, __global Key *sorted, __global uint *indices, uint source,
    __global const Key *keys, __global const uint *order, uint last, uint run, uint block, uint blocks, uint count) {
    __local ulong tile[TILE];
    uint begin = (uint)get_group_id(0) * block;
    for (uint k = (uint)get_local_id(0); k < block; k += (uint)get_local_size(0)) {
        tile[k] = elements[begin + k];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    bitonic_run(tile, begin, block, run, block / 2);
    bitonic_leave(elements, sorted, indices, source, keys, order, last, tile, begin, block, count);
}

// One stride between blocks, or with it half of that; a work-item takes one element of each stream.
__kernel void bitonic_exchange(__global ulong *elements, uint run, uint stride, uint two, uint items) {
    if (get_global_id(0) >= items) {
        return;
    }
    uint apart = two ? stride / 2 : stride;
    uint own = (uint)get_global_id(0);
    uint i = (own & ~(apart - 1)) * (stride / apart) * 2 | (own & (apart - 1));
    bool ascending = (i & run) == 0;
    __global ulong *q = elements + i;
    if (two) {
        ulong a = q[0], b = q[apart], c = q[2 * apart], d = q[3 * apart];
        bitonic_order(&a, &c, ascending);
        bitonic_order(&b, &d, ascending);
        bitonic_order(&a, &b, ascending);
        bitonic_order(&c, &d, ascending);
        q[0] = a;
        q[apart] = b;
        q[2 * apart] = c;
        q[3 * apart] = d;
    } else {
        ulong a = q[0], b = q[apart];
        bitonic_order(&a, &b, ascending);
        q[0] = a;
        q[apart] = b;
    }
}
