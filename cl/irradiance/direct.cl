// The direct light of the cells of a light volume, by null-collision tracking from each cell towards the lights
// (the first step of Lesar, Bohak and Marolt's hybrid diffusion), without bias.
//
// In a pass every cell sends one ray to a randomly chosen light, and one into a random direction where the background
// lights but is not among the lights to choose from. A work-item takes a block of cells on CPUs, one cell on GPUs.
// Random numbers count from (cell, pass), and passes are added in their order: the same bits whatever the launch sizes.
//
// The state of a cell is the running mean over its passes, as sums of two floats: most passes of a cell in thin media are
// alike, and what they would add to a single float rounds to nothing long before the rare others are averaged out.
#include "common/numeric.cl"
#include "irradiance/direct_rays.cl"

// Cells of a work-item.
#ifndef CELLS
#define CELLS 1
#endif

// log2 of the cells of a block.
#define BLOCK_SHIFT 8

// Rays of a cell and pass.
#if defined(SKY) && defined(SAMPLE_LIGHTS)
#define RAYS 2
#else
#define RAYS 1
#endif

// How many lanes must wait for a step, unless no lane can do anything else.
#define WAIT_TENTATIVE (WIDTH / 2)
#define WAIT_ARRIVED (WIDTH / 2)

#define NO_CELL 0xffffffffu

// What a pass brings to the cells of a work-item.
struct Pass {
    float4 fluence[CELLS];
#ifdef REDUCED
    float4 reduced[CELLS];
#endif
#ifdef FLOW
    float4 flow[CELLS];
#endif
#ifdef SPREAD
    float4 moment[CELLS];
#endif
};

// A sum of two floats.
struct TwoFloat4 {
    float4 high;
    float4 low;
};

// The state of the cells: running means over the passes.
struct DirectState {
    __global struct TwoFloat4 *fluence; // rgb; w of the high part: squared deviations, summed, of the groups of passes
    __global float *group;              // the channels' mean after the last whole group
    __global struct TwoFloat4 *reduced;
    __global struct TwoFloat4 *flow;    // vector flux, of the channels' mean
    __global float4 *moment; // (reduced) light of the channels' mean times the place where it is, from -1 to 1 in a cell
};

INLINE float channels_mean(float4 rgb) {
    return (rgb.x + rgb.y + rgb.z) * (1.0f / 3.0f);
}

// The cell `place` of a block, or NO_CELL beyond the grid.
INLINE uint block_cell(const struct DirectScene *s, uint block, uint place) {
    uint sx = s->parameters->block_x;
    uint sy = s->parameters->block_y;
    uint sz = s->parameters->block_z;
    int4 dims = s->grid->dims;
    uint across = ((uint)dims.x + (1u << sx) - 1u) >> sx;
    uint down = ((uint)dims.y + (1u << sy) - 1u) >> sy;
    uint x = (block % across << sx) + (place & ((1u << sx) - 1u));
    uint y = (block / across % down << sy) + (place >> sx & ((1u << sy) - 1u));
    uint z = (block / (across * down) << sz) + (place >> (sx + sy));
    return x < (uint)dims.x && y < (uint)dims.y && z < (uint)dims.z ? (z * (uint)dims.y + y) * (uint)dims.x + x : NO_CELL;
}

