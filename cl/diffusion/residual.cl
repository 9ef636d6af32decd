// The true residual of a solution that is a sum of two floats: right to about 2^-45 of the largest flux, so that a
// float32 solver can be driven to any residual that is asked for, and what is reported is not its own estimate.
#include "diffusion/cells.cl"

// (*high, *low) += x exactly but for the rounding of *low (Knuth's TwoSum).
INLINE void add_exactly(float *high, float *low, float x) {
    float sum = *high + x;
    float part = sum - *high;
    *low += (*high - (sum - part)) + (x - part);
    *high = sum;
}

// (*high, *low) -= factor * (x, x_low).
INLINE void subtract_product(float *high, float *low, float factor, float x, float x_low) {
    float product = factor * x;
    float rest = fma(factor, x, -product) + factor * x_low;
    add_exactly(high, low, -product);
    *low -= rest;
}

// Subtracts the flux through one face.
INLINE void subtract_flux(float *high, float *low, float conductance, float here, float here_low, float there,
    float there_low) {
    float difference = here;
    float rest = here_low - there_low;
    add_exactly(&difference, &rest, -there);
    subtract_product(high, low, conductance, difference, rest);
}

#define FLUX(conductance, at, neighbour) \
    subtract_flux(&sum, &rest, conductance[at], here, here_low, phi[neighbour], phi_low[neighbour])

__kernel void diffusion_residual(__global float *residual, __global const float *phi, __global const float *phi_low,
    __global const float *source, __global const float *conductance_x, __global const float *conductance_y,
    __global const float *conductance_z, __global const float *loss, SHAPE) {
    FIND_CELL
    float here = phi[own];
    float here_low = phi_low[own];
    float sum = source[own];
    float rest = 0.0f;
    subtract_product(&sum, &rest, loss[own], here, here_low);
    FLUX(conductance_x, own, high);
    FLUX(conductance_x, low, low);
    FLUX(conductance_y, own, high + row);
    FLUX(conductance_y, low - row, low - row);
    FLUX(conductance_z, own, high + slice);
    FLUX(conductance_z, low - slice, low - slice);
    residual[own] = sum + rest;
}
