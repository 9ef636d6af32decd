// The random numbers of one path: blocks of Philox, as many as the path asks for.
#include "common/rng.cl"

struct Stream {
    uint4 counter; // pixel, sample, block, purpose and path
    uint2 key;
};

INLINE struct Stream stream_start(uint2 seed, uint pixel, uint sample, uint path) {
    struct Stream stream;
    stream.counter = (uint4)(pixel, sample, 0u, path << 8 | RNG_PATH);
    stream.key = seed;
    return stream;
}

// The next four words.
INLINE uint4 stream_block(struct Stream *stream) {
    uint4 words = philox4x32(stream->counter, stream->key);
    stream->counter.z += 1u;
    return words;
}
