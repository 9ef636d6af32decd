// Camera rays: pinhole, thin lens or parallel, averaged over the pixel's area or through its centre.
#include "common/sobol.cl"
#include "types/camera.cl"

// A ray from the camera in local units; `t` counts local length from `origin`, which lies near the volume.
struct CameraRay {
    float3 origin;
    float3 direction; // unit length
    float t_min;      // where the eye is: everything before it is behind the camera
};

// Point of the unit disk, area-preserving (Shirley and Chiu 1997).
INLINE float2 concentric_disk(float2 u) {
    float2 p = 2.0f * u - 1.0f;
    if (p.x == 0.0f && p.y == 0.0f) {
        return p;
    }
    bool wide = fabs(p.x) > fabs(p.y);
    float radius = wide ? p.x : p.y;
    float angle = wide ? M_PI_4_F * (p.y / p.x) : M_PI_2_F - M_PI_4_F * (p.x / p.y);
    return radius * (float2)(cos(angle), sin(angle));
}

// `keys`: the pixel's random words (see sobol.cl).
INLINE struct CameraRay camera_ray(__constant struct Camera *camera, uint pixel, uint sample, uint4 keys) {
    uint2 size = (uint2)(camera->width, camera->height);
#ifdef FILTER_BOX
    float2 in_pixel = sobol_pair(sample, keys, 0);
#else
    float2 in_pixel = (float2)(0.5f, 0.5f);
#endif
    float x = 2.0f * ((float)(pixel % size.x) + in_pixel.x) / (float)size.x - 1.0f;
    float y = 1.0f - 2.0f * ((float)(pixel / size.x) + in_pixel.y) / (float)size.y;
    float3 point = camera->base.xyz + x * camera->base_u.xyz + y * camera->base_v.xyz;
    float3 direction = camera->dir.xyz + x * camera->dir_u.xyz + y * camera->dir_v.xyz;
#ifdef THIN_LENS
    // The lens moves the eye by `lens`; rays still meet at the focus distance.
    float2 disk = concentric_disk(sobol_pair(sample, keys, 2));
    float3 lens = disk.x * camera->lens_u.xyz + disk.y * camera->lens_v.xyz;
    point += lens * (1.0f - camera->depth * camera->inv_focus);
    direction -= lens * camera->inv_focus;
#endif
    // Not length(): compilers guard it against overflow that cannot happen here.
    float per_depth = sqrt(dot(direction, direction));
    struct CameraRay ray;
    ray.origin = point;
    ray.direction = direction / per_depth;
    ray.t_min = -camera->depth * per_depth;
    return ray;
}
