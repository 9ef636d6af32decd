//! The exact state of a film as channels of its image, from which a later run continues bit for bit.
//!
//! Every word (32 bits) of a per-pixel device struct is one plane. What other channels say already is stored as the
//! distance from it, in bits: the high part of the mean is `R G B A` itself, so its plane is zero everywhere and is
//! left out; the second moment is within a few units in the last place of what `variance.*` says, and shrinks to
//! next to nothing. No prediction has to be right for the film to come back whole, NaNs included. Planes are unsigned
//! integers, which no reader rounds.

use super::fingerprint::Fingerprint;
use crate::device::layout::StructLayout;
use crate::film::FilmPixel;
use crate::picture::{Channel, Picture, Samples};
use bytemuck::Pod;
use rayon::prelude::*;
use std::borrow::Cow;

/// Number of the format, as `svetlo.state` in the header: the planes, their predictions and the order of the tiles.
pub(super) const FORMAT: u32 = 1;

/// The bits that a plane should hold, told from the other channels; `None` without a prediction.
pub(super) type Predict<'a> = &'a (dyn Fn(&Picture, &str) -> Option<Vec<u32>> + Sync);

/// A per-pixel struct of the film, and how its planes are called and predicted.
pub(super) struct Part<'a> {
    /// Starts the names of the planes.
    pub prefix: &'static str,
    /// The struct.
    pub layout: StructLayout,
    /// What other channels say of its words, by the name of the word (`m2.R`).
    pub predict: Predict<'a>,
}

/// Adds the planes of `pixels` to a picture that has all other channels.
pub(super) fn add_planes<T: Pod + Sync>(
    picture: &mut Picture,
    part: &Part<'_>,
    pixels: &[T],
    sum: &mut Fingerprint,
) {
    let words: &[u32] = bytemuck::cast_slice(pixels);
    let per_pixel = size_of::<T>() / 4;
    let planes: Vec<Channel> = words_of(&part.layout)
        .into_iter()
        .filter_map(|(name, at)| {
            let mut plane: Vec<u32> =
                words.par_chunks_exact(per_pixel.max(1)).map(|pixel| pixel[at]).collect();
            sum.add(&name, bytemuck::cast_slice(&plane));
            if let Some(predicted) = (part.predict)(picture, &name) {
                plane
                    .par_iter_mut()
                    .zip(&predicted)
                    .for_each(|(word, &guess)| *word = distance(*word, guess));
            }
            let empty = plane.par_iter().all(|&word| word == 0);
            (!empty).then(|| Channel { name: format!("{}{name}", part.prefix), data: Samples::U32(plane) })
        })
        .collect();
    picture.channels.extend(planes);
}

/// The structs whose planes [`add_planes`] added; what was changed since shows in `sum`.
pub(super) fn read_planes<T: Pod + Send>(
    picture: &Picture,
    part: &Part<'_>,
    sum: &mut Fingerprint,
) -> Vec<T> {
    let mut pixels = vec![T::zeroed(); picture.width * picture.height];
    let per_pixel = size_of::<T>() / 4;
    for (name, at) in words_of(&part.layout) {
        let stored = picture.channel(&format!("{}{name}", part.prefix)).map(bits);
        let plane = match ((part.predict)(picture, &name), stored) {
            (Some(mut plane), Some(stored)) => {
                plane
                    .par_iter_mut()
                    .zip(&*stored)
                    .for_each(|(word, &distance)| *word = moved(*word, distance));
                plane
            }
            (Some(plane), None) => plane,
            (None, Some(stored)) => stored.into_owned(),
            (None, None) => vec![0; pixels.len()],
        };
        sum.add(&name, bytemuck::cast_slice(&plane));
        let words: &mut [u32] = bytemuck::cast_slice_mut(&mut pixels);
        words.par_chunks_exact_mut(per_pixel.max(1)).zip(&plane).for_each(|(pixel, &word)| pixel[at] = word);
    }
    pixels
}

