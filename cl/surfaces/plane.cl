// Planes as rays meet them.
#include "common/inline.cl"

// Whether a ray meets the plane n . p = offset (`plane`: n, w: offset) at 0 < *t < t_max.
INLINE bool plane_hit(float4 plane, float3 origin, float3 direction, float t_max, float *t) {
    *t = (plane.w - dot(plane.xyz, origin)) / dot(plane.xyz, direction);
    return *t > 0.0f && *t < t_max;
}

// The point of a plane nearest to `point`: takes away what rounding left between a hit and its plane.
INLINE float3 plane_point(float4 plane, float3 point) {
    return point + (plane.w - dot(plane.xyz, point)) * plane.xyz;
}
