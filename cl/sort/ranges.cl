// Which items of the sorted keys lie in each cell: ranges[2 key] is the first, ranges[2 key + 1] one past the last; both
// are 0 for cells without any (Bogolepov, Sopin and Turlapov). Keys of cells and above are of no cell.
#include "sort/words.cl"

// used: the key of every cell's first item, or KEY_NONE; what the next clearing has to go through.
INLINE void ranges_begin(__global uint *ranges, __global uint *used, __global const uint *keys, uint cells, uint i) {
    uint key = keys[i];
    bool first = key < cells && (i == 0 || keys[i - 1] != key);
    used[i] = first ? key : KEY_NONE;
    if (first) {
        ranges[2 * (size_t)key] = i;
    }
}

INLINE void ranges_end(__global uint *ranges, __global const uint *keys, uint cells, uint i, uint count) {
    uint key = keys[i];
    if (key < cells && (i == count - 1 || keys[i + 1] != key)) {
        ranges[2 * (size_t)key + 1] = i + 1;
    }
}

__kernel void ranges_both(__global uint *ranges, __global uint *used, __global const uint *keys, uint cells,
    uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) {
        ranges_begin(ranges, used, keys, cells, i);
        ranges_end(ranges, keys, cells, i, count);
    }
}

__kernel void ranges_first(__global uint *ranges, __global uint *used, __global const uint *keys, uint cells,
    uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) {
        ranges_begin(ranges, used, keys, cells, i);
    }
}

__kernel void ranges_last(__global uint *ranges, __global const uint *keys, uint cells, uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count) {
        ranges_end(ranges, keys, cells, i, count);
    }
}

__kernel void ranges_clear(__global uint2 *ranges, uint cells) {
    uint cell = (uint)get_global_id(0);
    if (cell < cells) {
        ranges[cell] = (uint2)(0);
    }
}

// Clears what was used before.
__kernel void ranges_forget(__global uint2 *ranges, __global const uint *used, uint count) {
    uint i = (uint)get_global_id(0);
    if (i < count && used[i] != KEY_NONE) {
        ranges[used[i]] = (uint2)(0);
    }
}