/// The words of a struct without its padding: name and position. Vectors have one word per channel.
fn words_of(layout: &StructLayout) -> Vec<(String, usize)> {
    let ends = layout.fields.iter().skip(1).map(|field| field.1).chain([layout.size]);
    let fields = layout.fields.iter().zip(ends).filter(|((name, _), _)| !name.starts_with("pad_"));
    fields
        .flat_map(|(&(name, start), end)| {
            let count = (end - start) / 4;
            (0..count).map(move |k| {
                let suffix = if count > 1 { [".R", ".G", ".B", ".A"].get(k) } else { None };
                (format!("{name}{}", suffix.unwrap_or(&"")), start / 4 + k)
            })
        })
        .collect()
}

/// How far `word` is from `guess`, small either way: 0, −1, 1, −2 … become 0, 1, 2, 3 …
fn distance(word: u32, guess: u32) -> u32 {
    let steps = word.wrapping_sub(guess) as i32;
    ((steps << 1) ^ (steps >> 31)) as u32
}

/// The word at a [`distance`] from `guess`.
fn moved(guess: u32, distance: u32) -> u32 {
    guess.wrapping_add((distance >> 1) ^ (distance & 1).wrapping_neg())
}

/// The samples' bits.
fn bits(samples: &Samples) -> Cow<'_, [u32]> {
    match samples {
        Samples::F32(values) => Cow::Borrowed(bytemuck::cast_slice(values)),
        Samples::U32(values) => Cow::Borrowed(values),
    }
}

/// What the image's channels say of a word of [`FilmPixel`]. `unit`: scene units per local unit, in which `Z` and the
/// film's depth are; `None` where `Z` is not that of the film.
pub(super) fn predict_film(picture: &Picture, word: &str, unit: Option<f64>) -> Option<Vec<u32>> {
    let floats = |name: &str| match picture.channel(name) {
        Some(Samples::F32(values)) => Some(values),
        _ => None,
    };
    let samples = || picture.channel("samples").map(bits);
    if let Some(channel) = word.strip_prefix("mean.") {
        return picture.channel(channel).map(|values| bits(values).into_owned());
    }
    if let Some(channel) = word.strip_prefix("m2.") {
        let (variance, samples) = (floats(&format!("variance.{channel}"))?, samples()?);
        // Unknown below two samples: 0 there.
        let m2 = |(&v, &n): (&f32, &u32)| {
            if n < 2 { 0 } else { ((f64::from(v) * f64::from(n - 1)) as f32).to_bits() }
        };
        return Some(variance.iter().zip(&*samples).map(m2).collect());
    }
    match word {
        "count" => Some(samples()?.into_owned()),
        "depth" => {
            let unit = unit?;
            Some(floats("Z")?.iter().map(|&z| ((f64::from(z) / unit) as f32).to_bits()).collect())
        }
        "hits" => {
            unit?;
            let hits = |(&z, &n): (&f32, &u32)| if z > 0.0 { n } else { 0 };
            Some(floats("Z")?.iter().zip(&*samples()?).map(hits).collect())
        }
        _ => None,
    }
}

