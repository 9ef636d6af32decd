//! Statistics of samples, by their definitions.

/// Mean, and unbiased variance of one sample (0 below two samples).
pub fn mean_and_variance(samples: &[f64]) -> (f64, f64) {
    let count = samples.len() as f64;
    let mean = samples.iter().sum::<f64>() / count;
    let squares: f64 = samples.iter().map(|x| (x - mean).powi(2)).sum();
    (mean, if samples.len() > 1 { squares / (count - 1.0) } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::mean_and_variance;

    #[test]
    fn of_few_samples() {
        assert_eq!(mean_and_variance(&[1.0, 2.0, 6.0]), (3.0, 7.0));
        assert_eq!(mean_and_variance(&[5.0]), (5.0, 0.0));
    }
}
