//! Owen-scrambled, shuffled Sobol points (Burley 2020), bit for bit as the kernels make them.

/// Degree, coefficients and initial numbers of the primitive polynomials of dimensions 1 to 3 (Joe and Kuo 2008,
/// `new-joe-kuo-6.21201`); dimension 0 is van der Corput's sequence.
const POLYNOMIALS: [(usize, u32, [u32; 3]); 3] = [(1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1])];

/// The direction numbers of a dimension, by the recurrence of Bratley and Fox.
pub fn directions(dimension: usize) -> [u32; 32] {
    let mut v = [0_u32; 32];
    if dimension == 0 {
        return std::array::from_fn(|i| 1 << (31 - i));
    }
    let (degree, coefficients, initial) = POLYNOMIALS[dimension - 1];
    for i in 0..32 {
        v[i] = if i < degree {
            initial[i] << (31 - i)
        } else {
            let inner = (1..degree).filter(|k| coefficients >> (degree - 1 - k) & 1 == 1);
            inner.fold(v[i - degree] ^ (v[i - degree] >> degree), |x, k| x ^ v[i - k])
        };
    }
    v
}

/// The point of an index in one dimension, as a fraction of 2³².
pub fn sobol(index: u32, dimension: usize) -> u32 {
    let v = directions(dimension);
    (0..32).filter(|bit| index >> bit & 1 == 1).fold(0, |x, bit| x ^ v[bit])
}

/// Burley's hash-based Owen scrambling: a nested uniform permutation of the bits from the most significant down.
pub fn scramble(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits().wrapping_add(seed);
    for factor in [0x6c50_b47c_u32, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6] {
        x ^= x.wrapping_mul(factor);
    }
    x.reverse_bits()
}

/// The place of a sample in the sequence: shuffled as by [`scramble`], without the constant that it puts into the bits
/// that a sample below 64 does not have.
pub fn place(sample: u32, key: u32) -> u32 {
    scramble(sample, key) ^ (scramble(0, key) & !63)
}

/// Keys of the second sequence (dimensions 4 to 7): the hash lowbias32 of each word (Wellons 2018).
pub fn second_keys(keys: [u32; 4]) -> [u32; 4] {
    keys.map(|word| {
        let x = word.wrapping_add(0x9e37_79b9);
        let x = (x ^ x >> 16).wrapping_mul(0x7feb_352d);
        let x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
        x ^ x >> 16
    })
}

/// The words of a sample in dimensions `first` and `first` + 1 (0, 2, 4 or 6), for a sequence with these keys.
pub fn pair(sample: u32, keys: [u32; 4], first: usize) -> [u32; 2] {
    let keys = if first < 4 { keys } else { second_keys(keys) };
    let first = first % 4;
    let index = place(sample, keys[3]);
    let key = keys[first / 2];
    [scramble(sobol(index, first), key), scramble(sobol(index, first + 1), key ^ keys[2])]
}

#[cfg(test)]
mod tests {
    use super::super::random::philox4x32;
    use super::*;

    #[test]
    fn the_first_points_are_the_published_ones() {
        // As Joe and Kuo list them, in Gray code order, times 2³.
        for (n, point) in [(1, [4, 4, 4, 4]), (2, [6, 2, 2, 2]), (3, [2, 6, 6, 6]), (4, [3, 3, 5, 7])] {
            assert_eq!([0, 1, 2, 3].map(|dimension| sobol(n ^ (n >> 1), dimension) >> 29), point);
        }
    }

    #[test]
    fn scrambled_pixels_keep_one_point_in_every_elementary_interval() {
        for pixel in 0..8 {
            let keys = philox4x32([pixel, 0, 0, 0], [1, 0]);
            let points: Vec<_> =
                (0..256).map(|sample| pair(sample, keys, 4 * (pixel as usize % 2))).collect();
            for split in 0..=8 {
                let mut seen = [false; 256];
                for [x, y] in &points {
                    let (x, y) = (u64::from(*x) >> (32 - split), u64::from(*y) >> (24 + split));
                    let cell = (x << (8 - split) | y) as usize;
                    assert!(!seen[cell], "pixel {pixel}, split {split}");
                    seen[cell] = true;
                }
            }
        }
    }

    #[test]
    fn every_dimension_is_stratified() {
        let keys = philox4x32([3, 0, 0, 0], [7, 9]);
        for first in [0, 2, 4, 6] {
            for which in 0..2 {
                let mut strata: Vec<_> = (0..1024).map(|s| pair(s, keys, first)[which] >> 22).collect();
                strata.sort_unstable();
                assert_eq!(strata, (0..1024).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn samples_below_a_power_of_two_keep_to_themselves() {
        for key in 0..20_u32 {
            let key = key.wrapping_mul(0x9e37_79b9);
            for count in [64, 128, 1024] {
                let mut places: Vec<_> = (0..count).map(|sample| place(sample, key)).collect();
                places.sort_unstable();
                assert_eq!(places, (0..count).collect::<Vec<_>>());
            }
        }
    }

    #[test]
    fn the_two_sequences_are_independent() {
        // Over keys, the strata of one sample in dimensions 0 and 4 fill a 16 x 16 table evenly.
        const KEYS: u32 = 1 << 16;
        for (a, b) in [((0, 0), (4, 0)), ((0, 1), (4, 1)), ((2, 0), (6, 0)), ((0, 0), (6, 1))] {
            let mut table = [0_u32; 256];
            for n in 0..KEYS {
                let keys = philox4x32([n, 0, 0, 0], [5, 0]);
                let stratum = |(first, which): (usize, usize)| pair(n % 64, keys, first)[which] >> 28;
                table[(stratum(a) << 4 | stratum(b)) as usize] += 1;
            }
            let expected = f64::from(KEYS) / 256.0;
            let chi_square: f64 = table.iter().map(|n| (f64::from(*n) - expected).powi(2) / expected).sum();
            // 255 degrees of freedom: mean 255, sigma = sqrt(2 * 255); k = 5.
            assert!((chi_square - 255.0).abs() < 5.0 * f64::sqrt(2.0 * 255.0), "{a:?} {b:?}: {chi_square}");
        }
    }
}