/// The film's part of the state.
pub(super) fn film_part<'a>(predict: Predict<'a>) -> Part<'a> {
    Part { prefix: "state.", layout: FilmPixel::LAYOUT, predict }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device_struct;
    use bytemuck::Zeroable;
    use proptest::prelude::*;

    device_struct! {
        "a file of the test",
        /// A struct with what a second buffer of a film may hold.
        pub struct Extra {
            /// A vector.
            pub light: [f32; 4],
            /// A word.
            pub orders: u32,
            /// Padding.
            pub pad_0: u32,
            /// Padding.
            pub pad_1: u32,
            /// A word after padding.
            pub cut: f32,
        }
    }

    fn extra() -> Part<'static> {
        Part { prefix: "state.extra.", layout: Extra::LAYOUT, predict: &|_, _| None }
    }

    fn film_with_its_picture(film: &[FilmPixel], unit: f64) -> Picture {
        let plane = |f: &dyn Fn(&FilmPixel) -> f64| film.iter().map(|pixel| f(pixel) as f32).collect();
        let mut picture = Picture::new(film.len(), 1);
        for (c, name) in ["R", "G", "B", "A"].into_iter().enumerate() {
            picture = picture.with_channel(name, plane(&|pixel| pixel.mean()[c])).with_channel(
                &format!("variance.{name}"),
                plane(&|pixel| pixel.variance().unwrap_or_default()[c]),
            );
        }
        picture
            .with_channel(
                "Z",
                plane(&|pixel| if pixel.hits > 0 { f64::from(pixel.depth) * unit } else { 0.0 }),
            )
            .with_counts("samples", film.iter().map(|pixel| pixel.count).collect())
    }

    fn words<T: Pod>(pixels: &[T]) -> &[u32] {
        bytemuck::cast_slice(pixels)
    }

    fn there_and_back(film: &[FilmPixel], unit: f64) -> Picture {
        let predict = |picture: &Picture, word: &str| predict_film(picture, word, Some(unit));
        let mut picture = film_with_its_picture(film, unit);
        let (mut written, mut read) = (Fingerprint::new(), Fingerprint::new());
        add_planes(&mut picture, &film_part(&predict), film, &mut written);
        let found: Vec<FilmPixel> = read_planes(&picture, &film_part(&predict), &mut read);
        assert_eq!(words(&found), words(film));
        assert_eq!(written.finish(), read.finish());
        picture
    }

    proptest! {
        /// Any bits at all: NaNs with any payload, infinities, negative zeros, denormals.
        #[test]
        fn any_film_comes_back_whole(bits in prop::collection::vec(any::<u32>(), 22 * 3), unit in 1e-9..1e9_f64) {
            let film: Vec<FilmPixel> = bits
                .chunks_exact(22)
                .map(|chunk| {
                    let mut pixel = [0; 24];
                    pixel[..22].copy_from_slice(chunk);
                    bytemuck::cast(pixel)
                })
                .collect();
            there_and_back(&film, unit);
        }
    }

    #[test]
    fn planes_that_follow_from_others_take_no_room() {
        // Three samples 0.1, 0.2, 0.4 of a pixel that was hit at depth 3, as the kernels' update leaves them.
        let pixel = FilmPixel {
            mean: [0.233_333_34; 4],
            mean_low: [-4.97e-9; 4],
            m2: [0.046_666_67; 4],
            m2_low: [1e-9; 4],
            depth: 3.0,
            hits: 3,
            count: 3,
            lookups_low: 12,
            ..FilmPixel::zeroed()
        };
        let picture = there_and_back(&[pixel; 4], 0.7);
        for derived in ["mean.R", "count", "hits", "rejected", "lookups_high", "pad_0"] {
            assert_eq!(picture.channel(&format!("state.{derived}")), None, "{derived}");
        }
        for kept in ["mean_low.A", "m2_low.B", "lookups_low"] {
            assert!(picture.channel(&format!("state.{kept}")).is_some(), "{kept}");
        }
        // Rounding to the variance and back moves the moment by a few units in the last place, and each counts two.
        if let Some(Samples::U32(steps)) = picture.channel("state.m2.G") {
            assert!(steps.iter().all(|&step| step <= 8), "{steps:?}");
        }
    }

    #[test]
    fn a_second_struct_has_planes_of_its_own() {
        let pixels = [1_u32, 2, 3].map(|k| Extra {
            light: [k as f32, -0.0, f32::NAN, f32::INFINITY],
            orders: k,
            cut: 0.5,
            ..Extra::zeroed()
        });
        let mut picture = Picture::new(3, 1);
        let mut sum = Fingerprint::new();
        add_planes(&mut picture, &extra(), &pixels, &mut sum);
        let mut names: Vec<&str> = picture.channels.iter().map(|channel| channel.name.as_str()).collect();
        names.sort_unstable();
        let lights = ["A", "B", "G", "R"].map(|c| format!("state.extra.light.{c}"));
        let expected: Vec<&str> = ["state.extra.cut"]
            .into_iter()
            .chain(lights.iter().map(String::as_str))
            .chain(["state.extra.orders"])
            .collect();
        assert_eq!(names, expected);
        let found: Vec<Extra> = read_planes(&picture, &extra(), &mut Fingerprint::new());
        assert_eq!(words(&found), words(&pixels));
        // A change shows.
        let mut other = Fingerprint::new();
        picture.channels.retain(|channel| channel.name != "state.extra.cut");
        read_planes::<Extra>(&picture, &extra(), &mut other);
        assert_ne!(other.finish(), sum.finish());
    }
}
