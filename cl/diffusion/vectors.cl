// Whole fields of the diffusion solver as vectors: updates and sums. Guards and padding are 0 and stay so.
#include "diffusion/residual.cl"

// phi (two floats) += step * direction; residual -= step * leaving.
__kernel void diffusion_step(__global float *phi, __global float *phi_low, __global float *residual,
    __global const float *direction, __global const float *leaving, float step, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    float high = phi[i];
    float low = phi_low[i];
    add_exactly(&high, &low, step * direction[i]);
    phi[i] = high + low;
    phi_low[i] = low - ((high + low) - high);
    residual[i] -= step * leaving[i];
}

// direction = ahead + turn * direction.
__kernel void diffusion_turn(__global float *direction, __global const float *ahead, float turn, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    direction[i] = ahead[i] + turn * direction[i];
}

// phi (two floats) += correction.
__kernel void diffusion_correct(__global float *phi, __global float *phi_low, __global const float *correction,
    uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    float high = phi[i];
    float low = phi_low[i];
    add_exactly(&high, &low, correction[i]);
    phi[i] = high + low;
    phi_low[i] = low - ((high + low) - high);
}

// phi (two floats) is at least 0.
__kernel void diffusion_clamp(__global float *phi, __global float *phi_low, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count || phi[i] >= 0.0f) return;
    phi[i] = 0.0f;
    phi_low[i] = 0.0f;
}

__kernel void diffusion_multiply(__global float *product, __global const float *a, __global const float *b,
    uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    product[i] = a[i] * b[i];
}

__kernel void diffusion_zero(__global float *field, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    field[i] = 0.0f;
}

INLINE float sum8(float8 v) {
    float4 s = v.lo + v.hi;
    return (s.x + s.y) + (s.z + s.w);
}

// Each work-item's share of the sums of a * b and b * c, in a fixed order; the host adds the shares in double
// precision. `eighths`: fields' elements over 8.
__kernel void diffusion_dots(__global float *shares, __global const float *a, __global const float *b,
    __global const float *c, uint eighths, uint items) {
    uint item = (uint)get_global_id(0);
    if (item >= items) return;
    float8 ab = (float8)(0.0f);
    float8 bc = (float8)(0.0f);
    for (uint i = item; i < eighths; i += items) {
        float8 b_i = vload8(i, b);
        ab += vload8(i, a) * b_i;
        bc += b_i * vload8(i, c);
    }
    shares[item] = sum8(ab);
    shares[items + item] = sum8(bc);
}

// Each work-item's share of the sums of a * a and of a.
__kernel void diffusion_sums(__global float *shares, __global const float *a, uint eighths, uint items) {
    uint item = (uint)get_global_id(0);
    if (item >= items) return;
    float8 squares = (float8)(0.0f);
    float8 sum = (float8)(0.0f);
    for (uint i = item; i < eighths; i += items) {
        float8 a_i = vload8(i, a);
        squares += a_i * a_i;
        sum += a_i;
    }
    shares[item] = sum8(squares);
    shares[items + item] = sum8(sum);
}
