//! Scenes for the tests of scattered light: a medium of voxels, direct light by a formula, the solution on the host.
//!
//! Each test file uses a part of this.
#![allow(dead_code)]

use crate::common::{Case, device, volume_f32};
use glam::DVec3;
use std::ops::ControlFlow;
use svetlo::Result;
use svetlo::device::{Buffer, Device};
use svetlo::diffusion::Method;
use svetlo::irradiance::{
    ChannelFacts, DirectLight, LightGrid, Limiter, LitMedium, ScatterObserver, ScatterSettings,
    ScatterSolver, ScatteredLight,
};
use svetlo::reference::diffusion::Diffusion;

/// Opacity is the value.
const RAMP: &str =
    "[transfer]\nresolution = 2\npoints = [{ value = 0, opacity = 0 }, { value = 1, opacity = 1 }]\n";

pub const MIRROR: f64 = f64::INFINITY;

/// A scene whose voxels' values are extinctions over `sigma_max` (per scene unit), all of albedo `albedo`.
pub struct Lit {
    pub case: Case,
    pub settings: ScatterSettings,
    /// Cells of the solution and of the direct light, in voxels along each axis.
    pub coarsening: [usize; 2],
    pub device: Device,
}

/// What was found, on the host, lengths in local units.
pub struct Found {
    pub grid: LightGrid,
    /// rgb of each cell of the direct light's grid.
    pub fluence: Vec<[f64; 3]>,
    pub drift: Option<Vec<DVec3>>,
    pub channels: Vec<ChannelFacts>,
}

impl Found {
    pub fn centres(&self) -> impl Iterator<Item = DVec3> + use<> {
        centres(self.grid)
    }

    /// The first channel.
    pub fn grey(&self) -> Vec<f64> {
        self.fluence.iter().map(|rgb| rgb[0]).collect()
    }
}

/// Centres of cells, local units.
pub fn centres(grid: LightGrid) -> impl Iterator<Item = DVec3> {
    let [nx, ny, _] = grid.dims;
    let cell = move |i: usize| DVec3::new((i % nx) as f64, (i / nx % ny) as f64, (i / nx / ny) as f64);
    (0..grid.cells()).map(move |i| (cell(i) + 0.5) * grid.cell)
}

impl Lit {
    /// Voxels of `spacing`, with extinction by the place of their centres (scene units, from the box's corner), at most
    /// `sigma_max`; `more`: the rest of `[medium]`, and further tables of the scene.
    pub fn new(
        dims: [usize; 3],
        spacing: DVec3,
        sigma_max: f64,
        more: &str,
        mut extinction: impl FnMut(DVec3) -> f64,
    ) -> Self {
        let [nx, ny, nz] = dims;
        let voxel = |i: usize| DVec3::new((i % nx) as f64, (i / nx % ny) as f64, (i / nx / ny) as f64);
        let values = (0..nx * ny * nz).map(|i| extinction((voxel(i) + 0.5) * spacing) / sigma_max);
        let text = format!(
            "[camera]\nposition = [-100, 0, 0]\ntarget = [0, 0, 0]\n[method]\nkind = \"single-scattering\"\n\
             [volume]\nspacing = {:?}\norigin = [0, 0, 0]\nwindow = {{ lo = 0, hi = 1 }}\n\
             {}[medium]\nsigma_max = {sigma_max:?}\n{more}\n",
            spacing.to_array(),
            if more.contains("[transfer]") { "" } else { RAMP }
        );
        Self {
            case: Case::new(&text, volume_f32(dims, values)),
            settings: ScatterSettings {
                limiter: Limiter::None,
                tolerance: 1e-6,
                ..ScatterSettings::new(Method::Multigrid)
            },
            coarsening: [1, 1],
            device: device(),
        }
    }

    /// A slab across z of thickness 1 between mirrors: cells of a cube's shape are too many, so voxels are long across.
    pub fn slab(cells: usize, sigma_max: f64, more: &str, extinction: impl FnMut(DVec3) -> f64) -> Self {
        let spacing = DVec3::new(1.0, 1.0, 1.0 / cells as f64);
        let mut lit = Self::new([1, 1, cells], spacing, sigma_max, more, extinction);
        lit.settings.reflection = [MIRROR, MIRROR, 1.0];
        lit
    }

    /// The grid of direct light.
    pub fn grid(&self) -> LightGrid {
        LightGrid::new(&self.case.plan().local, self.coarsening[1])
    }

    /// Scene units per local unit.
    pub fn unit(&self) -> f64 {
        self.case.plan().local.unit
    }

    /// The grid of the solution.
    pub fn coarse(&self) -> LightGrid {
        LightGrid::new(&self.case.plan().local, self.coarsening[0])
    }

    /// Direct light by place in scene units.
    pub fn direct(&self, fluence: impl FnMut(DVec3) -> [f64; 3]) -> DirectLight {
        DirectLight { fluence: self.upload(fluence), reduced: None, flow: None, extent: None }
    }

    /// A field on the direct light's grid by place in scene units.
    pub fn upload(&self, mut value: impl FnMut(DVec3) -> [f64; 3]) -> Buffer<[f32; 4]> {
        let unit = self.unit();
        let rgb = |p: DVec3| {
            let [r, g, b] = value(p * unit).map(|v| v as f32);
            [r, g, b, 0.0]
        };
        let values: Vec<[f32; 4]> = centres(self.grid()).map(rgb).collect();
        Buffer::from_slice(&self.device, &values).unwrap()
    }

