//! Lights as convection carries them through the cells.

use super::LightGrid;
use crate::device_struct;
use crate::render::local::LocalFrame;
use crate::scene::{Background, Light, Scene};
use crate::{Error, Result};
use glam::DVec3;
use std::f64::consts::PI;

device_struct! {
    "types/convection.cl",
    /// A light as convection carries it; see `cl/types/convection.cl`.
    pub struct CarriedLight {
        /// Position in cells, or direction of travel; w: largest squared distance, in cells, of cells that are held.
        pub place: [f32; 4],
        /// Intensity or irradiance; w: the least squared distance from which a point is seen, local units squared.
        pub power: [f32; 4],
        /// The cell that light comes from; w: 1 for points.
        pub cell: [i32; 4],
    }
}

/// Squared distance in cells, to rounding, up to which cells about a point light in the box keep the mean of its light.
const HELD2: f64 = 4.001;
/// Where nothing is held.
const NONE_HELD: f64 = -1.0;

impl CarriedLight {
    /// A light of the scene; `None` where it is black or a rectangle.
    pub fn new(light: &Light, grid: &LightGrid, local: &LocalFrame) -> Option<Self> {
        if !shines(light) {
            return None;
        }
        let float4 = |v: [f64; 3], w: f64| [v[0], v[1], v[2], w].map(|v| v as f32);
        let ends = grid.dims.map(|n| n as i32);
        match *light {
            Light::Directional { direction, irradiance } => {
                let travel = direction.to_array();
                let [x, y, z] = std::array::from_fn(|axis| if travel[axis] < 0.0 { ends[axis] } else { -1 });
                Some(Self {
                    place: float4(travel, NONE_HELD),
                    power: float4(irradiance, 0.0),
                    cell: [x, y, z, 0],
                })
            }
            Light::Point { position, intensity } => {
                let place = (local.point(position) / grid.cell).to_array();
                let [x, y, z] =
                    std::array::from_fn(|axis| place[axis].floor().clamp(-1.0, ends[axis].into()) as i32);
                let inside = (0..3).all(|axis| (0..ends[axis]).contains(&[x, y, z][axis]));
                let intensity = intensity.map(|i| i / (local.unit * local.unit));
                Some(Self {
                    place: float4(place, if inside { HELD2 } else { NONE_HELD }),
                    power: float4(intensity, nearest2(grid)),
                    cell: [x, y, z, 1],
                })
            }
            Light::Rectangle { .. } => None,
        }
    }

    pub(super) fn is_point(&self) -> bool {
        self.cell[3] != 0
    }

    /// Whether cells about it keep the light that they are given.
    pub(super) fn holds(&self) -> bool {
        self.place[3] >= 0.0
    }

    /// Whether the light lies between the volume's sides along x.
    pub(super) fn within_x(&self, grid: &LightGrid) -> bool {
        (0..grid.dims[0] as i32).contains(&self.cell[0])
    }

    /// The first and the last distance of cells from the light's, in cells along the axes.
    pub(super) fn levels(&self, grid: &LightGrid) -> [u32; 2] {
        let mut levels = [0, 0];
        for (&n, &cell) in grid.dims.iter().zip(&self.cell) {
            let last = n as i32 - 1;
            levels[0] += cell.clamp(0, last).abs_diff(cell);
            levels[1] += cell.abs_diff(0).max(cell.abs_diff(last));
        }
        levels
    }
}

fn shines(light: &Light) -> bool {
    light.color().iter().any(|&power| power > 0.0)
}

/// The squared distance from which a point light's light is the mean over a ball of a cell's volume about it: a third
/// of the ball's squared radius. (The mean over a cube is 1.6 % less.)
fn nearest2(grid: &LightGrid) -> f64 {
    let volume = grid.cell.element_product();
    (volume * 3.0 / (4.0 * PI)).powf(2.0 / 3.0) / 3.0
}

/// Refuses scenes with lights that convection cannot carry.
///
/// # Errors
/// [`Error::Input`] that names the first rectangle.
pub fn refusal(scene: &Scene) -> Result<()> {
    match scene.lights.iter().position(|light| matches!(light, Light::Rectangle { .. })) {
        None => Ok(()),
        Some(index) => Err(Error::Input(format!(
            "`light.{index}` is a rectangle: convection-diffusion carries the light of directional and point lights \
             only; the method hybrid-diffusion takes all kinds"
        ))),
    }
}

