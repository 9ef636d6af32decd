// Rays through the medium, side by side, and the state of each on its way: see tracking.cl.
#include "common/random_lanes.cl"
#include "types/path.cl"
#include "volume/tables.cl"

// Bounds per brick: majorant and minorant; -k as majorant: all bricks less than k away are empty.
typedef float2 BrickBound;

// What the medium is made from.
struct MediumTables {
    __constant struct Frame *frame;
    __constant struct Volume *volume;
    __constant struct Scattering *method;
    __global const VOXEL *voxels;
    __global const BrickBound *bounds;
    __global const float *sigmas;
#ifdef CONTROLLED
    float over, under; // tentative collisions come at the rate over * majorant - under * minorant
#endif
};

// Rays in grid coordinates; `t` counts local length.
struct RayLanes {
    struct Points origin;
    struct Points direction; // grid units per local length
    struct Points inverse;
    struct Points ahead;     // 1 towards larger coordinates, else 0: kept as floats beside the plane times they enter
};

// Directions this close to an axis plane count as this far from it, towards the middle of the box: 1 / direction stays
// finite, over any box the ray moves less than a rounding, and from a face a ray along it stays in the medium.
#define LEAST_STEP 1e-12f

INLINE Reals off_zero(Reals d, Reals origin, float low, float high) {
    return PICK(d, copysign((Reals)(LEAST_STEP), 0.5f * (low + high) - origin), fabs(d) < LEAST_STEP);
}

INLINE struct RayLanes ray_lanes(__constant struct Scattering *method, struct Points origin, struct Points direction) {
    struct RayLanes ray;
    ray.origin = origin;
    ray.direction = points(off_zero(direction.x, origin.x, method->low.x, method->high.x),
        off_zero(direction.y, origin.y, method->low.y, method->high.y),
        off_zero(direction.z, origin.z, method->low.z, method->high.z));
    ray.inverse = points(1.0f / ray.direction.x, 1.0f / ray.direction.y, 1.0f / ray.direction.z);
    Reals zero = (Reals)(0.0f);
    Reals one = (Reals)(1.0f);
    ray.ahead = points(PICK(zero, one, ray.direction.x > 0.0f), PICK(zero, one, ray.direction.y > 0.0f),
        PICK(zero, one, ray.direction.z > 0.0f));
    return ray;
}

INLINE struct RayLanes pick_rays(struct RayLanes no, struct RayLanes yes, Ints mask) {
    struct RayLanes ray;
    ray.origin = pick_points(no.origin, yes.origin, mask);
    ray.direction = pick_points(no.direction, yes.direction, mask);
    ray.inverse = pick_points(no.inverse, yes.inverse, mask);
    ray.ahead = pick_points(no.ahead, yes.ahead, mask);
    return ray;
}

// Times between which rays are inside the box of what can hold extinction; *from > *to for a miss.
INLINE void clip_rays(__constant struct Scattering *method, const struct RayLanes *ray, Reals *from, Reals *to) {
    Reals x0 = (method->low.x - ray->origin.x) * ray->inverse.x;
    Reals x1 = (method->high.x - ray->origin.x) * ray->inverse.x;
    Reals y0 = (method->low.y - ray->origin.y) * ray->inverse.y;
    Reals y1 = (method->high.y - ray->origin.y) * ray->inverse.y;
    Reals z0 = (method->low.z - ray->origin.z) * ray->inverse.z;
    Reals z1 = (method->high.z - ray->origin.z) * ray->inverse.z;
    *from = max(*from, max(max(min(x0, x1), min(y0, y1)), min(z0, z1)));
    *to = min(*to, min(min(max(x0, x1), max(y0, y1)), max(z0, z1)));
}

// Channels whose transmittance differs.
#ifdef CHROMATIC
#define TRACKED 3
#else
#define TRACKED 1
#endif

// States: their sum over the lanes counts each (STATE_COUNT).
#define TRAVELLING 0     // on its way to the next tentative collision
#define TENTATIVE 1      // at one
#define ARRIVED 0x100    // at the end of the ray, or nothing left of it
#define RESTING 0x10000  // no ray
#define STATE_COUNT(sum, state) (((sum) / (state)) & 0xff)

struct FlightLanes {
    Ints state;
    Ints bx, by, bz;         // the brick
    Reals t;
    Reals end;               // where the ray ends
    Reals depth;             // optical depth (of the majorant) left to the next tentative collision
    Reals majorant;          // of the brick of the tentative collision
    Reals scale;             // factor of the majorants
    Reals threshold;
    Reals through[TRACKED];
    Reals taken;             // mean over the channels
    Reals share[TRACKED];    // weights of the kept collision relative to their mean
    struct Points place;     // of the kept collision, grid coordinates
    Reals distance;          // its t
    Reals value;             // its place in the transfer function: window value in entries of the table
    Reals row;               // ... and row of a 2-D one
#ifdef CONTROLLED
    Reals minorant;          // of the brick of the tentative collision
    Reals control;           // optical depth of the minorants on the way, which the flight's owner takes into account
#endif
};

// What is left of a ray, in a channel of light.
INLINE Reals through_of(const struct FlightLanes *f, int channel) {
    return f->through[TRACKED == 1 ? 0 : channel];
}

// The weight of the kept collision in a channel of light.
INLINE Reals collided_of(const struct FlightLanes *f, int channel) {
    return f->taken * f->share[TRACKED == 1 ? 0 : channel];
}

// The extinction of a tracked channel relative to sigma_t.
INLINE float channel_extinction(const struct MediumTables *m, int channel) {
#ifdef CHROMATIC
    return channel == 0 ? m->method->extinction.x : channel == 1 ? m->method->extinction.y : m->method->extinction.z;
#else
    return 1.0f;
#endif
}
