// How much of the kernel around a point lies on its surface: what estimates are divided by, because no photons lie beyond
// an edge. 1 where no edges are known. Lengths are over the radius.
#include "common/inline.cl"
#include "types/photon_map.cl"

#ifdef EDGE_CORRECTION
// Below this, no correction divides: acute corners have more.
#define LEAST_MASS 1e-4f

// Weight of the kernel within t <= 1.
INLINE float kernel_within(float t) {
    float t2 = t * t;
#ifdef KERNEL_CONSTANT
    return t2;
#elif defined(KERNEL_CONE)
    return t2 * (3.0f - 2.0f * t);
#else
    return t2 * (10.0f / 3.0f + t2 * (-5.0f + (8.0f / 3.0f) * t));
#endif
}

// Its derivative.
INLINE float kernel_ring(float t) {
#ifdef KERNEL_CONSTANT
    return 2.0f * t;
#elif defined(KERNEL_CONE)
    return 6.0f * t * (1.0f - t);
#else
    return (20.0f / 3.0f) * t * (1.0f + t * t * (2.0f * t - 3.0f));
#endif
}

// Integral of kernel_within(d / cos a) da up to tan a = x / d, for d^2 + x^2 <= 1.
INLINE float within_triangle(float d, float x) {
#ifdef KERNEL_CONSTANT
    return d * x;
#else
    float rho = sqrt(d * d + x * x);
    float size = log((fabs(x) + rho) / d);
    float cubic = d * rho * x + d * d * d * (x < 0.0f ? -size : size); // twice the integral of (d / cos a)^3
#ifdef KERNEL_CONE
    return 3.0f * d * x - cubic;
#else
    return d * x * (10.0f / 3.0f - 5.0f * d * d - (5.0f / 3.0f) * x * x + (2.0f / 3.0f) * rho * rho * rho) + d * d * cubic;
#endif
#endif
}

// The angle at the origin between two points of a line at distance d.
INLINE float angle_between(float d, float from, float to) {
    return from == to ? 0.0f : atan2(d * (to - from), d * d + from * to);
}

// 2 pi times the weight of the kernel in the triangle of its centre, the origin, and an edge from a to b of a polygon around
// it, counterclockwise. What of the edge is farther than the radius sees the whole kernel.
INLINE float beside_edge(float2 a, float2 b) {
    float2 along = b - a;
    along *= 1.0f / sqrt(dot(along, along));
    float d = max(a.x * along.y - a.y * along.x, 1e-6f);
    float from = dot(a, along);
    float to = dot(b, along);
    if (d >= 1.0f) return angle_between(d, from, to);
    float across = sqrt(1.0f - d * d);
    float enters = clamp(from, -across, across);
    float leaves = clamp(to, -across, across);
    return angle_between(d, from, enters) + angle_between(d, leaves, to) + within_triangle(d, leaves)
        - within_triangle(d, enters);
}

// A parallelogram with edges (width, 0) and (slant, height), and a point `place` from its corner.
INLINE float mass_on_parallelogram(float2 place, float width, float slant, float height) {
    // Farther than the radius from all edges.
    float lean = height / sqrt(slant * slant + height * height);
    float left = (place.x - slant * place.y / height) * lean;
    float aside = min(left, width * lean - left);
    if (min(min(place.y, height - place.y), aside) >= 1.0f) return 1.0f;
    float2 a = -place;
    float2 b = a + (float2)(width, 0.0f);
    float2 c = b + (float2)(slant, height);
    float2 d = a + (float2)(slant, height);
    return (0.5f * M_1_PI_F) * (beside_edge(a, b) + beside_edge(b, c) + beside_edge(c, d) + beside_edge(d, a));
}

__constant float DISK_NODES[8] = {0.019855072f, 0.101666761f, 0.237233795f, 0.408282679f, 0.591717321f, 0.762766205f,
    0.898333239f, 0.980144928f};
__constant float DISK_WEIGHTS[8] = {0.050614268f, 0.111190517f, 0.156853323f, 0.181341892f, 0.181341892f, 0.156853323f,
    0.111190517f, 0.050614268f};

// A disk with a point at distance c from its centre: circles around the point that leave the disk lose the angle outside.
// By Gauss's rule, in a variable that takes the angle's roots away at both ends: to 1e-5.
INLINE float mass_on_disk(float radius, float c) {
    float from = max(radius - c, 0.0f);
    if (from >= 1.0f) return 1.0f;
    float span = min(1.0f, radius + c) - from;
    float outside = 0.0f;
    for (int k = 0; k < 8; ++k) {
        float s = DISK_NODES[k];
        float t = from + span * s * s * (3.0f - 2.0f * s);
        float cosine = ((radius - c) * (radius + c) - t * t) / (2.0f * max(c, 1e-6f) * t);
        outside += DISK_WEIGHTS[k] * s * (1.0f - s) * kernel_ring(t) * acos(clamp(cosine, -1.0f, 1.0f));
    }
    return kernel_within(from + span) - (6.0f * M_1_PI_F) * span * outside;
}

// The face of a box that the normal stands on.
INLINE float mass_on_face(float3 offset, float3 size, float3 normal) {
    float3 along = fabs(normal);
    bool on_x = along.x >= along.y && along.x >= along.z;
    bool on_z = !on_x && along.z >= along.y;
    float2 place = (float2)(on_x ? offset.y : offset.x, on_z ? offset.y : offset.z);
    return mass_on_parallelogram(place, on_x ? size.y : size.x, 0.0f, on_z ? size.y : size.z);
}

INLINE float kernel_mass(__global const struct Receiver *receiver, float3 point, float3 normal, float inverse_radius) {
    float3 offset = (point - receiver->origin.xyz) * inverse_radius;
    float4 u = receiver->u;
    float4 v = receiver->v;
    float mass = 1.0f;
    if (receiver->kind == RECEIVER_PARALLELOGRAM) {
        float2 place = (float2)(dot(offset, u.xyz), dot(offset, v.xyz));
        float width = receiver->origin.w * inverse_radius;
        mass = mass_on_parallelogram(place, width, u.w * inverse_radius, v.w * inverse_radius);
    } else if (receiver->kind == RECEIVER_BOX) {
        mass = mass_on_face(offset, u.xyz * inverse_radius, normal);
    } else if (receiver->kind == RECEIVER_DISK) {
        mass = mass_on_disk(receiver->origin.w * inverse_radius, sqrt(dot(offset, offset)));
    }
    return max(mass, LEAST_MASS);
}
#endif
