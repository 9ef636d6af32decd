//! The difference of two pictures as a picture.

use std::path::Path;

use super::pair::Pair;
use crate::{
    error::Result,
    picture::{BAD_PIXEL, Picture, write_exr, write_png_rgb8},
};

/// The signed difference image − reference, channel by channel (`R G B`, or `Y`). Values that are
/// not finite stay so.
///
/// # Errors
/// As [`super::compare`].
pub fn difference_picture(image: &Picture, reference: &Picture) -> Result<Picture> {
    let pair = Pair::new(image, reference)?;
    let mut picture = Picture::new(pair.width, pair.height);
    for channel in &pair.channels {
        let values = (0..channel.image.len()).map(|pixel| channel.difference(pixel) as f32).collect();
        picture = picture.with_channel(channel.name, values);
    }
    picture.metadata.insert("svetlo.content".into(), "image - reference, signed, linear".into());
    Ok(picture)
}

/// Writes the difference: signed values as EXR, or, where `path` ends in `.png`, the mean over the
/// channels in false colour: blue where the image is darker, white at 0, red where it is brighter.
///
/// Returns the scale of the false colour, the difference shown as full red or blue: the 99 %
/// quantile of |difference|, so that a few fireflies do not turn the rest white. `None` for EXR.
///
/// # Errors
/// As [`super::compare`], and [`crate::Error::Failed`] where the file cannot be written.
pub fn write_difference(path: &Path, image: &Picture, reference: &Picture) -> Result<Option<f64>> {
    let difference = difference_picture(image, reference)?;
    if !is_png(path) {
        write_exr(path, &difference)?;
        return Ok(None);
    }
    let means = channel_means(&difference);
    let scale = quantile_99(&means);
    let codes: Vec<u8> = means.iter().flat_map(|&mean| false_colour(mean, scale)).collect();
    write_png_rgb8(path, difference.width, difference.height, &codes)?;
    Ok(Some(scale))
}

pub(super) fn is_png(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"))
}

fn channel_means(difference: &Picture) -> Vec<f64> {
    let mut means = vec![0.0; difference.width * difference.height];
    let weight = 1.0 / difference.channels.len() as f64;
    for channel in &difference.channels {
        for (mean, &value) in means.iter_mut().zip(channel.data.to_f32().iter()) {
            *mean += weight * f64::from(value);
        }
    }
    means
}

/// The 99 % quantile of the finite |values|, or their maximum where that is 0.
fn quantile_99(values: &[f64]) -> f64 {
    let mut sizes: Vec<f64> =
        values.iter().map(|value| value.abs()).filter(|size| size.is_finite()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let largest = sizes.last().copied().unwrap_or(0.0);
    let rank = (sizes.len() * 99).div_ceil(100).saturating_sub(1);
    sizes.get(rank).copied().filter(|&size| size > 0.0).unwrap_or(largest)
}

/// Blue–white–red, linear in code values; [`BAD_PIXEL`] where the difference is not finite.
fn false_colour(difference: f64, scale: f64) -> [u8; 3] {
    if !difference.is_finite() {
        return BAD_PIXEL;
    }
    let share = if scale > 0.0 { (difference / scale).clamp(-1.0, 1.0) } else { 0.0 };
    let fade = (255.0 * (1.0 - share.abs())).round() as u8;
    if share < 0.0 { [fade, fade, 255] } else { [255, fade, fade] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_and_scale() {
        assert_eq!(false_colour(0.0, 2.0), [255, 255, 255]);
        assert_eq!(false_colour(2.0, 2.0), [255, 0, 0]);
        assert_eq!(false_colour(-9.0, 2.0), [0, 0, 255]);
        assert_eq!(false_colour(-1.0, 2.0), [128, 128, 255]);
        assert_eq!(false_colour(f64::NAN, 2.0), BAD_PIXEL);
        assert_eq!(false_colour(0.0, 0.0), [255, 255, 255]);
        let mut values = vec![1.0; 99];
        values.push(-1e6);
        assert_eq!(quantile_99(&values), 1.0);
        assert_eq!(quantile_99(&[0.0, 0.0, f64::NAN, 3.0]), 3.0);
        assert_eq!(quantile_99(&[]), 0.0);
    }

    #[test]
    fn the_difference_is_signed_and_keeps_bad_pixels() {
        let image = Picture::new(3, 1).with_channel("Y", vec![1.0, 0.25, f32::NAN]);
        let reference = Picture::new(3, 1).with_channel("Y", vec![0.5, 1.0, 0.0]);
        let difference = difference_picture(&image, &reference).unwrap();
        let values = difference.channel("Y").unwrap().to_f32().into_owned();
        assert_eq!(values[..2], [0.5, -0.75]);
        assert!(values[2].is_nan());
    }
}
