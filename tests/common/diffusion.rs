//! Media for the tests of the diffusion solver, on the device and in the twin.
//!
//! Each test file uses a part of this.
#![allow(dead_code)]

use crate::common::{device, noise};
use glam::DVec3;
use svetlo::device::{Buffer, Device};
use svetlo::diffusion::{Boundary, Coefficients, Outcome, Settings, Solution, Solver};
use svetlo::reference::diffusion::Diffusion;

pub const MIRROR: f64 = f64::INFINITY;

/// A box of cells with a medium.
pub struct Medium {
    pub dims: [usize; 3],
    pub spacing: DVec3,
    pub boundary: Boundary,
    pub absorption: Vec<f32>,
    pub diffusivity: Vec<f32>,
}

/// What a solve gave, with φ on the host.
pub struct Solved {
    pub phi: Vec<f64>,
    pub outcome: Outcome,
}

impl Medium {
    /// `dims` cells of `spacing`, open, with (σ_a, σ_tr) by the place of a cell's centre.
    pub fn new(dims: [usize; 3], spacing: DVec3, mut at: impl FnMut(DVec3) -> [f64; 2]) -> Self {
        let sigmas: Vec<[f64; 2]> = centres(dims, spacing).map(&mut at).collect();
        Self {
            dims,
            spacing,
            boundary: Boundary::OPEN,
            absorption: sigmas.iter().map(|[absorption, _]| *absorption as f32).collect(),
            diffusivity: sigmas.iter().map(|[_, transport]| (1.0 / (3.0 * transport)) as f32).collect(),
        }
    }

    /// A cube of edge 1 with extinction by place and 1 % of it absorption.
    pub fn cube(cells: usize, mut extinction: impl FnMut(DVec3) -> f64) -> Self {
        Self::new([cells; 3], DVec3::splat(1.0 / cells as f64), |p| {
            let sigma = extinction(p);
            [0.01 * sigma, sigma]
        })
    }

    /// A slab across z of thickness 1: a column between mirrors.
    pub fn slab(cells: usize, at: impl FnMut(DVec3) -> [f64; 2]) -> Self {
        let spacing = DVec3::new(1.0, 1.0, 1.0 / cells as f64);
        Self::new([1, 1, cells], spacing, at).between([MIRROR, MIRROR, 1.0])
    }

    /// With other boundaries.
    pub fn between(self, reflection: [f64; 3]) -> Self {
        Self { boundary: Boundary { reflection }, ..self }
    }

    /// The centres of all cells.
    pub fn centres(&self) -> impl Iterator<Item = DVec3> + use<> {
        centres(self.dims, self.spacing)
    }

    /// Solves on the device.
    pub fn try_solve(
        &self,
        device: &Device,
        source: &[f32],
        settings: &Settings,
    ) -> svetlo::Result<Solution> {
        let buffer = |values: &[f32]| Buffer::from_slice(device, values);
        let (absorption, diffusivity) = (buffer(&self.absorption)?, buffer(&self.diffusivity)?);
        let coefficients = Coefficients { absorption: &absorption, diffusivity: &diffusivity };
        let mut solver = Solver::new(device, self.dims, self.spacing, self.boundary)?;
        solver.solve(device, &coefficients, &buffer(source)?, settings)
    }

    /// Solves on the test device, to the tolerance.
    #[track_caller]
    pub fn solve(&self, source: &[f32], settings: &Settings) -> Solved {
        let device = device();
        let Solution { phi, outcome } = self.try_solve(&device, source, settings).unwrap();
        let phi: Vec<f64> = phi.read(&device).unwrap().into_iter().map(f64::from).collect();
        assert!(phi.iter().all(|phi| phi.is_finite() && *phi >= 0.0), "{:?}", settings.method);
        assert!(outcome.converged, "{:?}: {:e}", settings.method, outcome.residual);
        Solved { phi, outcome }
    }

    /// The same in double precision.
    pub fn twin(&self) -> Diffusion {
        let wide = |values: &[f32]| values.iter().map(|&value| f64::from(value)).collect();
        Diffusion {
            dims: self.dims,
            spacing: self.spacing.to_array(),
            reflection: self.boundary.reflection,
            absorption: wide(&self.absorption),
            diffusivity: wide(&self.diffusivity),
        }
    }
}

fn centres([nx, ny, nz]: [usize; 3], spacing: DVec3) -> impl Iterator<Item = DVec3> {
    let cell = move |i: usize| DVec3::new((i % nx) as f64, (i / nx % ny) as f64, (i / nx / ny) as f64);
    (0..nx * ny * nz).map(move |i| (cell(i) + 0.5) * spacing)
}

/// The four media by which solvers are judged: dense, thin, a dense ball in next to nothing, and cells that differ by
/// up to three decades.
pub fn media(cells: usize) -> [(&'static str, Medium); 4] {
    let ball = |p: DVec3| if p.distance(DVec3::splat(0.5)) < 0.3 { 200.0 } else { 0.05 };
    let mut random = noise(cells.pow(3), 11).into_iter();
    [
        ("dense", Medium::cube(cells, |_| 50.0)),
        ("thin", Medium::cube(cells, |_| 1.0)),
        ("ball", Medium::cube(cells, ball)),
        ("random", Medium::cube(cells, |_| 10_f64.powf(-1.0 + 3.3 * random.next().unwrap()))),
    ]
}

pub fn wide(values: &[f32]) -> Vec<f64> {
    values.iter().map(|&value| f64::from(value)).collect()
}
