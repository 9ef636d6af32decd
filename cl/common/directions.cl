// Directions: float4 of unit length with w = 0.
#include "common/inline.cl"

// (cos, sin) of 2 pi u for u in [0, 1), absolute error < 1e-7, without branches.
//
// u is reduced, exactly, to the nearest quarter turn and r in [-1/2, 1/2] quarter turns from it; the minimax polynomials
// err by less than 3e-9.
INLINE float2 unit_circle(float u) {
    int quarter = (int)(4.0f * u + 0.5f);
    float r = 4.0f * u - (float)quarter;
    float z = r * r;
    float s = r + r * (0.57079632f + z * (-0.64596346f + z * (0.0796800328f - z * 0.00460165789f)));
    float c = 1.0f + z * (-1.23370054f + z * (0.253669275f + z * (-0.0208604868f + z * 0.000904410716f)));
    bool odd = (quarter & 1) != 0;
    // Quarters 1 and 2 have a negative cosine, 2 and 3 a negative sine.
    uint cosine = as_uint(odd ? s : c) ^ ((uint)(quarter + 1) << 30 & 0x80000000u);
    uint sine = as_uint(odd ? c : s) ^ ((uint)quarter << 30 & 0x80000000u);
    return (float2)(as_float(cosine), as_float(sine));
}

// Uniform on the sphere.
INLINE float4 uniform_direction(float2 u) {
    float2 xy = 2.0f * sqrt(u.x * (1.0f - u.x)) * unit_circle(u.y);
    return (float4)(xy, 1.0f - 2.0f * u.x, 0.0f);
}

// `direction` turned by the angle with this cosine and sine, about an axis given by u in [0, 1).
//
// The frame is that of Duff et al. 2017 ("Building an Orthonormal Basis, Revisited"), its second axis mirrored for
// z < 0, and multiplied out. One Newton step of the inverse square root keeps the length at 1 over any number of turns.
INLINE float4 turned(float4 direction, float cosine, float sine, float u) {
    float2 aside = sine * unit_circle(u);
    float across = aside.x * direction.x + aside.y * direction.y;
    float along = cosine - across / (1.0f + fabs(direction.z));
    float x = aside.x + along * direction.x;
    float y = aside.y + along * direction.y;
    float z = cosine * direction.z - (direction.z < 0.0f ? -across : across);
    float scale = 1.5f - 0.5f * (x * x + y * y + z * z);
    return scale * (float4)(x, y, z, 0.0f);
}
