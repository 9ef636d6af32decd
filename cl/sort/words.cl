// What sorts read: 32-bit words of keys, each with the number of its item.
//
// Keys of 64 bits are sorted twice by one word: by the lower words, and then by the upper words of what that left, which
// keeps the order of equal ones.
#include "common/inline.cl"

#ifndef KEY_BITS
#define KEY_BITS 32
#endif
#if KEY_BITS == 64
typedef ulong Key;
#define KEY_NONE 0xfffffffffffffffful
#define LOWER_WORD(key) ((uint)(key))
#define UPPER_WORD(key) ((uint)((key) >> 32))
#else
typedef uint Key;
#define KEY_NONE 0xffffffffu
#define LOWER_WORD(key) (key)
#define UPPER_WORD(key) 0u
#endif

// Where a pass finds its items: the lower words of the keys, what the pass before left, or the upper words of the keys
// in the order that the pass before left.
#define SOURCE_KEYS 0u
#define SOURCE_PASS 1u
#define SOURCE_UPPER 2u
