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

// Distance along a ray to the front of a rectangle, or INFINITY.
INLINE float rectangle_distance(__global const struct Light *light, float4 origin, float4 direction) {
    float4 normal = light->normal;
    float4 to = light->position - origin;
    to.w = 0.0f;
    float height = -dot(normal, to);
    float approach = -dot(normal, direction);
    if (!(height > 0.0f && approach > 0.0f)) {
        return INFINITY;
    }
    float t = height / approach;
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

// Radiance of all rectangles that a ray meets before `t_max`, each weighted against light_sample given the density
// `phase_pdf` of the ray's direction (< 0: a camera ray, not weighted).
INLINE float4 rectangle_hits(__constant struct Frame *frame, __global const struct Light *lights, float4 origin,
    float4 direction, float t_max, float phase_pdf) {
    float4 radiance = (float4)(0.0f);
    for (uint i = 0; i < frame->rectangle_count; ++i) {
        float distance = rectangle_distance(lights + i, origin, direction);
        if (distance < t_max) {
            float4 power = lights[i].power;
            power.w = 0.0f;
            radiance += balance(phase_pdf, rectangle_pdf(lights + i, direction, distance)) * power;
        }
    }
    return radiance;
}
