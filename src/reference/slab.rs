//! Plane-parallel scattering slabs by adding–doubling (van de Hulst 1980), azimuthally averaged.
//!
//! A layer turns the radiances that enter it into those that leave it: I_out = r·I_in on the same side and t·I_in on the
//! other, as matrices over the cosines of a Gauss rule on [0, 1]. A layer thin enough for the implicit midpoint rule is
//! doubled until it has the optical thickness asked for. The Henyey–Greenstein phase function enters by its Legendre
//! moments gˡ, of which the rule carries l < 2n exactly; so g up to 0.9 needs n = 96. Cosines of interest are nodes of
//! weight 0.

use super::quadrature::gauss_legendre;

/// A homogeneous slab with matched refractive index.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slab {
    /// Optical thickness, > 0.
    pub tau: f64,
    /// Single-scattering albedo, 0..=1.
    pub albedo: f64,
    /// Mean cosine of the Henyey–Greenstein phase function, |g| ≤ 0.9.
    pub g: f64,
}

/// What a slab makes of light 1: hemispherical reflectance and transmittance for collimated light at a cosine, and by
/// reciprocity the radiance that leaves at that cosine on the side of an isotropic radiance 1, and on the other side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Reflectance.
    pub reflected: f64,
    /// Transmittance, with the light that was not scattered.
    pub transmitted: f64,
}

/// Nodes of the Gauss rule on [0, 1].
const NODES: usize = 96;
/// Optical thickness of the first layer, at most.
const THIN: f64 = 1e-4;

impl Slab {
    /// The slab's response at each of the cosines `at`, in 0..=1 exclusive of 0.
    pub fn responses(&self, at: &[f64]) -> Vec<Response> {
        let rule = gauss_legendre(NODES);
        let weightless = at.iter().map(|&mu| (mu, 0.0));
        let nodes: Vec<(f64, f64)> = rule.into_iter().chain(weightless).collect();
        let doublings = (self.tau / THIN).log2().ceil().max(0.0) as i32;
        let (mut r, mut t) = self.thin_layer(&nodes, self.tau / 2f64.powi(doublings));
        for _ in 0..doublings {
            // What goes back and forth between the halves: t (1 − r r)⁻¹ t, and r + t r (1 − r r)⁻¹ t.
            let between = r.times(&r).scaled(-1.0).plus_identity(1.0).solve(&t);
            (r, t) = (r.plus(&t.times(&r.times(&between))), t.times(&between));
        }
        let sum = |matrix: &Matrix, row: usize| (0..NODES).map(|column| matrix.at(row, column)).sum();
        // The diagonal of `t` holds the light that is not scattered; a node of weight 0 gets it from itself.
        let row =
            |row: usize| Response { reflected: sum(&r, row), transmitted: sum(&t, row) + t.at(row, row) };
        (NODES..nodes.len()).map(row).collect()
    }

    /// Reflection and transmission of a layer by the implicit midpoint rule: the sum of both sides' radiances and their
    /// difference decouple, and obey x_out = (1 + G)⁻¹(1 − G) x_in with G = (A ∓ B).
    fn thin_layer(&self, nodes: &[(f64, f64)], thickness: f64) -> (Matrix, Matrix) {
        let even = self.cayley(nodes, thickness, 1.0);
        let odd = self.cayley(nodes, thickness, -1.0);
        let reflection = even.plus(&odd.scaled(-1.0)).scaled(0.5);
        (reflection, even.plus(&odd).scaled(0.5))
    }

    /// The operator on the sum (`sign` 1) or difference (−1) of the radiances that go up and down.
    fn cayley(&self, nodes: &[(f64, f64)], thickness: f64, sign: f64) -> Matrix {
        let generator = Matrix::from_fn(nodes.len(), |i, j| {
            let (mu, _) = nodes[i];
            let (other, weight) = nodes[j];
            let (forward, backward) = self.redistribution(mu, other);
            let loss = if i == j { 1.0 } else { 0.0 };
            let gain = 0.5 * self.albedo * weight * (forward + sign * backward);
            0.5 * thickness * (loss - gain) / mu
        });
        let minus = generator.scaled(-1.0).plus_identity(1.0);
        generator.plus_identity(1.0).solve(&minus)
    }

    /// Azimuthal means of 4π times the phase function between two cosines, in the same hemisphere and across:
    /// Σ (2l + 1) gˡ P_l(μ) P_l(±μ').
    fn redistribution(&self, mu: f64, other: f64) -> (f64, f64) {
        let (mut a, mut b) = ((1.0, mu), (1.0, other));
        let (mut even, mut odd) = (0.0, 0.0);
        for l in 0..2 * NODES {
            let order = l as f64;
            let term = (2.0 * order + 1.0) * self.g.powi(l as i32) * a.0 * b.0;
            if l % 2 == 0 {
                even += term;
            } else {
                odd += term;
            }
            let next = |(before, value): (f64, f64), x: f64| {
                (value, ((2.0 * order + 3.0) * x * value - (order + 1.0) * before) / (order + 2.0))
            };
            (a, b) = (next(a, mu), next(b, other));
        }
        (even + odd, even - odd)
    }
}

