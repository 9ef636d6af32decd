// Boxes of the hierarchy as rays meet them. The test is conservative: rounding never hides a shape.
#include "common/inline.cl"
#include "types/surface.cl"

// The deepest that the hierarchy gets: DEPTH in src/surfaces/bvh.rs.
#define NODE_STACK 32
// Components of directions less than this count as this: no 0 * INFINITY. Small enough to leave every box that it should.
#define LEAST_COMPONENT 1e-20f
// Relative to where a ray enters or leaves a slab: the rounding of a difference, a reciprocal (2.5 ulp) and a product.
#define NODE_SLACK (1.0f + 16.0f / 8388608.0f)
// How far shapes may reach out of their boxes, relative to the coordinates: they and the origin of the ray are rounded,
// and so is what their tests compute from the difference.
#define NODE_PADDING (16.0f / 16777216.0f)

// A ray, with what tests of many boxes or shapes share.
struct Ray {
    float3 origin;
    float3 direction;
    float3 inverse; // 1 / direction, finite
    float3 above;   // origin + padding
    float3 below;   // origin - padding
#ifdef SHAPE_TRIANGLE
    uint axis;      // along which the direction is longest
    float3 shear;   // with that axis as z: x / z, y / z and 1 / z of the direction
#endif
};

// The coordinates in turn, so that `axis` is the last.
INLINE float3 turned(float3 v, uint axis) {
    return axis == 0 ? v.yzx : axis == 1 ? v.zxy : v;
}

INLINE uint node_first(__global const struct Node *node) {
    return as_uint(node->low.w);
}

INLINE uint node_count(__global const struct Node *node) {
    return as_uint(node->high.w);
}

INLINE float inverse_of(float x) {
    return 1.0f / (fabs(x) < LEAST_COMPONENT ? copysign(LEAST_COMPONENT, x) : x);
}

INLINE struct Ray ray_through(__global const struct Node *nodes, uint count, float3 origin, float3 direction) {
    struct Ray ray;
    ray.origin = origin;
    ray.direction = direction;
    ray.inverse = (float3)(inverse_of(direction.x), inverse_of(direction.y), inverse_of(direction.z));
#ifdef SHAPE_TRIANGLE
    float3 size = fabs(direction);
    ray.axis = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
    float3 along = turned(direction, ray.axis);
    ray.shear = (float3)(along.x / along.z, along.y / along.z, 1.0f / along.z);
#endif
    ray.above = ray.below = origin;
    if (count > 0) {
        float3 most = max(fabs(nodes[0].low.xyz), fabs(nodes[0].high.xyz)) + fabs(origin);
        float padding = NODE_PADDING * max(max(most.x, most.y), most.z);
        ray.above = origin + padding;
        ray.below = origin - padding;
    }
    return ray;
}

// Where a ray enters a box, 0 if it starts inside; INFINITY if it misses the box or enters after `t_max`.
INLINE float node_entry(__global const struct Node *node, const struct Ray *ray, float t_max) {
    float3 a = (node->low.xyz - ray->above) * ray->inverse;
    float3 b = (node->high.xyz - ray->below) * ray->inverse;
    float3 first = min(a, b);
    float3 last = max(a, b);
    float enters = max(max(first.x, first.y), max(first.z, 0.0f));
    float leaves = min(min(last.x, last.y), last.z);
    return enters <= min(leaves, t_max) * NODE_SLACK ? enters : INFINITY;
}
