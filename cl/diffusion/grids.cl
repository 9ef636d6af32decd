// Between what the caller has (plain boxes, x fastest) and the fields of the diffusion solver, and between levels.
#include "diffusion/cells.cl"

// Conductance between the centres of two cells: resistances in series.
INLINE float face(float factor, float a, float b) {
    return factor * (2.0f * a * b / (a + b));
}

// Loss through one side of a cell at the boundary.
INLINE float escape(bool at_boundary, float open, float outside, float diffusivity) {
    return at_boundary && outside >= 0.0f ? 1.0f / (outside + open / diffusivity) : 0.0f;
}

// The finest level's coefficients from diffusivity and absorption (times `absorption_scale`).
__kernel void diffusion_assemble(__global const struct DiffusionGrid *grid, __global const float *diffusivity,
    __global const float *absorption, __global float *conductance_x, __global float *conductance_y,
    __global float *conductance_z, __global float *loss, float absorption_scale) {
    uint x = (uint)get_global_id(0);
    uint y = (uint)get_global_id(1);
    uint z = (uint)get_global_id(2);
    uint nx = grid->nx, ny = grid->ny, nz = grid->nz;
    if (x >= nx || y >= ny || z >= nz) return;
    uint i = x + nx * (y + ny * z);
    float limit = grid->open.w;
    float d = fmin(diffusivity[i], limit);
    uint own = cell_at(grid, x, y, z);
    conductance_x[own] = x + 1u < nx ? face(grid->face.x, d, fmin(diffusivity[i + 1u], limit)) : 0.0f;
    conductance_y[own] = y + 1u < ny ? face(grid->face.y, d, fmin(diffusivity[i + nx], limit)) : 0.0f;
    conductance_z[own] = z + 1u < nz ? face(grid->face.z, d, fmin(diffusivity[i + nx * ny], limit)) : 0.0f;
    float lost = absorption_scale * absorption[i];
    lost += escape(x == 0u, grid->open.x, grid->outside.x, d) + escape(x + 1u == nx, grid->open.x, grid->outside.x, d);
    lost += escape(y == 0u, grid->open.y, grid->outside.y, d) + escape(y + 1u == ny, grid->open.y, grid->outside.y, d);
    lost += escape(z == 0u, grid->open.z, grid->outside.z, d) + escape(z + 1u == nz, grid->open.z, grid->outside.z, d);
    loss[own] = lost;
}

// The diagonal's inverse. Runs over cells, not colours: the padding keeps 0.
__kernel void diffusion_invert(__global const struct DiffusionGrid *grid, __global const float *conductance_x,
    __global const float *conductance_y, __global const float *conductance_z, __global const float *loss,
    __global float *inverse) {
    uint x = (uint)get_global_id(0);
    uint y = (uint)get_global_id(1);
    uint z = (uint)get_global_id(2);
    if (x >= grid->nx || y >= grid->ny || z >= grid->nz) return;
    uint own = cell_at(grid, x, y, z);
    float sum = loss[own] + conductance_x[own] + conductance_y[own] + conductance_z[own];
    sum += x > 0u ? conductance_x[cell_at(grid, x - 1u, y, z)] : 0.0f;
    sum += y > 0u ? conductance_y[cell_at(grid, x, y - 1u, z)] : 0.0f;
    sum += z > 0u ? conductance_z[cell_at(grid, x, y, z - 1u)] : 0.0f;
    inverse[own] = sum > 0.0f ? 1.0f / sum : 0.0f;
}

// The cells of the finer level that a coarse cell joins: first, and one behind the last, along one axis.
INLINE uint2 joined(uint coarse, uint count, bool halved) {
    return halved ? (uint2)(2u * coarse, min(2u * coarse + 2u, count)) : (uint2)(coarse, coarse + 1u);
}

#define JOINED_CELLS                                                   \
    uint x = (uint)get_global_id(0);                                   \
    uint y = (uint)get_global_id(1);                                   \
    uint z = (uint)get_global_id(2);                                   \
    if (x >= coarse->nx || y >= coarse->ny || z >= coarse->nz) return; \
    uint own = cell_at(coarse, x, y, z);                               \
    uint2 xs = joined(x, fine->nx, fine->halved & 1u);                 \
    uint2 ys = joined(y, fine->ny, fine->halved & 2u);                 \
    uint2 zs = joined(z, fine->nz, fine->halved & 4u);

