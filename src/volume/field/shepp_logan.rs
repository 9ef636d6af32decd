//! The three-dimensional Shepp–Logan head phantom.
//!
//! Source: M. Schabel, *3D Shepp–Logan phantom* (MATLAB File Exchange 9416), with the intensities of P. Toft,
//! *The Radon Transform*, 1996, pp. 199–200.

use super::Field;
use glam::{DMat3, DVec3};

/// How the tilted ellipsoids are turned; the two published conventions differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rotation {
    /// About the origin, so that the centres move too: what Schabel's program does.
    #[default]
    Schabel,
    /// About each ellipsoid's own centre.
    OwnAxis,
}

/// Ten ellipsoids of constant density that add up; 0 outside the head, 1 in the skull.
///
/// Its own coordinates are `q = 2p − 1 ∈ [−1, 1]³`. It is piecewise constant, so its gradient is 0.
#[derive(Debug, Clone, PartialEq)]
pub struct SheppLogan {
    ellipsoids: Box<[Ellipsoid]>,
}

/// Density, semi-axes, centre, and the Euler angles φ and ψ in degrees; θ is 0 throughout.
type Row = (f64, [f64; 3], [f64; 3], f64, f64);

#[rustfmt::skip]
const TABLE: [Row; 10] = [
    ( 1.0, [0.69,   0.92,  0.81], [ 0.0,   0.0,     0.0 ],   0.0,  0.0),
    (-0.8, [0.6624, 0.874, 0.78], [ 0.0,  -0.0184,  0.0 ],   0.0,  0.0),
    (-0.2, [0.11,   0.31,  0.22], [ 0.22,  0.0,     0.0 ], -18.0, 10.0),
    (-0.2, [0.16,   0.41,  0.28], [-0.22,  0.0,     0.0 ],  18.0, 10.0),
    ( 0.1, [0.21,   0.25,  0.41], [ 0.0,   0.35,   -0.15],   0.0,  0.0),
    ( 0.1, [0.046,  0.046, 0.05], [ 0.0,   0.1,     0.25],   0.0,  0.0),
    ( 0.1, [0.046,  0.046, 0.05], [ 0.0,  -0.1,     0.25],   0.0,  0.0),
    ( 0.1, [0.046,  0.023, 0.05], [-0.08, -0.605,   0.0 ],   0.0,  0.0),
    ( 0.1, [0.023,  0.023, 0.02], [ 0.0,  -0.606,   0.0 ],   0.0,  0.0),
    ( 0.1, [0.023,  0.046, 0.02], [ 0.06, -0.605,   0.0 ],   0.0,  0.0),
];

#[derive(Debug, Clone, Copy, PartialEq)]
struct Ellipsoid {
    density: f64,
    /// Maps `q` to a space in which the ellipsoid is the unit ball around `centre`.
    to_ball: DMat3,
    centre: DVec3,
}

impl Ellipsoid {
    fn new((density, axes, centre, phi, psi): Row, rotation: Rotation) -> Self {
        // With θ = 0 the Euler angles add up to one rotation about z.
        let (sin, cos) = (phi + psi).to_radians().sin_cos();
        let turn = DMat3::from_cols(DVec3::new(cos, -sin, 0.0), DVec3::new(sin, cos, 0.0), DVec3::Z);
        let shrink = DMat3::from_diagonal(DVec3::from_array(axes).recip());
        let to_ball = shrink * turn;
        let centre = DVec3::from_array(centre);
        let centre = match rotation {
            Rotation::Schabel => shrink * centre,
            Rotation::OwnAxis => to_ball * centre,
        };
        Self { density, to_ball, centre }
    }

    fn contains(&self, q: DVec3) -> bool {
        (self.to_ball * q - self.centre).length_squared() <= 1.0
    }
}

impl SheppLogan {
    /// The phantom in one of the two conventions.
    pub fn new(rotation: Rotation) -> Self {
        Self { ellipsoids: TABLE.into_iter().map(|row| Ellipsoid::new(row, rotation)).collect() }
    }
}

impl Field for SheppLogan {
    fn value(&self, p: DVec3) -> f64 {
        let q = 2.0 * p - 1.0;
        self.ellipsoids.iter().filter(|e| e.contains(q)).map(|e| e.density).sum()
    }

    fn gradient(&self, _: DVec3) -> DVec3 {
        DVec3::ZERO
    }

    fn extent(&self) -> DVec3 {
        DVec3::splat(2.0)
    }
}
