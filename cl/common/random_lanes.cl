// Random numbers of many paths at once: the same numbers as the scalar functions give.
#include "common/lanes.cl"
#include "common/rng.cl"
#include "common/sobol.cl"

// Philox4x32-7 of counters in place (see rng.cl).
INLINE void philox_lanes(Words words[4], uint2 key) {
    for (int round = 0; round < PHILOX_ROUNDS; ++round) {
        Words high_0 = mul_hi((Words)(0xD2511F53u), words[0]);
        Words low_0 = 0xD2511F53u * words[0];
        Words high_1 = mul_hi((Words)(0xCD9E8D57u), words[2]);
        Words low_1 = 0xCD9E8D57u * words[2];
        words[0] = high_1 ^ words[1] ^ key.x;
        words[1] = low_1;
        words[2] = high_0 ^ words[3] ^ key.y;
        words[3] = low_0;
        key += (uint2)(0x9E3779B9u, 0xBB67AE85u);
    }
}

// Philox2x32-7 of counters in place: two words for half the work.
INLINE void philox2_lanes(Words words[2], Words key) {
    for (int round = 0; round < PHILOX_ROUNDS; ++round) {
        Words high = mul_hi((Words)(0xD256D193u), words[0]);
        Words low = 0xD256D193u * words[0];
        words[0] = high ^ key ^ words[1];
        words[1] = low;
        key += 0x9E3779B9u;
    }
}

// 24 bits, in [0, 1).
INLINE Reals uniform_lanes(Words bits) {
    return TO_REALS(AS_INTS(bits >> 8)) * 0x1p-24f;
}

INLINE Words reverse_bits_lanes(Words x) {
    x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
    return (x >> 16) | (x << 16);
}

INLINE Words laine_karras_lanes(Words x, Words seed) {
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    x ^= x * 0x8d22f6e6u;
    return x;
}

// The point with this index (below 64) of a shuffled, Owen-scrambled Sobol sequence in four dimensions, 32 bits each
// (see sobol.cl). `keys`: four random words that belong to the sequence.
INLINE void sobol_lanes(Words index, const Words keys[4], Words point[4]) {
    Words place = laine_karras_lanes(reverse_bits_lanes(index), keys[3]);
    point[0] = point[1] = point[2] = point[3] = (Words)(0u);
    for (int bit = 0; bit < 6; ++bit) {
        Words mask = AS_WORDS(AS_INTS(place << bit) >> 31);
        point[0] ^= mask & (1u << bit);
        point[1] ^= mask & SOBOL_DIRECTIONS[0][bit];
        point[2] ^= mask & SOBOL_DIRECTIONS[1][bit];
        point[3] ^= mask & SOBOL_DIRECTIONS[2][bit];
    }
    point[0] = reverse_bits_lanes(laine_karras_lanes(point[0], keys[0]));
    point[1] = reverse_bits_lanes(laine_karras_lanes(point[1], keys[0] ^ keys[2]));
    point[2] = reverse_bits_lanes(laine_karras_lanes(point[2], keys[1]));
    point[3] = reverse_bits_lanes(laine_karras_lanes(point[3], keys[1] ^ keys[2]));
}
