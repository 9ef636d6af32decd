// Directions of photons that stay packed (see common/octahedron.cl).
#include "caustics/batch.cl"

// Whether photons travel against a normal: of their directions any length will do.
INLINE BatchMask travel_against(BatchWords packed, float3 normal) {
    Batch x = BATCH_REALS(packed & 0xffffu) - 32768.0f;
    Batch y = BATCH_REALS(packed >> 16) - 32768.0f;
    Batch z = 32767.0f - fabs(x) - fabs(y);
    Batch fold = max(-z, (Batch)(0.0f));
    x += BATCH_PICK(-fold, fold, x < 0.0f);
    y += BATCH_PICK(-fold, fold, y < 0.0f);
    return x * normal.x + y * normal.y + z * normal.z < 0.0f;
}
