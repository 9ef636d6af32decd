// Directions: float4 of unit length with w = 0.
#include "common/inline.cl"

// (cos, sin) of 2 pi u for u in [0, 1), absolute error < 1e-7, without branches.
//
// With v = u - 1/2 both are sines of at most a quarter turn, x turns: x = |v| - 1/4 for the cosine, 1/4 - ||v| - 1/4| with
// the sign of -v for the sine. The reductions are exact; the minimax polynomial's relative error is 5.3e-9.
INLINE float2 unit_circle(float u) {
    float v = u - 0.5f;
    float c = fabs(v) - 0.25f;
    float2 x = (float2)(c, copysign(0.25f - fabs(c), -v));
    float2 y = x * x;
    return x * (6.28318527f + y * (-41.3416775f + y * (81.6022312f + y * (-76.5749922f + y * 39.7109180f))));
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
