// Samples of direct light as a point sees it, without what lies between. Lengths in local units.
//
// The table of lights (src/render/lights/) has rectangles first, and with each light the probability of picking it,
// in proportion to the flux that reaches the volume; the environment map is what comes after the last one.
#include "common/inline.cl"
#include "lights/environment.cl"
#include "lights/rectangle.cl"
#include "types/frame.cl"
#include "types/light.cl"

struct LightSample {
    float4 direction; // unit, from the point towards the light; w = 0
    float4 weight;    // radiance over the density by solid angle, or irradiance, over the probability of picking; w = 0
    float distance;   // INFINITY for directional lights and the environment
    float pdf;        // density by solid angle times the probability of picking; 0 for lights without extent. The
                      // weight in a combination with other techniques is balance(pdf, other)
};

// Points nearer to a light's point than this (squared) get nothing: 1 / r^2 would overflow where the point is the
// light, an event of probability zero.
#define LIGHT_NEAREST2 1e-20f

INLINE uint pick_light(__global const struct Light *lights, uint count, float u) {
    uint low = 0;
    uint high = count;
    while (low < high) { // the first light whose sum exceeds u, or `count`
        uint middle = (low + high) >> 1;
        if (lights[middle].edge_u.w > u) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    return low;
}

// A light as seen from `point` (w is ignored). u: uniform multiples of 2^-24 in [0, 1); x picks the light, y and z a
// point on it. The scene must have a light to sample.
INLINE struct LightSample light_sample(__constant struct Frame *frame, __global const struct Light *lights,
    __global const float *environment_sums, __global const float4 *environment, float4 point, float4 u) {
    struct LightSample sample;
    sample.distance = INFINITY;
    sample.pdf = 0.0f;
    uint index = pick_light(lights, frame->light_count, u.x);
#ifdef ENVIRONMENT
    if (index == frame->light_count) {
        float pdf;
        sample.direction = environment_direction(frame, environment_sums, u.yz, &pdf);
        float2 place = environment_place(frame, sample.direction.xyz);
        float3 radiance = frame->background.xyz * environment_at(frame, environment, place);
        sample.weight = (float4)(radiance / (pdf * frame->environment_pick), 0.0f);
        // As environment_pdf has it, even where rounding moved the direction across the edge of its texel: the
        // weights of both techniques then add up to 1 for every direction.
        sample.pdf = environment_place_pdf(frame, environment_sums, place);
        return sample;
    }
#endif
    float4 position = lights[index].position;
    float4 power = lights[index].power;
    float pick = power.w;
    power.w = 0.0f;
    int kind = (int)position.w;
    if (kind == LIGHT_DIRECTIONAL) {
        position.w = 0.0f;
        sample.direction = -position;
        sample.weight = power / pick;
        return sample;
    }
    float4 to = position - point;
    to.w = 0.0f;
#ifdef RECTANGLES
    if (kind == LIGHT_RECTANGLE) {
        to += (u.y - 0.5f) * lights[index].edge_u + (u.z - 0.5f) * lights[index].edge_v;
        to.w = 0.0f;
    }
#endif
    float distance2 = dot(to, to);
    float facing = 1.0f / distance2; // of a rectangle: the solid angle it would have if all of it were this near
    sample.distance = sqrt(distance2);
    sample.direction = to / sample.distance;
#ifdef RECTANGLES
    if (kind == LIGHT_RECTANGLE) {
        facing *= -lights[index].edge_v.w * dot(lights[index].normal, sample.direction);
        sample.pdf = min(pick / facing, PDF_MAX);
    }
#endif
    sample.weight = power * (facing / pick);
    if (!(distance2 > LIGHT_NEAREST2 && facing > 0.0f)) {
        sample.direction = (float4)(0.0f, 1.0f, 0.0f, 0.0f);
        sample.weight = (float4)(0.0f);
        sample.pdf = 0.0f;
    }
    return sample;
}
