//! Named colour maps.
//!
//! The perceptual maps are stored as every 17th of the 256 colours of their published tables: viridis,
//! inferno, magma and plasma by Smith, van der Walt and Firing (matplotlib, CC0), turbo by Mikhailov
//! (Google, Apache-2.0), coolwarm by Moreland (2009, as in matplotlib). Between them the sRGB-encoded
//! components are interpolated linearly, which departs from the full table by at most 0.032 (8/255), for
//! coolwarm near its middle.

use crate::config::formats::{srgb_code_to_linear, srgb_to_linear};
use crate::scene::ColorMap;

use super::lerp;

const VIRIDIS: [u32; 16] = [
    0x440154, 0x481a6c, 0x472f7d, 0x414487, 0x39568c, 0x31688e, 0x2a788e, 0x23888e, 0x1f988b, 0x22a884,
    0x35b779, 0x54c568, 0x7ad151, 0xa5db36, 0xd2e21b, 0xfde725,
];
const INFERNO: [u32; 16] = [
    0x000004, 0x0c0826, 0x240c4f, 0x420a68, 0x5d126e, 0x781c6d, 0x932667, 0xae305c, 0xc73e4c, 0xdd513a,
    0xed6925, 0xf8850f, 0xfca50a, 0xfac62d, 0xf2e661, 0xfcffa4,
];
const MAGMA: [u32; 16] = [
    0x000004, 0x0b0924, 0x20114b, 0x3b0f70, 0x57157e, 0x721f81, 0x8c2981, 0xa8327d, 0xc43c75, 0xde4968,
    0xf1605d, 0xfa7f5e, 0xfe9f6d, 0xfebf84, 0xfddea0, 0xfcfdbf,
];
const PLASMA: [u32; 16] = [
    0x0d0887, 0x330597, 0x5002a2, 0x6a00a8, 0x8405a7, 0x9c179e, 0xb12a90, 0xc33d80, 0xd35171, 0xe16462,
    0xed7953, 0xf68f44, 0xfca636, 0xfec029, 0xf9dc24, 0xf0f921,
];
const TURBO: [u32; 16] = [
    0x30123b, 0x4143a7, 0x4771e9, 0x3e9bfe, 0x22c5e2, 0x1ae4b6, 0x46f884, 0x88ff4e, 0xb9f635, 0xe1dd37,
    0xfaba39, 0xfd8d27, 0xf05b12, 0xd63506, 0xaf1801, 0x7a0403,
];
const COOLWARM: [u32; 16] = [
    0x3b4cc0, 0x4f69d9, 0x6485ec, 0x7b9ff9, 0x93b5fe, 0xaac7fd, 0xc0d4f5, 0xd4dbe6, 0xe5d8d1, 0xf2cbb7,
    0xf7b89c, 0xf5a081, 0xee8468, 0xe0654f, 0xcc403a, 0xb40426,
];
/// Ours: air black, soft tissue red to pink, bone ivory.
const CT: [u32; 9] =
    [0x000000, 0x2b0f0d, 0x5e2318, 0x8f3f2b, 0xb8654a, 0xd49475, 0xe6c09c, 0xf3e3c8, 0xfffdf5];

/// The colour of a map at `x` (clamped to 0..=1; not a number counts as 0), linear sRGB in 0..=1.
pub fn map_color(map: ColorMap, x: f64) -> [f64; 3] {
    let x = if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) };
    match map {
        ColorMap::Grey => [x; 3],
        ColorMap::Hot => hot(x).map(srgb_to_linear),
        ColorMap::Bone => bone(x).map(srgb_to_linear),
        ColorMap::Viridis => interpolate(&VIRIDIS, x),
        ColorMap::Inferno => interpolate(&INFERNO, x),
        ColorMap::Magma => interpolate(&MAGMA, x),
        ColorMap::Plasma => interpolate(&PLASMA, x),
        ColorMap::Turbo => interpolate(&TURBO, x),
        ColorMap::Coolwarm => interpolate(&COOLWARM, x),
        ColorMap::Ct => interpolate(&CT, x),
    }
}

