// Sweeps of the diffusion solver: each kernel runs over the cells of one colour.
//
// conductance_*: of the face between a cell and the next one along an axis; loss: absorption and boundary; inverse: of
// the diagonal, loss and the six conductances; 0 in the padding.
#include "diffusion/cells.cl"

// Conductances times the neighbours' values.
#define NEIGHBOURS(phi)                                                                     \
    (conductance_x[own] * phi[high] + conductance_x[low] * phi[low]                         \
     + conductance_y[own] * phi[high + row] + conductance_y[low - row] * phi[low - row]     \
     + conductance_z[own] * phi[high + slice] + conductance_z[low - slice] * phi[low - slice])

// What leaves the cell: through faces by differences, so that what is nearly constant cancels exactly.
#define LEAVING(phi)                                                                                        \
    (loss[own] * phi[own]                                                                                   \
     + (conductance_x[own] * (phi[own] - phi[high]) + conductance_x[low] * (phi[own] - phi[low]))           \
     + (conductance_y[own] * (phi[own] - phi[high + row])                                                   \
        + conductance_y[low - row] * (phi[own] - phi[low - row]))                                           \
     + (conductance_z[own] * (phi[own] - phi[high + slice])                                                 \
        + conductance_z[low - slice] * (phi[own] - phi[low - slice])))

// Gauss-Seidel: each cell in balance with its neighbours.
__kernel void diffusion_balance(__global float *phi, __global const float *source,
    __global const float *conductance_x, __global const float *conductance_y, __global const float *conductance_z,
    __global const float *inverse, SHAPE) {
    FIND_CELL
    phi[own] = (source[own] + NEIGHBOURS(phi)) * inverse[own];
}

// The same where all neighbours are 0.
__kernel void diffusion_begin(__global float *phi, __global const float *source, __global const float *inverse,
    SHAPE) {
    FIND_CELL
    phi[own] = source[own] * inverse[own];
}

// Successive over-relaxation.
__kernel void diffusion_overrelax(__global float *phi, __global const float *source,
    __global const float *conductance_x, __global const float *conductance_y, __global const float *conductance_z,
    __global const float *inverse, float omega, SHAPE) {
    FIND_CELL
    float balanced = (source[own] + NEIGHBOURS(phi)) * inverse[own];
    phi[own] += omega * (balanced - phi[own]);
}

// Jacobi: one explicit step of each cell's own largest stable length.
__kernel void diffusion_explicit(__global float *next, __global const float *phi, __global const float *source,
    __global const float *conductance_x, __global const float *conductance_y, __global const float *conductance_z,
    __global const float *inverse, SHAPE) {
    FIND_CELL
    next[own] = (source[own] + NEIGHBOURS(phi)) * inverse[own];
}

// The operator.
__kernel void diffusion_apply(__global float *leaving, __global const float *phi,
    __global const float *conductance_x, __global const float *conductance_y, __global const float *conductance_z,
    __global const float *loss, SHAPE) {
    FIND_CELL
    leaving[own] = LEAVING(phi);
}

// What is missing for balance, in float32: right to the rounding of the largest flux.
__kernel void diffusion_imbalance(__global float *missing, __global const float *phi, __global const float *source,
    __global const float *conductance_x, __global const float *conductance_y, __global const float *conductance_z,
    __global const float *loss, SHAPE) {
    FIND_CELL
    missing[own] = source[own] - LEAVING(phi);
}
