// The grid of a light volume: the volume's box in equal cells. Boxes of numbers per cell have x fastest.
struct LightGrid {
    float4 cell; // size of a cell per axis, local units; w = 0
    int4 dims;   // cells per axis; w = 0
};
