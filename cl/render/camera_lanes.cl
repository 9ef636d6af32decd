// Camera rays of many paths at once: the rays of camera.cl.
#include "common/directions.cl"
#include "types/camera.cl"

// Points of the unit disk, area-preserving (Shirley and Chiu 1997).
INLINE void concentric_disks(Reals u, Reals v, Reals *x, Reals *y) {
    Reals a = 2.0f * u - 1.0f;
    Reals b = 2.0f * v - 1.0f;
    Ints wide = fabs(a) > fabs(b);
    Reals radius = PICK(b, a, wide);
    Reals ratio = PICK(a, b, wide) / PICK((Reals)(1.0f), radius, radius != 0.0f);
    // Eighths of a turn from the x or the y axis.
    Reals turns = PICK(0.25f - 0.125f * ratio, 0.125f * ratio, wide);
    Reals cosine, sine;
    unit_circle(turns - floor(turns), &cosine, &sine);
    *x = radius * cosine;
    *y = radius * sine;
}

// Rays through points of pixels (0 to 1 across each) and of the lens, in local units, and the times at which they leave
// the eye.
INLINE void camera_rays(__constant struct Camera *camera, Words pixel, Reals across, Reals down, Reals lens_u,
    Reals lens_v, struct Points *origin, struct Points *direction, Reals *from) {
    Words row = pixel / camera->width;
    Reals column = TO_REALS(AS_INTS(pixel - row * camera->width));
    Reals x = 2.0f * (column + across) / (float)camera->width - 1.0f;
    Reals y = 1.0f - 2.0f * (TO_REALS(AS_INTS(row)) + down) / (float)camera->height;
    struct Points p = points(camera->base.x + x * camera->base_u.x + y * camera->base_v.x,
        camera->base.y + x * camera->base_u.y + y * camera->base_v.y,
        camera->base.z + x * camera->base_u.z + y * camera->base_v.z);
    struct Points d = points(camera->dir.x + x * camera->dir_u.x + y * camera->dir_v.x,
        camera->dir.y + x * camera->dir_u.y + y * camera->dir_v.y,
        camera->dir.z + x * camera->dir_u.z + y * camera->dir_v.z);
#ifdef THIN_LENS
    // The lens moves the eye; rays still meet at the focus distance.
    Reals u, v;
    concentric_disks(lens_u, lens_v, &u, &v);
    float moved = 1.0f - camera->depth * camera->inv_focus;
    struct Points lens = points(u * camera->lens_u.x + v * camera->lens_v.x, u * camera->lens_u.y + v * camera->lens_v.y,
        u * camera->lens_u.z + v * camera->lens_v.z);
    p = points(p.x + moved * lens.x, p.y + moved * lens.y, p.z + moved * lens.z);
    d = points(d.x - camera->inv_focus * lens.x, d.y - camera->inv_focus * lens.y, d.z - camera->inv_focus * lens.z);
#endif
    Reals per_depth = sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
    *origin = p;
    *direction = points(d.x / per_depth, d.y / per_depth, d.z / per_depth);
    *from = -camera->depth * per_depth;
}