/// A dense square matrix, row by row.
#[derive(Clone)]
struct Matrix {
    size: usize,
    entries: Vec<f64>,
}

impl Matrix {
    fn from_fn(size: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let entry = &entry;
        Self { size, entries: (0..size).flat_map(|i| (0..size).map(move |j| entry(i, j))).collect() }
    }

    fn at(&self, row: usize, column: usize) -> f64 {
        self.entries[row * self.size + column]
    }

    fn scaled(&self, factor: f64) -> Self {
        Self { size: self.size, entries: self.entries.iter().map(|x| factor * x).collect() }
    }

    fn plus(&self, other: &Self) -> Self {
        let entries = self.entries.iter().zip(&other.entries).map(|(a, b)| a + b).collect();
        Self { size: self.size, entries }
    }

    fn plus_identity(mut self, factor: f64) -> Self {
        self.entries.iter_mut().step_by(self.size + 1).for_each(|x| *x += factor);
        self
    }

    fn times(&self, other: &Self) -> Self {
        let mut product = Self { size: self.size, entries: vec![0.0; self.entries.len()] };
        for (row, out) in self.entries.chunks(self.size).zip(product.entries.chunks_mut(self.size)) {
            for (factor, from) in row.iter().zip(other.entries.chunks(self.size)) {
                out.iter_mut().zip(from).for_each(|(out, x)| *out += factor * x);
            }
        }
        product
    }

    /// self⁻¹·`right`, by Gaussian elimination. No pivots are sought: these matrices are 1 plus a part that spreads
    /// less than it takes.
    fn solve(mut self, right: &Self) -> Self {
        let n = self.size;
        let mut solution = right.clone();
        let eliminate = |entries: &mut [f64], from: usize, to: usize, factor: f64| {
            let (low, high) = entries.split_at_mut(from.max(to) * n);
            let (source, target) = if from < to {
                (&low[from * n..][..n], &mut high[..n])
            } else {
                (&high[..n], &mut low[to * n..][..n])
            };
            target.iter_mut().zip(source).for_each(|(t, s)| *t -= factor * s);
        };
        for pivot in 0..n {
            for row in (0..n).filter(|&row| row != pivot) {
                let factor = self.at(row, pivot) / self.at(pivot, pivot);
                eliminate(&mut self.entries, pivot, row, factor);
                eliminate(&mut solution.entries, pivot, row, factor);
            }
        }
        for (row, entries) in solution.entries.chunks_mut(n).enumerate() {
            let pivot = self.entries[row * n + row];
            entries.iter_mut().for_each(|x| *x /= pivot);
        }
        solution
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    fn truths() -> Value {
        serde_json::from_str(include_str!("../../tests/truths.json")).unwrap()
    }

    #[test]
    fn every_published_row_is_met_to_seven_digits() {
        for row in truths()["slab_collimated"]["rows"].as_array().unwrap() {
            let number = |key: &str| row[key].as_f64().unwrap();
            let slab = Slab { tau: number("tau"), albedo: number("albedo"), g: number("g") };
            let response = slab.responses(&[number("mu0")])[0];
            println!(
                "{slab:?} {:.2e} {:.2e}",
                response.reflected - number("R"),
                response.transmitted - number("T")
            );
            assert!((response.reflected - number("R")).abs() < 1e-7, "{slab:?} {response:?} {row}");
            assert!((response.transmitted - number("T")).abs() < 1e-7, "{slab:?} {response:?} {row}");
        }
    }

    #[test]
    fn slabs_in_uniform_light_shine_as_published() {
        for row in truths()["slab_uniform"]["rows"].as_array().unwrap() {
            let number = |key: &str| row[key].as_f64().unwrap();
            let slab = Slab { tau: number("tau"), albedo: number("w"), g: 0.0 };
            let rule = gauss_legendre(24);
            let cosines: Vec<f64> = rule.iter().map(|node| node.0).chain([1.0]).collect();
            let responses = slab.responses(&cosines);
            let radiance: Vec<f64> = responses.iter().map(|r| r.reflected + r.transmitted).collect();
            assert!((radiance[24] - number("L_mu1")).abs() < 1e-7, "{slab:?} {}", radiance[24]);
            let exitance =
                rule.iter().zip(&radiance).map(|((mu, weight), l)| 2.0 * weight * mu * l).sum::<f64>();
            let exitance = std::f64::consts::PI * exitance;
            assert!((exitance - number("flux")).abs() < 1e-5, "{slab:?} {exitance}");
        }
    }
}
