// Owen-scrambled, shuffled Sobol points in four dimensions (Burley, "Practical Hash-based Owen Scrambling", 2020).
// Dimensions 0 and 1: position in the pixel; 2 and 3: position on the lens. Direction numbers: Joe and Kuo 2008.

#include "common/rng.cl"

__constant uint SOBOL_DIRECTIONS[3][32] = {
    {0x80000000u, 0xc0000000u, 0xa0000000u, 0xf0000000u, 0x88000000u, 0xcc000000u, 0xaa000000u, 0xff000000u,
     0x80800000u, 0xc0c00000u, 0xa0a00000u, 0xf0f00000u, 0x88880000u, 0xcccc0000u, 0xaaaa0000u, 0xffff0000u,
     0x80008000u, 0xc000c000u, 0xa000a000u, 0xf000f000u, 0x88008800u, 0xcc00cc00u, 0xaa00aa00u, 0xff00ff00u,
     0x80808080u, 0xc0c0c0c0u, 0xa0a0a0a0u, 0xf0f0f0f0u, 0x88888888u, 0xccccccccu, 0xaaaaaaaau, 0xffffffffu},
    {0x80000000u, 0xc0000000u, 0x60000000u, 0x90000000u, 0xe8000000u, 0x5c000000u, 0x8e000000u, 0xc5000000u,
     0x68800000u, 0x9cc00000u, 0xee600000u, 0x55900000u, 0x80680000u, 0xc09c0000u, 0x60ee0000u, 0x90550000u,
     0xe8808000u, 0x5cc0c000u, 0x8e606000u, 0xc5909000u, 0x6868e800u, 0x9c9c5c00u, 0xeeee8e00u, 0x5555c500u,
     0x8000e880u, 0xc0005cc0u, 0x60008e60u, 0x9000c590u, 0xe8006868u, 0x5c009c9cu, 0x8e00eeeeu, 0xc5005555u},
    {0x80000000u, 0xc0000000u, 0x20000000u, 0x50000000u, 0xf8000000u, 0x74000000u, 0xa2000000u, 0x93000000u,
     0xd8800000u, 0x25400000u, 0x59e00000u, 0xe6d00000u, 0x78080000u, 0xb40c0000u, 0x82020000u, 0xc3050000u,
     0x208f8000u, 0x51474000u, 0xfbea2000u, 0x75d93000u, 0xa0858800u, 0x914e5400u, 0xdbe79e00u, 0x25db6d00u,
     0x58800080u, 0xe54000c0u, 0x79e00020u, 0xb6d00050u, 0x800800f8u, 0xc00c0074u, 0x200200a2u, 0x50050093u},
};

INLINE uint reverse_bits(uint x) {
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    return (x >> 16) | (x << 16);
}

// Laine-Karras permutation: each bit depends only on lower bits.
INLINE uint laine_karras(uint x, uint seed) {
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
}

INLINE uint nested_uniform_scramble(uint x, uint seed) {
    return reverse_bits(laine_karras(reverse_bits(x), seed));
}

INLINE uint sobol(uint index, int dimension) {
    if (dimension == 0) {
        return reverse_bits(index);
    }
    uint x = 0;
    for (int bit = 0; bit < 32 && index >> bit; ++bit) {
        x ^= (index >> bit & 1u) ? SOBOL_DIRECTIONS[dimension - 1][bit] : 0u;
    }
    return x;
}

// The point of `sample` in the sequence of one pixel, dimensions `first` and `first` + 1, in [0, 1).
// `keys`: four random words that belong to the pixel.
INLINE float2 sobol_pair(uint sample, uint4 keys, int first) {
    uint index = nested_uniform_scramble(sample, keys.w);
    uint key = first == 0 ? keys.x : keys.y;
    uint a = nested_uniform_scramble(sobol(index, first), key);
    uint b = nested_uniform_scramble(sobol(index, first + 1), key ^ keys.z);
    return (float2)(uniform_float(a), uniform_float(b));
}
