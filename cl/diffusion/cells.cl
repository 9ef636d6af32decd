// Where cells of the diffusion solver's grids and their neighbours are stored; see types/diffusion.cl.
#pragma OPENCL FP_CONTRACT OFF
#include "common/inline.cl"
#include "types/diffusion.cl"

// The element of a cell.
INLINE uint cell_at(__global const struct DiffusionGrid *grid, uint x, uint y, uint z) {
    uint i = x + grid->row * y + grid->slice * z;
    return (i & 1u) * (grid->half_count + 2u * grid->guard) + grid->guard + (i >> 1);
}

// What kernels over all cells of a colour take: a cell's element is `own`, its neighbours' are `high`, `high + row`
// and `high + slice` above and `low`, `low - row` and `low - slice` below, where row and slice are half the strides,
// rounded down.
#define SHAPE uint half_count, uint guard, uint row, uint slice, uint colour
#define FIND_CELL                                                   \
    uint k = (uint)get_global_id(0);                                \
    if (k >= half_count) return;                                    \
    uint own = colour * (half_count + 2u * guard) + guard + k;      \
    uint other = (1u - colour) * (half_count + 2u * guard) + guard; \
    uint high = other + k + colour;                                 \
    uint low = high - 1u;
