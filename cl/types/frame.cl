// What does not change between the launches of one render.
struct Frame {
    float4 background;      // radiance behind everything, or the factor of the environment map
    uint seed_low;
    uint seed_high;
    uint environment_width; // texels
    uint environment_height;
    float environment_turn; // rotation about +y, in turns
    uint light_count;
    uint table_size;        // entries of the transfer function's table
    uint table_rows;        // rows of a 2-D table (gradient magnitude), 1 otherwise
    float gradient_scale;   // gradient of the value (in entries) per local unit -> row of the table
    uint rectangle_count;   // the first lights are rectangles
    float environment_pick; // probability with which light_sample picks the environment map; 0 = never
    uint sample_first;      // number of the render's first sample: 0 but for parts of pictures
    uint sample_stride;     // ... and from each to the next: 1
    uint pad_0;
    uint pad_1;
    uint pad_2;
};
