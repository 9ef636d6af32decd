// What rays meet of the surfaces: the nearest hit, or whether there is any. Local units; directions have unit length.
//
// Only the shapes whose SHAPE_* is defined are compiled in: PLANE, SPHERE, RECTANGLE, DISK, BOX, METABALLS, TRIANGLE;
// SMOOTH: some triangles have normals at their corners.
#include "common/inline.cl"
#include "types/surface.cl"
#include "surfaces/nodes.cl"
#include "surfaces/plane.cl"
#include "surfaces/sphere.cl"
#include "surfaces/rectangle.cl"
#include "surfaces/disk.cl"
#include "surfaces/box.cl"
#ifdef SHAPE_METABALLS
#include "surfaces/metaballs.cl"
#endif
#ifdef SHAPE_TRIANGLE
#include "surfaces/triangle.cl"
#endif

// How far a ray must start from the surface that it leaves, relative to the coordinates there: what rounding may do to
// the point of a hit and to the next test against the same shape, several times over.
#define SURFACE_MARGIN (32.0f / 16777216.0f)

// Cosines of grazing rays are at least this, where rounding has taken their sign.
#define LEAST_SLOPE 1e-6f

// All surfaces of a scene, as SurfaceArrays of the host describes them.
struct Surfaces {
    __global const struct Shape *shapes; // planes first, then those of the leaves
    uint plane_count;
    __global const struct Node *nodes;
    uint node_count; // 0 where there are only planes
    __global const struct Ball *balls;
    __global const float4 *normals;
    __global const uint *materials_of; // of each surface
    __global const struct Material *materials;
};

// Where a ray meets a surface.
struct Hit {
    float t;
    float margin;  // how far from the surface the next ray starts
    float3 point;  // on the surface as exactly as float32 can say: better than origin + t * direction
    float3 normal; // unit length, outward; where triangles are smooth, that for shading, on the same side as `face`
    float3 face;   // the normal of the surface itself
    uint surface;
    bool inside;   // the ray came from behind the surface: dot(direction, face) > 0, else < 0
};

// Where a ray that leaves a surface starts, on the side to which it goes.
INLINE float3 surface_offset(const struct Hit *hit, float3 direction) {
    return hit->point + (dot(direction, hit->face) < 0.0f ? -hit->margin : hit->margin) * hit->face;
}

INLINE float largest_component(float3 v) {
    v = fabs(v);
    return max(max(v.x, v.y), v.z);
}

// Whether the ray meets a shape at 0 < *t < t_max; for metaballs, with what normal, and if `any` not where.
INLINE bool shape_hit(const struct Surfaces *s, uint index, const struct Ray *ray, float t_max, bool any, float *t,
                      float3 *normal) {
    __global const struct Shape *shape = s->shapes + index;
    switch (shape->kind) {
#ifdef SHAPE_SPHERE
    case SURFACE_SPHERE:
        return sphere_hit(shape->b, shape->c.xyz, ray->origin, ray->direction, t_max, t);
#endif
#ifdef SHAPE_RECTANGLE
    case SURFACE_RECTANGLE:
        return rectangle_hit(shape->a.xyz, shape->b.xyz, shape->c.xyz, shape->d, ray->origin, ray->direction, t_max, t);
#endif
#ifdef SHAPE_DISK
    case SURFACE_DISK:
        return disk_hit(shape->a, shape->b, ray->origin, ray->direction, t_max, t);
#endif
#ifdef SHAPE_BOX
    case SURFACE_BOX:
        return box_hit(shape->a.xyz, shape->b.xyz, ray, t_max, t);
#endif
#ifdef SHAPE_METABALLS
    case SURFACE_METABALLS: {
        // Within its bounds, outside of which the field is 0 or less: only finite stretches have coefficients.
        struct Slabs slabs = box_slabs(shape->a.xyz, shape->b.xyz, ray);
        float enters = max(max(slabs.first.x, slabs.first.y), max(slabs.first.z, 0.0f));
        float leaves = min(min(slabs.last.x, slabs.last.y), min(slabs.last.z, t_max));
        return enters < leaves
            && metaballs_hit(s->balls, shape->first, shape->count, shape->c.x, ray->origin, ray->direction, enters, leaves,
                             any, t, normal)
            && (any || (*t > 0.0f && *t < t_max));
    }
#endif
#ifdef SHAPE_TRIANGLE
    case SURFACE_TRIANGLE:
        return triangle_hit(shape->a.xyz, shape->b.xyz, shape->c.xyz, ray, t_max, t);
#endif
    default:
        return false;
    }
}

