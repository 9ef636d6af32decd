// One pixel of the film: mean and second moment as unevaluated sums of two floats, good for 10^9 samples.
struct FilmPixel {
    float4 mean;      // rgb and opacity
    float4 mean_low;
    float4 m2;        // sum of squared deviations
    float4 m2_low;
    float depth;      // mean distance to the camera over the samples that hit, local units
    uint hits;        // samples with a depth
    uint count;       // samples added
    uint rejected;    // samples not added because they were not finite
    uint lookups_low; // cells fetched from the volume, 64 bits
    uint lookups_high;
    uint pad_0;
    uint pad_1;
};
