//! The steady diffusion equation −∇·(D∇φ) + σ_a φ = Q on a box of cells, on the device.
//!
//! Finite volumes: the diffusivity of a face is the harmonic mean of its cells', and nothing comes in from outside
//! (Marshak's condition φ + 2A D ∂φ/∂n = 0). One solve is one channel of colour. Fields are float32 boxes, x fastest;
//! the solution is kept as a sum of two floats, so that its residual can be made as small as is asked for, and the
//! residual that is reported is that of the equation, not the iteration's own estimate.
//!
//! - [`Solver`], [`Coefficients`], [`Settings`], [`Method`], [`Solution`], [`Outcome`]: what callers need
//! - `grid`: levels, how their cells are stored, and how they are coarsened
//! - `fields`, `launch`: device memory and kernels
//! - `multigrid`, `coarsest`: the preconditioner
//! - `krylov`, `stationary`: the iterations

mod coarsest;
mod fields;
mod grid;
mod krylov;
mod launch;
mod multigrid;
mod settings;
mod solver;
mod stationary;

pub use grid::DeviceDiffusionGrid;
pub use settings::{Boundary, Coefficients, Method, Observer, Outcome, Settings, Solution};
pub use solver::Solver;
