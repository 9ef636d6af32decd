// Metaballs as rays meet them: the field F = sum of w (1 - s^2)^2 over balls with s < 1, less a threshold.
//
// Along a ray, s^2 of a ball is quadratic, so between the places where rays enter and leave balls F is one quartic. Its
// first crossing is isolated by its Bernstein coefficients: where none of them differs in sign from the start, there is
// none; otherwise the stretch is halved. No list of balls is kept, so there may be any number of them.
#include "common/inline.cl"
#include "types/surface.cl"

// Halvings of a stretch: two crossings closer than its length / 4096 are taken for none. The field between them is
// within rounding of the threshold.
#define METABALLS_DEPTH 12

// A ball along a ray: 1 - s^2 = height - (t - middle)^2 slope.
struct BallStretch {
    float middle; // of the stretch inside
    float half_length; // 0 where the ray misses
    float height;
    float slope;
};

INLINE struct BallStretch ball_stretch(__global const struct Ball *ball, float3 origin, float3 direction) {
    struct BallStretch stretch;
    float3 to = ball->place.xyz - origin;
    float radius = ball->place.w;
    stretch.middle = dot(to, direction);
    float3 aside = to - stretch.middle * direction;
    float away = sqrt(dot(aside, aside));
    float square = (radius - away) * (radius + away);
    stretch.slope = 1.0f / (radius * radius);
    stretch.height = square * stretch.slope;
    stretch.half_length = square > 0.0f ? sqrt(square) : 0.0f;
    return stretch;
}

// The Bernstein coefficients of the part of a quartic between u and v, 0 to 1 being the whole.
struct Quartic {
    float b[5];
};

// One step of de Casteljau: what is left of the row after `drop` steps.
#define CASTELJAU(b, s, left)                      \
    for (int i = 0; i < (left); ++i) {             \
        (b)[i] = (b)[i] + (s) * ((b)[i + 1] - (b)[i]); \
    }

INLINE struct Quartic quartic_part(struct Quartic whole, float u, float v) {
    struct Quartic part;
    // Blossoms: coefficient k is that at u (4 - k times) and v (k times).
    float row[5];
    for (int k = 0; k < 5; ++k) {
        for (int i = 0; i < 5; ++i) {
            row[i] = whole.b[i];
        }
        for (int left = 4; left > 0; --left) {
            float s = left > k ? u : v;
            CASTELJAU(row, s, left)
        }
        part.b[k] = row[0];
    }
    return part;
}

// Where in [0, 1] a quartic with b[0] <= 0 < b[4] and one crossing between crosses: Newton's steps, or half of what is
// left of the bracket where they leave it.
INLINE float quartic_crossing(struct Quartic quartic) {
    float low = 0.0f;
    float high = 1.0f;
    float s = 0.5f;
    for (int step = 0; step < 32; ++step) {
        float row[5];
        for (int i = 0; i < 5; ++i) {
            row[i] = quartic.b[i];
        }
        for (int left = 4; left > 1; --left) {
            CASTELJAU(row, s, left)
        }
        float slope = row[1] - row[0];
        float value = row[0] + s * slope;
        bool after = value > 0.0f;
        low = after ? low : s;
        high = after ? s : high;
        float next = s - value / (4.0f * slope);
        next = next > low && next < high ? next : 0.5f * (low + high);
        if (fabs(next - s) <= 1e-7f || high - low <= 1e-7f) {
            return next;
        }
        s = next;
    }
    return s;
}

// The first place in (0, 1] where a quartic that starts with b[0] <= 0 gets above 0, or -1. Intervals are halved until
// their coefficients tell; the one at hand is [index, index + 1] / 2^depth.
INLINE float quartic_rise(struct Quartic whole) {
    uint depth = 0;
    uint index = 0;
    // Four crossings at most, each of which halves at most METABALLS_DEPTH times and looks at both halves.
    for (int turn = 0; turn < 16 * METABALLS_DEPTH; ++turn) {
        float width = 1.0f / (float)(1u << depth);
        float start = (float)index * width;
        struct Quartic part = whole;
        if (depth > 0u) {
            part = quartic_part(whole, start, start + width);
        }
        int changes = 0;
        bool above = false;
        for (int i = 1; i < 5; ++i) {
            bool now = part.b[i] > 0.0f;
            changes += now != above;
            above = now;
        }
        if (changes == 1 || (above && depth == METABALLS_DEPTH)) {
            return start + width * quartic_crossing(part);
        }
        if (changes != 0 && depth < METABALLS_DEPTH) {
            ++depth;
            index <<= 1;
            continue;
        }
        ++index;
        while ((index & 1u) == 0u && depth > 0u) {
            index >>= 1;
            --depth;
        }
        if (depth == 0u) {
            return -1.0f;
        }
    }
    return -1.0f;
}

