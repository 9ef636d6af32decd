// The camera, in local units: the box's low corner is the origin, the smallest voxel spacing is 1.
//
// A ray is given by its point at a reference depth near the volume and by its direction, not by the eye:
// a far eye would cost the float32 ray its precision (field of view of a telescope, scene far from its camera).
struct Camera {
    float4 base;     // point of the central ray at the reference depth
    float4 base_u;   // change of that point over half the image's width
    float4 base_v;   // ... and half its height
    float4 dir;      // direction per unit of view depth, central ray
    float4 dir_u;
    float4 dir_v;
    float4 lens_u;   // lens radius times the unit vectors of the image plane
    float4 lens_v;
    float depth;     // the reference depth, >= 0
    float inv_focus; // 1 / focus distance
    uint width;      // pixels
    uint height;
};
