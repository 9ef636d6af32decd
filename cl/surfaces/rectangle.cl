// Parallelograms as rays meet them.
#include "surfaces/plane.cl"

// Whether a ray meets a parallelogram at 0 < *t < t_max. `across_u`, `across_v`: their products with the way from the
// corner are 0..1 along the edges.
INLINE bool rectangle_hit(float3 corner, float3 across_u, float3 across_v, float4 plane, float3 origin,
                          float3 direction, float t_max, float *t) {
    if (!plane_hit(plane, origin, direction, t_max, t)) {
        return false;
    }
    float3 way = plane_point(plane, origin + *t * direction) - corner;
    float u = dot(way, across_u);
    float v = dot(way, across_v);
    return u >= 0.0f && u <= 1.0f && v >= 0.0f && v <= 1.0f;
}
