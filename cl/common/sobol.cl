// Owen-scrambled, shuffled Sobol points in eight dimensions (Burley, "Practical Hash-based Owen Scrambling", 2020).
//
// Dimensions 0 to 3 are one sequence, 4 to 7 the same one, shuffled and scrambled independently, as Burley pads. Within a
// pixel's sequence over samples, 0 and 1 are the position in the pixel, 2 and 3 that on the lens.

#include "common/rng.cl"

// Direction numbers of dimensions 1 to 3 (Joe and Kuo 2008), bit-reversed: hashes act on reversed numbers.
__constant uint SOBOL_DIRECTIONS[3][32] = {
    {0x00000001u, 0x00000003u, 0x00000005u, 0x0000000fu, 0x00000011u, 0x00000033u, 0x00000055u, 0x000000ffu,
     0x00000101u, 0x00000303u, 0x00000505u, 0x00000f0fu, 0x00001111u, 0x00003333u, 0x00005555u, 0x0000ffffu,
     0x00010001u, 0x00030003u, 0x00050005u, 0x000f000fu, 0x00110011u, 0x00330033u, 0x00550055u, 0x00ff00ffu,
     0x01010101u, 0x03030303u, 0x05050505u, 0x0f0f0f0fu, 0x11111111u, 0x33333333u, 0x55555555u, 0xffffffffu},
    {0x00000001u, 0x00000003u, 0x00000006u, 0x00000009u, 0x00000017u, 0x0000003au, 0x00000071u, 0x000000a3u,
     0x00000116u, 0x00000339u, 0x00000677u, 0x000009aau, 0x00001601u, 0x00003903u, 0x00007706u, 0x0000aa09u,
     0x00010117u, 0x0003033au, 0x00060671u, 0x000909a3u, 0x00171616u, 0x003a3939u, 0x00717777u, 0x00a3aaaau,
     0x01170001u, 0x033a0003u, 0x06710006u, 0x09a30009u, 0x16160017u, 0x3939003au, 0x77770071u, 0xaaaa00a3u},
    {0x00000001u, 0x00000003u, 0x00000004u, 0x0000000au, 0x0000001fu, 0x0000002eu, 0x00000045u, 0x000000c9u,
     0x0000011bu, 0x000002a4u, 0x0000079au, 0x00000b67u, 0x0000101eu, 0x0000302du, 0x00004041u, 0x0000a0c3u,
     0x0001f104u, 0x0002e28au, 0x000457dfu, 0x000c9baeu, 0x0011a105u, 0x002a7289u, 0x0079e7dbu, 0x00b6dba4u,
     0x0100011au, 0x030002a7u, 0x0400079eu, 0x0a000b6du, 0x1f001001u, 0x2e003003u, 0x45004004u, 0xc900a00au},
};

INLINE uint reverse_bits(uint x) {
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    return (x >> 16) | (x << 16);
}

// Laine-Karras permutation: each bit depends only on lower bits. Of reversed numbers, a nested uniform scramble.
INLINE uint laine_karras(uint x, uint seed) {
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
}

// Keys of the second sequence: the finaliser lowbias32 (Wellons 2018) of each word.
INLINE uint4 second_keys(uint4 x) {
    x += 0x9e3779b9u;
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ x >> 16;
}

// The place of a sample after shuffling, bit-reversed: samples below any power of two from 64 keep to themselves.
//
// A plain shuffle would also flip the bits above, all alike. That is left out, because it only adds a constant to every
// Sobol point, which scrambling does anyway, and few samples then take few direction numbers.
INLINE uint shuffled(uint sample, uint key) {
    uint place = laine_karras(reverse_bits(sample), key);
    return sample < 64u ? place & 0xfc000000u : place ^ (laine_karras(0u, key) & 0x03ffffffu);
}

// The point of `sample` in dimensions `first` (0, 2, 4 or 6) and `first` + 1, in [0, 1).
// `keys`: four random words that belong to the sequence.
INLINE float2 sobol_pair(uint sample, uint4 keys, int first) {
    if (first >= 4) {
        keys = second_keys(keys);
    }
    bool low = (first & 2) == 0;
    uint a = 0u;
    uint b = 0u;
    uint places = shuffled(sample, keys.w);
    for (int bit = 0; places != 0u; ++bit) {
        uint mask = (uint)((int)places >> 31);
        a ^= mask & (low ? 1u << bit : SOBOL_DIRECTIONS[1][bit]);
        b ^= mask & (low ? SOBOL_DIRECTIONS[0][bit] : SOBOL_DIRECTIONS[2][bit]);
        places <<= 1;
    }
    uint key = low ? keys.x : keys.y;
    a = reverse_bits(laine_karras(a, key));
    b = reverse_bits(laine_karras(b, key ^ keys.z));
    return (float2)(uniform_float(a), uniform_float(b));
}
