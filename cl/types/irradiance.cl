// The grid of a light volume: the volume's box in equal cells. Boxes of numbers per cell have x fastest.
struct LightGrid {
    float4 cell; // size of a cell per axis, local units; w = 0
    int4 dims;   // cells per axis; w = 0
};

// How the direct light of cells is computed.
struct DirectParameters {
    float4 control;    // extinction per channel relative to sigma_t that is known without look-ups, of light that is
                       // attenuated by sigma_a + (1 - g) sigma_s (REDUCED)
    float mean_cosine; // g
    float over;        // tentative collisions come at the rate over * majorant - under * minorant
    float under;
    uint block_x;      // log2 of the cells per axis of a block of cells
    uint block_y;
    uint block_z;
    uint pad_0;
    uint pad_1;
};

// Counters that work-items share; 64 bits, low and high.
struct DirectCounts {
    uint lookups_low;
    uint lookups_high;
    uint above;      // look-ups outside the bounds of their bricks: must stay 0
    uint unfinished; // passes that the device did not follow to their ends: must stay 0
};
