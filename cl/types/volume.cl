// The voxel grid on the device. Grid coordinates count voxels: voxel i is centred at i + GRID_PAD, so that
// truncation is floor and every access of the trilinear kernel stays inside the padded buffer.
#define GRID_PAD 2

struct Volume {
    float4 scale;        // grid units per local unit, per axis (1 on the axes of smallest spacing)
    int4 dims;           // voxels per axis
    int4 bricks;         // distance in memory between neighbouring bricks along x, y, z; w: log2 of the cells per edge
    int4 brick_counts;   // bricks per axis
    uint row;            // elements per row of the padded buffer
    uint slice;          // elements per slice
    float value_scale;   // raw value -> window value: v = (raw - value_zero) * value_scale, exactly 0 at the
    float value_zero;    // window's low end. Raw values are those of the file; floats are window values already
    int octant;          // number of bricks: the distance between octants in tables of strides
    uint pad_0;
    uint pad_1;
    uint pad_2;
};
