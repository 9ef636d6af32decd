//! Which paths photons follow, and how many photons each kind of path gets.
//!
//! Light that met a diffuse surface reaches another one by photons that diffuse surfaces reflect. So that every path has
//! photons of one role alone: "caustic" ends where it first meets a diffuse surface; of the others, which go on from
//! there, one met mirrors or glass before, one did not. The latter leave the light in all directions; where it is known
//! what is near to others, a part of them is sent there, and the rest all around but there.

use super::target::{Parts, Target};
use crate::surfaces::{DeviceMaterial, DeviceShape, SurfaceArrays};
use crate::{Error, Result};
use glam::DVec3;

/// What `role` of an emitter says.
pub mod role {
    /// Ends at the first diffuse surface.
    pub const CAUSTIC: u32 = 0;
    /// Goes on from there if it met mirrors or glass before.
    pub const AFTER_CAUSTIC: u32 = 1;
    /// Goes on from there if it did not.
    pub const AFTER_DIRECT: u32 = 2;
}

/// How far beside what reflects light to others a diffuse surface still gets photons for that, over its width in the eyes
/// of the light; all around it gets fewer.
const NEAR: f64 = 3.0;

/// How much wider the rectangle for parallel light elsewhere is; FAR_ALONG of `cl/types/emission.cl`.
const FAR: f64 = 16.0;

/// Where photons are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Aim {
    /// To mirrors and glass.
    Specular,
    /// To what light goes to and fro between.
    Near,
    /// Everywhere else.
    Elsewhere,
}

/// Photons of a kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Group {
    pub role: u32,
    pub aim: Aim,
    /// Of the photons, relative to the others.
    pub part: f64,
}

/// The kinds of photons; those that can bring anything are told from the others later. Caustics have most, because they are
/// gathered within the smaller radius.
pub(super) const GROUPS: [Group; 4] = [
    Group { role: role::CAUSTIC, aim: Aim::Specular, part: 0.7 },
    Group { role: role::AFTER_CAUSTIC, aim: Aim::Specular, part: 0.05 },
    Group { role: role::AFTER_DIRECT, aim: Aim::Near, part: 0.12 },
    Group { role: role::AFTER_DIRECT, aim: Aim::Elsewhere, part: 0.13 },
];

fn material<'s>(surfaces: &'s SurfaceArrays, shape: &DeviceShape) -> &'s DeviceMaterial {
    &surfaces.materials[surfaces.materials_of[shape.surface as usize] as usize]
}

pub(super) fn is_specular(surfaces: &SurfaceArrays, shape: &DeviceShape) -> bool {
    material(surfaces, shape).kind != DeviceMaterial::DIFFUSE
}

/// Whether a diffuse surface reflects light that another one may get: not so where all are black, or a single one is flat.
pub fn diffuse_light_returns(surfaces: &SurfaceArrays) -> bool {
    const FLAT: [u32; 3] = [0, 2, 3];
    let reflects = |shape: &DeviceShape| {
        !is_specular(surfaces, shape) && material(surfaces, shape).color[..3].iter().any(|&c| c > 0.0)
    };
    let alone = surfaces.shapes.len() == 1 && FLAT.contains(&surfaces.shapes[0].kind);
    !alone && surfaces.shapes.iter().any(reflects)
}

/// What diffuse surfaces send light to that comes back: mirrors and glass, or else all that has bounds.
pub(super) fn focus(surfaces: &SurfaceArrays) -> Parts {
    let specular = Parts::of(surfaces, |shape| is_specular(surfaces, shape));
    if specular.parts.is_empty() { Parts::of(surfaces, |_| true) } else { specular }
}

/// A ball around it, local units: centre and radius, 0 where there is none.
pub fn guide(surfaces: &SurfaceArrays) -> [f32; 4] {
    let parts = focus(surfaces);
    if parts.parts.is_empty() {
        return [0.0; 4];
    }
    let centre = parts.centre();
    let DVec3 { x, y, z } = centre;
    [x as f32, y as f32, z as f32, parts.radius_about(centre) as f32]
}

