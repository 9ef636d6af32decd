// Single and multiple scattering in volumes, by null-collision tracking: the radiative transfer equation without bias.
//
// A work-item follows the paths of one sample of its pixels (a tile on CPUs, one pixel on GPUs), WIDTH of them side by
// side. A path that ends makes room for the next, so lanes stay busy however long paths are. Rays move in three steps,
// each taken when enough lanes wait for it: travel to the next tentative collision, look the medium up there, and at
// the end of the ray turn to what comes next.
//
// Random numbers count from (pixel, sample, path), lights are summed per pixel in a fixed order: the same bits
// whatever the launch sizes.
//
// Light is counted from a constant radiance, the background's mean: a path starts with it, every collision takes away
// what it absorbs of it, (1 - albedo), and an escaping ray brings what the background differs by. The transport equation
// is linear, so the mean is the same, but a constant background takes no noise at all: a furnace is white in every
// sample, and paths may end early where little more can change.
#include "film/accumulate.cl"
#include "render/begin.cl"
#include "render/events.cl"
#include "render/frame.cl"
#include "render/ledger.cl"

// Pixels of a work-item.
#ifndef PIXELS
#define PIXELS 1
#endif

// How many lanes must wait for a step, unless no lane can do anything else.
#define WAIT_TENTATIVE (WIDTH / 2)
#define WAIT_ARRIVED (WIDTH / 2)

// The pixel `in_tile` of a tile, or -1 beyond the image.
INLINE int tile_pixel(uint width, uint height, uint tile, uint in_tile) {
    uint tiles_per_row = (width + (1u << TILE_SHIFT) - 1) >> TILE_SHIFT;
    uint x = ((tile % tiles_per_row) << TILE_SHIFT) + (in_tile & ((1u << TILE_SHIFT) - 1));
    uint y = ((tile / tiles_per_row) << TILE_SHIFT) + (in_tile >> TILE_SHIFT);
    return x < width && y < height ? (int)(y * width + x) : -1;
}

// Hands the next paths of the sample to the lanes of `free`; returns those that got one.
INLINE Ints assign_paths(struct PathLanes *path, const int pixels[PIXELS], uint paths, uint *next, Ints free) {
    IntLanes is_free = int_lanes(free);
    IntLanes got = int_lanes((Ints)(0));
    IntLanes slot = int_lanes(path->slot);
    WordLanes pixel, number;
    pixel.all = path->pixel;
    number.all = path->path;
    for (int i = 0; i < WIDTH; ++i) {
        if (!is_free.lane[i]) {
            continue;
        }
        while (*next < paths * PIXELS && pixels[*next % PIXELS] < 0) {
            *next += 1;
        }
        if (*next >= paths * PIXELS) {
            break;
        }
        got.lane[i] = WIDTH == 1 ? 1 : -1;
        slot.lane[i] = (int)(*next % PIXELS);
        pixel.lane[i] = (uint)pixels[*next % PIXELS];
        number.lane[i] = *next / PIXELS;
        *next += 1;
    }
    path->slot = slot.all;
    path->pixel = pixel.all;
    path->path = number.all;
    return got.all;
}

// What a sample brings to the pixels of a work-item.
struct Sample {
    float4 sums[PIXELS]; // radiance and opacity, over the sample's paths
#ifdef AUXILIARY
    struct Auxiliary notes[PIXELS];
#endif
};

INLINE void clear_sample(struct Sample *sums) {
    for (int i = 0; i < PIXELS; ++i) {
        sums->sums[i] = (float4)(0.0f);
#ifdef AUXILIARY
        sums->notes[i] = no_notes();
#endif
    }
}

// Follows the paths of a sample to their ends. Returns whether some are unfinished: some compilers end loops after a
// number of turns.
INLINE bool follow_paths(struct Sample *sums, struct Tally *tally, const struct MediumTables *m,
    const struct Surroundings *s, __constant struct Camera *camera, const int pixels[PIXELS], uint sample) {
    struct FlightLanes flight = resting_flights();
    struct RayLanes ray = ray_lanes(m->method, points((Reals)(0.0f), (Reals)(0.0f), (Reals)(0.0f)),
        points((Reals)(1.0f), (Reals)(1.0f), (Reals)(1.0f)));
    struct PathLanes path = idle_paths();
    uint paths = m->method->paths;
    uint next = 0;
    for (;;) {
#ifndef CLOSED_FORM
        travel(&flight, &ray, m);
#endif
        int states = sum_ints(flight.state);
        int arrived = STATE_COUNT(states, ARRIVED);
#ifndef CLOSED_FORM
        int tentative = STATE_COUNT(states, TENTATIVE);
        int travelling = WIDTH - arrived - tentative - STATE_COUNT(states, RESTING);
        if (tentative > 0 && (tentative >= WAIT_TENTATIVE || travelling == 0)) {
            look_up(&path, &flight, &ray, m, tally);
            continue;
        }
        if (travelling + tentative > 0 && arrived < max(WAIT_ARRIVED, 1)) {
            continue;
        }
#endif
        if (arrived > 0) {
            Ints ended = take_turns(&path, &flight, &ray, m, s, tally, sample);
            if (ANY(ended)) {
                add_up(sums->sums, &path, ended);
            }
        }
        Ints idle = flight.state == RESTING;
        if (ANY(idle) && next < paths * PIXELS) {
            Ints begun = assign_paths(&path, pixels, paths, &next, idle);
            begin_paths(&path, &flight, &ray, m, camera, sample, begun);
        }
        if (!ANY(flight.state != RESTING)) {
            break;
        }
    }
    return ANY(flight.state != RESTING);
}

