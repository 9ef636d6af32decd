//! Auxiliary images of scattering methods, for denoisers: what camera rays meet first.

use super::state::Part;
use crate::device_struct;
use crate::film::{Double, halves, joined, single};
use crate::picture::{Picture, Samples};

device_struct! {
    "types/path.cl",
    /// Auxiliary images of a pixel; see `cl/types/path.cl`.
    pub struct Auxiliary {
        /// Albedo of the first collision times the share of the camera ray that collides.
        pub albedo: [f32; 4],
        /// Normal at the first collision, times the same.
        pub normal: [f32; 4],
        /// Transmittance of the camera ray.
        pub transmittance: f32,
        /// The share that collides.
        pub taken: f32,
        /// Distance of the first collision from the eye, local units, times the same.
        pub depth: f32,
        /// Padding.
        pub pad_0: u32,
    }
}

device_struct! {
    "no kernel has it",
    /// What the floats of an [`Auxiliary`] cannot hold of several films together: float64, low and high halves of their
    /// bits, by fours of its words.
    pub struct AuxiliaryRest {
        /// Of the albedo.
        pub albedo_low: [u32; 4],
        /// High half.
        pub albedo_high: [u32; 4],
        /// Of the normal.
        pub normal_low: [u32; 4],
        /// High half.
        pub normal_high: [u32; 4],
        /// Of the transmittance, the share that collides and the distance.
        pub shares_low: [u32; 4],
        /// High half.
        pub shares_high: [u32; 4],
    }
}

/// The words of the normal.
const NORMAL: std::ops::Range<usize> = 4..8;

/// The means of several films together.
pub(super) type AuxiliaryMeans = [Double; 12];

/// Those of one film.
pub(super) fn means(pixel: &Auxiliary, rest: &AuxiliaryRest) -> AuxiliaryMeans {
    let words: [u32; 12] = bytemuck::cast(*pixel);
    let rest: [[u32; 4]; 6] = bytemuck::cast(*rest);
    // The last word is padding, and zero.
    std::array::from_fn(|k| {
        let (low, high) = (rest[k / 4 * 2][k % 4], rest[k / 4 * 2 + 1][k % 4]);
        Double::from(f64::from(f32::from_bits(words[k]))) + Double::from(joined(low, high))
    })
}

/// As a film keeps them, and what it cannot hold.
pub(super) fn of_means(means: &AuxiliaryMeans) -> (Auxiliary, AuxiliaryRest) {
    let mut words = [0_u32; 12];
    let mut rest = [[0_u32; 4]; 6];
    for (k, &mean) in means.iter().enumerate() {
        // Normals may cancel.
        let scale = if NORMAL.contains(&k) { 1.0 } else { mean.value().abs() };
        let (float, more) = single(mean, scale);
        words[k] = float.to_bits();
        (rest[k / 4 * 2][k % 4], rest[k / 4 * 2 + 1][k % 4]) = halves(more);
    }
    (bytemuck::cast(words), bytemuck::cast(rest))
}

/// What the header says of the channels.
pub(super) const MEANING: &str = "albedo.* and normal.* are those of camera rays' first collisions times the share \
    of the rays that collide; Z is the collisions' mean distance to the camera in scene units, 0 where there are none; \
    transmittance is that of the camera rays";

/// Adds the channels. `unit`: scene units per local unit.
pub(super) fn add_channels(picture: &mut Picture, pixels: &[Auxiliary], unit: f64) {
    let mut add = |name: String, value: &dyn Fn(&Auxiliary) -> f32| {
        let data = Samples::F32(pixels.iter().map(value).collect());
        picture.channels.push(crate::picture::Channel { name, data });
    };
    for c in 0..3 {
        add(format!("albedo.{}", ["R", "G", "B"][c]), &|pixel| pixel.albedo[c]);
        add(format!("normal.{}", ["X", "Y", "Z"][c]), &|pixel| pixel.normal[c]);
    }
    add("transmittance".into(), &|pixel| pixel.transmittance);
    add("Z".into(), &|pixel| {
        if pixel.taken > 0.0 { (f64::from(pixel.depth) / f64::from(pixel.taken) * unit) as f32 } else { 0.0 }
    });
}

/// What the image's channels say of a word of [`Auxiliary`].
pub(super) fn predict(picture: &Picture, word: &str, unit: f64) -> Option<Vec<u32>> {
    let floats = |name: &str| match picture.channel(name) {
        Some(Samples::F32(values)) => Some(values),
        _ => None,
    };
    let bits = |name: &str| Some(floats(name)?.iter().map(|value| value.to_bits()).collect());
    match word {
        "albedo.R" | "albedo.G" | "albedo.B" | "transmittance" => bits(word),
        // The planes of a vector are R, G and B.
        "normal.R" => bits("normal.X"),
        "normal.G" => bits("normal.Y"),
        "normal.B" => bits("normal.Z"),
        // These are within a few units in the last place.
        "taken" => bits("A"),
        "depth" => {
            let product = |(&z, &a): (&f32, &f32)| ((f64::from(z) / unit * f64::from(a)) as f32).to_bits();
            Some(floats("Z")?.iter().zip(floats("A")?).map(product).collect())
        }
        _ => None,
    }
}

/// The part of the state that keeps them.
pub(super) fn part<'a>(predict: super::state::Predict<'a>) -> Part<'a> {
    Part { prefix: "state.auxiliary.", layout: Auxiliary::LAYOUT, predict }
}