// The field less the threshold along the ray from u to v, between which no ball is entered or left.
INLINE struct Quartic field_quartic(__global const struct Ball *balls, uint first, uint count, float threshold,
    float3 origin, float3 direction, float u, float v) {
    struct Quartic quartic;
    for (int i = 0; i < 5; ++i) {
        quartic.b[i] = 0.0f;
    }
    float middle = 0.5f * (u + v);
    float half_width = 0.5f * (v - u);
    for (uint i = first; i < first + count; ++i) {
        struct BallStretch stretch = ball_stretch(&balls[i], origin, direction);
        // 1 - s^2 = a + b x + c x^2 for x from -1 to 1.
        float shift = middle - stretch.middle;
        float a = stretch.height - stretch.slope * shift * shift;
        if (!(a > 0.0f && stretch.half_length > 0.0f)) {
            continue;
        }
        float b = -2.0f * stretch.slope * shift * half_width;
        float c = -stretch.slope * half_width * half_width;
        float low = a - b + c;
        float inner = a - c;
        float high = a + b + c;
        float weight = balls[i].weight;
        quartic.b[0] += weight * low * low;
        quartic.b[1] += weight * low * inner;
        quartic.b[2] += weight * (low * high + 2.0f * inner * inner) / 3.0f;
        quartic.b[3] += weight * inner * high;
        quartic.b[4] += weight * high * high;
    }
    for (int i = 0; i < 5; ++i) {
        quartic.b[i] -= threshold;
    }
    return quartic;
}

// The nearest place after t where the ray enters or leaves a ball, at most t_max.
INLINE float next_ball(__global const struct Ball *balls, uint first, uint count, float3 origin, float3 direction,
    float t, float t_max) {
    float next = t_max;
    for (uint i = first; i < first + count; ++i) {
        struct BallStretch stretch = ball_stretch(&balls[i], origin, direction);
        if (stretch.half_length > 0.0f) {
            float enter = stretch.middle - stretch.half_length;
            float leave = stretch.middle + stretch.half_length;
            next = enter > t ? min(next, enter) : (leave > t ? min(next, leave) : next);
        }
    }
    return next;
}

// Down the field at a point, of unit length; `otherwise` where the field is flat.
INLINE float3 metaballs_normal(__global const struct Ball *balls, uint first, uint count, float3 point,
    float3 otherwise) {
    float3 down = (float3)(0.0f);
    for (uint i = first; i < first + count; ++i) {
        float3 from = point - balls[i].place.xyz;
        float radius = balls[i].place.w;
        float slope = 1.0f / (radius * radius);
        float inside = max(1.0f - slope * dot(from, from), 0.0f);
        down += balls[i].weight * slope * inside * from;
    }
    float square = dot(down, down);
    return square > 1e-30f ? down * rsqrt(square) : otherwise;
}

// The first place between t_min and t_max where the ray goes through the surface F = 0 of balls [first, first + count).
// At t_min it is on the side that F there tells. The direction has unit length; the normal, too, points out of the
// body, so that direction . normal < 0 where the ray enters it.
INLINE bool metaballs_hit(__global const struct Ball *balls, uint first, uint count, float threshold, float3 origin,
    float3 direction, float t_min, float t_max, float *t, float3 *normal) {
    float at = t_min;
    float sign = 0.0f;
    for (uint part = 0; part <= 2 * count && at < t_max; ++part) {
        float next = next_ball(balls, first, count, origin, direction, at, t_max);
        struct Quartic field = field_quartic(balls, first, count, threshold, origin, direction, at, next);
        // Of the side on which the ray starts.
        sign = part > 0 ? sign : (field.b[0] > 0.0f ? -1.0f : 1.0f);
        for (int i = 0; i < 5; ++i) {
            field.b[i] *= sign;
        }
        float s = quartic_rise(field);
        if (s >= 0.0f) {
            float middle = 0.5f * (at + next);
            *t = middle + (s - 0.5f) * (next - at);
            float3 out = metaballs_normal(balls, first, count, origin + *t * direction, -direction * sign);
            // Rounding may tilt the normal of a grazing ray past the ray.
            float slope = sign * dot(out, direction);
            *normal = slope < 0.0f ? out : normalize(out - (slope + 1e-6f) * sign * direction);
            return true;
        }
        at = next;
    }
    return false;
}
