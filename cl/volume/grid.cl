// A ray in grid coordinates, clipped to the volume's box.
//
// Vectors have four lanes of which the last is unused: three-lane vectors cost CPU compilers shuffles.
#include "common/inline.cl"
#include "types/volume.cl"

struct GridRay {
    float4 origin;    // grid coordinates at t = 0
    float4 direction; // grid units per local length
    float4 inverse;   // 1 / direction; 0 where the ray does not move along the axis
    float4 never;     // +inf where the ray does not move along the axis (and in w), else 0
    int4 step;        // +1, -1, or 0 where the ray does not move
    int4 ahead;       // 1 where step is +1, else 0: the exit plane of cell c is c + ahead
    float t0;         // where it enters the box, not before the eye
    float t1;         // where it leaves the box; the ray misses when t1 <= t0
};

// Below this a ray counts as parallel to the axis: over any box it moves less than 2^-24 of a cell.
#define PARALLEL 1e-12f

// Grid coordinates of the box's low corner: half a voxel before the first voxel's centre.
#define GRID_LOW ((float)GRID_PAD - 0.5f)

// Times at which the ray crosses the planes `grid coordinate = plane`; +inf where it never does. Every use
// recomputes them from the integer planes, so the same plane always gives the same time, whichever way the ray
// was followed.
INLINE float4 plane_times(const struct GridRay *ray, float4 plane) {
    return (plane - ray->origin) * ray->inverse + ray->never;
}

// Exit times of a cell (or, with planes scaled, of a brick) per axis.
INLINE float4 exit_times(const struct GridRay *ray, int4 cell) {
    return plane_times(ray, convert_float4(cell + ray->ahead));
}

INLINE float least3(float4 v) {
    return min(min(v.x, v.y), v.z);
}

// Clips [t0, t1] to the slab of one axis.
INLINE void clip_axis(struct GridRay *ray, float origin, float inverse, float size) {
    float high = GRID_LOW + size;
    if (inverse == 0.0f) {
        if (origin < GRID_LOW || origin > high) {
            ray->t1 = -INFINITY;
        }
        return;
    }
    float a = (GRID_LOW - origin) * inverse;
    float b = (high - origin) * inverse;
    ray->t0 = max(ray->t0, min(a, b));
    ray->t1 = min(ray->t1, max(a, b));
}

// The part of a ray (local units, starting at `t_min`) inside the box.
INLINE struct GridRay grid_ray(__constant struct Volume *volume, float3 origin, float3 direction, float t_min) {
    struct GridRay ray;
    float4 scale = volume->scale;
    float4 d = (float4)(direction, 0.0f) * scale;
    int4 still = fabs(d) < PARALLEL;
    ray.origin = (float4)(origin, 0.0f) * scale + GRID_LOW;
    ray.direction = select(d, (float4)(0.0f), still);
    ray.inverse = select(1.0f / d, (float4)(0.0f), still);
    ray.never = select((float4)(0.0f), (float4)(INFINITY), still);
    ray.ahead = (ray.direction > 0.0f) & 1;
    ray.step = ray.ahead - ((ray.direction < 0.0f) & 1);
    ray.t0 = t_min;
    ray.t1 = INFINITY;
    clip_axis(&ray, ray.origin.x, ray.inverse.x, (float)volume->dims.x);
    clip_axis(&ray, ray.origin.y, ray.inverse.y, (float)volume->dims.y);
    clip_axis(&ray, ray.origin.z, ray.inverse.z, (float)volume->dims.z);
    return ray;
}

INLINE float4 grid_point(const struct GridRay *ray, float t) {
    return ray->origin + t * ray->direction;
}
