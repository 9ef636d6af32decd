// Triangles as rays meet them, without gaps between neighbours (Woop, Benthin and Wald 2013, "Watertight ray/triangle
// intersection"): corners are sheared so that the ray is the z axis, and each edge is seen from there by a function
// whose sign is exact for the sheared corners, hence opposite for the two triangles that share it.
#include "common/inline.cl"
#include "surfaces/nodes.cl"

// a b - c d with the sign of the exact value: both products are rounded, what that loses is added back (Kahan).
INLINE float difference_of_products(float a, float b, float c, float d) {
    float cd = c * d;
    return fma(a, b, -cd) + fma(-c, d, cd);
}

// A corner as seen along the ray.
INLINE float3 sheared(float3 corner, const struct Ray *ray) {
    float3 way = turned(corner - ray->origin, ray->axis);
    return (float3)(fma(-ray->shear.x, way.z, way.x), fma(-ray->shear.y, way.z, way.y), way.z);
}

// Whether the line of a ray meets a triangle: then *weights are the shares of the corners, times a common factor, their
// sum.
INLINE bool triangle_weights(float3 a, float3 b, float3 c, const struct Ray *ray, float3 *weights, float *t) {
    float3 p = sheared(a, ray);
    float3 q = sheared(b, ray);
    float3 r = sheared(c, ray);
    float u = difference_of_products(r.x, q.y, r.y, q.x);
    float v = difference_of_products(p.x, r.y, p.y, r.x);
    float w = difference_of_products(q.x, p.y, q.y, p.x);
    float sum = u + v + w;
    *weights = (float3)(u, v, w);
    *t = ray->shear.z * (u * p.z + v * q.z + w * r.z) / sum;
    return !(min(min(u, v), w) < 0.0f && max(max(u, v), w) > 0.0f) && sum != 0.0f;
}

// Whether a ray meets a triangle at 0 < *t < t_max.
INLINE bool triangle_hit(float3 a, float3 b, float3 c, const struct Ray *ray, float t_max, float *t) {
    float3 weights;
    return triangle_weights(a, b, c, ray, &weights, t) && *t > 0.0f && *t < t_max;
}

// Whether a ray that meets a triangle comes from behind it, by the sense in which it sees the corners.
INLINE bool triangle_inside(float3 a, float3 b, float3 c, const struct Ray *ray) {
    float3 weights;
    float t;
    triangle_weights(a, b, c, ray, &weights, &t);
    return (weights.x + weights.y + weights.z < 0.0f) == (ray->shear.z > 0.0f);
}

// The normal for shading between those of the corners. That of the triangle itself where the other would turn the ray's
// side, or send its reflection into the surface.
INLINE float3 triangle_normal(float3 a, float3 b, float3 c, __global const float4 *normals, float3 face,
                              const struct Ray *ray) {
    float3 weights;
    float t;
    triangle_weights(a, b, c, ray, &weights, &t);
    weights /= weights.x + weights.y + weights.z;
    float3 sum = weights.x * normals[0].xyz + weights.y * normals[1].xyz + weights.z * normals[2].xyz;
    float square = dot(sum, sum);
    float3 normal = sum * rsqrt(max(square, FLT_MIN));
    float before = dot(ray->direction, face);
    float slope = dot(ray->direction, normal);
    float after = before - 2.0f * slope * dot(normal, face);
    return square > 1e-12f && before * slope > 0.0f && before * after < 0.0f ? normal : face;
}