// A coarse level's coefficients: sums over the cells joined and over their outer faces. Those are divided by how much
// farther apart the centres are (Galerkin's sums for piecewise constant corrections are too stiff by that).
__kernel void diffusion_coarsen(__global const struct DiffusionGrid *fine, __global const struct DiffusionGrid *coarse,
    __global const float *fine_x, __global const float *fine_y, __global const float *fine_z,
    __global const float *fine_loss, __global float *coarse_x, __global float *coarse_y, __global float *coarse_z,
    __global float *coarse_loss) {
    JOINED_CELLS
    float4 sum = (float4)(0.0f);
    for (uint k = zs.x; k < zs.y; ++k) {
        for (uint j = ys.x; j < ys.y; ++j) {
            for (uint i = xs.x; i < xs.y; ++i) {
                uint cell = cell_at(fine, i, j, k);
                sum.x += i + 1u == xs.y ? fine_x[cell] : 0.0f;
                sum.y += j + 1u == ys.y ? fine_y[cell] : 0.0f;
                sum.z += k + 1u == zs.y ? fine_z[cell] : 0.0f;
                sum.w += fine_loss[cell];
            }
        }
    }
    coarse_x[own] = sum.x * (x + 2u == coarse->nx ? fine->last.x : fine->narrower.x);
    coarse_y[own] = sum.y * (y + 2u == coarse->ny ? fine->last.y : fine->narrower.y);
    coarse_z[own] = sum.z * (z + 2u == coarse->nz ? fine->last.z : fine->narrower.z);
    coarse_loss[own] = sum.w;
}

// The residual of the cells of colour 0 (the others have none) summed over the cells joined.
__kernel void diffusion_restrict(__global const struct DiffusionGrid *fine, __global const struct DiffusionGrid *coarse,
    __global const float *residual, __global float *source) {
    JOINED_CELLS
    float sum = 0.0f;
    for (uint k = zs.x; k < zs.y; ++k) {
        for (uint j = ys.x; j < ys.y; ++j) {
            uint odd = (j + k) & 1u;
            for (uint i = xs.x + ((xs.x + odd) & 1u); i < xs.y; i += 2u) {
                sum += residual[cell_at(fine, i, j, k)];
            }
        }
    }
    source[own] = sum;
}

// The coarse correction added to the cells of colour 0 (the others are swept next).
__kernel void diffusion_prolong(__global const struct DiffusionGrid *fine, __global const struct DiffusionGrid *coarse,
    __global const float *correction, __global float *phi) {
    JOINED_CELLS
    float value = correction[own];
    for (uint k = zs.x; k < zs.y; ++k) {
        for (uint j = ys.x; j < ys.y; ++j) {
            uint odd = (j + k) & 1u;
            for (uint i = xs.x + ((xs.x + odd) & 1u); i < xs.y; i += 2u) {
                phi[cell_at(fine, i, j, k)] += value;
            }
        }
    }
}

// The coarsest level, solved exactly: its inverse times the source. `order` cells; `cells`: their elements.
__kernel void diffusion_coarsest(__global float *phi, __global const float *source, __global const float *inverse,
    __global const uint *cells, uint order) {
    uint i = (uint)get_global_id(0);
    if (i >= order) return;
    float sum = 0.0f;
    for (uint j = 0; j < order; ++j) {
        sum += inverse[j * order + i] * source[cells[j]];
    }
    phi[cells[i]] = sum;
}

// A box of the caller's as a field, times `scale`.
__kernel void diffusion_load(__global const struct DiffusionGrid *grid, __global const float *box,
    __global float *field, float scale) {
    uint x = (uint)get_global_id(0);
    uint y = (uint)get_global_id(1);
    uint z = (uint)get_global_id(2);
    if (x >= grid->nx || y >= grid->ny || z >= grid->nz) return;
    field[cell_at(grid, x, y, z)] = scale * box[x + grid->nx * (y + grid->ny * z)];
}

// A field as a box for the caller, times `scale`.
__kernel void diffusion_store(__global const struct DiffusionGrid *grid, __global const float *field,
    __global float *box, float scale) {
    uint x = (uint)get_global_id(0);
    uint y = (uint)get_global_id(1);
    uint z = (uint)get_global_id(2);
    if (x >= grid->nx || y >= grid->ny || z >= grid->nz) return;
    box[x + grid->nx * (y + grid->ny * z)] = scale * field[cell_at(grid, x, y, z)];
}

// What a box holds, as each work-item's share: the largest value, how many are below 0 or not a number, how many are
// 0, and how many are above `limit`. Not a number is found by bits: compilers may assume it away.
__kernel void diffusion_inspect(__global const float *box, __global uint *shares, float limit, uint count,
    uint items) {
    uint item = (uint)get_global_id(0);
    if (item >= items) return;
    float largest = 0.0f;
    uint wrong = 0u;
    uint zero = 0u;
    uint above = 0u;
    for (uint i = item; i < count; i += items) {
        uint bits = as_uint(box[i]);
        if ((bits & 0x7fffffffu) == 0u) {
            zero += 1u;
        } else if (bits > 0x7f800000u) {
            wrong += 1u;
        } else {
            above += box[i] > limit;
            largest = fmax(largest, box[i]);
        }
    }
    shares[item] = as_uint(largest);
    shares[items + item] = wrong;
    shares[2u * items + item] = zero;
    shares[3u * items + item] = above;
}
