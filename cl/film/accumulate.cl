// Adds one sample to a pixel of the film (Welford's update in two-float arithmetic).
//
// The update is per sample, so the film does not depend on how samples are grouped into launches.
#include "common/numeric.cl"
#include "types/film.cl"

// `rgba`: radiance and opacity; `depth`: distance to the camera in local units, or negative for no hit;
// `lookups`: cells fetched for this sample.
INLINE void film_add(struct FilmPixel *pixel, float4 rgba, float depth, uint lookups) {
    pixel->lookups_low += lookups;
    pixel->lookups_high += pixel->lookups_low < lookups;
    bool finite = is_finite_bits(rgba.x) && is_finite_bits(rgba.y) && is_finite_bits(rgba.z) && is_finite_bits(rgba.w)
        && is_finite_bits(depth);
    if (!finite) {
        pixel->rejected += 1;
        return;
    }
    pixel->count += 1;
    float4 before = (rgba - pixel->mean) - pixel->mean_low;
    two_float_add(&pixel->mean, &pixel->mean_low, before / (float)pixel->count);
    float4 after = (rgba - pixel->mean) - pixel->mean_low;
    two_float_add(&pixel->m2, &pixel->m2_low, before * after);
    if (depth >= 0.0f) {
        pixel->hits += 1;
        pixel->depth += (depth - pixel->depth) / (float)pixel->hits;
    }
}
