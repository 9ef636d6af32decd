// Adds films of one sample to a film: where devices render whole samples, in the order of the samples.
#include "film/accumulate.cl"

// The mean of one sample is the sample itself, to the bit. `number`: that of the sample, from 0; pixels of a film that was
// stopped within a sample may have had it.
__kernel void film_fold(__global struct FilmPixel *film, __global const struct FilmPixel *samples, uint number,
    uint count) {
    size_t index = get_global_id(0);
    if (index >= count) {
        return;
    }
    struct FilmPixel pixel = film[index];
    if (pixel.count + pixel.rejected != number) {
        return;
    }
    struct FilmPixel sample = samples[index];
    if (sample.count > 0) {
        film_add(&pixel, sample.mean, sample.hits > 0 ? sample.depth : -1.0f, sample.lookups_low);
    } else {
        film_add(&pixel, (float4)(NAN), -1.0f, sample.lookups_low);
    }
    pixel.lookups_high += sample.lookups_high;
    film[index] = pixel;
}
