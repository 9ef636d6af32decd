//! A comparison as a table for people.

use std::fmt;

use super::{
    blocks::Estimate,
    compare::Comparison,
    corrected::{Corrected, Removed},
};

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let total = self.width * self.height;
        writeln!(
            f,
            "{}×{}, channels {}, {} of {total} pixels compared",
            self.width,
            self.height,
            self.channels.join(" "),
            self.pixels
        )?;
        if self.pixels < total {
            let bad = self.non_finite;
            writeln!(f, "not finite: {} pixels of the image, {} of the reference", bad.image, bad.reference)?;
        }
        writeln!(f, "{:<26} {:>13}  95 % interval", "metric", "value")?;
        row(f, "MSE", Some(self.mse))?;
        plain(f, "RMSE", Some(self.rmse))?;
        row(f, "relMSE", self.relmse)?;
        row(f, "MAPE", self.mape)?;
        self.peaks(f)?;
        self.bias_rows(f)?;
        for corrected in &self.corrected {
            correction(f, corrected)?;
        }
        if let Some(z) = self.pixel_z {
            let share = 100.0 * z.beyond_1_96;
            writeln!(f, "{:<26} {share:>11.3} %  of {} values; 5 % expected", "beyond 1.96 sigma", z.values)?;
        }
        Ok(())
    }
}

impl Comparison {
    fn peaks(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let decibels = |value: Option<f64>| match value {
            Some(value) => format!("{value:.3} dB"),
            None if self.mse.value == 0.0 => "infinite".into(),
            None => "undefined".into(),
        };
        let label = format!("PSNR, P = {:.4}", self.psnr.peak);
        writeln!(f, "{label:<26} {:>13}", decibels(self.psnr.linear_db))?;
        writeln!(f, "{:<26} {:>13}", "PSNR, sRGB codes, P = 1", decibels(self.psnr.display_db))
    }

    fn bias_rows(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let error =
            |error: Option<f64>| error.map_or(String::new(), |error| format!("  ± {error:.3e} (1 sigma)"));
        let z = self.bias.z.map_or(String::new(), |z| format!(", z = {z:.2}"));
        let bias = &self.bias;
        writeln!(f, "{:<26} {:>13.6e}{}{z}", "bias", bias.mean, error(bias.standard_error))?;
        if let Some(relative) = bias.relative {
            writeln!(f, "{:<26} {:>11.5} %", "bias / mean reference", 100.0 * relative)?;
        }
        for channel in bias.channels.iter().filter(|_| bias.channels.len() > 1) {
            let label = format!("bias {}", channel.name);
            writeln!(f, "{label:<26} {:>13.6e}{}", channel.mean, error(channel.standard_error))?;
        }
        Ok(())
    }
}

fn row(f: &mut fmt::Formatter<'_>, label: &str, estimate: Option<Estimate>) -> fmt::Result {
    let Some(Estimate { value, low, high }) = estimate else {
        return plain(f, label, None);
    };
    write!(f, "{label:<26} {value:>13.6e}")?;
    match low.zip(high) {
        Some((low, high)) => writeln!(f, "  {low:.3e} … {high:.3e}"),
        None => writeln!(f),
    }
}

fn plain(f: &mut fmt::Formatter<'_>, label: &str, value: Option<f64>) -> fmt::Result {
    match value {
        Some(value) => writeln!(f, "{label:<26} {value:>13.6e}"),
        None => writeln!(f, "{label:<26} {:>13}", "undefined"),
    }
}

fn correction(f: &mut fmt::Formatter<'_>, corrected: &Corrected) -> fmt::Result {
    let whose = match corrected.removed {
        Removed::Reference => "− reference noise",
        Removed::Image => "− image noise",
        Removed::Both => "− both noises",
    };
    row(f, &format!("MSE {whose}"), Some(corrected.mse))?;
    match corrected.rmse {
        Some(rmse) => plain(f, &format!("RMSE {whose}"), Some(rmse))?,
        None => writeln!(f, "{:<26} {:>13}", format!("RMSE {whose}"), "below noise")?,
    }
    row(f, &format!("relMSE {whose}"), corrected.relmse)?;
    if corrected.unknown > 0 {
        writeln!(f, "  {} values left out: fewer than 2 samples", corrected.unknown)?;
    }
    Ok(())
}
