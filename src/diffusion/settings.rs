//! What a solve is given and what it gives back.

use crate::device::Buffer;
use std::ops::ControlFlow;

/// What happens at the six sides of the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boundary {
    /// A of Marshak's condition φ + 2A D ∂φ/∂n = 0 at the two sides across each axis: 1 where the refractive index
    /// does not change, (1 + F_dr) / (1 − F_dr) where it does, infinite at a mirror.
    pub reflection: [f64; 3],
}

impl Boundary {
    /// Nothing is reflected.
    pub const OPEN: Self = Self { reflection: [1.0; 3] };
}

/// The medium: one number per cell, x fastest.
#[derive(Clone, Copy)]
pub struct Coefficients<'a> {
    /// Absorption σ_a, 1/length; 0 or more.
    pub absorption: &'a Buffer<f32>,
    /// Diffusivity D = 1 / (3 σ_tr), length; more than 0, infinite in a vacuum.
    pub diffusivity: &'a Buffer<f32>,
}

/// How to solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Explicit steps of each cell's own largest stable length (Jacobi): as many as N² for N cells along an edge.
    Explicit,
    /// Red–black successive over-relaxation; without a factor, the best one for a box whose boundary absorbs.
    OverRelaxation {
        /// Between 0 and 2.
        factor: Option<f64>,
    },
    /// Conjugate gradients, preconditioned by the diagonal: as many iterations as N.
    ConjugateGradients,
    /// Conjugate gradients, preconditioned by a multigrid cycle: 10 to 20 iterations whatever the size.
    Multigrid,
}

/// When to stop, and where the diffusion equation ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// How.
    pub method: Method,
    /// Largest ‖Q − Aφ‖ / ‖Q‖ at which to stop, once ten times this bounds the imbalance, too.
    pub tolerance: f64,
    /// Iterations after which to stop anyway.
    pub max_iterations: usize,
    /// Least optical thickness (reduced) of the box's longest edge: near vacuum, diffusivity is limited to this.
    pub floor: f64,
}

impl Settings {
    /// A method with its usual limits.
    pub fn new(method: Method) -> Self {
        let max_iterations = match method {
            Method::Explicit => 200_000,
            Method::OverRelaxation { .. } => 20_000,
            Method::ConjugateGradients => 10_000,
            Method::Multigrid => 200,
        };
        Self { method, tolerance: 1e-6, max_iterations, floor: 1e-2 }
    }
}

/// Who watches a solve: told now and then how many iterations there were and the relative residual; a break ends it.
pub type Observer<'a> = dyn FnMut(usize, f64) -> ControlFlow<()> + 'a;

/// What a solve found.
pub struct Solution {
    /// Fluence φ ≥ 0 of each cell, x fastest, in units of the source times length.
    pub phi: Buffer<f32>,
    /// How it came about.
    pub outcome: Outcome,
}

/// How a solve went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Iterations done.
    pub iterations: usize,
    /// ‖Q − Aφ‖ / ‖Q‖, computed from the solution itself.
    pub residual: f64,
    /// |ΣQ − ΣAφ| / ΣQ: power that is neither absorbed nor leaves.
    pub imbalance: f64,
    /// Whether residual and imbalance are within the tolerance.
    pub converged: bool,
    /// Iterations and relative residual after them, from 0 iterations on, as the iteration estimated it or, where it was
    /// checked, as it is; empty without a source.
    pub history: Vec<(usize, f64)>,
    /// Cells whose diffusivity was limited by [`Settings::floor`].
    pub floor_cells: u64,
}
