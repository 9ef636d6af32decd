//! Emission-absorption along a ray: L = ∫ T q dt + T(D) L_bg, with T = exp(−∫σ) (Max 1995).
//!
//! The ray is cut where the integrand is not smooth: at the planes through voxel centres, and for functions of the
//! value alone at every table entry that the field crosses. Each part is integrated by Gauss–Legendre rules and
//! halved until halving changes nothing.

use super::camera::Ray;
use super::field::{Field, Piece};
use super::medium::Medium;
use super::quadrature::gauss_legendre;

/// Halving stops when it changes a part's radiance and optical depth by less than this.
const TOLERANCE: f64 = 1e-11;
/// Halvings at most: parts of 2⁻³⁰ of a cell cannot matter.
const DEPTH: u32 = 30;
/// Points of the rules.
const ORDER: usize = 8;

/// What a stretch of a ray adds: its own light, and how much it dims what lies behind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// ∫ T q dt per channel, for source colours as in the transfer function.
    pub radiance: [f64; 3],
    /// ∫ σ dt.
    pub depth: f64,
}

impl Stretch {
    /// Nothing.
    pub const EMPTY: Self = Self { radiance: [0.0; 3], depth: 0.0 };

    /// This stretch in front of another.
    pub fn before(self, behind: Self) -> Self {
        let transmittance = (-self.depth).exp();
        let radiance = std::array::from_fn(|c| self.radiance[c] + transmittance * behind.radiance[c]);
        Self { radiance, depth: self.depth + behind.depth }
    }

    /// exp(−depth).
    pub fn transmittance(&self) -> f64 {
        (-self.depth).exp()
    }
}

/// Integrates rays through a field and a medium.
pub struct Integrator<'a> {
    field: &'a Field,
    medium: &'a Medium,
    knots: Vec<f64>,
    rule: Vec<(f64, f64)>,
}

impl<'a> Integrator<'a> {
    /// An integrator of this field and medium.
    pub fn new(field: &'a Field, medium: &'a Medium) -> Self {
        Self { field, medium, knots: medium.knots().collect(), rule: gauss_legendre(ORDER) }
    }

    /// The whole ray inside the box.
    pub fn ray(&self, ray: &Ray) -> Stretch {
        let pieces = self.field.pieces(ray);
        pieces.iter().fold(Stretch::EMPTY, |front, piece| front.before(self.piece(ray, piece)))
    }

    /// One piece, cut where its field crosses table entries.
    fn piece(&self, ray: &Ray, piece: &Piece) -> Stretch {
        let one_d = self.medium.gradients == 1;
        let mut cuts = vec![0.0, 1.0];
        if one_d {
            let turns = piece.cubic.turning_points();
            let values = turns.iter().map(|&s| piece.cubic.value(s));
            let (low, high) =
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            let crossed = self.knots.iter().filter(|&&knot| knot >= low && knot <= high);
            cuts.extend(crossed.flat_map(|&knot| piece.cubic.crossings(knot)));
            cuts.sort_by(f64::total_cmp);
        }
        let medium = |s: f64| {
            let length = piece.end - piece.start;
            let gradient = if one_d { 0.0 } else { self.field.gradient(ray.at(piece.at(s))).length() };
            self.medium.at(piece.cubic.value(s), gradient).map(|x| x * length)
        };
        cuts.windows(2).fold(Stretch::EMPTY, |front, pair| {
            let whole = self.gauss(&medium, pair[0], pair[1]);
            front.before(self.refine(&medium, pair[0], pair[1], whole, DEPTH))
        })
    }

    /// Halves until nothing changes.
    fn refine(
        &self,
        medium: &impl Fn(f64) -> [f64; 4],
        from: f64,
        to: f64,
        whole: Stretch,
        depth: u32,
    ) -> Stretch {
        let middle = 0.5 * (from + to);
        let (first, second) = (self.gauss(medium, from, middle), self.gauss(medium, middle, to));
        let both = first.before(second);
        let change = (0..3).map(|c| (both.radiance[c] - whole.radiance[c]).abs()).fold(0.0, f64::max);
        if depth == 0 || change.max((both.depth - whole.depth).abs()) < TOLERANCE {
            return both;
        }
        self.refine(medium, from, middle, first, depth - 1).before(self.refine(
            medium,
            middle,
            to,
            second,
            depth - 1,
        ))
    }

