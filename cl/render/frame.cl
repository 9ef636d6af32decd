// Which pixel a work-item renders, and which of its samples.
#include "common/inline.cl"
#include "types/frame.cl"

#define TILE_SHIFT 3 // tiles of 8 x 8 pixels: neighbours share bricks and cache lines

// The pixel of a work-item, or -1 when it lies beyond the image or the launch.
// Consecutive work-items fill one tile, tiles go left to right, then top to bottom.
INLINE int frame_pixel(uint width, uint height, uint first_tile, uint tile_count) {
    size_t item = get_global_id(0);
    size_t local_tile = item >> (2 * TILE_SHIFT);
    if (local_tile >= tile_count) {
        return -1;
    }
    uint tile = first_tile + (uint)local_tile;
    uint tiles_per_row = (width + (1u << TILE_SHIFT) - 1) >> TILE_SHIFT;
    uint in_tile = (uint)item & ((1u << (2 * TILE_SHIFT)) - 1);
    uint x = ((tile % tiles_per_row) << TILE_SHIFT) + (in_tile & ((1u << TILE_SHIFT) - 1));
    uint y = ((tile / tiles_per_row) << TILE_SHIFT) + (in_tile >> TILE_SHIFT);
    return x < width && y < height ? (int)(y * width + x) : -1;
}

// The number in the whole picture of the sample that is number `turn` of this render, which may be a part of it.
INLINE uint frame_sample(__constant struct Frame *frame, uint turn) {
    return frame->sample_first + turn * frame->sample_stride;
}