/// The rectangle of near photons for light from these places. `None`: they go all around.
pub(super) fn near(focus: &Parts, all: &Parts, places: &[DVec3]) -> Option<Target> {
    let found = if focus.parts.is_empty() { None } else { focus.seen_from(places) };
    Some(widened(found?, focus, all))
}

/// The same for parallel light: all that has bounds.
pub(super) fn near_along(all: &Parts, direction: DVec3) -> Option<Target> {
    (!all.parts.is_empty()).then(|| widened(all.seen_along(direction), all, all))
}

/// Where parallel light meets what has no bounds, around that: what is farther away is left out.
pub(super) fn far_along(all: &Parts, direction: DVec3) -> Option<Target> {
    let near = near_along(all, direction).filter(|_| all.unbounded);
    near.map(|near| Target { edge_u: FAR * near.edge_u, edge_v: FAR * near.edge_v, ..near })
}

/// Wider where there is anything beside it to be lit.
fn widened(target: Target, focus: &Parts, all: &Parts) -> Target {
    let wider = if has_elsewhere(focus, all) { NEAR } else { 1.0 };
    Target { edge_u: wider * target.edge_u, edge_v: wider * target.edge_v, ..target }
}

/// Whether there is anything beside what light goes to and fro between.
pub(super) fn has_elsewhere(focus: &Parts, all: &Parts) -> bool {
    all.unbounded || focus.parts.len() < all.parts.len()
}

/// Photons for each group by its part, at least one for each of its lights.
pub(super) fn split(photons: u32, groups: &[(Group, u32)]) -> Result<Vec<u32>> {
    let least: u32 = groups.iter().map(|(_, lights)| lights).sum();
    if photons < least {
        let lights = groups.iter().map(|(_, lights)| *lights).max().unwrap_or(0);
        let each = if groups.len() > 1 {
            format!(
                ", and {} for light that diffuse surfaces reflect (bounces = 0 is without)",
                groups.len() - 1
            )
        } else {
            String::new()
        };
        return Err(Error::Input(format!(
            "{photons} photons are too few for {lights} lights: each light that shines needs one at least{each}"
        )));
    }
    if groups.is_empty() {
        return Ok(Vec::new());
    }
    let parts: f64 = groups.iter().map(|(group, _)| group.part).sum();
    let spare = f64::from(photons - least);
    let mut counts: Vec<u32> =
        groups.iter().map(|(group, lights)| lights + (spare * group.part / parts) as u32).collect();
    // What rounding left over is the first one's.
    counts[0] += photons - counts.iter().sum::<u32>();
    Ok(counts)
}

/// So many photons for each flux, one at least and together `photons`, which are as many at least: the largest remainders get what is left over.
pub(super) fn shares(fluxes: &[f64], photons: u32) -> Vec<u32> {
    let lights = fluxes.len() as u32;
    let total: f64 = fluxes.iter().sum();
    let spare = f64::from(photons - lights);
    let exact: Vec<f64> = fluxes.iter().map(|flux| spare * (flux / total)).collect();
    let mut counts: Vec<u32> = exact.iter().map(|share| 1 + share.floor() as u32).collect();
    let mut order: Vec<usize> = (0..fluxes.len()).collect();
    order.sort_by(|&a, &b| exact[b].fract().total_cmp(&exact[a].fract()));
    // Rounding may have given one too many.
    let mut left = i64::from(photons) - counts.iter().map(|&count| i64::from(count)).sum::<i64>();
    for index in order.into_iter().cycle() {
        match left {
            0 => break,
            1.. => (counts[index], left) = (counts[index] + 1, left - 1),
            _ if counts[index] > 1 => (counts[index], left) = (counts[index] - 1, left + 1),
            _ => {}
        }
    }
    counts
}