// The nearest shape with 0 < *t < t_max, or NO_SHAPE; any of them if `any`. Metaballs: with what normal.
#define NO_SHAPE 0xffffffffu
INLINE uint nearest_shape(const struct Surfaces *s, const struct Ray *ray, float t_max, bool any, float *t,
                          float3 *normal) {
    uint found = NO_SHAPE;
    float t_shape;
    float3 shape_normal = ray->direction;
    *normal = shape_normal;
    *t = t_max;
#ifdef SHAPE_PLANE
    for (uint i = 0; i < s->plane_count; ++i) {
        if (plane_hit(s->shapes[i].b, ray->origin, ray->direction, *t, &t_shape)) {
            *t = t_shape;
            found = i;
        }
    }
#endif
    if (s->node_count == 0 || (any && found != NO_SHAPE)) {
        return found;
    }
    // Nodes to be visited, with where the ray enters them.
    uint stack[NODE_STACK];
    float entries[NODE_STACK];
    uint depth = 0;
    uint node = 0;
    float entry = node_entry(s->nodes, ray, *t);
    while (true) {
        // Not into what begins behind the nearest hit.
        if (entry <= *t && entry < INFINITY) {
            uint first = node_first(s->nodes + node);
            uint count = node_count(s->nodes + node);
            if (count == 0) {
                float left = node_entry(s->nodes + first, ray, *t);
                float right = node_entry(s->nodes + first + 1, ray, *t);
                bool left_first = left <= right;
                float later = left_first ? right : left;
                if (later < INFINITY) {
                    stack[depth] = left_first ? first + 1 : first;
                    entries[depth] = later;
                    ++depth;
                }
                node = left_first ? first : first + 1;
                entry = left_first ? left : right;
                continue;
            }
            for (uint i = first; i < first + count; ++i) {
                if (shape_hit(s, i, ray, *t, any, &t_shape, &shape_normal)) {
                    *t = t_shape;
                    *normal = shape_normal;
                    found = i;
                    if (any) return found;
                }
            }
        }
        if (depth == 0) {
            return found;
        }
        --depth;
        node = stack[depth];
        entry = entries[depth];
    }
}

// Fills in where the ray meets the shape `index` at `hit->t`; for metaballs, `hit->face` is there.
INLINE void describe_hit(const struct Surfaces *s, uint index, const struct Ray *ray, struct Hit *hit) {
    __global const struct Shape *shape = s->shapes + index;
    float3 point = ray->origin + hit->t * ray->direction;
    // Of the coordinates that its test computes with, besides the point's.
    float scale = 0.0f;
    // Whether the test itself has told the side, which the normal of a grazing hit may miss.
    bool known = false;
    switch (shape->kind) {
#ifdef SHAPE_PLANE
    case SURFACE_PLANE:
        hit->face = shape->b.xyz;
        point = plane_point(shape->b, point);
        break;
#endif
#ifdef SHAPE_SPHERE
    case SURFACE_SPHERE:
        point = sphere_point(shape->b, shape->c.xyz, point, &hit->face);
        known = true;
        hit->inside = sphere_height(ray->origin - shape->b.xyz, shape->c.xyz, shape->b.w) < 0.0f;
        scale = largest_component(shape->b.xyz);
        break;
#endif
#ifdef SHAPE_RECTANGLE
    case SURFACE_RECTANGLE:
        hit->face = shape->d.xyz;
        point = plane_point(shape->d, point);
        break;
#endif
#ifdef SHAPE_DISK
    case SURFACE_DISK:
        hit->face = shape->b.xyz;
        point = plane_point(shape->b, point);
        break;
#endif
#ifdef SHAPE_BOX
    case SURFACE_BOX:
        point = box_point(shape->a.xyz, shape->b.xyz, ray, point, &hit->face);
        break;
#endif
#ifdef SHAPE_METABALLS
    case SURFACE_METABALLS:
        scale = largest_component(max(fabs(shape->a.xyz), fabs(shape->b.xyz))) + largest_component(ray->origin);
        break;
#endif
#ifdef SHAPE_TRIANGLE
    case SURFACE_TRIANGLE:
        hit->face = shape->d.xyz;
        point = plane_point(shape->d, point);
        known = true;
        hit->inside = triangle_inside(shape->a.xyz, shape->b.xyz, shape->c.xyz, ray);
        scale = largest_component(max(max(fabs(shape->a.xyz), fabs(shape->b.xyz)), fabs(shape->c.xyz)));
        break;
#endif
    default:
        break;
    }
    float slope = dot(ray->direction, hit->face);
    if (!known) {
        hit->inside = slope > 0.0f;
    } else if (hit->inside != slope > 0.0f) {
        // Tilted by as little as turns it to the side of the ray.
        hit->face = normalize(hit->face - (slope - (hit->inside ? LEAST_SLOPE : -LEAST_SLOPE)) * ray->direction);
    }
    hit->normal = hit->face;
#ifdef SHAPE_SMOOTH
    if (shape->kind == SURFACE_TRIANGLE && shape->first != NO_NORMALS) {
        hit->normal = triangle_normal(shape->a.xyz, shape->b.xyz, shape->c.xyz, s->normals + shape->first, hit->face, ray);
    }
#endif
    hit->point = point;
    hit->margin = SURFACE_MARGIN * (largest_component(point) + scale);
    hit->surface = shape->surface;
}

// The nearest hit with 0 < t < t_max, if there is one.
INLINE bool surfaces_hit(const struct Surfaces *s, float3 origin, float3 direction, float t_max, struct Hit *hit) {
    struct Ray ray = ray_through(s->nodes, s->node_count, origin, direction);
    uint found = nearest_shape(s, &ray, t_max, false, &hit->t, &hit->face);
    if (found == NO_SHAPE) {
        return false;
    }
    describe_hit(s, found, &ray, hit);
    return true;
}

// Whether anything is hit with 0 < t < t_max.
INLINE bool surfaces_block(const struct Surfaces *s, float3 origin, float3 direction, float t_max) {
    struct Ray ray = ray_through(s->nodes, s->node_count, origin, direction);
    float t;
    float3 normal;
    return nearest_shape(s, &ray, t_max, true, &t, &normal) != NO_SHAPE;
}
