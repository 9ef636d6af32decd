//! Two pictures laid side by side: the channels both have, and the pixels that count.

use std::borrow::Cow;

use super::{
    blocks::{BlockGrid, BlockMeans, Estimate},
    noise::variance_of_mean,
};
use crate::{
    error::{Error, Result},
    picture::{Picture, Plane},
};

/// One channel of both pictures.
pub(super) struct PairChannel<'a> {
    pub name: &'static str,
    pub image: Cow<'a, [f32]>,
    pub reference: Cow<'a, [f32]>,
    /// Variance of the mean per pixel, NaN where unknown.
    pub image_noise: Option<Vec<f64>>,
    /// Variance of the mean per pixel, NaN where unknown.
    pub reference_noise: Option<Vec<f64>>,
}

impl PairChannel<'_> {
    /// r.
    pub fn reference_value(&self, pixel: usize) -> f64 {
        f64::from(self.reference[pixel])
    }

    /// x − r, exact in f64 to rounding.
    pub fn difference(&self, pixel: usize) -> f64 {
        f64::from(self.image[pixel]) - f64::from(self.reference[pixel])
    }
}

/// A picture and its reference.
pub(super) struct Pair<'a> {
    pub width: usize,
    pub height: usize,
    pub channels: Vec<PairChannel<'a>>,
    /// Pixels finite in every channel of both.
    pub usable: Vec<usize>,
    /// Pixels of the image with a value that is not finite.
    pub bad_image: usize,
    /// Pixels of the reference with a value that is not finite.
    pub bad_reference: usize,
}

impl<'a> Pair<'a> {
    /// # Errors
    /// [`Error::Input`] where the sizes differ, a picture has no colour or no pixel can be compared.
    pub fn new(image: &'a Picture, reference: &'a Picture) -> Result<Self> {
        let (width, height) = common_size(image, reference)?;
        let (x, r) = (colour(image, "image")?, colour(reference, "reference")?);
        let bad = |planes: &[Plane], pixel: usize| planes.iter().any(|plane| !plane.data[pixel].is_finite());
        let pixels = 0..width * height;
        let bad_image = pixels.clone().filter(|&pixel| bad(&x, pixel)).count();
        let bad_reference = pixels.clone().filter(|&pixel| bad(&r, pixel)).count();
        let usable: Vec<usize> = pixels.filter(|&pixel| !bad(&x, pixel) && !bad(&r, pixel)).collect();
        if usable.is_empty() {
            return Err(Error::Input(format!(
                "no pixel is finite in both pictures ({bad_image} bad in the image, {bad_reference} in the \
                 reference, of {}); render them again",
                width * height
            )));
        }
        // Grey stands for three equal channels where the other picture has colour.
        let count = x.len().max(r.len());
        let channel = |c: usize| {
            let (x, r) = (&x[c.min(x.len() - 1)], &r[c.min(r.len() - 1)]);
            PairChannel {
                name: if count == 1 { "Y" } else { ["R", "G", "B"][c] },
                image: x.data.clone(),
                reference: r.data.clone(),
                image_noise: variance_of_mean(image, x.name),
                reference_noise: variance_of_mean(reference, r.name),
            }
        };
        let channels = (0..count).map(channel).collect();
        Ok(Self { width, height, channels, usable, bad_image, bad_reference })
    }

    /// The mean of `term(channel, pixel)` over all values where it is known.
    pub fn mean(&self, term: impl Fn(&PairChannel, usize) -> Option<f64>) -> Option<Estimate> {
        let mut means = BlockMeans::new(BlockGrid::new(self.width, self.height));
        for channel in &self.channels {
            for &pixel in &self.usable {
                if let Some(value) = term(channel, pixel) {
                    means.add(pixel, value);
                }
            }
        }
        means.estimate()
    }

    /// The largest value of the reference.
    pub fn peak(&self) -> f64 {
        let values =
            self.channels.iter().flat_map(|channel| self.usable.iter().map(|&p| channel.reference_value(p)));
        values.fold(f64::NEG_INFINITY, f64::max)
    }

    /// 0.1 · mean |r|, the level below which relative errors fade; `None` for a black reference.
    pub fn floor(&self) -> Option<f64> {
        let mean = self.mean_of_all(|channel, pixel| channel.reference_value(pixel).abs()).value;
        (mean > 0.0).then_some(0.1 * mean)
    }

    /// Sums of `term` over the channels and pixels of each block; all are finite where `term` is.
    pub fn block_sums(&self, term: impl Fn(&PairChannel, usize) -> f64) -> Vec<f64> {
        let mut means = BlockMeans::new(BlockGrid::new(self.width, self.height));
        for channel in &self.channels {
            self.usable.iter().for_each(|&pixel| means.add(pixel, term(channel, pixel)));
        }
        means.into_sums()
    }

    /// The mean of `term` that is known for every value. Never empty, as [`Pair::new`] saw to it.
    pub fn mean_of_all(&self, term: impl Fn(&PairChannel, usize) -> f64) -> Estimate {
        let known = self.mean(|channel, pixel| Some(term(channel, pixel)));
        known.unwrap_or(Estimate { value: f64::NAN, low: None, high: None })
    }
}

/// 10 log₁₀(P²/MSE); `None` where undefined.
pub(super) fn decibels(peak: f64, mse: f64) -> Option<f64> {
    (peak > 0.0 && mse > 0.0).then(|| 10.0 * (peak * peak / mse).log10())
}

fn common_size(image: &Picture, reference: &Picture) -> Result<(usize, usize)> {
    for (picture, role) in [(image, "image"), (reference, "reference")] {
        picture.validate().map_err(|what| Error::Input(format!("the {role} cannot be compared: {what}")))?;
    }
    let (a, b) = ((image.width, image.height), (reference.width, reference.height));
    if a != b {
        return Err(Error::Input(format!(
            "the image has {}×{} pixels and the reference {}×{}; they must be of one size",
            a.0, a.1, b.0, b.1
        )));
    }
    Ok(a)
}

fn colour<'a>(picture: &'a Picture, role: &str) -> Result<Vec<Plane<'a>>> {
    picture.colour().ok_or_else(|| {
        let names: Vec<_> = picture.channels.iter().map(|channel| channel.name.as_str()).collect();
        let names = names.join(", ");
        Error::Input(format!(
            "the {role} has no channels R, G, B or Y (it has {names}); give a colour picture"
        ))
    })
}