// What `follow_paths` would find where no camera ray meets more than a constant background.
INLINE void pass_by(struct Sample *sums, struct Tally *tally, const struct MediumTables *m, int pixels) {
    float paths = (float)m->method->paths;
    for (int i = 0; i < PIXELS; ++i) {
        sums->sums[i] = paths * (float4)(m->frame->background.xyz, 0.0f);
#ifdef AUXILIARY
        sums->notes[i].transmittance = paths;
#endif
    }
    RealLanes escaped = real_lanes(tally->escaped);
    escaped.lane[0] = paths * (float)pixels;
    tally->escaped = escaped.all;
}

// Adds a sample to the film: `share` times the sums.
INLINE void add_sample(__global struct FilmPixel *film, __global struct Auxiliary *auxiliary, const int pixels[PIXELS],
    const struct Sample *sums, float share) {
    for (int i = 0; i < PIXELS; ++i) {
        if (pixels[i] < 0) {
            continue;
        }
        struct FilmPixel pixel = film[pixels[i]];
#ifdef AUXILIARY
        uint count = pixel.count;
#endif
        film_add(&pixel, share * sums->sums[i], -1.0f, 0u);
#ifdef AUXILIARY
        if (pixel.count > count) {
            add_notes(auxiliary + pixels[i], sums->notes + i, share, pixel.count);
        }
#endif
        film[pixels[i]] = pixel;
    }
}

__kernel void render_scattering(__constant struct Frame *frame, __constant struct Camera *camera,
    __constant struct Volume *volume, __constant struct Scattering *method, __global const VOXEL *voxels,
    __global const BrickBound *bounds, __global const float *sigmas, __global const float4 *colors,
    __global const float4 *emissions, __global const struct Light *lights, __global const float *environment_sums,
    __global const uchar *tile_sees, __global const float4 *environment, __global struct FilmPixel *film,
    __global struct Ledger *ledgers, __global struct Auxiliary *auxiliary, uint first_tile, uint tile_count, uint first_sample, uint sample_count) {
    size_t item = get_global_id(0);
    size_t local_tile = PIXELS == 1 ? item >> (2 * TILE_SHIFT) : item;
    if (local_tile >= tile_count) {
        return;
    }
    uint tile = first_tile + (uint)local_tile;
    struct MediumTables m;
    m.frame = frame;
    m.volume = volume;
    m.method = method;
    m.voxels = voxels;
    m.bounds = bounds;
    m.sigmas = sigmas;
    struct Surroundings s;
    s.colors = colors;
    s.emissions = emissions;
    s.lights = lights;
    s.environment_sums = environment_sums;
    s.environment = environment;

    int pixels[PIXELS];
    int inside = 0;
    for (int i = 0; i < PIXELS; ++i) {
        pixels[i] = tile_pixel(camera->width, camera->height, tile, PIXELS == 1 ? (uint)item & 63u : (uint)i);
        inside += pixels[i] >= 0;
    }
    if (inside == 0) {
        return;
    }
    size_t account = PIXELS == 1 ? ((size_t)tile << (2 * TILE_SHIFT)) + (item & 63u) : tile;
    bool sees = tile_sees[tile];
    struct Sample sums;
    for (uint turn = first_sample; turn < first_sample + sample_count; ++turn) {
        uint sample = frame_sample(frame, turn);
        struct Tally tally = empty_tally();
#ifdef AUXILIARY
        tally.notes = sums.notes;
#endif
        bool unfinished = false;
        clear_sample(&sums);
        if (sees) {
            unfinished = follow_paths(&sums, &tally, &m, &s, camera, pixels, sample);
        } else {
            pass_by(&sums, &tally, &m, inside);
        }
        settle_accounts(ledgers + account, &tally, method->paths * (uint)inside, unfinished);
        add_sample(film, auxiliary, pixels, &sums, unfinished ? NAN : 1.0f / (float)method->paths);
    }
}
