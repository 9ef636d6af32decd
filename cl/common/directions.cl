// Directions of unit length.
#include "common/lanes.cl"

// (cos, sin) of 2 pi u for u in [0, 1), absolute error < 1e-7, without branches.
//
// With v = u - 1/2 both are sines of at most a quarter turn, x turns: x = |v| - 1/4 for the cosine, 1/4 - ||v| - 1/4| with
// the sign of -v for the sine. The reductions are exact; the minimax polynomial's relative error is 5.3e-9.
INLINE Reals sine_of_turns(Reals x) {
    Reals y = x * x;
    return x * (6.28318527f + y * (-41.3416775f + y * (81.6022312f + y * (-76.5749922f + y * 39.7109180f))));
}

INLINE void unit_circle(Reals u, Reals *cosine, Reals *sine) {
    Reals v = u - 0.5f;
    Reals c = fabs(v) - 0.25f;
    *cosine = sine_of_turns(c);
    *sine = sine_of_turns(copysign(0.25f - fabs(c), -v));
}

// Uniform on the sphere.
INLINE struct Points uniform_directions(Reals u, Reals v) {
    Reals cosine, sine;
    unit_circle(v, &cosine, &sine);
    Reals radius = 2.0f * sqrt(u * (1.0f - u));
    return points(radius * cosine, radius * sine, 1.0f - 2.0f * u);
}

// `direction` turned by the angle with this cosine and sine, about an axis given by u in [0, 1).
//
// The frame is that of Duff et al. 2017 ("Building an Orthonormal Basis, Revisited"), its second axis mirrored for
// z < 0, and multiplied out. One Newton step of the inverse square root keeps the length at 1 over any number of turns.
INLINE struct Points turned(struct Points direction, Reals cosine, Reals sine, Reals u) {
    Reals x, y;
    unit_circle(u, &x, &y);
    x *= sine;
    y *= sine;
    Reals across = x * direction.x + y * direction.y;
    Reals along = cosine - across / (1.0f + fabs(direction.z));
    x += along * direction.x;
    y += along * direction.y;
    Reals z = cosine * direction.z - PICK(across, -across, direction.z < 0.0f);
    Reals scale = 1.5f - 0.5f * (x * x + y * y + z * z);
    return points(scale * x, scale * y, scale * z);
}
