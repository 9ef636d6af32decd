// Rectangles as rays meet them. They shine on one side, towards their normal, and block nothing.
#include "common/inline.cl"
#include "types/frame.cl"
#include "types/light.cl"

// Densities stay finite where a rectangle is seen from its plane.
#define PDF_MAX 1e30f

// The balance heuristic's weight of a technique of density `pdf` against `other`; a `pdf` <= 0 marks what nothing
// competes with: a camera ray, a light without extent.
INLINE float balance(float pdf, float other) {
    return pdf > 0.0f ? pdf / (pdf + other) : 1.0f;
}

// Distance along a ray, later than `t_min` (which may be negative), to the front of a rectangle, or INFINITY.
INLINE float rectangle_distance(__global const struct Light *light, float4 origin, float4 direction, float t_min) {
    float4 normal = light->normal;
    float4 to = light->position - origin;
    to.w = 0.0f;
    float approach = -dot(normal, direction);
    float t = -dot(normal, to) / approach;
    if (!(approach > 0.0f && t > t_min)) {
        return INFINITY;
    }
    float4 hit = t * direction - to;
    float4 edge_u = light->edge_u;
    float4 edge_v = light->edge_v;
    float area = edge_v.w;
    // Coordinates along the edges, times the area; cross() leaves w = 0.
    float a = dot(cross(hit, edge_v), normal);
    float b = dot(cross(edge_u, hit), normal);
    return fabs(a) <= 0.5f * area && fabs(b) <= 0.5f * area ? t : INFINITY;
}

// The density by solid angle with which light_sample takes the direction in which the ray meets the rectangle at
// `distance`, its picking this light included.
INLINE float rectangle_pdf(__global const struct Light *light, float4 direction, float distance) {
    float cosine = -dot(light->normal, direction);
    return min(light->power.w * distance * distance / (light->edge_v.w * cosine), PDF_MAX);
}

// Radiance of a rectangle that a ray meets at `distance`, weighted against light_sample given the density `phase_pdf`
// of the ray's direction (< 0: a camera ray, not weighted).
INLINE float4 rectangle_radiance(__global const struct Light *light, float4 direction, float distance, float phase_pdf) {
    float4 power = light->power;
    power.w = 0.0f;
    return balance(phase_pdf, rectangle_pdf(light, direction, distance)) * power;
}
