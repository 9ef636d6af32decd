// The diffusion solver: every kernel of it.
#include "diffusion/relax.cl"
#include "diffusion/vectors.cl"
#include "diffusion/grids.cl"
