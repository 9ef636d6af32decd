// A ray in grid coordinates, clipped to the volume's box.
#include "types/volume.cl"

struct GridRay {
    float3 origin;    // grid coordinates at t = 0
    float3 direction; // grid units per local length
    float3 inverse;   // 1 / direction; 0 where the ray does not move along the axis
    float t0;         // where it enters the box, not before the eye
    float t1;         // where it leaves the box; the ray misses when t1 <= t0
};

// Below this a ray counts as parallel to the axis: over any box it moves less than 2^-24 of a cell.
#define PARALLEL 1e-12f

// Grid coordinates of the box's low corner: half a voxel before the first voxel's centre.
#define GRID_LOW ((float)GRID_PAD - 0.5f)

// Time at which the ray crosses the plane `grid coordinate = plane` of one axis. Every use recomputes it
// from the integer plane, so the same plane always gives the same time, whichever way the ray was followed.
inline float plane_time(float plane, float origin, float inverse) {
    return (plane - origin) * inverse;
}

inline void clip_axis(struct GridRay *ray, float origin, float direction, float inverse, float size) {
    float high = GRID_LOW + size;
    if (direction == 0.0f) {
        if (origin < GRID_LOW || origin > high) {
            ray->t1 = -INFINITY;
        }
        return;
    }
    float a = plane_time(GRID_LOW, origin, inverse);
    float b = plane_time(high, origin, inverse);
    ray->t0 = fmax(ray->t0, fmin(a, b));
    ray->t1 = fmin(ray->t1, fmax(a, b));
}

// The part of a ray (local units, starting at `t_min`) inside the box.
inline struct GridRay grid_ray(__constant struct Volume *volume, float3 origin, float3 direction, float t_min) {
    struct GridRay ray;
    ray.origin = origin * volume->scale.xyz + GRID_LOW;
    float3 d = direction * volume->scale.xyz;
    ray.direction.x = fabs(d.x) < PARALLEL ? 0.0f : d.x;
    ray.direction.y = fabs(d.y) < PARALLEL ? 0.0f : d.y;
    ray.direction.z = fabs(d.z) < PARALLEL ? 0.0f : d.z;
    ray.inverse.x = ray.direction.x == 0.0f ? 0.0f : 1.0f / ray.direction.x;
    ray.inverse.y = ray.direction.y == 0.0f ? 0.0f : 1.0f / ray.direction.y;
    ray.inverse.z = ray.direction.z == 0.0f ? 0.0f : 1.0f / ray.direction.z;
    ray.t0 = t_min;
    ray.t1 = INFINITY;
    clip_axis(&ray, ray.origin.x, ray.direction.x, ray.inverse.x, (float)volume->dims.x);
    clip_axis(&ray, ray.origin.y, ray.direction.y, ray.inverse.y, (float)volume->dims.y);
    clip_axis(&ray, ray.origin.z, ray.direction.z, ray.inverse.z, (float)volume->dims.z);
    return ray;
}

inline float3 grid_point(const struct GridRay *ray, float t) {
    return ray->origin + t * ray->direction;
}
