// Directions in 32 bits: the octahedron |x| + |y| + |z| = 1 unfolded onto a square, 16 bits for each side
// (Cigolle et al. 2014). Within 7e-5 radians; the axes are exact.
#include "common/inline.cl"

#define OCTAHEDRON_STEPS 32767.0f

INLINE float2 octahedron_fold(float2 p) {
    return (1.0f - fabs(p.yx)) * (float2)(p.x < 0.0f ? -1.0f : 1.0f, p.y < 0.0f ? -1.0f : 1.0f);
}

// Any direction but zero.
INLINE uint pack_direction(float3 d) {
    float2 p = d.xy / (fabs(d.x) + fabs(d.y) + fabs(d.z));
    p = d.z < 0.0f ? octahedron_fold(p) : p;
    float2 steps = floor(OCTAHEDRON_STEPS * p + 0.5f) + 32768.0f;
    return (uint)steps.x | (uint)steps.y << 16;
}

// Of unit length.
INLINE float3 unpack_direction(uint packed) {
    float2 p = (float2)((float)(packed & 0xffffu) - 32768.0f, (float)(packed >> 16) - 32768.0f) / OCTAHEDRON_STEPS;
    float z = 1.0f - fabs(p.x) - fabs(p.y);
    p = z < 0.0f ? octahedron_fold(p) : p;
    float3 d = (float3)(p, z);
    return d * rsqrt(dot(d, d));
}
