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
    float middle;
    float height; // 0 or less where the ray misses
    float slope;
};

INLINE struct BallStretch ball_stretch(__global const struct Ball *ball, float3 origin, float3 direction) {
    struct BallStretch stretch;
    float3 to = ball->place.xyz - origin;
    stretch.middle = dot(to, direction);
    float3 aside = to - stretch.middle * direction;
    stretch.slope = ball->slope;
    stretch.height = 1.0f - dot(aside, aside) * stretch.slope;
    return stretch;
}

// From the middle to where the ray enters or leaves the ball, which it does not miss.
INLINE float half_length(struct BallStretch stretch) {
    return sqrt(stretch.height / stretch.slope);
}

// The Bernstein coefficients of a quartic between 0 and 1. No array: compilers keep those in memory.
struct Quartic {
    float a;
    float b;
    float c;
    float d;
    float e;
};

INLINE float between(float from, float to, float s) {
    return from + s * (to - from);
}

// The rows of de Casteljau's scheme at s: what is left of (a, b, c, d, e) after one, two and three steps.
#define CASTELJAU(q, s)                                                                                               \
    float ab = between((q).a, (q).b, s), bc = between((q).b, (q).c, s), cd = between((q).c, (q).d, s);                \
    float de = between((q).d, (q).e, s);                                                                              \
    float abc = between(ab, bc, s), bcd = between(bc, cd, s), cde = between(cd, de, s);                               \
    float abcd = between(abc, bcd, s), bcde = between(bcd, cde, s);

// The part between u and v, v > 0.
INLINE struct Quartic quartic_part(struct Quartic whole, float u, float v) {
    struct Quartic before;
    {
        CASTELJAU(whole, v)
        before.a = whole.a;
        before.b = ab;
        before.c = abc;
        before.d = abcd;
        before.e = between(abcd, bcde, v);
    }
    struct Quartic part;
    float s = u / v;
    CASTELJAU(before, s)
    part.a = between(abcd, bcde, s);
    part.b = bcde;
    part.c = cde;
    part.d = de;
    part.e = before.e;
    return part;
}

// Where in [0, 1] a quartic with a <= 0 < e and one crossing between crosses: Newton's steps from where its chord
// crosses, or half of what is left of the bracket where they leave it.
INLINE float quartic_crossing(struct Quartic quartic) {
    // What rounding does to the values: closer to 0 they tell nothing, and steps would wander to and fro.
    float2 most = max(fabs((float2)(quartic.a, quartic.e)), fabs((float2)(quartic.b, quartic.d)));
    float noise = 2.4e-7f * max(max(most.x, most.y), fabs(quartic.c));
    float low = 0.0f;
    float high = 1.0f;
    float s = clamp(quartic.a / (quartic.a - quartic.e), 0.0f, 1.0f);
    for (int step = 0; step < 32; ++step) {
        CASTELJAU(quartic, s)
        float slope = bcde - abcd;
        float value = abcd + s * slope;
        bool after = value > 0.0f;
        low = after ? low : s;
        high = after ? s : high;
        float next = s - value / (4.0f * slope);
        // A ray that has just left the surface starts at 0, too, but falls.
        if ((slope > 0.0f && fabs(value) <= noise) || high - low <= 1e-7f) {
            return clamp(next, low, high);
        }
        next = next > low && next < high ? next : 0.5f * (low + high);
        s = next;
    }
    return s;
}

