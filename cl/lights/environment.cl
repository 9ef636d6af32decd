// Directions drawn from the environment map, in proportion to what shines from each texel.
//
// The table (src/render/lights/environment.rs) holds, for every row of texels, the probability of the rows down to
// it, then, for every texel, the probability within its row of the texels up to it. All are multiples of 2^-24, as the
// random numbers are, so that each texel is drawn with exactly the probability that the density assumes. Within a
// texel, directions are uniform in solid angle.
#include "common/inline.cl"
#include "render/background.cl"
#include "types/frame.cl"

// A probability table's choice: the entry, its probability, and where in the entry the number fell, in (0, 1).
struct Choice {
    uint index;
    float probability;
    float rest;
};

INLINE struct Choice choose(__global const float *sums, uint count, float u) {
    uint low = 0;
    uint high = count - 1;
    while (low < high) { // the first entry whose sum exceeds u
        uint middle = (low + high) >> 1;
        if (sums[middle] > u) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    struct Choice choice;
    float before = low > 0 ? sums[low - 1] : 0.0f;
    choice.index = low;
    choice.probability = sums[low] - before;
    // The middle of the 2^-24 that u stands for.
    choice.rest = min((u - before + 0x1p-25f) / choice.probability, 1.0f - 0x1p-24f);
    return choice;
}

#ifdef ENVIRONMENT
// Density of a texel by solid angle. Cosines of its edges differ by 2 sin(pi (y + 1/2) / height) sin(pi / (2 height)).
INLINE float environment_density(__constant struct Frame *frame, uint row, float probability) {
    float per_row = 1.0f / (float)frame->environment_height;
    float band = sinpi(((float)row + 0.5f) * per_row) * sinpi(0.5f * per_row);
    return probability * (float)frame->environment_width / (4.0f * M_PI_F * band);
}

// The density with which light_sample takes the direction at `place`, its picking the environment included.
INLINE float environment_place_pdf(__constant struct Frame *frame, __global const float *sums, float2 place) {
    uint width = frame->environment_width;
    uint height = frame->environment_height;
    uint column = min((uint)(place.x * (float)width), width - 1);
    uint row = min((uint)(place.y * (float)height), height - 1);
    __global const float *in_row = sums + height + (size_t)row * width;
    float of_row = sums[row] - (row > 0 ? sums[row - 1] : 0.0f);
    float of_column = in_row[column] - (column > 0 ? in_row[column - 1] : 0.0f);
    return frame->environment_pick * environment_density(frame, row, of_row * of_column);
}

INLINE float environment_pdf(__constant struct Frame *frame, __global const float *sums, float4 direction) {
    if (frame->environment_pick == 0.0f) {
        return 0.0f;
    }
    return environment_place_pdf(frame, sums, environment_place(frame, direction.xyz));
}

// A direction towards the map; `*pdf`: its density by solid angle, without the probability of picking the map.
INLINE float4 environment_direction(__constant struct Frame *frame, __global const float *sums, float2 u, float *pdf) {
    uint width = frame->environment_width;
    uint height = frame->environment_height;
    struct Choice row = choose(sums, height, u.x);
    struct Choice column = choose(sums + height + (size_t)row.index * width, width, u.y);
    *pdf = environment_density(frame, row.index, row.probability * column.probability);
    // sin^2 of half the angle from the nearer pole is uniform, and exact near it.
    bool below = (float)row.index + row.rest > 0.5f * (float)height;
    float from_pole = (float)(below ? height - 1 - row.index : row.index);
    float per_row = 1.0f / (float)height;
    float edge = sinpi(0.5f * from_pole * per_row);
    float band = sinpi((from_pole + 0.5f) * per_row) * sinpi(0.5f * per_row);
    float half_sine2 = edge * edge + (below ? 1.0f - row.rest : row.rest) * band;
    float sine = 2.0f * sqrt(half_sine2 * (1.0f - half_sine2));
    float cosine = 1.0f - 2.0f * half_sine2;
    float turn = ((float)column.index + column.rest) / (float)width + frame->environment_turn;
    return (float4)(sine * cospi(2.0f * turn), below ? -cosine : cosine, sine * sinpi(2.0f * turn), 0.0f);
}
#endif
