// Spheres as rays meet them, of any size against the scene.
//
// A sphere is given by a point q of it, the curvature k = 1 / radius and the normal n at q: with x = p - q it is where
//     f(x) = n . x + k |x|^2 / 2 = 0,
// the height above the sphere to first order. No term is of the size of the radius, so that a sphere much larger than
// the scene is as exact as a plane, which is the case k = 0. The quadratic along a ray starts from the ray's point
// nearest to q, so that what is far away cancels before it is squared (the discriminant from the perpendicular
// distance: Haines, Günther and Akenine-Möller 2019, "Precision improvements for ray/sphere intersection"); its roots
// are taken without cancellation.
#include "common/inline.cl"

// `place`: q, w: k.
INLINE float sphere_height(float3 x, float3 normal, float curvature) {
    return dot(normal, x) + 0.5f * curvature * dot(x, x);
}

// Whether a ray meets a sphere at 0 < *t < t_max. Rays from inside always leave, rays that start outside and go away never
// hit, and those that start on it and go inwards enter at once: the side is that of the origin, not of a root.
INLINE bool sphere_hit(float4 place, float3 normal, float3 origin, float3 direction, float t_max, float *t) {
    float3 from = origin - place.xyz;
    bool inside = sphere_height(from, normal, place.w) < 0.0f;
    if (!inside && dot(normal + place.w * from, direction) >= 0.0f) {
        return false;
    }
    float shift = -dot(from, direction);
    float3 x = from + shift * direction;
    float slope = dot(normal + place.w * x, direction);
    float height = sphere_height(x, normal, place.w);
    float discriminant = slope * slope - 2.0f * place.w * height;
    if (!inside && !(discriminant >= 0.0f)) {
        return false;
    }
    float root = sqrt(max(discriminant, 0.0f));
    // Into the sphere the lower root, out of it the higher one: (-slope -+ root) / k, or 2 height / (-slope +- root).
    float sum = -slope + (inside ? root : -root);
    float other = -slope + (inside ? -root : root);
    bool cancels = fabs(sum) < fabs(other);
    float s = cancels ? 2.0f * height / other : sum / place.w;
    *t = max(shift + s, FLT_MIN);
    return *t < t_max;
}

// The point of a sphere near `point`, and the outward normal there.
INLINE float3 sphere_point(float4 place, float3 normal, float3 point, float3 *outward) {
    float3 x = point - place.xyz;
    float3 gradient = normal + place.w * x;
    // Of length 1 at the sphere.
    *outward = normalize(gradient);
    return point - sphere_height(x, normal, place.w) * *outward;
}
