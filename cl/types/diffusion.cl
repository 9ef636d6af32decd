// The grid of one level of the diffusion solver.
//
// Cell (x, y, z) is the element i = x + row * y + slice * z of a padded box. Both strides are odd, so the parity of i
// is that of x + y + z: its colour. Fields are stored colour after colour: cell i is element i / 2 of its colour, and
// its six neighbours, all of the other colour, are at fixed distances. `guard` zeros before and after each colour, and
// zeros in the padding, stand for what is outside.
struct DiffusionGrid {
    float4 face;     // conductance of a face per diffusivity (that of the cells next to it), per axis
    float4 open;     // half a cell's resistance to the boundary per 1 / diffusivity, per axis; w: largest diffusivity
    float4 outside;  // resistance of the boundary itself, per axis: negative where nothing leaves
    float4 narrower; // coarse faces over the sum of the fine ones, per axis, at the next coarser level
    float4 last;     // the same, for the last face of the axis
    uint nx;         // cells
    uint ny;
    uint nz;
    uint row;        // distance of cells that are neighbours along y, odd
    uint slice;      // and along z, odd
    uint half_count; // elements per colour
    uint guard;      // zeros before and after each colour
    uint halved;     // bits 0, 1, 2: the next coarser level joins two cells along x, y, z
};
