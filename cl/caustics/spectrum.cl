// Colours of wavelengths.
#include "common/inline.cl"

#define SHORTEST_WAVELENGTH 0.38f // micrometres
#define LONGEST_WAVELENGTH 0.73f

// A bell around `middle` nanometres, with another width on each side.
INLINE float bell(float nanometres, float middle, float below, float above) {
    float x = nanometres - middle;
    x *= x < 0.0f ? 1.0f / below : 1.0f / above;
    return exp(-0.5f * x * x);
}

// The colour matching functions of the CIE 1931 by Wyman, Sloan and Shirley 2013 ("Simple Analytic Approximations to the
// CIE XYZ Color Matching Functions"), as linear sRGB: channels may be negative. `nanometres`: wavelength.
INLINE float3 color_of(float nanometres) {
    float x = 1.056f * bell(nanometres, 599.8f, 37.9f, 31.0f) + 0.362f * bell(nanometres, 442.0f, 16.0f, 26.7f)
        - 0.065f * bell(nanometres, 501.1f, 20.4f, 26.2f);
    float y = 0.821f * bell(nanometres, 568.8f, 46.9f, 40.5f) + 0.286f * bell(nanometres, 530.9f, 16.3f, 31.1f);
    float z = 1.217f * bell(nanometres, 437.0f, 11.8f, 36.0f) + 0.681f * bell(nanometres, 459.0f, 26.0f, 13.8f);
    return (float3)(3.2404542f * x - 1.5371385f * y - 0.4985314f * z,
        -0.9692660f * x + 1.8760108f * y + 0.0415560f * z,
        0.0556434f * x - 0.2040259f * y + 1.0572252f * z);
}
