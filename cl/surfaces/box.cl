// Boxes along the axes as rays meet them.
#include "common/inline.cl"
#include "surfaces/nodes.cl"

// Where a ray enters and leaves each slab of a box.
struct Slabs {
    float3 first;
    float3 last;
};

INLINE struct Slabs box_slabs(float3 low, float3 high, const struct Ray *ray) {
    float3 a = (low - ray->origin) * ray->inverse;
    float3 b = (high - ray->origin) * ray->inverse;
    struct Slabs slabs = {min(a, b), max(a, b)};
    return slabs;
}

// Whether a ray meets a box at 0 < *t < t_max: from outside where it enters, from inside where it leaves.
INLINE bool box_hit(float3 low, float3 high, const struct Ray *ray, float t_max, float *t) {
    struct Slabs slabs = box_slabs(low, high, ray);
    float enters = max(max(slabs.first.x, slabs.first.y), slabs.first.z);
    float leaves = min(min(slabs.last.x, slabs.last.y), slabs.last.z);
    *t = enters > 0.0f ? enters : leaves;
    return enters <= leaves && *t > 0.0f && *t < t_max;
}

// The outward normal where the ray meets the box, and `point` moved onto that face.
INLINE float3 box_point(float3 low, float3 high, const struct Ray *ray, float3 point, float3 *outward) {
    struct Slabs slabs = box_slabs(low, high, ray);
    float enters = max(max(slabs.first.x, slabs.first.y), slabs.first.z);
    bool outside = enters > 0.0f;
    // The slab that is entered last or left first.
    float3 order = outside ? slabs.first : -slabs.last;
    bool x = order.x >= order.y && order.x >= order.z;
    bool y = !x && order.y >= order.z;
    float3 axis = (float3)(x, y, !x && !y);
    bool forward = dot(axis, ray->direction) > 0.0f;
    *outward = forward == outside ? -axis : axis;
    float3 face = forward == outside ? low : high;
    return point + axis * (face - point);
}
