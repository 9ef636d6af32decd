//! Scenes for the tests of scattered light: a medium of voxels, direct light by a formula, the solution on the host.
//!
//! Each test file uses a part of this.
#![allow(dead_code)]

use crate::common::{Case, device, volume_f32};
use glam::DVec3;
use std::ops::ControlFlow;
use svetlo::device::{Buffer, Device};
use svetlo::diffusion::Method;
use svetlo::irradiance::{
    ChannelFacts, DirectLight, LightGrid, Limiter, LitMedium, ScatterSettings, ScatteredLight, solve,
};

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
    /// `sigma_max`; `more`: further tables of the scene.
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
             [transfer]\nresolution = 2\npoints = [{{ value = 0, opacity = 0 }}, {{ value = 1, opacity = 1 }}]\n\
             [medium]\nsigma_max = {sigma_max:?}\n{more}\n",
            spacing.to_array()
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

    /// Solves for direct light by place in scene units.
    #[track_caller]
    pub fn solve(&self, fluence: impl FnMut(DVec3) -> [f64; 3]) -> Found {
        self.solve_with(fluence, None, None)
    }

    /// The same, with what is reduced and with a flow.
    #[track_caller]
    pub fn solve_with(
        &self,
        fluence: impl FnMut(DVec3) -> [f64; 3],
        reduced: Option<&dyn Fn(DVec3) -> [f64; 3]>,
        flow: Option<&dyn Fn(DVec3) -> DVec3>,
    ) -> Found {
        let plan = self.case.plan();
        let (device, unit, grid) = (&self.device, plan.local.unit, self.grid());
        let upload = |values: Vec<[f32; 4]>| Buffer::from_slice(device, &values).unwrap();
        let rgb = |values: [f64; 3]| {
            let [r, g, b] = values.map(|v| v as f32);
            [r, g, b, 0.0]
        };
        let places = || centres(grid).map(|p| p * unit);
        let direct = DirectLight {
            fluence: upload(places().map(fluence).map(rgb).collect()),
            reduced: reduced.map(|reduced| upload(places().map(reduced).map(rgb).collect())),
            flow: flow.map(|flow| upload(places().map(|p| rgb(flow(p).to_array())).collect())),
        };
        let medium = LitMedium::new(device, &plan, &plan.method).unwrap();
        let coarse = LightGrid::new(&plan.local, self.coarsening[0]);
        let mut patient = |_: &_| ControlFlow::Continue(());
        let found = solve(device, &medium, &coarse, &grid, &direct, &self.settings, &mut patient);
        self.read(grid, &found.unwrap())
    }

    #[track_caller]
    pub fn read(&self, grid: LightGrid, light: &ScatteredLight) -> Found {
        let rgb = |v: [f32; 4]| [v[0], v[1], v[2]].map(f64::from);
        let read = |buffer: &Buffer<[f32; 4]>| buffer.read(&self.device).unwrap().into_iter().map(rgb);
        let fluence: Vec<[f64; 3]> = read(&light.fluence).collect();
        assert!(fluence.iter().flatten().all(|phi| phi.is_finite() && *phi >= 0.0));
        let drift: Option<Vec<DVec3>> =
            light.drift.as_ref().map(|drift| read(drift).map(DVec3::from_array).collect());
        assert!(drift.iter().flatten().all(|d| d.is_finite() && d.length() <= 1.0 + 1e-6));

        Found { grid, fluence, drift, channels: light.channels.clone() }
    }
}
