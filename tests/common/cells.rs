//! Light volumes whose cells are given number by number.
//!
//! Each test file uses a part of this.
#![allow(dead_code)]

use crate::common::noise;
use glam::DVec3;
use svetlo::device::{Buffer, Device};
use svetlo::irradiance::{Cells, LightGrid};
use svetlo::render::local::LocalFrame;

/// A box of cells and its medium, per local unit.
pub struct Medium {
    pub grid: LightGrid,
    pub local: LocalFrame,
    pub scattering: Vec<[f32; 3]>,
    pub absorption: Vec<[f32; 3]>,
}

impl Medium {
    /// A medium of the same scattering and absorption in every channel, by the number of the cell.
    pub fn grey(dims: [usize; 3], cell: DVec3, of: impl Fn(usize) -> [f64; 2]) -> Self {
        Self::new(dims, cell, |i| of(i).map(|sigma| [sigma; 3]))
    }

    /// A medium of scattering and absorption per channel, by the number of the cell. The frame is moved and scaled, so
    /// that scene and local units differ.
    pub fn new(dims: [usize; 3], cell: DVec3, of: impl Fn(usize) -> [[f64; 3]; 2]) -> Self {
        let local = LocalFrame::new(DVec3::new(-3.0, 1.0, 0.5), 0.25 * cell, dims);
        let grid = LightGrid::new(&local, 1);
        let cells = (0..grid.cells()).map(&of);
        let [scattering, absorption] =
            [0, 1].map(|k| cells.clone().map(|c| c[k].map(|v| v as f32)).collect());
        Self { grid, local, scattering, absorption }
    }

    /// Extinctions over four decades and none in a third of the cells, of another colour in each where `coloured`; about
    /// half of it scatters, by channel.
    pub fn random(dims: [usize; 3], cell: DVec3, coloured: bool, seed: u32) -> Self {
        let random = noise(9 * dims.iter().product::<usize>(), seed);
        Self::new(dims, cell, |i| {
            let u = &random[9 * i..][..9];
            let sigma = |c: usize| {
                let c = if coloured { c } else { 0 };
                if u[c] < 0.3 { 0.0 } else { 10_f64.powf(4.0 * u[3 + c] - 3.0) }
            };
            let scattering = [0, 1, 2].map(|c| sigma(c) * u[6 + c]);
            [scattering, [0, 1, 2].map(|c| sigma(c) - scattering[c])]
        })
    }

    pub fn cells(&self, device: &Device) -> Cells {
        let upload = |values: &[[f32; 3]]| {
            let values: Vec<[f32; 4]> = values.iter().map(|&[r, g, b]| [r, g, b, 0.0]).collect();
            Buffer::from_slice(device, &values).unwrap()
        };
        Cells { scattering: upload(&self.scattering), absorption: upload(&self.absorption), glow: None }
    }

    /// Absorption and a share of the scattering of a channel.
    pub fn extinction(&self, channel: usize, counted: f64) -> Vec<f64> {
        let of = |values: &[f32; 3]| f64::from(values[channel]);
        self.scattering.iter().zip(&self.absorption).map(|(s, a)| counted * of(s) + of(a)).collect()
    }

    /// A point of the box's local frame in scene units.
    pub fn point(&self, local: DVec3) -> DVec3 {
        self.local.origin + local * self.local.unit
    }

    /// A cell's centre, local units.
    pub fn centre(&self, i: usize) -> DVec3 {
        let [nx, ny, _] = self.grid.dims;
        (DVec3::new((i % nx) as f64, (i / nx % ny) as f64, (i / nx / ny) as f64) + 0.5) * self.grid.cell
    }
}
