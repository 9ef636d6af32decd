//! Pictures against what is known of them: closed forms and published numbers.

use super::results::{Judged, Quantity};
use super::spec::TruthSpec;
use crate::picture::Picture;
use crate::{Error, Result};

const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// A channel with the variance of each pixel's value, where that is known.
struct Channel {
    values: Vec<f64>,
    variances: Option<Vec<f64>>,
}

impl Channel {
    fn of(picture: &Picture, name: &str) -> Result<Self> {
        let plane = |name: &str| {
            let samples = picture.channel(name)?.to_f32();
            Some(samples.iter().map(|&value| f64::from(value)).collect::<Vec<_>>())
        };
        let values =
            plane(name).ok_or_else(|| Error::Failed(format!("a picture without the channel {name}")))?;
        let counts = plane("samples").filter(|counts| counts.iter().all(|&count| count > 1.0));
        let variances = plane(&format!("variance.{name}")).zip(counts).map(|(variances, counts)| {
            variances.iter().zip(counts).map(|(variance, count)| variance / count).collect()
        });
        Ok(Self { values, variances })
    }

    fn deviation(&self, pixel: usize) -> f64 {
        self.variances.as_ref().map_or(0.0, |variances| variances[pixel].max(0.0).sqrt())
    }
}

/// What a channel has, beside its value.
struct Found {
    value: f64,
    /// Standard error; 0 where none is known.
    error: f64,
    /// Deviation, over what is allowed.
    share: f64,
    /// Deviation.
    off: f64,
    /// Standard error of both.
    sigma: f64,
}

/// Holds a picture against its truth; `shared`: its pixels share noise, so that their variances say little of their mean.
///
/// # Errors
/// [`Error::Failed`] for a picture without colour.
pub fn judge(picture: &Picture, truth: &TruthSpec, shared: bool) -> Result<Judged> {
    let channels = CHANNELS.into_iter().map(|name| Channel::of(picture, name)).collect::<Result<Vec<_>>>()?;
    let pixels = pixels_of(truth.region, picture.width);
    let found: Vec<Found> = channels
        .iter()
        .zip(truth.value)
        .map(|(of, value)| found(of, value, &pixels, truth, shared))
        .collect();
    let values = || channels.iter().flat_map(|channel| channel.values.iter());
    let not_finite = values().filter(|value| !value.is_finite()).count() as u64;
    let below = |of: &Channel| {
        (0..of.values.len()).filter(|&p| of.values[p] < -truth.sigmas * of.deviation(p)).count() as u64
    };
    let negative = channels.iter().map(below).sum();
    let share = found.iter().map(|of| of.share).fold(0.0, f64::max);
    let random = found.iter().any(|of| of.error > 0.0);
    let three = |f: &dyn Fn(&Found) -> f64| [f(&found[0]), f(&found[1]), f(&found[2])];
    // Where the tolerance allows for more than noise does, standard errors say nothing.
    let decides = |(of, value): &(&Found, f64)| {
        of.sigma > 0.0 && truth.sigmas * of.sigma >= truth.tolerance * value.abs()
    };
    let with_sigma = found.iter().zip(truth.value).filter(decides).map(|(of, _)| of);
    let z = with_sigma.map(|of| of.off / of.sigma).max_by(|a, b| a.abs().total_cmp(&b.abs()));
    let relative = found.iter().zip(truth.value).filter(|(_, value)| *value > 0.0);
    let relative = relative.map(|(of, value)| of.off / value).max_by(|a, b| a.abs().total_cmp(&b.abs()));
    Ok(Judged {
        value: truth.value,
        of: truth.of,
        region: truth.region,
        error: truth.error,
        tolerance: truth.tolerance,
        sigmas: truth.sigmas,
        source: truth.source.clone(),
        found: three(&|of| of.value),
        standard_error: random.then(|| three(&|of| of.error)),
        z: z.filter(|z| z.is_finite()),
        relative: relative.filter(|relative| relative.is_finite()),
        share: Some(share).filter(|share| share.is_finite()),
        not_finite,
        negative,
        right: share <= 1.0 && not_finite == 0 && negative == 0,
    })
}

fn pixels_of([left, top, right, bottom]: [u32; 4], width: usize) -> Vec<usize> {
    let row = |y: u32| (left..right).map(move |x| y as usize * width + x as usize);
    (top..bottom).flat_map(row).collect()
}