    /// One application of the rule: the optical depth up to each node is a rule of its own.
    fn gauss(&self, medium: &impl Fn(f64) -> [f64; 4], from: f64, to: f64) -> Stretch {
        let width = to - from;
        let depth_to = |end: f64| -> f64 {
            self.rule.iter().map(|(x, w)| w * (end - from) * medium(from + x * (end - from))[3]).sum()
        };
        let mut stretch = Stretch { radiance: [0.0; 3], depth: depth_to(to) };
        for (x, w) in &self.rule {
            let s = from + x * width;
            let q = medium(s);
            if q[..3] == [0.0; 3] {
                continue;
            }
            let seen = w * width * (-depth_to(s)).exp();
            for (sum, q) in stretch.radiance.iter_mut().zip(q) {
                *sum += seen * q;
            }
        }
        stretch
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn slab(values: Vec<f64>) -> Field {
        Field { dims: [values.len(), 1, 1], spacing: DVec3::ONE, origin: DVec3::ZERO, values }
    }

    fn table(entries: Vec<[f64; 4]>) -> Medium {
        Medium { values: entries.len(), gradients: 1, entries, gradient_scale: 0.0 }
    }

    fn across() -> Ray {
        Ray::towards(DVec3::new(-2.0, 0.5, 0.5), DVec3::new(0.0, 0.5, 0.5))
    }

    #[test]
    fn a_constant_medium_has_a_closed_form() {
        let medium = table(vec![[0.25, 0.5, 0.0, 2.0]; 2]);
        let stretch = Integrator::new(&slab(vec![0.3; 4]), &medium).ray(&across());
        assert!((stretch.depth - 8.0).abs() < 1e-13);
        // Source colour (1/4, 1/2, 0).
        let opacity = -(-8.0f64).exp_m1();
        assert!((stretch.radiance[0] - 0.25 * opacity).abs() < 1e-12);
        assert!((stretch.radiance[1] - 0.5 * opacity).abs() < 1e-12);
        assert_eq!(stretch.radiance[2], 0.0);
    }

    #[test]
    fn emission_that_grows_while_extinction_stays_has_a_closed_form() {
        // v = x over one unit between voxel centres, constant outside: σ = 1, q = v.
        let medium = table(vec![[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0]]);
        let stretch = Integrator::new(&slab(vec![0.0, 1.0]), &medium).ray(&across());
        // ∫₀¹ x e^{−(x+½)} dx + ∫_{3/2}^2 e^{−t} dt = e^{−½}(1 − 2/e) + e^{−3/2} − e^{−2}.
        let exact = (-0.5f64).exp() * (1.0 - 2.0 * (-1.0f64).exp()) + (-1.5f64).exp() - (-2.0f64).exp();
        assert!((stretch.radiance[0] - exact).abs() < 1e-12, "{} {exact}", stretch.radiance[0]);
    }

    #[test]
    fn a_kinked_function_is_cut_where_it_bends() {
        // σ = max(0, 10 (v − 0.5)) over v = 0..1: ∫ = 10·⅛, and 5 over the last half unit.
        let medium = table(vec![[0.0; 4], [0.0; 4], [0.0, 0.0, 0.0, 5.0]]);
        let stretch = Integrator::new(&slab(vec![0.0, 1.0]), &medium).ray(&across());
        assert!((stretch.depth - 3.75).abs() < 1e-12, "{}", stretch.depth);
    }

    #[test]
    fn a_two_dimensional_function_of_the_value_alone_agrees_with_one_dimension() {
        let entries = vec![[0.0, 0.1, 0.0, 0.2], [0.5, 0.0, 2.0, 3.0], [0.1, 0.0, 0.0, 0.1]];
        let line = table(entries.clone());
        let plane = Medium {
            gradients: 2,
            entries: [entries.clone(), entries].concat(),
            gradient_scale: 1.0,
            ..line
        };
        let field = Field { dims: [2, 2, 2], ..slab((0..8).map(|i| f64::from(i * 5 % 8) / 7.0).collect()) };
        let line = table(plane.entries[..3].to_vec());
        let ray = Ray::towards(DVec3::new(-1.0, 0.2, 0.4), DVec3::new(2.0, 1.7, 1.1));
        let (a, b) = (Integrator::new(&field, &line).ray(&ray), Integrator::new(&field, &plane).ray(&ray));
        assert!(
            (a.depth - b.depth).abs() < 1e-9 && (a.radiance[2] - b.radiance[2]).abs() < 1e-9,
            "{a:?} {b:?}"
        );
    }
}
