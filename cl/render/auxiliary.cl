// Auxiliary images: what camera rays meet first, for denoisers.
//
// Means are float32 and take one sample at a time. Beyond some 10^7 samples of a pixel they hardly change any more.
#include "render/paths.cl"

#ifdef AUXILIARY
INLINE struct Auxiliary no_notes(void) {
    struct Auxiliary notes;
    notes.albedo = notes.normal = (float4)(0.0f);
    notes.transmittance = notes.taken = notes.depth = 0.0f;
    notes.pad_0 = 0u;
    return notes;
}

// Adds what the camera rays of `mask`, which have ended, met to the sums of their pixels. `albedo`: at their collisions.
INLINE void note_first_collisions(struct Auxiliary *notes, const struct PathLanes *path, const struct FlightLanes *f,
    const struct MediumTables *m, const Reals albedo[CHANNELS], Ints mask) {
    Reals left = (Reals)(0.0f);
    for (int c = 0; c < TRACKED; ++c) {
        left += f->through[c] * (1.0f / TRACKED);
    }
    RealLanes color[CHANNELS];
    for (int c = 0; c < CHANNELS; ++c) {
        color[c] = real_lanes(albedo[c] * collided_of(f, c));
    }
    IntLanes noted = int_lanes(mask);
    IntLanes slot = int_lanes(path->slot);
    RealLanes through = real_lanes(left);
    RealLanes taken = real_lanes(f->taken);
    RealLanes distance = real_lanes(f->distance - path->eye);
    RealLanes x = real_lanes(f->place.x), y = real_lanes(f->place.y), z = real_lanes(f->place.z);
    for (int i = 0; i < WIDTH; ++i) {
        if (!noted.lane[i]) {
            continue;
        }
        struct Auxiliary *note = notes + slot.lane[i];
        note->transmittance += through.lane[i];
        if (!(taken.lane[i] > 0.0f)) {
            continue;
        }
        note->taken += taken.lane[i];
        note->depth += taken.lane[i] * distance.lane[i];
        note->albedo += (float4)(color[0].lane[i], color[CHANNELS / 2].lane[i], color[CHANNELS - 1].lane[i], 0.0f);
        float3 gradient = gradient_raw(m->volume, m->voxels, (float4)(x.lane[i], y.lane[i], z.lane[i], 0.0f));
        // Of the value in the window; what is small enough to vanish squared counts as flat.
        gradient *= m->volume->value_scale;
        float length2 = dot(gradient, gradient);
        if (length2 > 0.0f) {
            note->normal -= (float4)(gradient, 0.0f) * (taken.lane[i] * rsqrt(length2));
        }
    }
}

// Takes a sample into a pixel's means: `sums` times `share`, as sample number `count`.
INLINE void add_notes(__global struct Auxiliary *pixel, const struct Auxiliary *sums, float share, uint count) {
    struct Auxiliary mean = *pixel;
    float part = 1.0f / (float)count;
    mean.albedo += (share * sums->albedo - mean.albedo) * part;
    mean.normal += (share * sums->normal - mean.normal) * part;
    mean.transmittance += (share * sums->transmittance - mean.transmittance) * part;
    mean.taken += (share * sums->taken - mean.taken) * part;
    mean.depth += (share * sums->depth - mean.depth) * part;
    *pixel = mean;
}

#endif
