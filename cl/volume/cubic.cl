// The field along a ray inside a cell: a cubic of s in [0, 1], from where the ray enters the cell to where it leaves.
#include "volume/sampling.cl"

// value(s) = a + b s + c s^2 + d s^3.
struct Cubic {
    float a, b, c, d;
};

INLINE float cubic_value(struct Cubic p, float s) {
    return p.a + s * (p.b + s * (p.c + s * p.d));
}

// `from`: position in the cell (0 to 1 per axis) where the segment starts; `along`: the segment.
INLINE struct Cubic cell_cubic(struct Corners c, float4 from, float4 along) {
    // Interpolating axis by axis raises the degree by one each time.
    float4 slope = c.high - c.low;
    float4 z0 = c.low + from.z * slope;
    float4 z1 = along.z * slope;
    float2 slope0 = z0.zw - z0.xy;
    float2 slope1 = z1.zw - z1.xy;
    float2 y0 = z0.xy + from.y * slope0;
    float2 y1 = z1.xy + from.y * slope1 + along.y * slope0;
    float2 y2 = along.y * slope1;
    float e0 = y0.y - y0.x;
    float e1 = y1.y - y1.x;
    float e2 = y2.y - y2.x;
    struct Cubic p;
    p.a = y0.x + from.x * e0;
    p.b = y1.x + from.x * e1 + along.x * e0;
    p.c = y2.x + from.x * e2 + along.x * e1;
    p.d = along.x * e2;
    return p;
}

// The cubic in window values.
INLINE struct Cubic cubic_window(__constant struct Volume *volume, struct Cubic p) {
    p.a = window_value(volume, p.a);
    p.b *= volume->value_scale;
    p.c *= volume->value_scale;
    p.d *= volume->value_scale;
    return p;
}

INLINE float extremum_inside(float s) {
    return s > 0.0f && s < 1.0f ? s : 1.0f;
}

// The extrema inside (0, 1), ascending; 1 where there is none. Between them the cubic is monotone.
INLINE float2 cubic_extrema(struct Cubic p) {
    // Derivative b + 2 c s + 3 d s^2, roots in the form that does not cancel.
    float discriminant = p.c * p.c - 3.0f * p.b * p.d;
    if (!(discriminant > 0.0f)) {
        return (float2)(1.0f);
    }
    float q = -(p.c + copysign(sqrt(discriminant), p.c));
    float r0 = extremum_inside(q != 0.0f ? p.b / q : 1.0f);
    float r1 = extremum_inside(p.d != 0.0f ? q / (3.0f * p.d) : 1.0f);
    return (float2)(min(r0, r1), max(r0, r1));
}

#define ROOT_STEPS 24

// The root in [lo, hi], where the cubic changes sign once: Newton's method kept inside the bracket by bisection.
INLINE float bracketed_root(struct Cubic p, float lo, float hi, bool positive_at_lo) {
    float s = 0.5f * (lo + hi);
    for (int i = 0; i < ROOT_STEPS; ++i) {
        float value = cubic_value(p, s);
        if ((value >= 0.0f) == positive_at_lo) {
            lo = s;
        } else {
            hi = s;
        }
        float slope = p.b + s * (2.0f * p.c + s * 3.0f * p.d);
        float next = s - value / slope;
        if (!(next > lo && next < hi)) {
            next = 0.5f * (lo + hi);
        }
        if (fabs(next - s) < 1e-7f) {
            return next;
        }
        s = next;
    }
    return s;
}
