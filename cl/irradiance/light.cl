// What a light volume sends towards the eye.
//
// `light` holds the fluence of all light, for media that scatter into all directions alike. With DIRECTED, of what was scattered more than once, while unscattered light is apart with its directions.
#include "common/phase.cl"
#include "irradiance/grid.cl"
#include "types/method.cl"
#include "volume/grid.cl"

struct Lit {
    __constant struct LightGrid *grid;
    __constant struct Volume *volume;
    __global const float4 *light;
#ifdef DIRECTED
    __constant struct EmissionAbsorption *method;
    __global const float4 *drift;  // its flux over its fluence
    __global const float4 *direct; // fluence of unscattered light
    __global const float4 *flow;   // its flux over its fluence
    float4 towards;                // the direction of propagation towards the eye
#endif
};

// A place among the centres of cells.
struct LightPlace {
    uint index[8];
    float weight[8];
};

// Per axis the lower of two neighbours, the distance to the other in memory, and its weight.
INLINE float light_axis(float x, int count, int *low, int *step) {
    float position = clamp(x - 0.5f, 0.0f, (float)(count - 1));
    *low = min((int)position, max(count - 2, 0));
    *step = count > 1 ? 1 : 0;
    return position - (float)*low;
}

INLINE struct LightPlace light_place(struct Lit lit, float4 point) {
    float4 place = (point - GRID_LOW) / (lit.volume->scale * lit.grid->cell);
    int x, y, z, dx, dy, dz;
    float u = light_axis(place.x, lit.grid->dims.x, &x, &dx);
    float v = light_axis(place.y, lit.grid->dims.y, &y, &dy);
    float w = light_axis(place.z, lit.grid->dims.z, &z, &dz);
    uint row = (uint)lit.grid->dims.x;
    uint slice = row * (uint)lit.grid->dims.y;
    uint first = (uint)x + row * (uint)y + slice * (uint)z;
    struct LightPlace found;
    for (uint i = 0; i < 8u; ++i) {
        bool bx = i & 1u, by = i & 2u, bz = i & 4u;
        found.index[i] = first + (bx ? (uint)dx : 0u) + (by ? row * (uint)dy : 0u) + (bz ? slice * (uint)dz : 0u);
        found.weight[i] = (bx ? u : 1.0f - u) * (by ? v : 1.0f - v) * (bz ? w : 1.0f - w);
    }
    return found;
}

INLINE float4 light_between(__global const float4 *box, const struct LightPlace *place) {
    float4 sum = place->weight[0] * box[place->index[0]];
    for (int i = 1; i < 8; ++i) {
        sum += place->weight[i] * box[place->index[i]];
    }
    return sum;
}

#ifdef DIRECTED
INLINE float flow_phase(__constant struct EmissionAbsorption *method, float4 from, float4 to) {
    struct Phase p;
    p.g0 = method->phase.x;
    p.g1 = method->phase.y;
    p.weight = method->phase.z;
    p.pad = 0.0f;
    float4 minus = from - to;
    float4 plus = from + to;
    RealLanes phase = real_lanes(phase_at(p, cosines((Reals)(0.5f * dot(minus, minus)), (Reals)(0.5f * dot(plus, plus)))));
    return phase.lane[0];
}
#endif

// Radiance scattered towards the eye at a point (grid coordinates), per sigma_s; w = 0.
INLINE float4 light_towards_eye(struct Lit lit, float4 point) {
    struct LightPlace place = light_place(lit, point);
    float4 light = INV_4PI * light_between(lit.light, &place);
#ifdef DIRECTED
    // First order in the direction; where that is negative, nothing.
    float4 drift = light_between(lit.drift, &place);
    drift.w = 0.0f;
    light *= max(1.0f + 3.0f * lit.method->phase.w * dot(drift, lit.towards), 0.0f);
    // A share of the unscattered light goes along one direction, the rest along all alike: as it is, for one light.
    float4 flow = light_between(lit.flow, &place);
    flow.w = 0.0f;
    float share = min(sqrt(dot(flow, flow)), 1.0f);
    float phase = (1.0f - share) * INV_4PI;
    if (share > 0.0f) {
        phase += share * flow_phase(lit.method, flow / sqrt(dot(flow, flow)), lit.towards);
    }
    light += phase * light_between(lit.direct, &place);
#endif
    light.w = 0.0f;
    return light;
}
