// Unbiased estimates of the transmittance between two times of a ray, one ray at a time and per channel.
//
// TRANSMITTANCE_RESIDUAL: residual ratio tracking (Novák et al. 2014). In each brick a control between its bounds is
// integrated in closed form; only what the extinction deviates from it is tracked, with signed weights.
// TRANSMITTANCE_MARCHING: unbiased ray marching (Kettunen et al. 2021). Evenly spaced look-ups estimate the optical
// depth; a random number of such estimates, in a power series of their differences, gives its exponential.
// Otherwise: ratio tracking, or delta tracking below the threshold of shadow rays.
//
// Neither of the first two stays between 0 and 1, and nothing here clamps.
#include "common/numeric.cl"
#include "common/stream.cl"
#include "volume/tracking.cl"

#if defined(TRANSMITTANCE_RESIDUAL) || defined(TRANSMITTANCE_MARCHING)
#define ESTIMATED
#endif

// RayLanes as a table: origin, direction, inverse, ahead, by axis and lane.
typedef union {
    struct RayLanes all;
    float lane[12][WIDTH];
} RayTable;

// Numbers of a stream, one by one.
struct Numbers {
    struct Stream stream;
    uint4 block;
    uint used;
};

INLINE uint next_number(struct Numbers *numbers) {
    numbers->block = (numbers->used & 3u) == 0u ? stream_block(&numbers->stream) : numbers->block.yzwx;
    numbers->used += 1u;
    return numbers->block.x;
}

#if !defined(CONSTANT_SIGMA) && (defined(ESTIMATED) || defined(RECTANGLES) || defined(EQUIANGULAR) || defined(MEDIUM))

// One of RayLanes.
struct TrackedRay {
    float4 origin;
    float4 direction;
    float4 inverse;
    float4 ahead;
};

INLINE struct TrackedRay ray_of_lane(const RayTable *rays, int i) {
    struct TrackedRay ray;
    ray.origin = (float4)(rays->lane[0][i], rays->lane[1][i], rays->lane[2][i], 0.0f);
    ray.direction = (float4)(rays->lane[3][i], rays->lane[4][i], rays->lane[5][i], 0.0f);
    ray.inverse = (float4)(rays->lane[6][i], rays->lane[7][i], rays->lane[8][i], 0.0f);
    ray.ahead = (float4)(rays->lane[9][i], rays->lane[10][i], rays->lane[11][i], 0.0f);
    return ray;
}

// What an estimate costs, and look-ups outside the bounds of their bricks.
struct Cost {
    uint lookups;
    uint above;
};

// The extinction of the channels relative to sigma_t.
INLINE float4 channel_extinctions(const struct MediumTables *m) {
#ifdef CHROMATIC
    return m->method->extinction;
#else
    return (float4)(1.0f);
#endif
}

// A ray on its way from brick to brick.
struct BrickWalk {
    int4 brick;
    float4 exits;     // when each axis leaves the brick, or the cube of empty bricks
    float t;          // where the ray is
    float next;       // where it leaves
    float reach;      // half the cube's edge and a half, 1 for a brick
    BrickBound bound; // (0, 0) where there is no extinction
};

// Looks the walk's brick up; `end`: where the ray ends.
INLINE void walk_look(struct BrickWalk *walk, const struct MediumTables *m, const struct TrackedRay *ray, float end) {
    int4 stride = m->volume->bricks;
    BrickBound bound = m->bounds[walk->brick.x + walk->brick.y * stride.y + walk->brick.z * stride.z];
    bool empty = bound.x < 0.0f;
    walk->reach = empty ? -bound.x : 1.0f;
    walk->bound = empty ? (BrickBound)(0.0f) : bound;
    float4 plane = convert_float4(walk->brick) + 1.0f - walk->reach + ray->ahead * (2.0f * walk->reach - 1.0f);
    walk->exits = (plane * (float)(1 << stride.w) - ray->origin) * ray->inverse;
    walk->next = max(min(least3(walk->exits), end), walk->t);
}

// The brick at the walk's time: as seek_brick finds it.
INLINE void walk_seek(struct BrickWalk *walk, const struct MediumTables *m, const struct TrackedRay *ray) {
    float brick = (float)(1 << m->volume->bricks.w);
    float4 last = convert_float4(m->volume->brick_counts) - 1.0f;
    float4 zero = (float4)(0.0f);
    float4 position = max(ray->origin + walk->t * ray->direction, zero) * (1.0f / brick);
    float4 b = convert_float4(convert_int4(min(position, last)));
    float4 step = 2.0f * ray->ahead - 1.0f;
    b -= select(zero, step, ((b + 1.0f - ray->ahead) * brick - ray->origin) * ray->inverse > walk->t);
    b += select(zero, step, ((b + ray->ahead) * brick - ray->origin) * ray->inverse <= walk->t);
    walk->brick = convert_int4(clamp(b, zero, last));
}

INLINE struct BrickWalk walk_start(const struct MediumTables *m, const struct TrackedRay *ray, float from, float end) {
    struct BrickWalk walk;
    walk.t = from;
    walk_seek(&walk, m, ray);
    walk_look(&walk, m, ray, end);
    return walk;
}

