// What lies behind the volume: a constant, or a lat-long environment map
// with direction = (sin(theta) cos(phi), cos(theta), sin(theta) sin(phi)), theta = pi v, phi = 2 pi u.
#include "common/inline.cl"
#include "types/frame.cl"

#ifdef ENVIRONMENT
// Where a direction lies on the map: turns from its left edge, half turns from its top. The angle from the pole is
// that of atan2: acos loses it where the cosine is near 1.
INLINE float2 environment_place(__constant struct Frame *frame, float3 direction) {
    float u = atan2(direction.z, direction.x) * (0.5f * M_1_PI_F) - frame->environment_turn;
    float across = sqrt(direction.x * direction.x + direction.z * direction.z);
    return (float2)(u - floor(u), atan2(across, direction.y) * M_1_PI_F);
}

// Bilinear between texel centres; u wraps around, v stops at the poles.
INLINE float3 environment_at(__constant struct Frame *frame, __global const float4 *map, float2 place) {
    int width = (int)frame->environment_width;
    int height = (int)frame->environment_height;
    float x = place.x * (float)width - 0.5f;
    x = x < 0.0f ? x + (float)width : x;
    float y = clamp(place.y * (float)height - 0.5f, 0.0f, (float)(height - 1));
    int x0 = min((int)x, width - 1);
    int y0 = (int)y;
    int x1 = x0 + 1 < width ? x0 + 1 : 0;
    int y1 = min(y0 + 1, height - 1);
    float fx = x - (float)x0;
    float fy = y - (float)y0;
    float3 top = mix(map[y0 * width + x0].xyz, map[y0 * width + x1].xyz, fx);
    float3 bottom = mix(map[y1 * width + x0].xyz, map[y1 * width + x1].xyz, fx);
    return mix(top, bottom, fy);
}

INLINE float3 environment_radiance(__constant struct Frame *frame, __global const float4 *map, float3 direction) {
    return environment_at(frame, map, environment_place(frame, direction));
}
#endif

INLINE float3 background_radiance(__constant struct Frame *frame, __global const float4 *map, float3 direction) {
#ifdef ENVIRONMENT
    return frame->background.xyz * environment_radiance(frame, map, direction);
#else
    return frame->background.xyz;
#endif
}
