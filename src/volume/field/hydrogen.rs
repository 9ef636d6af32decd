//! Electron densities of the hydrogen atom.
//!
//! Source: L. Landau & E. Lifshitz, *Quantum Mechanics*, §36, in atomic units; real spherical harmonics.

use super::simple::checked_aspect;
use super::{Field, FieldError};
use glam::DVec3;
use std::f64::consts::PI;

/// Largest principal quantum number: beyond it a grid of usual size does not resolve the shells.
const MAX_N: u32 = 10;
/// Samples in the searches for a maximum; the nodes are at least 20 times as far apart.
const SEARCH: u32 = 8192;

/// The probability density `|ψ_nlm|²` over its maximum in space, hence in [0, 1] on every grid.
///
/// `ψ_nlm = R_nl(r) Y_lm(θ, φ)` with `∫|ψ|² d³x = 1`; `Y_lm` is real: `∝ cos mφ` for m ≥ 0, `∝ sin |m|φ` for m < 0.
/// Its own coordinates are Bohr radii from the nucleus, `x = (2p − 1)·extent·aspect`, so that orbitals keep their
/// shape in a box that is not a cube. The gradient of an s orbital at the nucleus, a cusp, is given as 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hydrogen {
    n: u32,
    l: u32,
    m: i32,
    /// Half the box along each axis, in Bohr radii.
    half: DVec3,
    /// Factor of ψ that normalises it.
    norm: f64,
    /// `max |ψ|²`, in inverse cubic Bohr radii.
    peak: f64,
}

impl Hydrogen {
    /// The orbital with quantum numbers n, l, m in a box whose largest half extent is `extent` Bohr radii.
    /// `aspect` is the extent of the box along each axis over the largest one.
    ///
    /// # Errors
    /// When not 1 ≤ n ≤ 10, l < n and |m| ≤ l, or the extent is not in (0, 10⁶], or the aspect not in (0, 1].
    pub fn new(n: u32, l: u32, m: i32, extent: f64, aspect: DVec3) -> Result<Self, FieldError> {
        if !(1..=MAX_N).contains(&n) {
            return Err(FieldError::new("n", n, format!("it must be from 1 to {MAX_N}")));
        }
        if l >= n {
            return Err(FieldError::new("l", l, format!("it must be from 0 to {} for n = {n}", n - 1)));
        }
        if m.unsigned_abs() > l {
            return Err(FieldError::new("m", m, format!("it must be from -{l} to {l} for l = {l}")));
        }
        if !(extent > 0.0 && extent <= 1e6) {
            return Err(FieldError::new(
                "extent",
                extent,
                "it must be greater than 0 and at most 1e6 Bohr radii",
            ));
        }
        let half = extent * checked_aspect(aspect)?;
        let mut orbital = Self { n, l, m, half, norm: normalisation(n, l, m.unsigned_abs()), peak: 1.0 };
        orbital.peak = orbital.find_peak();
        Ok(orbital)
    }

    /// A half extent in Bohr radii that holds all but a few thousandths of the electron: `2n(n + 2)`.
    pub fn default_extent(n: u32) -> f64 {
        let n = f64::from(n);
        2.0 * n * (n + 2.0)
    }

    /// `max |ψ|²` in inverse cubic Bohr radii: the density is `value · peak`.
    pub fn peak(&self) -> f64 {
        self.peak
    }

    /// `|ψ|²` is a product of functions of r, θ and φ, so its maximum is the product of theirs; that of φ is 1.
    fn find_peak(&self) -> f64 {
        let power = self.l as i32;
        let m = self.m.unsigned_abs();
        let far = 4.0 * f64::from(self.n * self.n);
        let radial = maximum(far, |r| (self.radial(r).0 * r.powi(power)).powi(2));
        let polar = maximum(1.0, |u| {
            let sine = (1.0 - u * u).max(0.0).sqrt();
            (solid_legendre(self.l, m, u, 1.0).0 * sine.powi(m as i32)).powi(2)
        });
        self.norm * self.norm * radial * polar
    }

    /// `g(r) = e^{−r/n} L_{n−l−1}^{2l+1}(2r/n)` and `dg/dr`.
    fn radial(&self, r: f64) -> (f64, f64) {
        let n = f64::from(self.n);
        let (degree, order) = (self.n - self.l - 1, f64::from(2 * self.l + 1));
        let argument = 2.0 * r / n;
        let polynomial = laguerre(degree, order, argument);
        // d/dx L_k^a = −L_{k−1}^{a+1}
        let slope = if degree == 0 { 0.0 } else { -laguerre(degree - 1, order + 1.0, argument) };
        let decay = (-r / n).exp();
        (decay * polynomial, decay * (2.0 * slope - polynomial) / n)
    }

    /// ψ and its gradient at `x`, in Bohr radii.
    fn amplitude(&self, x: DVec3) -> (f64, DVec3) {
        let r = x.length();
        let (g, g_slope) = self.radial(r);
        let (s, s_gradient) = self.solid_harmonic(x);
        let gradient = g_slope * s * x.normalize_or_zero() + g * s_gradient;
        (self.norm * g * s, self.norm * gradient)
    }

