// Where paths begin: at the camera, with the stratified numbers of their sample.
#include "render/camera_lanes.cl"
#include "render/paths.cl"

// Starts paths at the camera in the lanes of `begun`.
INLINE void begin_paths(struct PathLanes *path, struct FlightLanes *f, struct RayLanes *ray,
    const struct MediumTables *m, __constant struct Camera *camera, uint sample, Ints begun) {
    // The keys of a sample's Sobol points, the same for all of its paths.
    Words keys[4], more[4], lens[4], turn[4];
    keys[0] = path->pixel;
    keys[1] = more[1] = (Words)(sample);
    keys[2] = more[2] = (Words)(0u);
    keys[3] = (Words)(RNG_STRATA);
    more[0] = path->pixel;
    more[3] = (Words)(RNG_STRATA | 1u << 8);
    uint2 seed = (uint2)(m->frame->seed_low, m->frame->seed_high);
    philox_lanes(keys, seed);
    philox_lanes(more, seed);
    sobol_lanes(path->path, keys, lens);
    sobol_lanes(path->path, more, turn);
    path->strata[0] = PICK(path->strata[0], lens[2], begun);
    path->strata[1] = PICK(path->strata[1], lens[3], begun);
    for (int k = 0; k < 4; ++k) {
        path->strata[k + 2] = PICK(path->strata[k + 2], turn[k], begun);
    }
    path->block = PICK(path->block, (Words)(0u), begun);
    path->lookups = PICK(path->lookups, (Words)(0u), begun);
    Words stream[4];
    path_block(path, m, sample, begun, stream);
    path->stream[0] = PICK(path->stream[0], stream[0], begun);
    path->stream[1] = PICK(path->stream[1], stream[1], begun);
#ifdef THIN_LENS
    // The lens takes their dimensions.
    path->strata[0] = PICK(path->strata[0], stream[2], begun);
    path->strata[1] = PICK(path->strata[1], stream[3], begun);
#endif
    Reals half_way = (Reals)(0.5f);
#ifdef FILTER_BOX
    Reals across = uniform_lanes(lens[0]);
    Reals down = uniform_lanes(lens[1]);
#else
    Reals across = half_way;
    Reals down = half_way;
#endif
    struct Points origin, direction;
    Reals from;
    camera_rays(camera, path->pixel, across, down, uniform_lanes(lens[2]), uniform_lanes(lens[3]), &origin, &direction,
        &from);
    path->direction = pick_points(path->direction, direction, begun);
    path->pdf = PICK(path->pdf, (Reals)(-1.0f), begun);
    path->order = PICK(path->order, (Ints)(0), begun);
    path->ray = PICK(path->ray, (Ints)(CAMERA_RAY), begun);
    path->opacity = PICK(path->opacity, (Reals)(0.0f), begun);
    path->eye = PICK(path->eye, from, begun);
    for (int c = 0; c < CHANNELS; ++c) {
        path->light[c] = PICK(path->light[c], (Reals)(channel_of(m->method->control, c)), begun);
        path->throughput[c] = PICK(path->throughput[c], (Reals)(1.0f), begun);
    }
    f->threshold = PICK(f->threshold, (Reals)(m->method->camera_threshold), begun);
    f->scale = PICK(f->scale, (Reals)(m->method->majorant_scale), begun);
    start_rays(f, ray, m, to_grid(m->volume, origin), direction, from, (Reals)(INFINITY), path->strata[0], begun);
}

INLINE struct FlightLanes resting_flights(void) {
    struct FlightLanes f;
    Reals zero = (Reals)(0.0f);
    f.state = (Ints)(RESTING);
    f.bx = f.by = f.bz = (Ints)(0);
    f.t = f.end = f.depth = f.taken = f.distance = f.value = f.row = zero;
    f.majorant = f.scale = f.threshold = (Reals)(1.0f);
    for (int c = 0; c < TRACKED; ++c) {
        f.through[c] = f.share[c] = (Reals)(1.0f);
    }
    f.place = points(zero, zero, zero);
    return f;
}

INLINE struct PathLanes idle_paths(void) {
    struct PathLanes path;
    Reals zero = (Reals)(0.0f);
    path.ray = (Ints)(NO_RAY);
    path.slot = path.order = path.flights = (Ints)(0);
    path.pixel = path.path = path.block = path.lookups = path.stream[0] = path.stream[1] = (Words)(0u);
    path.direction = points((Reals)(1.0f), zero, zero);
    path.vertex = points(zero, zero, zero);
    path.incoming = path.direction;
    path.opacity = path.pdf = path.eye = zero;
    for (int c = 0; c < CHANNELS; ++c) {
        path.throughput[c] = path.light[c] = path.pending[c] = zero;
    }
    for (int k = 0; k < 6; ++k) {
        path.strata[k] = (Words)(0u);
    }
    return path;
}
