// Weights of photons by their distance t from a point, over the radius: KERNEL_CONSTANT, KERNEL_CONE or
// KERNEL_SMOOTHSTEP. Their sums are scaled so that the weight of a plane, or of space, is 1 (MapFrame.scale).
#include "caustics/batch.cl"

// The weight at distance t < 1, from t^2.
INLINE Batch kernel_weight(Batch t2) {
#ifdef KERNEL_CONSTANT
    return (Batch)(1.0f);
#elif defined(KERNEL_CONE)
    return 1.0f - sqrt(t2);
#else
    return 1.0f - t2 * (3.0f - 2.0f * sqrt(t2));
#endif
}