/// What to say of a background that would light the volume: convection does not carry its light.
pub fn unlit_by(background: &Background) -> Option<String> {
    let dark = match background {
        Background::Constant(color) => color.iter().all(|&c| c == 0.0),
        Background::Environment { intensity, .. } => *intensity == 0.0,
    };
    (!dark).then(|| {
        "the background is seen, but lights nothing: convection-diffusion carries the light of directional and point \
         lights only; the method hybrid-diffusion takes the background's, too"
            .into()
    })
}

/// The largest courant number, the way of light in a step over the smallest edge of a cell, with which convection of
/// these lights is stable: in a step, light then crosses at most one cell, summed over the axes. Infinite without lights.
pub fn largest_courant(lights: &[Light], grid: &LightGrid, local: &LocalFrame) -> f64 {
    let edges = grid.cell / grid.cell.min_element();
    let rates = lights.iter().filter(|light| shines(light)).filter_map(|light| match *light {
        Light::Directional { direction, .. } => Some((direction.abs() / edges).element_sum()),
        Light::Point { position, .. } => Some(largest_rate(local.point(position), grid)),
        Light::Rectangle { .. } => None,
    });
    1.0 / rates.fold(0.0, f64::max)
}

/// The largest |u_x|/h_x + |u_y|/h_y + |u_z|/h_z, with the smallest edge of a cell as the unit, over the centres' box for
/// a point light at `point`.
fn largest_rate(point: DVec3, grid: &LightGrid) -> f64 {
    let edges = grid.cell / grid.cell.min_element();
    let weight = edges.recip().to_array();
    // Only |r| of an axis matters: between these bounds. Cells that are level with the light have r = 0 there.
    let (low, high) = (0.5 * grid.cell - point, extent(grid) - 0.5 * grid.cell - point);
    let most = low.abs().max(high.abs()).to_array();
    let level = point.cmpge(DVec3::ZERO) & point.cmplt(extent(grid));
    let least = DVec3::select(level, DVec3::ZERO, low.max(-high)).to_array();
    // w·r/|r| is largest where every axis that no bound stops has r = s w, with the s at which Σ r² = s Σ w r: that
    // difference falls with s.
    let at = |s: f64| DVec3::from_array(std::array::from_fn(|a| (s * weight[a]).clamp(least[a], most[a])));
    let weight = DVec3::from_array(weight);
    let (mut below, mut above) = (0.0, (DVec3::from_array(most) / weight).max_element());
    for _ in 0..100 {
        let middle = 0.5 * (below + above);
        let r = at(middle);
        if r.length_squared() > middle * weight.dot(r) { below = middle } else { above = middle }
    }
    let r = at(0.5 * (below + above));
    if r == DVec3::ZERO { weight.length() } else { weight.dot(r) / r.length() }
}

fn extent(grid: &LightGrid) -> DVec3 {
    grid.cell * DVec3::from_array(grid.dims.map(|n| n as f64))
}

/// Refuses courant numbers that are unstable for these lights.
///
/// # Errors
/// [`Error::Input`] with the largest number that is allowed.
pub fn check_courant(courant: f64, lights: &[Light], grid: &LightGrid, local: &LocalFrame) -> Result<()> {
    let largest = largest_courant(lights, grid, local);
    if courant > 0.0 && courant <= largest {
        return Ok(());
    }
    if courant > largest {
        // Rounded down, to a number that passes.
        let shown = (largest * 1e4).floor() / 1e4;
        return Err(Error::Input(format!(
            "`method.courant` = {courant} is too large: light would cross more than a cell in a step, which is unstable; with \
             this volume and these lights it must be at most {shown:.4}"
        )));
    }
    Err(Error::Input(format!("`method.courant` = {courant} must be above 0: light would not move")))
}

/// Steps after which light has crossed the box: all but e⁻⁸ of it, wherever it goes, of parallel light; of a point
/// light about as much.
///
/// Upwind light walks at random: per step it moves an edge h of a cell along each axis with probability cΔt |u|/h, or
/// stays. Along u this is cΔt in the mean with a second moment of at most cΔt h_max, so after n steps it lacks the box's
/// diagonal with a probability of at most exp(−(n cΔt − diagonal)² / (2 n cΔt h_max)) (Bernstein).
pub fn crossing_steps(grid: &LightGrid, courant: f64) -> u32 {
    let (step, edge) = (courant * grid.cell.min_element(), grid.cell.max_element());
    let way = (2.0 * edge.sqrt() + (4.0 * edge + extent(grid).length()).sqrt()).powi(2);
    (way / step).ceil() as u32
}