// Hands the pass's next rays to the lanes of `free`; returns those that got one.
INLINE Ints assign_rays(struct DirectLanes *d, const uint cells[CELLS], uint *next, Ints free) {
    IntLanes is_free = int_lanes(free);
    IntLanes got = int_lanes((Ints)(0));
    IntLanes slot = int_lanes(d->slot);
    WordLanes cell, kind;
    cell.all = d->cell;
    kind.all = d->kind;
    for (int i = 0; i < WIDTH; ++i) {
        if (!is_free.lane[i]) {
            continue;
        }
        while (*next < RAYS * CELLS && cells[*next % CELLS] == NO_CELL) {
            *next += 1;
        }
        if (*next >= RAYS * CELLS) {
            break;
        }
        got.lane[i] = WIDTH == 1 ? 1 : -1;
        slot.lane[i] = (int)(*next % CELLS);
        cell.lane[i] = cells[*next % CELLS];
#if RAYS == 2
        kind.lane[i] = *next / CELLS;
#elif defined(SKY)
        kind.lane[i] = TO_SKY;
#else
        kind.lane[i] = TO_LIGHT;
#endif
        *next += 1;
    }
    d->slot = slot.all;
    d->cell = cell.all;
    d->kind = kind.all;
    return got.all;
}

INLINE void clear_pass(struct Pass *pass) {
    for (int i = 0; i < CELLS; ++i) {
        pass->fluence[i] = (float4)(0.0f);
#ifdef REDUCED
        pass->reduced[i] = (float4)(0.0f);
#endif
#ifdef FLOW
        pass->flow[i] = (float4)(0.0f);
#endif
#ifdef SPREAD
        pass->moment[i] = (float4)(0.0f);
#endif
    }
}

// Adds what the arrived rays bring to their cells.
INLINE void arrive(struct Pass *pass, struct DirectLanes *d, struct FlightLanes *f, const struct MediumTables *m,
    const struct DirectScene *s) {
    Ints arrived = f->state == ARRIVED;
    wear(d, f, m, s, arrived);
    IntLanes ends = int_lanes(arrived);
    IntLanes slot = int_lanes(d->slot);
    RealLanes light[3];
    for (int c = 0; c < 3; ++c) {
        light[c] = real_lanes(d->weight[c] * through_of(f, c));
    }
#ifdef REDUCED
    RealLanes reduced[3];
    for (int c = 0; c < 3; ++c) {
        reduced[c] = real_lanes(d->weight[c] * d->reduced[REDUCED_TRACKED == 1 ? 0 : c]);
    }
#endif
#ifdef SPREAD
    RealLanes px = real_lanes(d->place.x), py = real_lanes(d->place.y), pz = real_lanes(d->place.z);
#endif
#ifdef FLOW
    RealLanes dx = real_lanes(d->direction.x), dy = real_lanes(d->direction.y), dz = real_lanes(d->direction.z);
#endif
    for (int i = 0; i < WIDTH; ++i) {
        if (!ends.lane[i]) {
            continue;
        }
        int cell = slot.lane[i];
        float4 rgb = (float4)(light[0].lane[i], light[1].lane[i], light[2].lane[i], 0.0f);
        pass->fluence[cell] += rgb;
        float4 scattered = rgb;
#ifdef REDUCED
        scattered = (float4)(reduced[0].lane[i], reduced[1].lane[i], reduced[2].lane[i], 0.0f);
        pass->reduced[cell] += scattered;
#endif
#ifdef SPREAD
        pass->moment[cell] += channels_mean(scattered) * (float4)(px.lane[i], py.lane[i], pz.lane[i], 0.0f);
#endif
#ifdef FLOW
        // Light travels from the light to the cell.
        pass->flow[cell] -= channels_mean(rgb) * (float4)(dx.lane[i], dy.lane[i], dz.lane[i], 0.0f);
#endif
    }
    f->state = PICK(f->state, (Ints)(RESTING), arrived);
}

// Takes one more value, the `share` of all, into a mean over its first three components.
INLINE void average(struct TwoFloat4 *mean, float4 value, float share) {
    float4 change = share * ((value - mean->high) - mean->low);
    change.w = 0.0f;
    two_float_add(&mean->high, &mean->low, change);
}

