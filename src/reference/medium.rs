//! The transfer function as the medium of a ray: emission and extinction per scene unit.

use crate::Result;
use crate::scene::{Medium as Opacity, Transfer};
use crate::transfer::{TransferFunction1d, TransferFunction2d, sigma_table};

/// A table of (r, g, b, σ), each linear between entries along the window value and the scaled gradient.
#[derive(Debug, Clone, PartialEq)]
pub struct Medium {
    /// Entries along the value, from 0 to 1.
    pub values: usize,
    /// Entries along the gradient, from 0 to 1; 1 for a function of the value alone.
    pub gradients: usize,
    /// Colour, and extinction per scene unit; value fastest.
    pub entries: Vec<[f64; 4]>,
    /// Scaled gradient per gradient of the window value per scene unit; 0 for a function of the value alone.
    pub gradient_scale: f64,
}

impl Medium {
    /// The medium of a scene: `window` in data units, `smallest_spacing` in scene units.
    ///
    /// # Errors
    /// [`crate::Error::Input`] when a table cannot be read.
    pub fn new(
        transfer: &Transfer,
        opacity: &Opacity,
        window: (f64, f64),
        smallest_spacing: f64,
    ) -> Result<Self> {
        let (rgba, values, gradients, gradient_scale) = match transfer {
            Transfer::OneD(settings) => {
                let rgba = TransferFunction1d::from_settings(settings, window).rgba;
                let values = rgba.len();
                (rgba, values, 1, 0.0)
            }
            Transfer::TwoD(settings) => {
                let table = TransferFunction2d::from_settings(settings)?;
                (table.rgba, table.width, table.height, smallest_spacing / settings.gradient_max)
            }
        };
        let entries = sigma_table(&rgba, opacity, smallest_spacing);
        Ok(Self { values, gradients, entries, gradient_scale })
    }

    /// (σ r, σ g, σ b, σ) at a window value and a gradient magnitude (window value per scene unit).
    pub fn at(&self, value: f64, gradient: f64) -> [f64; 4] {
        let (i, x) = position(value, self.values);
        let row = |j: usize| mix(self.entries[j * self.values + i], self.entries[j * self.values + i + 1], x);
        let [r, g, b, sigma] = if self.gradients == 1 {
            row(0)
        } else {
            let (j, y) = position(gradient * self.gradient_scale, self.gradients);
            mix(row(j), row(j + 1), y)
        };
        [sigma * r, sigma * g, sigma * b, sigma]
    }

    /// The window values of the entries: the table is smooth between neighbours.
    pub fn knots(&self) -> impl Iterator<Item = f64> {
        let last = (self.values - 1) as f64;
        (0..self.values).map(move |k| k as f64 / last)
    }
}

/// Entry below and fraction to the next of a position in 0..1, clamped.
fn position(x: f64, entries: usize) -> (usize, f64) {
    let x = x.clamp(0.0, 1.0) * (entries - 1) as f64;
    let index = (x as usize).min(entries - 2);
    (index, x - index as f64)
}

fn mix(a: [f64; 4], b: [f64; 4], x: f64) -> [f64; 4] {
    std::array::from_fn(|c| a[c] + x * (b[c] - a[c]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_linear_and_clamped() {
        let entries = vec![[0.0; 4], [1.0; 4], [4.0; 4], [10.0; 4]];
        let line = Medium { values: 4, gradients: 1, entries: entries.clone(), gradient_scale: 0.0 };
        assert_eq!([-1.0, 0.0, 0.5, 1.0, 2.0].map(|v| line.at(v, 9.0)[3]), [0.0, 0.0, 2.5, 10.0, 10.0]);
        let square = Medium { values: 2, gradients: 2, entries, gradient_scale: 0.5 };
        assert_eq!(square.at(0.5, 1.0)[3], (0.5 + 7.0) / 2.0);
        assert_eq!(square.at(0.5, 1.0)[0], square.at(0.5, 1.0)[3].powi(2), "colour times extinction");
        assert_eq!(square.at(1.0, 5.0)[3], 10.0);
    }
}