    /// The polynomial `r^l Y_lm` without its factor, and its gradient.
    fn solid_harmonic(&self, x: DVec3) -> (f64, DVec3) {
        let m = self.m.unsigned_abs();
        let (polar, by_z, by_s) = solid_legendre(self.l, m, x.z, x.length_squared());
        let polar_gradient = 2.0 * by_s * x + DVec3::Z * by_z;
        // (x + iy)^m and its derivative m (x + iy)^{m−1}
        let lower = complex_power(x.x, x.y, m.saturating_sub(1));
        let (re, im) = complex_power(x.x, x.y, m);
        let m = f64::from(m);
        let (wave, wave_gradient) = if self.m >= 0 {
            (re, DVec3::new(m * lower.0, -m * lower.1, 0.0))
        } else {
            (im, DVec3::new(m * lower.1, m * lower.0, 0.0))
        };
        (polar * wave, polar_gradient * wave + polar * wave_gradient)
    }

    fn position(&self, p: DVec3) -> DVec3 {
        (2.0 * p - 1.0) * self.half
    }
}

impl Field for Hydrogen {
    fn value(&self, p: DVec3) -> f64 {
        let (psi, _) = self.amplitude(self.position(p));
        psi * psi / self.peak
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        let (psi, gradient) = self.amplitude(self.position(p));
        2.0 * psi * gradient / self.peak
    }

    fn extent(&self) -> DVec3 {
        2.0 * self.half
    }
}

/// The factor that makes `∫|ψ|² = 1` for `ψ = norm · g(r) · r^l Π(z) Re or Im (x + iy)^m`.
fn normalisation(n: u32, l: u32, m: u32) -> f64 {
    let scale = 2.0 / f64::from(n);
    let radial = scale.powi(3) * falling(n + l, 2 * l + 1).recip() / (2.0 * f64::from(n));
    let angular = f64::from(2 * l + 1) / (4.0 * PI) / falling(l + m, 2 * m);
    let azimuth = if m == 0 { 1.0 } else { 2.0 };
    (radial * angular * azimuth).sqrt() * scale.powi(l as i32)
}

/// `a! / (a − count)!`.
fn falling(a: u32, count: u32) -> f64 {
    (a - count + 1..=a).map(f64::from).product()
}

/// The associated Laguerre polynomial `L_k^a(x)`, by its three-term recurrence.
fn laguerre(k: u32, a: f64, x: f64) -> f64 {
    let (mut before, mut current) = (0.0, 1.0);
    for j in 0..k {
        let j = f64::from(j);
        let next = ((2.0 * j + 1.0 + a - x) * current - (j + a) * before) / (j + 1.0);
        (before, current) = (current, next);
    }
    current
}

/// `Π(z, s) = r^{l−m} d^m P_l(u)/du^m` at `u = z/r`, `s = r²`, a polynomial in z and s, with ∂Π/∂z and ∂Π/∂s.
///
/// It follows from the recurrence of the associated Legendre functions,
/// `(l−m) Π_l = (2l−1) z Π_{l−1} − (l+m−1) s Π_{l−2}`, differentiated term by term.
fn solid_legendre(l: u32, m: u32, z: f64, s: f64) -> (f64, f64, f64) {
    let start: f64 = (1..=m).map(|k| f64::from(2 * k - 1)).product();
    let (mut before, mut current) = ((0.0, 0.0, 0.0), (start, 0.0, 0.0));
    for degree in m + 1..=l {
        let a = f64::from(2 * degree - 1);
        let b = f64::from(degree + m - 1);
        let c = f64::from(degree - m);
        let next = (
            (a * z * current.0 - b * s * before.0) / c,
            (a * (current.0 + z * current.1) - b * s * before.1) / c,
            (a * z * current.2 - b * (before.0 + s * before.2)) / c,
        );
        (before, current) = (current, next);
    }
    current
}

/// Real and imaginary part of `(x + iy)^m`.
fn complex_power(x: f64, y: f64, m: u32) -> (f64, f64) {
    (0..m).fold((1.0, 0.0), |(re, im), _| (re * x - im * y, re * y + im * x))
}

/// The maximum of a function on `[0, end]`: the best of many samples, refined by golden-section search.
fn maximum(end: f64, f: impl Fn(f64) -> f64) -> f64 {
    let step = end / f64::from(SEARCH);
    let best =
        (0..=SEARCH).map(|i| f64::from(i) * step).fold(0.0, |best, x| if f(x) > f(best) { x } else { best });
    let ratio = (5f64.sqrt() - 1.0) / 2.0;
    let (mut low, mut high) = ((best - step).max(0.0), (best + step).min(end));
    // 60 steps shrink the bracket by 3e-13; the value is then exact to rounding, as it is flat there.
    for _ in 0..60 {
        let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
        if f(a) > f(b) { high = b } else { low = a }
    }
    f(best).max(f((low + high) / 2.0))
}
