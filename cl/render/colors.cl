// The colours of the medium where paths collide.
#include "render/paths.cl"

// The albedo and the emission at the lanes' collisions.
INLINE void look_up_colors(const struct FlightLanes *f, const struct MediumTables *m, const struct Surroundings *s,
    Ints mask, Reals albedo[CHANNELS], Reals emission[CHANNELS]) {
    for (int c = 0; c < CHANNELS; ++c) {
        albedo[c] = (Reals)(channel_of(m->method->albedo, c));
        emission[c] = (Reals)(0.0f);
    }
#if !defined(CONSTANT_ALBEDO) || defined(EMISSION)
    IntLanes wanted = int_lanes(mask);
    RealLanes value = real_lanes(f->value);
    RealLanes row = real_lanes(f->row);
    RealLanes colors[CHANNELS], glows[CHANNELS];
    for (int c = 0; c < CHANNELS; ++c) {
        colors[c] = real_lanes(albedo[c]);
        glows[c] = real_lanes(emission[c]);
    }
    for (int i = 0; i < WIDTH; ++i) {
        if (!wanted.lane[i]) {
            continue;
        }
        struct TablePlace place = table_place(m->frame, value.lane[i], row.lane[i]);
#ifndef CONSTANT_ALBEDO
        float4 color = table_color(m->frame, s->colors, place);
        for (int c = 0; c < CHANNELS; ++c) {
            colors[c].lane[i] = channel_of(color, c);
        }
#endif
#ifdef EMISSION
        float4 glow = table_color(m->frame, s->emissions, place);
        for (int c = 0; c < CHANNELS; ++c) {
            glows[c].lane[i] = channel_of(glow, c);
        }
#endif
    }
    for (int c = 0; c < CHANNELS; ++c) {
        albedo[c] = colors[c].all;
        emission[c] = glows[c].all;
    }
#endif
}
