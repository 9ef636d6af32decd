// Disks as rays meet them.
#include "surfaces/plane.cl"

// Whether a ray meets a disk (`place`: centre, w: radius) at 0 < *t < t_max.
INLINE bool disk_hit(float4 place, float4 plane, float3 origin, float3 direction, float t_max, float *t) {
    if (!plane_hit(plane, origin, direction, t_max, t)) {
        return false;
    }
    float3 way = plane_point(plane, origin + *t * direction) - place.xyz;
    return dot(way, way) <= place.w * place.w;
}