// The first place in (0, 1] where a quartic that starts with a <= 0 gets above 0, or -1. Intervals are halved until
// their coefficients tell; the one at hand is [index, index + 1] / 2^depth. If `any`, a place before the crossing will do.
INLINE float quartic_rise(struct Quartic whole, bool any) {
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
        bool b = part.b > 0.0f, c = part.c > 0.0f, d = part.d > 0.0f, e = part.e > 0.0f;
        int changes = (int)b + (int)(b != c) + (int)(c != d) + (int)(d != e);
        if (changes == 1 || (e && depth == METABALLS_DEPTH)) {
            return any ? start : start + width * quartic_crossing(part);
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

// The field less the threshold along the ray from u to v, between which no ball is entered or left, times `sign`.
INLINE struct Quartic field_quartic(__global const struct Ball *balls, uint first, uint count, float threshold,
    float3 origin, float3 direction, float u, float v, float sign) {
    float start = -sign * threshold;
    struct Quartic quartic = { start, start, start, start, start };
    float middle = 0.5f * (u + v);
    float half_width = 0.5f * (v - u);
    for (uint i = first; i < first + count; ++i) {
        struct BallStretch stretch = ball_stretch(&balls[i], origin, direction);
        // 1 - s^2 = a + b x + c x^2 for x from -1 to 1.
        float shift = middle - stretch.middle;
        float a = stretch.height - stretch.slope * shift * shift;
        if (!(a > 0.0f)) {
            continue;
        }
        float b = -2.0f * stretch.slope * shift * half_width;
        float c = -stretch.slope * half_width * half_width;
        float low = a - b + c;
        float inner = a - c;
        float high = a + b + c;
        float weight = sign * balls[i].weight;
        quartic.a += weight * low * low;
        quartic.b += weight * low * inner;
        quartic.c += weight * (low * high + 2.0f * inner * inner) * (1.0f / 3.0f);
        quartic.d += weight * inner * high;
        quartic.e += weight * high * high;
    }
    return quartic;
}

// Where a ray is inside any ball.
struct Stay {
    float enters; // INFINITY where it is in none
    float leaves;
    float most;   // what the field there is at most
};

INLINE struct Stay stay_in_balls(__global const struct Ball *balls, uint first, uint count, float3 origin,
    float3 direction, float t_min, float t_max) {
    struct Stay stay = { INFINITY, t_min, 0.0f };
    for (uint i = first; i < first + count; ++i) {
        struct BallStretch stretch = ball_stretch(&balls[i], origin, direction);
        float away = clamp(stretch.middle, t_min, t_max) - stretch.middle;
        float most = stretch.height - stretch.slope * away * away;
        if (most > 0.0f) {
            float half_way = half_length(stretch);
            stay.enters = min(stay.enters, stretch.middle - half_way);
            stay.leaves = max(stay.leaves, stretch.middle + half_way);
            stay.most += max(balls[i].weight, 0.0f) * most * most;
        }
    }
    return stay;
}

// The nearest place after t where the ray enters or leaves a ball, at most t_max.
INLINE float next_ball(__global const struct Ball *balls, uint first, uint count, float3 origin, float3 direction,
    float t, float t_max) {
    float next = t_max;
    for (uint i = first; i < first + count; ++i) {
        struct BallStretch stretch = ball_stretch(&balls[i], origin, direction);
        if (stretch.height > 0.0f) {
            float half_way = half_length(stretch);
            float enter = stretch.middle - half_way;
            float leave = stretch.middle + half_way;
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
        float slope = balls[i].slope;
        float inside = max(1.0f - slope * dot(from, from), 0.0f);
        down += balls[i].weight * slope * inside * from;
    }
    float square = dot(down, down);
    return square > 1e-30f ? down * rsqrt(square) : otherwise;
}

// The first place between t_min and t_max where the ray goes through the surface F = 0 of balls [first, first + count).
// At t_min it is on the side that F there tells. The direction has unit length; the normal, too, points out of the
// body, so that direction . normal < 0 where the ray enters it. If `any`, it is enough that there is one: *t is some
// place before it, and there is no normal.
INLINE bool metaballs_hit(__global const struct Ball *balls, uint first, uint count, float threshold, float3 origin,
    float3 direction, float t_min, float t_max, bool any, float *t, float3 *normal) {
    struct Stay stay = stay_in_balls(balls, first, count, origin, direction, t_min, t_max);
    if (stay.most <= threshold) {
        return false;
    }
    // Before the first ball and behind the last one there is no field.
    float at = max(t_min, stay.enters);
    float end = min(t_max, stay.leaves);
    float sign = 1.0f;
    for (uint part = 0; part <= 2 * count && at < end; ++part) {
        float next = next_ball(balls, first, count, origin, direction, at, end);
        struct Quartic field = field_quartic(balls, first, count, threshold, origin, direction, at, next, sign);
        if (part == 0 && field.a > 0.0f) {
            // The ray starts inside.
            sign = -1.0f;
            field = (struct Quartic){ -field.a, -field.b, -field.c, -field.d, -field.e };
        }
        float s = quartic_rise(field, any);
        if (s >= 0.0f) {
            float middle = 0.5f * (at + next);
            *t = middle + (s - 0.5f) * (next - at);
            if (any) return true;
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
