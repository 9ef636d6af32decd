// Directions of unit length.
#include "common/lanes.cl"

// (cos, sin) of 2 pi u for u in [0, 1), absolute error < 1e-7, without branches.
//
// u is reduced, exactly, to the nearest quarter turn and r in [-1/2, 1/2] quarter turns from it; the minimax polynomials
// err by less than 3e-9.
INLINE void unit_circle(Reals u, Reals *cosine, Reals *sine) {
    Ints quarter = TO_INTS(4.0f * u + 0.5f);
    Reals r = 4.0f * u - TO_REALS(quarter);
    Reals z = r * r;
    Reals s = r + r * (0.57079632f + z * (-0.64596346f + z * (0.0796800328f - z * 0.00460165789f)));
    Reals c = 1.0f + z * (-1.23370054f + z * (0.253669275f + z * (-0.0208604868f + z * 0.000904410716f)));
    Ints odd = (quarter & 1) != 0;
    // Quarters 1 and 2 have a negative cosine, 2 and 3 a negative sine.
    Words negative = (Words)(0x80000000u);
    *cosine = AS_REALS(AS_WORDS(PICK(c, s, odd)) ^ (AS_WORDS((quarter + 1) << 30) & negative));
    *sine = AS_REALS(AS_WORDS(PICK(s, c, odd)) ^ (AS_WORDS(quarter << 30) & negative));
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
