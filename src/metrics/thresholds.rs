//! Limits on a comparison.

use serde::Serialize;

use super::compare::Comparison;

/// The largest errors (smallest PSNR) that are accepted; `None` is no limit.
///
/// They apply to the plain metrics, not to the noise-corrected ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Thresholds {
    /// Limit of the RMSE.
    pub max_rmse: Option<f64>,
    /// Limit of the linear PSNR (P = largest value of the reference) in dB.
    pub min_psnr: Option<f64>,
    /// Limit of relMSE.
    pub max_relmse: Option<f64>,
    /// Limit of MAPE (1 = 100 %).
    pub max_mape: Option<f64>,
    /// Limit of |bias|.
    pub max_bias: Option<f64>,
}

impl Thresholds {
    /// One sentence per violated limit. With any limit set, pixels of the image that are not
    /// finite are a violation too, since the metrics leave them out. A metric that is undefined
    /// violates its limit, except that equal pictures pass all of them.
    pub fn violations(&self, comparison: &Comparison) -> Vec<String> {
        if *self == Self::default() {
            return Vec::new();
        }
        let equal = comparison.mse.value == 0.0;
        let value = |metric: Option<f64>| if equal { Some(0.0) } else { metric };
        let limits = [
            ("RMSE", Some(comparison.rmse), self.max_rmse),
            ("relMSE", value(comparison.relmse.map(|metric| metric.value)), self.max_relmse),
            ("MAPE", value(comparison.mape.map(|metric| metric.value)), self.max_mape),
            ("|bias|", Some(comparison.bias.mean.abs()), self.max_bias),
        ];
        let mut found: Vec<String> =
            limits.into_iter().filter_map(|(name, value, limit)| above(name, value, limit?)).collect();
        if let Some(limit) = self.min_psnr.filter(|_| !equal) {
            found.extend(below("PSNR", comparison.psnr.linear_db, limit));
        }
        if comparison.non_finite.image > 0 {
            found.push(format!("{} pixels of the image are not finite", comparison.non_finite.image));
        }
        found
    }
}

fn above(name: &str, value: Option<f64>, limit: f64) -> Option<String> {
    match value {
        Some(value) if value <= limit => None,
        Some(value) => Some(format!("{name} is {value:.6e}, above {limit}")),
        None => Some(format!("{name} is undefined for a black reference, so it cannot be within {limit}")),
    }
}

fn below(name: &str, value: Option<f64>, limit: f64) -> Option<String> {
    match value {
        Some(value) if value >= limit => None,
        Some(value) => Some(format!("{name} is {value:.3} dB, below {limit} dB")),
        None => Some(format!("{name} is undefined for a black reference, so it cannot reach {limit} dB")),
    }
}