// Goes on to the next brick; false at the end.
INLINE bool walk_on(struct BrickWalk *walk, const struct MediumTables *m, const struct TrackedRay *ray, float end) {
    if (walk->next >= end) {
        return false;
    }
    walk->t = walk->next;
    if (walk->reach > 1.0f) {
        walk_seek(walk, m, ray);
    } else {
        int4 step = convert_int4(2.0f * ray->ahead - 1.0f);
        walk->brick += (walk->exits <= walk->t) & step;
    }
    walk_look(walk, m, ray, end);
    return true;
}

// The extinction where the walk is at time t: inside its brick, so that the bounds hold.
INLINE float walk_sigma(const struct BrickWalk *walk, const struct MediumTables *m, const struct TrackedRay *ray,
    float t, struct Cost *cost) {
    float brick = (float)(1 << m->volume->bricks.w);
    float4 low = convert_float4(walk->brick) * brick;
    float4 point = clamp(ray->origin + t * ray->direction, low, low + brick);
#ifdef SIGMA_RAMP
    float value = window_value(m->volume, sample_raw(m->volume, m->voxels, point));
    value = clamp(value, 0.0f, (float)(m->frame->table_size - 1));
    float sigma = m->method->ramp_offset + m->method->ramp_slope * value;
#else
    float value, row;
    float sigma = sigma_at(m->frame, m->volume, m->voxels, m->sigmas, point, &value, &row);
#endif
    cost->lookups += 1u;
    cost->above += (sigma > walk->bound.x) | (sigma < walk->bound.y);
    return sigma;
}

#if defined(TRANSMITTANCE_RESIDUAL)

// The control lies a quarter of the way up from the minorant: where bricks are empty but for a corner, as at the edges of
// most things, the mean of the bounds makes estimates noisier than no control would.
#define CONTROL_PLACE 0.25f

// So much of the majorant is tracked at least: the control is rounded.
#define LEAST_RESIDUAL 0x1p-22f

float4 transmittance(const struct MediumTables *m, const struct TrackedRay *ray, float from, float end,
    struct Numbers *numbers, struct Cost *cost) {
    float4 extinction = channel_extinctions(m);
    float4 weight = (float4)(1.0f);
    float depth = exponential_float(next_number(numbers));
    struct BrickWalk walk = walk_start(m, ray, from, end);
    do {
        float span = walk.bound.x - walk.bound.y;
        float control = walk.bound.y + CONTROL_PLACE * span;
        float rate = ((1.0f - CONTROL_PLACE) * span + LEAST_RESIDUAL * walk.bound.x) * m->method->majorant_scale;
        float t = walk.t;
        float left = rate * (walk.next - t);
        while (depth < left) {
            float next = min(t + depth / rate, walk.next);
            // The control bit by bit: neither of the two factors over- or underflows without the other.
            weight *= exp(-extinction * (control * (next - t)));
            t = next;
            weight *= 1.0f - extinction * ((walk_sigma(&walk, m, ray, t, cost) - control) / rate);
            depth = exponential_float(next_number(numbers));
            left = rate * (walk.next - t);
        }
        depth -= left;
        weight *= exp(-extinction * (control * (walk.next - t)));
        if (!(fabs(weight.x) + fabs(weight.y) + fabs(weight.z) > 0.0f)) {
            return (float4)(0.0f);
        }
    } while (walk_on(&walk, m, ray, end));
    return weight;
}

#elif defined(TRANSMITTANCE_MARCHING)

// Longer series have a probability of 2e-15.
#define MOST_ORDER 20

#define PROBES 16

// The numbers of a vector's lanes.
INLINE Reals lane_numbers(void) {
    RealLanes number;
    for (int i = 0; i < WIDTH; ++i) {
        number.lane[i] = (float)i;
    }
    return number.all;
}

// How far the optical depth may be from what is known of it: the integral of majorant - minorant, by the bricks at a few
// places. It decides on costs alone.
INLINE float uncertainty(const struct MediumTables *m, const struct TrackedRay *ray, float from, float end) {
    float per_brick = 1.0f / (float)(1 << m->volume->bricks.w);
    int4 stride = m->volume->bricks;
    int4 last = m->volume->brick_counts - 1;
    float step = (end - from) * (1.0f / PROBES);
    Reals numbers = lane_numbers() + 0.5f;
    float sum = 0.0f;
    for (int j = 0; j < PROBES; j += WIDTH) {
        Reals t = from + step * ((float)j + numbers);
        Ints x = clamp(TO_INTS((ray->origin.x + t * ray->direction.x) * per_brick), (Ints)(0), (Ints)(last.x));
        Ints y = clamp(TO_INTS((ray->origin.y + t * ray->direction.y) * per_brick), (Ints)(0), (Ints)(last.y));
        Ints z = clamp(TO_INTS((ray->origin.z + t * ray->direction.z) * per_brick), (Ints)(0), (Ints)(last.z));
        IntLanes index = int_lanes(x + y * stride.y + z * stride.z);
        for (int i = 0; i < WIDTH; ++i) {
            BrickBound bound = m->bounds[index.lane[i]];
            sum += max(bound.x, 0.0f) - bound.y;
        }
    }
    return step * sum;
}

