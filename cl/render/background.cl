// What lies behind the volume: a constant, or a lat-long environment map
// with direction = (sin(theta) cos(phi), cos(theta), sin(theta) sin(phi)), theta = pi v, phi = 2 pi u.
#include "common/inline.cl"
#include "types/frame.cl"

#ifdef ENVIRONMENT
// Bilinear between texel centres; u wraps around, v stops at the poles.
INLINE float3 environment_radiance(__constant struct Frame *frame, __global const float4 *map, float3 direction) {
    float u = atan2(direction.z, direction.x) * (0.5f * M_1_PI_F) - frame->environment_turn;
    u -= floor(u);
    float v = acos(clamp(direction.y, -1.0f, 1.0f)) * M_1_PI_F;
    int width = (int)frame->environment_width;
    int height = (int)frame->environment_height;
    float x = u * (float)width + (float)width - 0.5f;
    float y = clamp(v * (float)height - 0.5f, 0.0f, (float)(height - 1));
    int x0 = (int)x;
    int y0 = (int)y;
    int y1 = min(y0 + 1, height - 1);
    float fx = x - (float)x0;
    float fy = y - (float)y0;
    int x1 = (x0 + 1) % width;
    x0 %= width;
    float3 top = mix(map[y0 * width + x0].xyz, map[y0 * width + x1].xyz, fx);
    float3 bottom = mix(map[y1 * width + x0].xyz, map[y1 * width + x1].xyz, fx);
    return mix(top, bottom, fy);
}
#endif

INLINE float3 background_radiance(__constant struct Frame *frame, __global const float4 *map, float3 direction) {
#ifdef ENVIRONMENT
    return frame->background.xyz * environment_radiance(frame, map, direction);
#else
    return frame->background.xyz;
#endif
}
