// Marks of photons: on which surface they lie, on which side, and which way it faces there. Photons on the other side of a
// thin shell, or past a sharp edge, are not those of a place.
//
// Normals take 12 bits: the octahedron of common/octahedron.cl, 63 steps along each side of the square. The axes are exact.
#include "caustics/batch.cl"
#include "types/photon.cl"

#define MARK_STEPS 31.0f

// Photons count where the surface turned by less than 65 degrees on the way to them, and not where it did by more than 76:
// a twelfth of a turn and more is left to curved surfaces, right angles are edges. Of normals as long as MARK_STEPS in the
// sum of their components.
#define MARK_ALIKE (0.25f * MARK_STEPS)

// `facing`: the normal on the side that the photon came from.
INLINE uint mark_of(uint surface, bool inside, float3 facing) {
    float2 p = facing.xy / (fabs(facing.x) + fabs(facing.y) + fabs(facing.z));
    float2 folded = 1.0f - fabs(p.yx);
    folded = select(folded, -folded, p < 0.0f);
    p = facing.z < 0.0f ? folded : p;
    float2 steps = floor(MARK_STEPS * p + 0.5f) + 32.0f;
    uint normal = (uint)steps.x | (uint)steps.y << 6;
    return normal << MARK_NORMAL | (inside ? MARK_INSIDE : 0u) | (surface + 1u);
}

INLINE uint marked_surface(uint mark) {
    return (mark & MARK_SURFACE) - 1u;
}

// Whether surfaces face the same way as `normal`.
INLINE BatchMask faces_alike(BatchWords marks, float3 normal) {
    Batch x = BATCH_REALS((marks >> MARK_NORMAL) & 63u) - 32.0f;
    Batch y = BATCH_REALS((marks >> (MARK_NORMAL + 6)) & 63u) - 32.0f;
    Batch z = MARK_STEPS - fabs(x) - fabs(y);
    Batch fold = max(-z, (Batch)(0.0f));
    x += BATCH_PICK(-fold, fold, x < 0.0f);
    y += BATCH_PICK(-fold, fold, y < 0.0f);
    return x * normal.x + y * normal.y + z * normal.z > MARK_ALIKE;
}