// An estimate of the optical depth by `count` evenly spaced look-ups.
INLINE float comb(const struct MediumTables *m, const struct TrackedRay *ray, float from, float end, int count, float u) {
    float step = (end - from) / (float)count;
    float sum = 0.0f;
#ifdef TF_2D
    for (int j = 0; j < count; ++j) {
        float value, row;
        float t = min(from + step * ((float)j + u), end);
        sum += sigma_at(m->frame, m->volume, m->voxels, m->sigmas, ray->origin + t * ray->direction, &value, &row);
    }
#else
    Reals numbers = lane_numbers() + u;
    Reals sums = (Reals)(0.0f);
    for (int j = 0; j < count; j += WIDTH) {
        Reals place = (float)j + numbers;
        Reals t = min(from + step * place, end);
        Reals value, row;
        struct Points points_at = points(ray->origin.x + t * ray->direction.x, ray->origin.y + t * ray->direction.y,
            ray->origin.z + t * ray->direction.z);
        Reals sigma = sigma_lanes(m, points_at, &value, &row);
        sums += PICK((Reals)(0.0f), sigma, place < (float)count);
    }
    sum = sum_lanes(sums);
#endif
    return step * sum;
}

float4 transmittance(const struct MediumTables *m, const struct TrackedRay *ray, float from, float end,
    struct Numbers *numbers, struct Cost *cost) {
    float spread = uncertainty(m, ray, from, end) * m->method->majorant_scale;
    // Kettunen's estimate of the look-ups that an optical depth of this uncertainty is worth, shared among 1.3195
    // estimates in the mean.
    float worth = ceil(cbrt((0.015f + spread) * (0.65f + spread) * (60.3f + spread)));
    int count = (int)clamp(round(worth / 1.3195f), 1.0f, 1e6f);
    // P(order >= k) = 0.1 2^(k-1) / k! from 1 on.
    int order = 0;
    if (uniform_float(next_number(numbers)) < 0.1f) {
        order = 2;
        while (order < MOST_ORDER && uniform_float(next_number(numbers)) * (float)(order + 1) < 2.0f) {
            order += 1;
        }
    }
    float depths[MOST_ORDER + 1];
    for (int i = 0; i <= order; ++i) {
        depths[i] = comb(m, ray, from, end, count, uniform_float(next_number(numbers)));
    }
    cost->lookups += (uint)(order + 1) * (uint)count;
    float4 extinction = channel_extinctions(m);
    float4 sum = (float4)(0.0f);
    for (int i = 0; i <= order; ++i) {
        // Elementary symmetric means of the differences from this estimate.
        float means[MOST_ORDER + 1];
        int n = 0;
        for (int j = 0; j <= order; ++j) {
            if (j == i) {
                continue;
            }
            n += 1;
            means[n] = 0.0f;
            for (int k = n; k > 0; --k) {
                float before = k > 1 ? means[k - 1] : 1.0f;
                means[k] += (float)k / (float)n * ((depths[i] - depths[j]) * before - means[k]);
            }
        }
        float4 series = (float4)(1.0f);
        float4 factor = (float4)(20.0f);
        for (int k = 1; k <= order; ++k) {
            factor *= 0.5f * extinction;
            series += factor * means[k];
        }
        float4 pivot = exp(-extinction * depths[i]);
        sum += pivot * select((float4)(0.0f), series, pivot > 0.0f);
    }
    return sum / (float)(order + 1);
}

#else

float4 transmittance(const struct MediumTables *m, const struct TrackedRay *ray, float from, float end,
    struct Numbers *numbers, struct Cost *cost) {
    float4 extinction = channel_extinctions(m);
    float4 left = (float4)(1.0f, 1.0f, 1.0f, 0.0f);
    float depth = exponential_float(next_number(numbers));
    struct BrickWalk walk = walk_start(m, ray, from, end);
    do {
        float rate = walk.bound.x * m->method->majorant_scale;
        float t = walk.t;
        float ahead = rate * (walk.next - t);
        while (depth < ahead) {
            t = min(t + depth / rate, walk.next);
            float4 part = left * extinction * (walk_sigma(&walk, m, ray, t, cost) / rate);
            float mean = left.x + left.y + left.z;
            float chance = (part.x + part.y + part.z) / mean;
            left -= part;
            if (mean <= 3.0f * m->method->shadow_threshold) {
                if (uniform_float(next_number(numbers)) < chance) {
                    return (float4)(0.0f);
                }
                left /= 1.0f - chance;
            }
            if (!(left.x + left.y + left.z > 0.0f)) {
                return (float4)(0.0f);
            }
            depth = exponential_float(next_number(numbers));
            ahead = rate * (walk.next - t);
        }
        depth -= ahead;
    } while (walk_on(&walk, m, ray, end));
    return left;
}

#endif

#endif
