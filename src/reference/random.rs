//! Philox4x32-7 and Philox2x32-7, the counter-based generators of the kernels (Salmon et al. 2011).

/// Four random words of a counter and a key.
pub fn philox4x32(counter: [u32; 4], key: [u32; 2]) -> [u32; 4] {
    let [mut a, mut b, mut c, mut d] = counter;
    let [mut k0, mut k1] = key;
    for _ in 0..7 {
        let first = u64::from(a) * 0xD251_1F53;
        let second = u64::from(c) * 0xCD9E_8D57;
        (a, b, c, d) =
            ((second >> 32) as u32 ^ b ^ k0, second as u32, (first >> 32) as u32 ^ d ^ k1, first as u32);
        k0 = k0.wrapping_add(0x9E37_79B9);
        k1 = k1.wrapping_add(0xBB67_AE85);
    }
    [a, b, c, d]
}

/// Two random words of a counter and a key.
pub fn philox2x32(counter: [u32; 2], key: u32) -> [u32; 2] {
    let ([mut a, mut b], mut key) = (counter, key);
    for _ in 0..7 {
        let product = u64::from(a) * 0xD256_D193;
        (a, b) = ((product >> 32) as u32 ^ key ^ b, product as u32);
        key = key.wrapping_add(0x9E37_79B9);
    }
    [a, b]
}

/// The 24 high bits as a number in [0, 1).
pub fn uniform(word: u32) -> f64 {
    f64::from(word >> 8) / f64::from(1 << 24)
}

/// −ln w of w = (word + 1) 2⁻³²: exponentially distributed, with mean 1.
pub fn exponential(word: u32) -> f64 {
    -(-f64::from(!word) / 2f64.powi(32)).ln_1p()
}

/// Block `block` of the random words of a path.
pub fn path_block(seed: [u32; 2], pixel: u32, sample: u32, path: u32, block: u32) -> [u32; 4] {
    const PURPOSE: u32 = 2;
    philox4x32([pixel, sample, block, path << 8 | PURPOSE], seed)
}

/// Known answers from Random123's `kat_vectors`: counter, key, output.
pub const KNOWN_ANSWERS: [([u32; 4], [u32; 2], [u32; 4]); 3] = [
    ([0; 4], [0; 2], [0x5f6f_b709, 0x0d89_3f64, 0x4f12_1f81, 0x4f73_0a48]),
    ([u32::MAX; 4], [u32::MAX; 2], [0x5207_ddc2, 0x4516_5e59, 0x4d8e_e751, 0x8c52_f662]),
    (
        [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
        [0xa409_3822, 0x299f_31d0],
        [0x4dfc_caba, 0x190a_87f0, 0xc473_62ba, 0xb6b5_242a],
    ),
];

/// The same of the generator with two words.
pub const KNOWN_ANSWERS_2X32: [([u32; 2], u32, [u32; 2]); 3] = [
    ([0; 2], 0, [0x257a_3673, 0xcd26_be2a]),
    ([u32::MAX; 2], u32::MAX, [0xab30_2c4d, 0x3dc9_d239]),
    ([0x243f_6a88, 0x85a3_08d3], 0x1319_8a2e, [0xbedb_be6b, 0xe4c7_70b3]),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_answers() {
        for (counter, key, output) in KNOWN_ANSWERS {
            assert_eq!(philox4x32(counter, key), output);
        }
        for (counter, key, output) in KNOWN_ANSWERS_2X32 {
            assert_eq!(philox2x32(counter, key), output);
        }
    }

    #[test]
    fn uniform_numbers_never_reach_one() {
        assert_eq!((uniform(0), uniform(255)), (0.0, 0.0));
        assert_eq!(uniform(u32::MAX), 1.0 - 2f64.powi(-24));
    }

    #[test]
    fn exponential_numbers_reach_from_0_to_32_ln_2() {
        assert_eq!(exponential(u32::MAX), 0.0);
        assert!((exponential(0) - 32.0 * std::f64::consts::LN_2).abs() < 1e-14);
        assert!((exponential(u32::MAX - 1) * 2f64.powi(32) - 1.0).abs() < 1e-9);
        assert_eq!(exponential((1 << 31) - 1), std::f64::consts::LN_2);
    }
}
