//! What the repeats of a case say together.

use super::measure::root;
use super::results::{Case, Interval, LightRun, Metrics, Point, Repeat, Spread, Summary, TimeToError};
use super::statistics::{ErrorBlocks, Variance, slope, spread};

/// An exponent of error against time above this is no longer near the −1/2 of noise.
const FLAT: f64 = -0.25;

/// A finished repeat with the squared errors of its checkpoints in blocks.
pub struct Measured<'a> {
    /// The repeat.
    pub repeat: &'a Repeat,
    /// `[checkpoint][block]`.
    pub blocks: &'a [Vec<f64>],
}

/// Sums up the repeats of a case; `errors` are the relative errors whose times are wanted, descending.
pub fn summarise(case: &Case, measured: &[Measured<'_>], errors: &[f64]) -> Summary {
    let repeats: Vec<&Repeat> = measured.iter().map(|entry| entry.repeat).collect();
    let count = repeats.iter().map(|repeat| repeat.checkpoints.len()).min().unwrap_or(0);
    let Some(last) = count.checked_sub(1) else { return Summary::default() };
    let values = f64::from(case.width) * f64::from(case.height) * 3.0;
    let blocks = ErrorBlocks::new(measured.iter().map(|entry| entry.blocks).collect(), values);
    let points: Vec<Point> = (0..count).filter_map(|k| point(case, &repeats, k, blocks.as_ref())).collect();
    let over = |f: &dyn Fn(&Repeat) -> f64| spread(repeats.iter().map(|repeat| f(repeat)));
    let per_second = over(&|repeat| {
        let checkpoint = &repeat.checkpoints[last];
        let light = repeat.light.map_or(0.0, |light| light.seconds);
        checkpoint.samples as f64 / (checkpoint.seconds - light).max(0.0)
    });
    // The noise of a light volume does not fall with samples.
    let stays = case.deterministic || repeats.iter().any(|repeat| repeat.light.is_some());
    let light = || repeats.iter().filter_map(|repeat| repeat.light);
    let photons = || repeats.iter().filter_map(|repeat| repeat.photons);
    let light_rate = |run: LightRun| Some(f64::from(run.iterations?) / run.seconds);
    let pixels = f64::from(case.width) * f64::from(case.height);
    let rate = |f: &dyn Fn(&Repeat) -> f64| over(f).map(|spread| spread.median).filter(|&value| value > 0.0);
    Summary {
        slope: slope_of(&points, &repeats, blocks.as_ref()),
        efficiency: efficiency(&repeats, last, blocks.as_ref()),
        time_to_error: times_to_errors(&points, errors, stays),
        build: over(&|repeat| repeat.build_seconds),
        prepare: over(&|repeat| repeat.prepare_seconds),
        light: spread(light().map(|run| run.seconds)),
        light_iterations_per_second: spread(light().filter_map(light_rate)),
        trace_seconds: spread(photons().map(|run| run.trace_seconds)),
        sort_seconds: spread(photons().map(|run| run.sort_seconds)),
        samples_per_second: per_second,
        lookups_per_sample: rate(&|repeat| {
            let checkpoint = &repeat.checkpoints[last];
            checkpoint.lookups as f64 / (checkpoint.samples as f64 * pixels)
        }),
        lookups_per_second: rate(&|repeat| {
            let checkpoint = &repeat.checkpoints[last];
            checkpoint.lookups as f64 / checkpoint.seconds
        }),
        points,
    }
}

fn noise(repeats: &[&Repeat]) -> f64 {
    repeats.first().map_or(0.0, |repeat| repeat.checkpoints[0].metrics.reference_noise)
}

fn point(case: &Case, repeats: &[&Repeat], k: usize, blocks: Option<&ErrorBlocks<'_>>) -> Option<Point> {
    let over = |f: &dyn Fn(&super::results::Checkpoint) -> f64| {
        spread(repeats.iter().map(|repeat| f(&repeat.checkpoints[k])))
    };
    let median = |f: &dyn Fn(&super::results::Checkpoint) -> f64| over(f).map(|spread| spread.median);
    let some = |f: &dyn Fn(&Metrics) -> Option<Interval>| {
        median(&|checkpoint| f(&checkpoint.metrics).map_or(f64::NAN, |interval| interval.value))
    };
    let mse = mean_square(repeats, k, blocks);
    let rmse = root(mse);
    let peak = repeats.first()?.checkpoints[k].metrics.psnr_peak;
    let mean = case.reference.mean.abs();
    let relative = |rmse: Interval| Interval {
        value: rmse.value / mean,
        low: rmse.low.map(|low| low / mean),
        high: rmse.high.map(|high| high / mean),
    };
    Some(Point {
        samples: median(&|checkpoint| checkpoint.samples as f64)?,
        seconds: over(&|checkpoint| checkpoint.seconds)?,
        device_seconds: over(&|checkpoint| checkpoint.device_seconds)?,
        rmse,
        relative_rmse: rmse.filter(|_| mean > 0.0).map(relative),
        psnr_linear_db: (peak > 0.0 && mse.value > 0.0).then(|| 10.0 * (peak * peak / mse.value).log10()),
        relmse: some(&|metrics| metrics.relmse),
        mape: some(&|metrics| metrics.mape),
        launches: median(&|checkpoint| checkpoint.launches as f64)?,
        lookups: median(&|checkpoint| checkpoint.lookups as f64)?,
        bytes: median(&|checkpoint| checkpoint.bytes as f64)?,
    })
}

/// The mean of the repeats' MSE. Its interval is that between repeats; of one repeat that of the picture's blocks.
fn mean_square(repeats: &[&Repeat], k: usize, blocks: Option<&ErrorBlocks<'_>>) -> Interval {
    let all = || repeats.iter().map(|repeat| repeat.checkpoints[k].metrics.mse);
    let value = all().map(|mse| mse.value).sum::<f64>() / repeats.len() as f64;
    if let [only] = repeats {
        return only.checkpoints[k].metrics.mse;
    }
    match blocks.and_then(|blocks| variance_at(blocks, repeats, k)) {
        Some(variance) => variance.around(value),
        None => Interval { value, low: None, high: None },
    }
}

fn variance_at(blocks: &ErrorBlocks<'_>, repeats: &[&Repeat], k: usize) -> Option<Variance> {
    let mut weights = vec![0.0; repeats[0].checkpoints.len()];
    *weights.get_mut(k)? = 1.0;
    blocks.variance(&weights)
}

fn slope_of(points: &[Point], repeats: &[&Repeat], blocks: Option<&ErrorBlocks<'_>>) -> Option<Interval> {
    let samples: Vec<f64> = points.iter().map(|point| point.samples).collect();
    let (value, variance) = slope(&samples, blocks?, noise(repeats))?;
    Some(variance.around(value))
}

/// 1/(MSE·t): the geometric mean over repeats, with the spread of the times and the variance of the MSE.
fn efficiency(repeats: &[&Repeat], last: usize, blocks: Option<&ErrorBlocks<'_>>) -> Option<Interval> {
    let mse = repeats.iter().map(|repeat| repeat.checkpoints[last].metrics.mse.value).sum::<f64>()
        / repeats.len() as f64;
    let times: Vec<f64> = repeats.iter().map(|repeat| repeat.checkpoints[last].seconds.ln()).collect();
    let log_time = times.iter().sum::<f64>() / times.len() as f64;
    if mse <= 0.0 || !log_time.is_finite() {
        return None;
    }
    let value = (-mse.ln() - log_time).exp();
    let of_time = Variance::of_mean(&times);
    let of_mse = blocks
        .and_then(|blocks| variance_at(blocks, repeats, last))
        .map(|variance| Variance { value: variance.value / (mse * mse), ..variance });
    let half = of_time.zip(of_mse).map(|(time, mse)| Variance::sum([time, mse]).half_width());
    Some(Interval {
        value,
        low: half.map(|half| value * (-half).exp()),
        high: half.map(|half| value * half.exp()),
    })
}

/// When the error falls below each of `errors`: between checkpoints by interpolation of logarithms, beyond the last by
/// the n^−1/2 law unless the error `stays` with more samples. The first checkpoint stands for everything above its error.
fn times_to_errors(points: &[Point], errors: &[f64], stays: bool) -> Vec<TimeToError> {
    let known: Vec<(f64, f64)> = points
        .iter()
        .filter_map(|point| Some((point.seconds.median, point.relative_rmse?.value)))
        .filter(|&(seconds, error)| seconds > 0.0 && error > 0.0)
        .collect();
    errors.iter().filter_map(|&error| time_to_error(&known, error, stays)).collect()
}

fn time_to_error(known: &[(f64, f64)], wanted: f64, stays: bool) -> Option<TimeToError> {
    let found = |seconds: f64, measured: bool| TimeToError { relative_error: wanted, seconds, measured };
    let (last_seconds, last_error) = *known.last()?;
    match known.iter().position(|&(_, error)| error <= wanted) {
        Some(0) => Some(found(known[0].0, true)),
        Some(next) => {
            let ((t0, e0), (t1, e1)) = (known[next - 1], known[next]);
            let part = (e0 / wanted).ln() / (e0 / e1).ln();
            Some(found(t0 * (t1 / t0).powf(part), true))
        }
        None if stays || is_flat(known) => None,
        None => Some(found(last_seconds * (last_error / wanted).powi(2), false)),
    }
}

/// Whether the error no longer falls with time: what is left is no noise, and the law of noise does not hold.
fn is_flat(known: &[(f64, f64)]) -> bool {
    let [.., (t0, e0), (t1, e1)] = known else { return false };
    (e1 / e0).ln() > FLAT * (t1 / t0).ln()
}

/// A spread in another unit.
pub(super) fn inverse(spread: Spread) -> Spread {
    Spread { median: 1.0 / spread.median, low: 1.0 / spread.high, high: 1.0 / spread.low, ..spread }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_to_errors_interpolate_and_extrapolate() {
        let known = [(1.0, 0.4), (4.0, 0.2), (16.0, 0.1)];
        let found = |wanted: f64, stays: bool| time_to_error(&known, wanted, stays);
        // The first checkpoint stands for what it is already below.
        assert_eq!(found(0.5, false).map(|t| (t.seconds, t.measured)), Some((1.0, true)));
        let between = found(0.2 / 2.0_f64.sqrt(), false).unwrap();
        assert!((between.seconds - 8.0).abs() < 1e-12 && between.measured);
        let beyond = found(0.01, false).unwrap();
        assert!((beyond.seconds - 1600.0).abs() < 1e-9 && !beyond.measured);
        assert_eq!(found(0.01, true), None);
        // A model's error does not fall: 0.4, 0.2, 0.19.
        assert_eq!(time_to_error(&[(1.0, 0.4), (4.0, 0.2), (16.0, 0.19)], 0.01, false), None);
        assert_eq!(time_to_error(&[], 0.1, false), None);
    }

    #[test]
    fn a_rate_becomes_a_time() {
        let rate = Spread { median: 4.0, low: 2.0, high: 8.0, count: 3 };
        assert_eq!(inverse(rate), Spread { median: 0.25, low: 0.125, high: 0.5, count: 3 });
    }
}
