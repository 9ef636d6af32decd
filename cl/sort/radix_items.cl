// Radix sort with one work-item per chunk, which counts and moves its items in their order: for CPUs, whose caches hold
// a row of counters per thread. counts: a row of counters per chunk.
#include "sort/radix_passes.cl"

__kernel void radix_count(__global uint *counts, __global const Key *keys, __global const uint2 *pairs, uint source,
    uint shift, uint digits, uint chunk, uint count) {
    uint own = (uint)get_global_id(0);
    if ((ulong)own * chunk >= count) {
        return;
    }
    __global uint *row = counts + own * digits;
    for (uint digit = 0; digit < digits; ++digit) {
        row[digit] = 0;
    }
    uint first = own * chunk, end = first + min(chunk, count - first);
    for (uint i = first; i < end; ++i) {
        ++row[(radix_load(source, keys, pairs, i).x >> shift) & (digits - 1)];
    }
}

// Counters become where the chunk's items of a digit begin among all items of that digit; totals: items per digit.
__kernel void radix_offsets(__global uint *counts, __global uint *totals, uint digits, uint chunks) {
    uint digit = (uint)get_global_id(0);
    if (digit >= digits) {
        return;
    }
    uint sum = 0;
    for (uint own = 0; own < chunks; ++own) {
        uint items = counts[own * digits + digit];
        counts[own * digits + digit] = sum;
        sum += items;
    }
    totals[digit] = sum;
}

// last: whether keys and numbers go to sorted and indices, not to out.
__kernel void radix_scatter(__global uint2 *out, __global Key *sorted, __global uint *indices, __global uint *counts,
    __global const uint *totals, __global const Key *keys, __global const uint2 *pairs, uint source, uint shift,
    uint digits, uint last, uint chunk, uint count) {
    uint own = (uint)get_global_id(0);
    if ((ulong)own * chunk >= count) {
        return;
    }
    __global uint *row = counts + own * digits;
    uint before = 0;
    for (uint digit = 0; digit < digits; ++digit) {
        row[digit] += before;
        before += totals[digit];
    }
    uint first = own * chunk, end = first + min(chunk, count - first);
    for (uint i = first; i < end; ++i) {
        uint2 pair = radix_load(source, keys, pairs, i);
        uint at = row[(pair.x >> shift) & (digits - 1)]++;
        if (last) {
            radix_finish(sorted, indices, keys, at, pair);
        } else {
            out[at] = pair;
        }
    }
}
