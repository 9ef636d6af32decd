// Direct light on diffuse surfaces: irradiance from the lights by shadow rays.
#include "lights/rectangle.cl"
#include "surfaces/intersect.cl"

// What one light would bring to a point, and from where.
struct Arrival {
    float3 irradiance;
    float3 direction; // towards the light
    float distance;
};

// `u`: two uniform numbers, for the place on a rectangle. Rectangles shine on one side.
INLINE struct Arrival light_arrival(__global const struct Light *light, float3 point, float3 normal, float2 u) {
    struct Arrival arrival;
    float4 position = light->position;
    float3 power = light->power.xyz;
    int kind = (int)position.w;
    if (kind == LIGHT_DIRECTIONAL) {
        arrival.direction = -position.xyz;
        arrival.distance = INFINITY;
    } else {
        float3 to = position.xyz - point;
#ifdef RECTANGLES
        if (kind == LIGHT_RECTANGLE) {
            to += (u.x - 0.5f) * light->edge_u.xyz + (u.y - 0.5f) * light->edge_v.xyz;
        }
#endif
        float square = max(dot(to, to), 1e-30f);
        float inverse = rsqrt(square);
        arrival.direction = to * inverse;
        arrival.distance = square * inverse;
        // Lamps may lie on a surface, such as a ceiling: it does not shade them, however slanting the light (to 2 degrees).
        arrival.distance -= 32.0f * SURFACE_MARGIN * (largest_component(position.xyz) + arrival.distance);
        power *= inverse * inverse;
#ifdef RECTANGLES
        if (kind == LIGHT_RECTANGLE) {
            power *= max(-dot(light->normal.xyz, arrival.direction), 0.0f) * light->edge_v.w;
        }
#endif
    }
    arrival.irradiance = max(dot(normal, arrival.direction), 0.0f) * power;
    return arrival;
}

// Irradiance from one light on the side of a surface that `normal` points to.
INLINE float3 direct_irradiance(const struct Surfaces *s, __global const struct Light *light, const struct Hit *hit,
    float3 normal, float2 u) {
    struct Arrival arrival = light_arrival(light, hit->point, normal, u);
    float3 e = arrival.irradiance;
    if (!(e.x + e.y + e.z > 0.0f)) {
        return (float3)(0.0f);
    }
    // The shadow ray starts off the surface, and ends where the light is.
    float3 origin = surface_offset(hit, arrival.direction);
    return surfaces_block(s, origin, arrival.direction, arrival.distance) ? (float3)(0.0f) : e;
}