    /// A solver of the medium.
    pub fn solver(&self) -> Result<(LitMedium, ScatterSolver)> {
        let plan = self.case.plan();
        let medium = LitMedium::new(&self.device, &plan, &plan.method)?;
        let solver = ScatterSolver::new(&self.device, &medium, &self.coarse(), &self.grid(), &self.settings)?;
        Ok((medium, solver))
    }

    /// Solves with an observer.
    pub fn try_solve(
        &self,
        direct: &DirectLight,
        observer: &mut ScatterObserver<'_>,
    ) -> Result<ScatteredLight> {
        let (medium, mut solver) = self.solver()?;
        solver.solve(&self.device, &medium, direct, observer)
    }

    /// Solves for direct light by place in scene units.
    #[track_caller]
    pub fn solve(&self, fluence: impl FnMut(DVec3) -> [f64; 3]) -> Found {
        self.solve_for(&self.direct(fluence))
    }

    /// Solves to convergence.
    #[track_caller]
    pub fn solve_for(&self, direct: &DirectLight) -> Found {
        let found = self.try_solve(direct, &mut |_| ControlFlow::Continue(())).unwrap();
        assert!(found.channels.iter().all(|facts| facts.converged), "{:?}", found.channels);
        self.read(&found)
    }

    /// On the host: no number is below 0, and no drift beyond 1.
    #[track_caller]
    pub fn read(&self, light: &ScatteredLight) -> Found {
        let rgb = |v: [f32; 4]| [v[0], v[1], v[2]].map(f64::from);
        let read = |buffer: &Buffer<[f32; 4]>| buffer.read(&self.device).unwrap().into_iter().map(rgb);
        let fluence: Vec<[f64; 3]> = read(&light.fluence).collect();
        assert!(fluence.iter().flatten().all(|phi| phi.is_finite() && *phi >= 0.0));
        let grey = light.channels.len() == 1;
        assert!(fluence.iter().all(|[r, g, b]| !grey || (r == g && g == b)));
        let drift: Option<Vec<DVec3>> =
            light.drift.as_ref().map(|drift| read(drift).map(DVec3::from_array).collect());
        // The length's own rounding.
        assert!(drift.iter().flatten().all(|d| d.is_finite() && d.length() <= 1.0 + 1e-6));
        Found { grid: self.grid(), fluence, drift, channels: light.channels.clone() }
    }

    /// The equation of a channel in double precision without a limiter, and its source, from the same points of each
    /// cell: two per voxel and axis. `fluence`: (reduced) direct light by place in scene units.
    pub fn twin(
        &self,
        albedo: f64,
        forward: f64,
        sigma_max: f64,
        fluence: impl Fn(DVec3) -> f64,
    ) -> (Diffusion, Vec<f64>) {
        let (plan, field, coarse, grid) = (self.case.plan(), self.case.field(), self.coarse(), self.grid());
        let unit = plan.local.unit;
        let values: Vec<f64> = centres(grid).map(|p| fluence(p * unit)).collect();
        let points: [usize; 3] =
            std::array::from_fn(|axis| 2 * plan.local.dims[axis].div_ceil(coarse.dims[axis]));
        let count = points.iter().product::<usize>();
        let place = |k: usize| {
            let k = [k % points[0], k / points[0] % points[1], k / points[0] / points[1]];
            DVec3::from_array(std::array::from_fn(|axis| (k[axis] as f64 + 0.5) / points[axis] as f64))
        };
        let (mut absorption, mut diffusivity, mut source) = (Vec::new(), Vec::new(), Vec::new());
        for centre in centres(coarse) {
            let (mut extinction, mut power) = (0.0, 0.0);
            for k in 0..count {
                let point = centre + (place(k) - 0.5) * coarse.cell;
                let sigma = field.value(point * unit) * sigma_max * unit;
                extinction += sigma / count as f64;
                // A cell of direct light scatters at most twice what it is met by.
                let most = 2.0 / grid.cell.min_element() / (1.0 - albedo * forward);
                power += sigma.min(most) * between(grid, &values, point) / count as f64;
            }
            let transport = (1.0 - albedo * forward) * extinction;
            absorption.push((1.0 - albedo) * extinction);
            diffusivity.push(1.0 / (3.0 * transport));
            source.push(albedo * (1.0 - forward) * power);
        }
        let reflection = self.settings.reflection;
        let spacing = coarse.cell.to_array();
        (Diffusion { dims: coarse.dims, spacing, reflection, absorption, diffusivity }, source)
    }
}

/// Direct light at a point of a cell: a third as far from the centre as it is, linear between centres, and the slope goes
/// on beyond the outermost ones.
fn between(grid: LightGrid, values: &[f64], point: DVec3) -> f64 {
    let axis = |a: usize| {
        let (place, last) = ((point / grid.cell)[a], grid.dims[a] - 1);
        let centre = (place.floor() as usize).min(last);
        let position = centre as f64 + (place - 0.5 - centre as f64) / 3.0;
        let low = (position.floor().max(0.0) as usize).min(last.max(1) - 1);
        ([low, (low + 1).min(last)], position - low as f64)
    };
    let [x, y, z] = [0, 1, 2].map(axis);
    let corner = |k: usize| {
        let pick = |(ends, f): ([usize; 2], f64), bit: usize| (ends[bit], if bit == 1 { f } else { 1.0 - f });
        let ((i, u), (j, v), (k, w)) = (pick(x, k & 1), pick(y, k >> 1 & 1), pick(z, k >> 2));
        u * v * w * values[i + grid.dims[0] * (j + grid.dims[1] * k)]
    };
    (0..8).map(corner).sum()
}