fn found(channel: &Channel, truth: f64, pixels: &[usize], spec: &TruthSpec, shared: bool) -> Found {
    // Those that are not are counted apart: the picture is wrong then, whatever the others are.
    let finite = || pixels.iter().copied().filter(|&p| channel.values[p].is_finite());
    let (value, error) = match spec.of {
        Quantity::Mean => {
            let count = finite().count().max(1) as f64;
            let variance: f64 = finite().map(|p| channel.deviation(p).powi(2)).sum();
            let mean = finite().map(|p| channel.values[p]).sum::<f64>() / count;
            (mean, if shared { 0.0 } else { variance.sqrt() / count })
        }
        Quantity::Each => {
            let off = |p: usize| (channel.values[p] - truth).abs();
            let worst = finite().max_by(|&a, &b| off(a).total_cmp(&off(b)));
            (worst.map_or(0.0, |worst| channel.values[worst]), 0.0)
        }
    };
    let off = value - truth;
    let sigma = error.hypot(spec.error);
    let allowed = spec.sigmas * sigma + spec.tolerance * truth.abs();
    // Nothing is allowed of a truth that is 0 and without noise: then only 0 will do.
    let share = if off == 0.0 { 0.0 } else { off.abs() / allowed };
    Found { value, error, share, off, sigma }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn truth(value: [f64; 3]) -> TruthSpec {
        TruthSpec {
            value,
            of: Quantity::Mean,
            region: [0, 0, 2, 2],
            error: 0.0,
            tolerance: 1e-5,
            sigmas: 5.0,
            source: String::new(),
        }
    }

    /// 3×2 pixels: 1 and 3 by turns in the first two columns, 100 in the third; each of 16 samples of variance 4.
    fn picture() -> Picture {
        let mut picture = Picture::new(3, 2).with_counts("samples", vec![16; 6]);
        for name in CHANNELS {
            picture = picture
                .with_channel(name, vec![1.0, 3.0, 100.0, 3.0, 1.0, 100.0])
                .with_channel(&format!("variance.{name}"), vec![4.0; 6]);
        }
        picture
    }

    #[test]
    fn means_are_judged_by_their_noise() {
        // The mean of four pixels of variance 4/16 has the standard error 1/4.
        let right = judge(&picture(), &truth([2.0, 2.5, 1.0]), false).unwrap();
        assert_eq!((right.found, right.standard_error), ([2.0; 3], Some([0.25; 3])));
        assert!(
            right.right && (right.z.unwrap() - 4.0).abs() < 1e-12 && right.relative == Some(1.0),
            "{right:?}"
        );
        let wrong = judge(&picture(), &truth([2.0, 2.0, 0.74]), false).unwrap();
        assert!(!wrong.right && wrong.z.unwrap() > 5.0, "{wrong:?}");
        // A truth of 0.74 ± 0.1 is not that far off.
        let loose = TruthSpec { error: 0.1, ..truth([2.0, 2.0, 0.74]) };
        assert!(judge(&picture(), &loose, false).unwrap().right);
        // Shared noise does not count.
        let shared = judge(&picture(), &truth([2.0, 2.0, 1.9]), true).unwrap();
        assert!(!shared.right && shared.standard_error.is_none() && shared.z.is_none());
        assert!(
            judge(&picture(), &TruthSpec { tolerance: 0.06, ..truth([2.0, 2.0, 1.9]) }, true).unwrap().right
        );
    }

    #[test]
    fn single_pixels_are_judged_by_the_worst() {
        let each = |value, tolerance| TruthSpec { of: Quantity::Each, tolerance, ..truth([value; 3]) };
        let off = judge(&picture(), &each(2.5, 0.5), false).unwrap();
        assert_eq!((off.found, off.right), ([1.0; 3], false));
        assert!(judge(&picture(), &each(2.5, 0.61), false).unwrap().right);
    }

    #[test]
    fn no_value_may_be_wrong_anywhere() {
        // Beyond the region, too.
        for (bad, good) in [(f32::NAN, false), (f32::INFINITY, false), (-2.6, false), (-2.4, true)] {
            let mut picture = picture();
            picture.channels.retain(|channel| channel.name != "G");
            let picture = picture.with_channel("G", vec![2.0, 2.0, bad, 2.0, 2.0, 2.0]);
            let judged = judge(&picture, &truth([2.0; 3]), false).unwrap();
            assert_eq!(judged.right, good, "{bad}: {judged:?}");
        }
        let none = judge(&Picture::new(1, 1).with_channel("Y", vec![1.0]), &truth([1.0; 3]), false);
        assert!(none.is_err());
        let mut nan = picture();
        nan.channels.retain(|channel| channel.name != "R");
        let nan = nan.with_channel("R", vec![f32::NAN; 6]);
        let judged = judge(&nan, &truth([2.0; 3]), false).unwrap();
        assert!(!judged.right && judged.not_finite == 6 && judged.found[0] == 0.0, "{judged:?}");
    }

    #[test]
    fn nothing_is_nothing() {
        let black = |value: f32| {
            let channels = CHANNELS.into_iter();
            channels.fold(Picture::new(2, 2), |picture, name| picture.with_channel(name, vec![value; 4]))
        };
        assert!(judge(&black(0.0), &truth([0.0; 3]), false).unwrap().right);
        assert!(!judge(&black(1e-30), &truth([0.0; 3]), false).unwrap().right);
    }
}
