// The light that cameras project, from unscattered and scattered fluence: all of it where the medium scatters into all
// directions alike, else (DIRECTED) what is not unscattered light.
#include "common/inline.cl"

// light: the scattered fluence before.
__kernel void irradiance_combine(__global float4 *light, __global const float4 *direct, __global const float4 *reduced,
    uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) {
        return;
    }
#ifdef DIRECTED
    // Light that was scattered ahead counts as unscattered in the similar medium, not in this one.
    float4 added = max(reduced[i] - direct[i], 0.0f);
#else
    float4 added = direct[i];
#endif
    float4 sum = light[i] + added;
    sum.w = 0.0f;
    light[i] = sum;
}
