//! The noise a picture says it has.
//!
//! `variance.C` is the variance s² of one sample of channel C, `samples` the count n of samples
//! in each pixel; the mean in C then has the variance s²/n. It is unknown where n < 2 or where a
//! value is negative or not finite.

use crate::picture::Picture;

/// The variance of the mean in `channel`, per pixel; NaN where unknown. `None` where the picture
/// carries no variance for the channel or no sample counts.
pub(super) fn variance_of_mean(picture: &Picture, channel: &str) -> Option<Vec<f64>> {
    let variance = picture.channel(&format!("variance.{channel}"))?.to_f32();
    let samples = picture.channel("samples")?.to_f32();
    let of_mean = |(&variance, &samples): (&f32, &f32)| {
        let (variance, samples) = (f64::from(variance), f64::from(samples));
        let known = samples >= 2.0 && samples.is_finite() && variance >= 0.0 && variance.is_finite();
        if known { variance / samples } else { f64::NAN }
    };
    Some(variance.iter().zip(samples.iter()).map(of_mean).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_and_unknown_pixels() {
        let picture = Picture::new(6, 1)
            .with_channel("variance.R", vec![8.0, 8.0, 8.0, -1.0, f32::NAN, 0.0])
            .with_counts("samples", vec![4, 1, 0, 4, 4, 4]);
        let variance = variance_of_mean(&picture, "R").unwrap();
        assert_eq!((variance[0], variance[5]), (2.0, 0.0));
        assert!(variance[1..5].iter().all(|value| value.is_nan()));
        assert_eq!(variance_of_mean(&picture, "G"), None);
        assert_eq!(variance_of_mean(&Picture::new(1, 1).with_channel("variance.R", vec![1.0]), "R"), None);
    }
}
