// Bitonic sort with one work-item per block of elements and vectors of eight: for CPUs, whose caches hold a block.
//
// Elements i and i + stride of runs of 2 stride are put in order, ascending where i & run is 0.
#include "sort/bitonic_words.cl"

// Elements that a work-item puts in order between blocks, of each of the two or four streams.
#define SPAN 1024u

// Lanes that take the larger element at strides 1, 2, 4.
#define LARGER_1 ((long8)(0, -1, 0, -1, 0, -1, 0, -1))
#define LARGER_2 ((long8)(0, 0, -1, -1, 0, 0, -1, -1))
#define LARGER_4 ((long8)(0, 0, 0, 0, -1, -1, -1, -1))

INLINE ulong8 bitonic_smaller(ulong8 a, ulong8 b) {
    return select(b, a, a < b);
}

INLINE ulong8 bitonic_larger(ulong8 a, ulong8 b) {
    return select(a, b, a < b);
}

INLINE ulong8 bitonic_keep(ulong8 own, ulong8 other, long8 larger) {
    return select(bitonic_smaller(own, other), bitonic_larger(own, other), larger);
}

// Strides 4, 2, 1; turn: -1 for descending.
INLINE ulong8 bitonic_vector(ulong8 v, long8 turn) {
    v = bitonic_keep(v, v.s45670123, LARGER_4 ^ turn);
    v = bitonic_keep(v, v.s23016745, LARGER_2 ^ turn);
    return bitonic_keep(v, v.s10325476, LARGER_1 ^ turn);
}

// Runs of 2, 4 and 8.
INLINE ulong8 bitonic_sort_vector(ulong8 v, long8 turn) {
    v = bitonic_keep(v, v.s10325476, LARGER_1 ^ LARGER_2);
    v = bitonic_keep(v, v.s23016745, LARGER_2 ^ LARGER_4);
    v = bitonic_keep(v, v.s10325476, LARGER_1 ^ LARGER_4);
    return bitonic_vector(v, turn);
}

INLINE void bitonic_pair(__global ulong *low, __global ulong *high) {
    ulong8 a = vload8(0, low), b = vload8(0, high);
    vstore8(bitonic_smaller(a, b), 0, low);
    vstore8(bitonic_larger(a, b), 0, high);
}

// Strides of two quarters and of one, at once.
INLINE void bitonic_quad(__global ulong *q0, __global ulong *q1, __global ulong *q2, __global ulong *q3) {
    ulong8 a = vload8(0, q0), b = vload8(0, q1), c = vload8(0, q2), d = vload8(0, q3);
    ulong8 ac = bitonic_smaller(a, c), ca = bitonic_larger(a, c);
    ulong8 bd = bitonic_smaller(b, d), db = bitonic_larger(b, d);
    vstore8(bitonic_smaller(ac, bd), 0, q0);
    vstore8(bitonic_larger(ac, bd), 0, q1);
    vstore8(bitonic_smaller(ca, db), 0, q2);
    vstore8(bitonic_larger(ca, db), 0, q3);
}

// All strides below the run's length; descending: quarters and halves change places.
INLINE void bitonic_run(__global ulong *run, uint length, bool descending) {
    uint stride = length / 2;
    for (; stride >= 16; stride >>= 2) {
        uint quarter = stride / 2;
        uint first = descending ? 3 * quarter : 0;
        int step = descending ? -(int)quarter : (int)quarter;
        for (uint begin = 0; begin < length; begin += 2 * stride) {
            __global ulong *q = run + begin + first;
            for (uint i = 0; i < quarter; i += 8) {
                bitonic_quad(q + i, q + i + step, q + i + 2 * step, q + i + 3 * step);
            }
        }
    }
    long8 turn = descending ? (long8)(-1) : (long8)(0);
    if (stride == 8) {
        for (uint i = 0; i < length; i += 16) {
            ulong8 a = vload8(0, run + i), b = vload8(0, run + i + 8);
            ulong8 smaller = bitonic_smaller(a, b), larger = bitonic_larger(a, b);
            vstore8(bitonic_vector(descending ? larger : smaller, turn), 0, run + i);
            vstore8(bitonic_vector(descending ? smaller : larger, turn), 0, run + i + 8);
        }
    } else {
        for (uint i = 0; i < length; i += 8) {
            vstore8(bitonic_vector(vload8(0, run + i), turn), 0, run + i);
        }
    }
}

INLINE void bitonic_leave(__global Key *sorted, __global uint *indices, uint source, __global const Key *keys,
    __global const uint *order, __global const ulong *elements, uint begin, uint block, uint count) {
    uint end = begin + min(block, count - min(count, begin));
    for (uint i = begin; i < end; ++i) {
        bitonic_finish(sorted, indices, source, keys, order, i, elements[i]);
    }
}

// Loads and sorts blocks; last: they are all there is.
__kernel void bitonic_sort(__global ulong *elements, __global Key *sorted, __global uint *indices, uint source,
    __global const Key *keys, __global const uint *order, uint last, uint block, uint blocks, uint count) {
    if (get_global_id(0) >= blocks) {
        return;
    }
    uint begin = (uint)get_global_id(0) * block;
    __global ulong *own = elements + begin;
    for (uint i = 0; i < block; ++i) {
        own[i] = bitonic_load(source, keys, order, begin + i, count);
    }
    for (uint i = 0; i < block; i += 8) {
        long8 turn = ((begin + i) & 8u) ? (long8)(-1) : (long8)(0);
        vstore8(bitonic_sort_vector(vload8(0, own + i), turn), 0, own + i);
    }
    for (uint run = 16; run <= block; run <<= 1) {
        for (uint i = 0; i < block; i += run) {
            bitonic_run(own + i, run, ((begin + i) & run) != 0);
        }
    }
    if (last) {
        bitonic_leave(sorted, indices, source, keys, order, elements, begin, block, count);
    }
}

// All strides within blocks, for runs that are longer.
__kernel void bitonic_merge(__global ulong *elements, __global Key *sorted, __global uint *indices, uint source,
    __global const Key *keys, __global const uint *order, uint last, uint run, uint block, uint blocks, uint count) {
    if (get_global_id(0) >= blocks) {
        return;
    }
    uint begin = (uint)get_global_id(0) * block;
    bitonic_run(elements + begin, block, (begin & run) != 0);
    if (last) {
        bitonic_leave(sorted, indices, source, keys, order, elements, begin, block, count);
    }
}

// One stride, or with it half of that, of at least SPAN; a work-item takes SPAN elements of each stream.
__kernel void bitonic_exchange(__global ulong *elements, uint run, uint stride, uint two, uint items) {
    if (get_global_id(0) >= items) {
        return;
    }
    uint i = (uint)get_global_id(0) * SPAN;
    uint apart = two ? stride / 2 : stride;
    uint begin = (i / apart) * 2 * stride + i % apart;
    bool descending = (begin & run) != 0;
    __global ulong *q = elements + begin;
    if (two) {
        int step = descending ? -(int)apart : (int)apart;
        q += descending ? 3 * apart : 0;
        for (uint k = 0; k < SPAN; k += 8) {
            bitonic_quad(q + k, q + k + step, q + k + 2 * step, q + k + 3 * step);
        }
    } else {
        __global ulong *low = descending ? q + apart : q, *high = descending ? q : q + apart;
        for (uint k = 0; k < SPAN; k += 8) {
            bitonic_pair(low + k, high + k);
        }
    }
}
