// Binary search in sorted keys: which items lie in a cell, where there are too many cells for a table of them.
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