/// Equidistant sRGB codes, interpolated in sRGB.
fn interpolate(codes: &[u32], x: f64) -> [f64; 3] {
    let position = x * (codes.len() - 1) as f64;
    let index = (position as usize).min(codes.len() - 2);
    let t = position - index as f64;
    if t == 0.0 {
        return srgb_code_to_linear(codes[index]);
    }
    lerp(encoded(codes[index]), encoded(codes[index + 1]), t).map(srgb_to_linear)
}

fn encoded(code: u32) -> [f64; 3] {
    [16, 8, 0].map(|shift| f64::from((code >> shift) & 0xff) / 255.0)
}

/// Red rises over the first 3/8, green over the next, blue over the last quarter.
fn hot(x: f64) -> [f64; 3] {
    [8.0 / 3.0 * x, 8.0 / 3.0 * x - 1.0, 4.0 * x - 3.0].map(|c| c.clamp(0.0, 1.0))
}

/// Seven parts grey and one part `hot` with red and blue exchanged.
fn bone(x: f64) -> [f64; 3] {
    let [r, g, b] = hot(x);
    [b, g, r].map(|c| (7.0 * x + c) / 8.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [ColorMap; 10] = [
        ColorMap::Grey,
        ColorMap::Hot,
        ColorMap::Viridis,
        ColorMap::Inferno,
        ColorMap::Magma,
        ColorMap::Plasma,
        ColorMap::Turbo,
        ColorMap::Coolwarm,
        ColorMap::Bone,
        ColorMap::Ct,
    ];

    #[test]
    fn ends_are_the_published_colours() {
        assert_eq!(map_color(ColorMap::Viridis, 0.0), srgb_code_to_linear(0x440154));
        assert_eq!(map_color(ColorMap::Viridis, 1.0), srgb_code_to_linear(0xfde725));
        assert_eq!(map_color(ColorMap::Turbo, 0.0), srgb_code_to_linear(0x30123b));
        assert_eq!(map_color(ColorMap::Coolwarm, 1.0), srgb_code_to_linear(0xb40426));
    }

    /// Entries 128 (from 0) of matplotlib's tables, to the accuracy that the module promises.
    #[test]
    fn middles_are_close_to_the_published_colours() {
        let cases = [
            (ColorMap::Viridis, [0.127568, 0.566949, 0.550556]),
            (ColorMap::Inferno, [0.735683, 0.215906, 0.330245]),
            (ColorMap::Magma, [0.716387, 0.214982, 0.475290]),
            (ColorMap::Plasma, [0.798216, 0.280197, 0.469538]),
        ];
        for (map, published) in cases {
            let got = map_color(map, 128.0 / 255.0);
            for (got, published) in got.iter().zip(published) {
                assert!((got - srgb_to_linear(published)).abs() < 0.03, "{map:?}: {got}");
            }
        }
    }

    #[test]
    fn formulas() {
        assert_eq!(hot(3.0 / 8.0), [1.0, 0.0, 0.0]);
        assert_eq!(hot(0.75), [1.0, 1.0, 0.0]);
        assert_eq!(hot(1.0), [1.0, 1.0, 1.0]);
        assert_eq!(bone(0.0), [0.0; 3]);
        assert_eq!(bone(1.0), [1.0; 3]);
        assert_eq!(map_color(ColorMap::Grey, 0.25), [0.25; 3]);
    }

    #[test]
    fn every_map_stays_in_range_whatever_it_is_asked() {
        let asked = (0..=1000).map(|k| f64::from(k) / 1000.0);
        for x in asked.chain([-1.0, 2.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY]) {
            for map in ALL {
                let color = map_color(map, x);
                assert!(color.iter().all(|c| (0.0..=1.0).contains(c)), "{map:?} at {x}: {color:?}");
            }
        }
    }
}
