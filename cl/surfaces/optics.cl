// Reflection and refraction at a smooth boundary.
//
// A body has the index `index` relative to its surroundings. Cosines are |direction . normal|; that outside the body, p,
// and that inside, c, are linked by n^2 c^2 = p^2 + k with k = (n - 1) (n + 1), Snell's law, and every difference is
// written through k. So nothing cancels: not at grazing angles, and not for indices near 1.
#include "common/inline.cl"

// What a boundary does to a ray.
struct Boundary {
    float reflectance; // of unpolarised light (Fresnel); 1 where it is totally reflected
    float scale;       // what passes goes along scale * direction + shift * facing, where `facing` is the unit normal
    float shift;       // on the ray's side; both 0 where nothing passes
};

// Index at a wavelength in micrometres by Cauchy's equation.
INLINE float index_at(float4 cauchy, float wavelength) {
    float w = 1.0f / (wavelength * wavelength);
    return cauchy.x + w * (cauchy.y + w * cauchy.z);
}

// `inside`: the ray comes from inside the body; `cosine`: of its angle to the normal, >= 0.
INLINE struct Boundary boundary(float index, bool inside, float cosine) {
    struct Boundary result = {1.0f, 0.0f, 0.0f};
    float k = (index - 1.0f) * (index + 1.0f);
    float outer = cosine; // p
    float inner = index * cosine; // n c
    float square = inside ? inner * inner - k : outer * outer + k;
    if (!(square >= 0.0f)) {
        return result;
    }
    outer = inside ? sqrt(square) : outer;
    inner = inside ? inner : sqrt(square);
    // Above 0 even where the ray grazes a body of index 1.
    float sum = max(outer + inner, 1e-20f);
    float turn = k / sum; // n c - p
    // Amplitudes across and along the plane of incidence: (p - n c) / (p + n c) and (n p - c) / (n p + c).
    float across = turn / sum;
    float along = turn * (outer * sum - 1.0f) / max((1.0f + k) * outer + inner, 1e-20f);
    result.reflectance = min(0.5f * (across * across + along * along), 1.0f);
    result.scale = inside ? index : 1.0f / index;
    result.shift = inside ? turn : -turn / index;
    return result;
}

// The unit direction of what passes, for a unit direction and normal; the ray must not be totally reflected.
INLINE float3 refracted(struct Boundary boundary, float3 direction, float3 facing) {
    float3 passed = boundary.scale * direction + boundary.shift * facing;
    return passed * rsqrt(dot(passed, passed));
}

// The unit direction of what is reflected.
INLINE float3 mirrored(float3 direction, float3 normal) {
    float3 back = direction - 2.0f * dot(direction, normal) * normal;
    return back * rsqrt(dot(back, back));
}
