// Radix sort with work-groups that first sort tiles by the digit in local memory: for GPUs (Satish, Harris and Garland
// 2009). Any power of two up to TILE will do as size of a work-group.
#include "sort/radix_passes.cl"

#define TILE 1024u
#define MAX_DIGITS 256u
#define MAX_GROUP 256u

// Where the items of each digit begin and end in a sorted tile; digits that it lacks: 0 and 0.
INLINE void radix_runs(__local uint *begin, __local uint *end, __local const uint2 *tile, uint shift, uint digits) {
    uint item = (uint)get_local_id(0), items = (uint)get_local_size(0);
    for (uint digit = item; digit < digits; digit += items) {
        begin[digit] = 0;
        end[digit] = 0;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint i = item; i < TILE; i += items) {
        uint digit = (tile[i].x >> shift) & (digits - 1);
        if (i == 0 || ((tile[i - 1].x >> shift) & (digits - 1)) != digit) {
            begin[digit] = i;
        }
        if (i == TILE - 1 || ((tile[i + 1].x >> shift) & (digits - 1)) != digit) {
            end[digit] = i + 1;
        }
    }
    barrier(CLK_LOCAL_MEM_FENCE);
}

// Sums of the work-items' numbers before each one, in sums[item]; the sum of all. sums: two rows of MAX_GROUP.
INLINE ulong radix_sums(__local ulong *sums, ulong own) {
    uint item = (uint)get_local_id(0), items = (uint)get_local_size(0);
    uint from = 0;
    sums[item] = own;
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint step = 1; step < items; step <<= 1) {
        ulong sum = sums[from + item];
        if (item >= step) {
            sum += sums[from + item - step];
        }
        from = MAX_GROUP - from;
        sums[from + item] = sum;
        barrier(CLK_LOCAL_MEM_FENCE);
    }
    ulong before = sums[from + item] - own;
    ulong all = sums[from + items - 1];
    barrier(CLK_LOCAL_MEM_FENCE);
    sums[item] = before;
    return all;
}

// Sorts tiles by the digit, two bits at a time, and counts digits: counts[digit × tiles + tile]. The last tile is filled
// up with the largest word, which stays behind all items of its digit.
__kernel void radix_tiles(__global uint2 *sorted_tiles, __global uint *counts, __global const Key *keys,
    __global const uint2 *pairs, uint source, uint shift, uint digits, uint tiles, uint count) {
    __local uint2 tile[2 * TILE];
    __local ulong sums[2 * MAX_GROUP];
    __local uint begin[MAX_DIGITS], end[MAX_DIGITS];
    uint item = (uint)get_local_id(0), items = (uint)get_local_size(0), group = (uint)get_group_id(0);
    for (uint k = item; k < TILE; k += items) {
        uint i = group * TILE + k;
        tile[k] = i < count ? radix_load(source, keys, pairs, i) : (uint2)(0xffffffffu);
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    uint from = 0, share = TILE / items;
    for (uint bit = 0; (1u << bit) < digits; bit += 2) {
        // How many of the four values are among the item's own share, 16 bits each.
        uint mask = (1u << (bit + 1)) < digits ? 3u : 1u;
        ulong own = 0;
        for (uint k = item * share; k < (item + 1) * share; ++k) {
            own += 1ul << (16 * ((tile[from + k].x >> (shift + bit)) & mask));
        }
        ulong all = radix_sums(sums, own);
        // A field's sum of all fields below it: places of the values.
        ulong place = sums[item] + (all << 16) + (all << 32) + (all << 48);
        uint to = TILE - from;
        for (uint k = item * share; k < (item + 1) * share; ++k) {
            uint2 pair = tile[from + k];
            uint field = 16 * ((pair.x >> (shift + bit)) & mask);
            tile[to + ((uint)(place >> field) & 0xffffu)] = pair;
            place += 1ul << field;
        }
        from = to;
        barrier(CLK_LOCAL_MEM_FENCE);
    }
    radix_runs(begin, end, tile + from, shift, digits);
    for (uint digit = item; digit < digits; digit += items) {
        counts[digit * tiles + group] = end[digit] - begin[digit];
    }
    for (uint k = item; k < TILE; k += items) {
        sorted_tiles[group * TILE + k] = tile[from + k];
    }
}

// A work-group per digit: counters become where the tile's items of the digit begin among all of that digit.
__kernel void radix_offsets(__global uint *counts, __global uint *totals, uint tiles) {
    __local ulong sums[2 * MAX_GROUP];
    uint item = (uint)get_local_id(0), items = (uint)get_local_size(0), digit = (uint)get_group_id(0);
    uint before = 0;
    for (uint first = 0; first < tiles; first += items) {
        uint tile = first + item;
        uint own = tile < tiles ? counts[digit * tiles + tile] : 0;
        uint all = (uint)radix_sums(sums, own);
        if (tile < tiles) {
            counts[digit * tiles + tile] = before + (uint)sums[item];
        }
        before += all;
    }
    if (item == 0) {
        totals[digit] = before;
    }
}

// last: whether keys and numbers go to sorted and indices, not to out.
__kernel void radix_scatter(__global uint2 *out, __global Key *sorted, __global uint *indices,
    __global const uint *counts, __global const uint *totals, __global const Key *keys,
    __global const uint2 *sorted_tiles, uint shift, uint digits, uint last, uint tiles, uint count) {
    __local uint2 tile[TILE];
    __local ulong sums[2 * MAX_GROUP];
    __local uint begin[MAX_DIGITS], end[MAX_DIGITS];
    uint item = (uint)get_local_id(0), items = (uint)get_local_size(0), group = (uint)get_group_id(0);
    for (uint k = item; k < TILE; k += items) {
        tile[k] = sorted_tiles[group * TILE + k];
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    radix_runs(begin, end, tile, shift, digits);
    // Where the tile's items of each digit go, less their place in the tile.
    uint before = 0;
    for (uint first = 0; first < digits; first += items) {
        uint digit = first + item;
        uint own = digit < digits ? totals[digit] : 0;
        uint all = (uint)radix_sums(sums, own);
        if (digit < digits) {
            end[digit] = before + (uint)sums[item] + counts[digit * tiles + group] - begin[digit];
        }
        before += all;
    }
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint k = item; k < TILE; k += items) {
        uint2 pair = tile[k];
        uint at = end[(pair.x >> shift) & (digits - 1)] + k;
        // Only what fills up the last tile goes beyond the items.
        if (at < count) {
            if (last) {
                radix_finish(sorted, indices, keys, at, pair);
            } else {
                out[at] = pair;
            }
        }
    }
}
