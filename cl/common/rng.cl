// Counter-based random numbers: Philox4x32-7 (Salmon et al. 2011). Stateless, so the same scene and seed give
// the same bits whatever the launch sizes.
#include "common/inline.cl"

// The fewest with which its authors found no statistical flaw (BigCrush). Their margin of three more, where nothing is
// known to be gained, costs 7 % of a path.
#define PHILOX_ROUNDS 7

// Purposes keep streams apart that share a pixel and a sample.
#define RNG_STEP_PHASE 1u
#define RNG_STRATA 3u // keys of a sample's stratified points
#define RNG_DIRECT 4u // direct light of cells, with the kind of ray in the upper 24 bits, as the next
#define RNG_DIRECT_STRATA 5u
#define RNG_PHOTON 6u // with the turn of the photon as the block
#define RNG_PHOTON_SHIFT 7u // with the pass in place of the photon
#define RNG_PHOTON_PASS 8u
#define RNG_WAVELENGTH 10u
#define RNG_SURFACES 9u // rays among surfaces, with the draw in the upper 24 bits
#define RNG_PATH 2u // with the path's number in the upper 24 bits (see stream.cl)

INLINE uint4 philox4x32(uint4 counter, uint2 key) {
    for (int round = 0; round < PHILOX_ROUNDS; ++round) {
        uint high_0 = mul_hi(0xD2511F53u, counter.x);
        uint low_0 = 0xD2511F53u * counter.x;
        uint high_1 = mul_hi(0xCD9E8D57u, counter.z);
        uint low_1 = 0xCD9E8D57u * counter.z;
        counter = (uint4)(high_1 ^ counter.y ^ key.x, low_1, high_0 ^ counter.w ^ key.y, low_0);
        key += (uint2)(0x9E3779B9u, 0xBB67AE85u);
    }
    return counter;
}

// 24 bits, in [0, 1).
INLINE float uniform_float(uint bits) {
    return (float)(bits >> 8) * 0x1p-24f;
}

INLINE float4 uniform_float4(uint4 bits) {
    return convert_float4(bits >> 8) * 0x1p-24f;
}

// Four uniform numbers for one pixel, sample and purpose.
INLINE float4 random4(uint2 seed, uint pixel, uint sample, uint purpose) {
    return uniform_float4(philox4x32((uint4)(pixel, sample, 0u, purpose), seed));
}