// Adds pass number `index` to the state of the cells.
INLINE void add_pass(const struct DirectState *state, const struct Pass *pass, const uint cells[CELLS], uint index) {
    float share = 1.0f / (float)(index + 1u);
    bool whole = (index + 1u) % STRATA == 0u;
    float groups = (float)((index + 1u) / STRATA);
    for (int i = 0; i < CELLS; ++i) {
        uint cell = cells[i];
        if (cell == NO_CELL) {
            continue;
        }
        struct TwoFloat4 mean = state->fluence[cell];
        average(&mean, pass->fluence[i], share);
        if (whole) {
            // The last group's own mean m is where the mean of all went, and as far again for each group before:
            // (m - mean before) (m - mean after), as Welford (1962) has it.
            float now = channels_mean(mean.high);
            float moved = now - state->group[cell];
            mean.high.w += moved * moved * groups * (groups - 1.0f);
            state->group[cell] = now;
        }
        state->fluence[cell] = mean;
#ifdef REDUCED
        mean = state->reduced[cell];
        average(&mean, pass->reduced[i], share);
        state->reduced[cell] = mean;
#endif
#ifdef FLOW
        mean = state->flow[cell];
        average(&mean, pass->flow[i], share);
        state->flow[cell] = mean;
#endif
#ifdef SPREAD
        state->moment[cell] += share * (pass->moment[i] - state->moment[cell]);
#endif
    }
}

// Adds passes to the state of the cells. Returns how many it did not come to: some compilers end loops after a number of
// turns.
INLINE uint follow_rays(const struct DirectState *state, struct DirectTally *tally, const struct MediumTables *m,
    const struct DirectScene *s, const uint cells[CELLS], uint first, uint count) {
    struct FlightLanes flight = idle_flights();
    struct RayLanes ray = ray_lanes(m->method, points((Reals)(0.0f), (Reals)(0.0f), (Reals)(0.0f)),
        points((Reals)(1.0f), (Reals)(1.0f), (Reals)(1.0f)));
    struct DirectLanes lanes = idle_rays();
    struct Pass pass;
    clear_pass(&pass);
    uint done = 0;
    uint next = 0;
    while (done < count) {
#ifndef CONSTANT_SIGMA
        travel(&flight, &ray, m);
        Ints worn = (flight.state == TRAVELLING) & (flight.control > WORN_DEPTH);
        if (ANY(worn)) {
            wear_down(&lanes, &flight, m, s, worn);
        }
#endif
        int states = sum_ints(flight.state);
        int arrived = STATE_COUNT(states, ARRIVED);
#ifndef CONSTANT_SIGMA
        int tentative = STATE_COUNT(states, TENTATIVE);
        int travelling = WIDTH - arrived - tentative - STATE_COUNT(states, RESTING);
        if (tentative > 0 && (tentative >= WAIT_TENTATIVE || travelling == 0)) {
            attenuate(&lanes, &flight, &ray, m, s, tally);
            continue;
        }
        if (travelling + tentative > 0 && arrived < max(WAIT_ARRIVED, 1)) {
            continue;
        }
#endif
        if (arrived > 0) {
            arrive(&pass, &lanes, &flight, m, s);
        }
        Ints idle = flight.state == RESTING;
        if (next < RAYS * CELLS && ANY(idle)) {
            Ints begun = assign_rays(&lanes, cells, &next, idle);
            if (ANY(begun)) {
                begin_rays(&lanes, &flight, &ray, m, s, first + done, begun, tally);
            }
        }
        if (!ANY(flight.state != RESTING)) {
            add_pass(state, &pass, cells, first + done);
            clear_pass(&pass);
            done += 1;
            next = 0;
        }
    }
    return count - done;
}

INLINE void count_lookups(__global struct DirectCounts *counts, uint more) {
    // Whoever passes 2^32 carries.
    uint before = atomic_add(&counts->lookups_low, more);
    if (before + more < before) {
        atomic_inc(&counts->lookups_high);
    }
}

