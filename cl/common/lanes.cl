// Several paths side by side in one work-item: vectors of WIDTH lanes, one path each.
//
// CPU compilers leave the divergent loops of tracking kernels scalar, so CPUs get explicit vectors (WIDTH 4, 8 or 16);
// on GPUs the hardware does the same with work-items, and WIDTH is 1: every type here is then a scalar. A mask is what
// comparisons give: all bits of a lane set, or 1 when WIDTH is 1.
#include "common/inline.cl"

#ifndef WIDTH
#define WIDTH 1
#endif

#if WIDTH == 1
typedef float Reals;
typedef int Ints;
typedef uint Words;
#define PICK(no, yes, mask) ((mask) ? (yes) : (no))
#define NOT(mask) (!(mask))
#define ANY(mask) (mask)
#define TO_REALS(x) ((float)(x))
#define TO_INTS(x) ((int)(x))
#define TO_WORDS(x) ((uint)(x))
#define AS_REALS(x) as_float(x)
#define AS_INTS(x) as_int(x)
#define AS_WORDS(x) as_uint(x)
#else
#define LANES_CONCAT_(a, b) a##b
#define LANES_CONCAT(a, b) LANES_CONCAT_(a, b)
typedef LANES_CONCAT(float, WIDTH) Reals;
typedef LANES_CONCAT(int, WIDTH) Ints;
typedef LANES_CONCAT(uint, WIDTH) Words;
#define PICK(no, yes, mask) select(no, yes, mask)
#define NOT(mask) (~(mask))
#define ANY(mask) any(mask)
#define TO_REALS(x) LANES_CONCAT(convert_float, WIDTH)(x)
#define TO_INTS(x) LANES_CONCAT(convert_int, WIDTH)(x)
#define TO_WORDS(x) LANES_CONCAT(convert_uint, WIDTH)(x)
#define AS_REALS(x) LANES_CONCAT(as_float, WIDTH)(x)
#define AS_INTS(x) LANES_CONCAT(as_int, WIDTH)(x)
#define AS_WORDS(x) LANES_CONCAT(as_uint, WIDTH)(x)
#endif

// Access to single lanes.
typedef union {
    Reals all;
    float lane[WIDTH];
} RealLanes;

typedef union {
    Ints all;
    int lane[WIDTH];
} IntLanes;

typedef union {
    Words all;
    uint lane[WIDTH];
} WordLanes;

INLINE RealLanes real_lanes(Reals all) {
    RealLanes lanes;
    lanes.all = all;
    return lanes;
}

INLINE IntLanes int_lanes(Ints all) {
    IntLanes lanes;
    lanes.all = all;
    return lanes;
}

INLINE int sum_ints(Ints x) {
    IntLanes lanes = int_lanes(x);
    int sum = 0;
    for (int i = 0; i < WIDTH; ++i) {
        sum += lanes.lane[i];
    }
    return sum;
}

// How many lanes a mask holds.
INLINE int count_lanes(Ints mask) {
    return sum_ints(mask & 1);
}

INLINE float sum_lanes(Reals x) {
    RealLanes lanes = real_lanes(x);
    float sum = 0.0f;
    for (int i = 0; i < WIDTH; ++i) {
        sum += lanes.lane[i];
    }
    return sum;
}

// table[index] per lane. Written out, so that compilers insert what they load into vectors: through memory, the vector
// would wait for its lanes to be stored.
INLINE Reals gather_lanes(__global const float *table, Ints index) {
#if WIDTH == 1
    return table[index];
#elif WIDTH == 4
    return (Reals)(table[index.s0], table[index.s1], table[index.s2], table[index.s3]);
#elif WIDTH == 8
    return (Reals)(table[index.s0], table[index.s1], table[index.s2], table[index.s3], table[index.s4], table[index.s5],
        table[index.s6], table[index.s7]);
#else
    return (Reals)(table[index.s0], table[index.s1], table[index.s2], table[index.s3], table[index.s4], table[index.s5],
        table[index.s6], table[index.s7], table[index.s8], table[index.s9], table[index.sa], table[index.sb],
        table[index.sc], table[index.sd], table[index.se], table[index.sf]);
#endif
}

// Three coordinates per lane.
struct Points {
    Reals x, y, z;
};

INLINE struct Points points(Reals x, Reals y, Reals z) {
    struct Points p;
    p.x = x;
    p.y = y;
    p.z = z;
    return p;
}

INLINE struct Points pick_points(struct Points no, struct Points yes, Ints mask) {
    return points(PICK(no.x, yes.x, mask), PICK(no.y, yes.y, mask), PICK(no.z, yes.z, mask));
}