// `count_slots`: entries of `counts`.
__kernel void irradiance_direct(__constant struct Frame *frame, __constant struct Volume *volume,
    __constant struct Scattering *method, __global const VOXEL *voxels, __global const BrickBound *bounds,
    __global const float *sigmas, __global const float4 *colors, __global const float4 *emissions,
    __global const struct Light *lights, __global const float *environment_sums, __global const float4 *environment,
    __constant struct LightGrid *grid, __constant struct DirectParameters *parameters,
    __global const float2 *extents, __global struct TwoFloat4 *fluence,
    __global float *group, __global struct TwoFloat4 *reduced, __global struct TwoFloat4 *flow,
    __global float4 *moment, __global struct DirectCounts *counts, uint count_slots, uint first_block, uint block_count, uint first_pass, uint pass_count) {
    size_t item = get_global_id(0);
    size_t block = CELLS == 1 ? item >> BLOCK_SHIFT : item;
    if (block >= block_count) {
        return;
    }
    struct MediumTables m;
    m.frame = frame;
    m.volume = volume;
    m.method = method;
    m.voxels = voxels;
    m.bounds = bounds;
    m.sigmas = sigmas;
    m.over = parameters->over;
    m.under = parameters->under;
    struct DirectScene s;
    s.grid = grid;
    s.parameters = parameters;
    s.extents = extents;
    s.colors = colors;
    s.lights = lights;
    s.environment_sums = environment_sums;
    s.environment = environment;
    struct DirectState state;
    state.fluence = fluence;
    state.group = group;
    state.reduced = reduced;
    state.flow = flow;
    state.moment = moment;

    uint cells[CELLS];
    bool any = false;
    for (int i = 0; i < CELLS; ++i) {
        uint place = CELLS == 1 ? (uint)item & ((1u << BLOCK_SHIFT) - 1u) : (uint)i;
        cells[i] = block_cell(&s, first_block + (uint)block, place);
        any |= cells[i] != NO_CELL;
    }
    if (!any) {
        return;
    }
    struct DirectTally tally;
    tally.lookups = tally.above = 0u;
    uint unfinished = follow_rays(&state, &tally, &m, &s, cells, first_pass, pass_count);
    __global struct DirectCounts *mine = counts + item % count_slots;
    count_lookups(mine, tally.lookups);
    if (tally.above + unfinished > 0u) {
        atomic_add(&mine->above, tally.above);
        atomic_add(&mine->unfinished, unfinished);
    }
}

// The direct light after `passes` of them; `groups`: whole groups, whose spread tells the variance.
__kernel void irradiance_direct_means(__global const struct TwoFloat4 *fluence,
    __global const struct TwoFloat4 *reduced, __global const struct TwoFloat4 *flow, __global const float4 *moment,
    __global const float2 *extents, __global float4 *fluence_out, __global float4 *reduced_out,
    __global float4 *flow_out, __global float4 *extent_out, uint cells, uint passes, uint groups) {
    size_t i = get_global_id(0);
    if (i >= cells) {
        return;
    }
    float4 mean = fluence[i].high;
    float of_group = mean.w / ((float)groups - 1.0f);
    float light = channels_mean(mean);
#ifdef EXACT
    mean.w = 0.0f;
#else
    mean.w = groups < 2u ? INFINITY : of_group * ((float)STRATA / (float)passes);
#endif
    fluence_out[i] = mean;
#ifdef REDUCED
    reduced_out[i] = (float4)(reduced[i].high.xyz, 0.0f);
#endif
#ifdef FLOW
    float4 along = light > 0.0f ? flow[i].high / light : (float4)(0.0f);
    float length2 = dot(along, along);
    flow_out[i] = length2 > 1.0f ? along / sqrt(length2) : along;
#endif
#ifdef SPREAD
    float scattered = light;
#ifdef REDUCED
    scattered = channels_mean(reduced_out[i]);
#endif
    float4 place = scattered > 0.0f ? clamp(moment[i] / scattered, -1.0f, 1.0f) : (float4)(0.0f);
    place.w = extents[i].x;
    extent_out[i] = place;
#endif
}
