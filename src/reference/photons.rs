//! Density estimation from photons, by the long way: every photon is looked at, every integral is a quadrature.

use super::quadrature::gauss_legendre;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// A photon on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StoredPhoton {
    /// Where.
    pub position: DVec3,
    /// The surface's unit normal there, on the side that it came from.
    pub facing: DVec3,
    /// Whether that is not the outward one.
    pub inside: bool,
    /// Flux per channel.
    pub flux: [f64; 3],
    /// The surface; `None` for a slot that holds nothing.
    pub surface: Option<u32>,
}

/// The weight of a photon at distance t times the radius.
pub type Weight = fn(f64) -> f64;

/// 1 within the radius.
pub fn constant(t: f64) -> f64 {
    if t < 1.0 { 1.0 } else { 0.0 }
}

/// 1 − t within the radius.
pub fn cone(t: f64) -> f64 {
    if t < 1.0 { 1.0 - t } else { 0.0 }
}

/// 1 − smoothstep(t) within the radius.
pub fn smoothstep(t: f64) -> f64 {
    if t < 1.0 { 1.0 - t * t * (3.0 - 2.0 * t) } else { 0.0 }
}

/// The integral of a weight over the unit disk.
pub fn area(weight: Weight) -> f64 {
    gauss_legendre(8).iter().map(|(t, share)| share * TAU * t * weight(*t)).sum()
}

/// The integral of a weight over the unit ball.
pub fn volume(weight: Weight) -> f64 {
    gauss_legendre(8).iter().map(|(t, share)| share * 4.0 * PI * t * t * weight(*t)).sum()
}

/// Where photons are looked for.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// A point of a surface.
    pub point: DVec3,
    /// Its normal on the side that is looked at.
    pub normal: DVec3,
    /// Whether that is not the outward one.
    pub inside: bool,
    /// The surface.
    pub surface: u32,
    /// How far out of the tangent plane photons may lie.
    pub thickness: f64,
}

/// Whether a surface faces the same way in two places: where its normals are less than 65 degrees apart, and not where more
/// than 76. `facing` is measured by the sum of its components, so that it need not be normalised.
pub fn alike(facing: DVec3, normal: DVec3) -> bool {
    facing.dot(normal) > 0.25 * facing.abs().element_sum()
}

/// Irradiance per channel: flux of the photons within `radius` that arrived on the same side of the same surface where it
/// faces alike, weighted and normalised.
pub fn irradiance(photons: &[StoredPhoton], place: &Place, radius: f64, weight: Weight) -> [f64; 3] {
    let counts = |photon: &StoredPhoton| {
        photon.surface == Some(place.surface)
            && photon.inside == place.inside
            && alike(photon.facing, place.normal)
            && (photon.position - place.point).dot(place.normal).abs() <= place.thickness
    };
    let sum = sum(photons, place.point, radius, weight, counts);
    sum.map(|sum| sum / (area(weight) * radius * radius))
}

/// Flux over volume per channel of photons within `radius`, weighted and normalised.
pub fn density(photons: &[StoredPhoton], point: DVec3, radius: f64, weight: Weight) -> [f64; 3] {
    let sum = sum(photons, point, radius, weight, |photon| photon.surface.is_some());
    sum.map(|sum| sum / (volume(weight) * radius.powi(3)))
}

fn sum(
    photons: &[StoredPhoton],
    point: DVec3,
    radius: f64,
    weight: Weight,
    counts: impl Fn(&StoredPhoton) -> bool,
) -> [f64; 3] {
    photons.iter().filter(|photon| counts(photon)).fold([0.0; 3], |sum, photon| {
        let weight = weight(photon.position.distance(point) / radius);
        std::array::from_fn(|channel| sum[channel] + weight * photon.flux[channel])
    })
}

/// The share of a kernel around a point that lies inside a region seen from there: `edge` is the distance at which it ends
/// in each direction (in the plane, over the radius). A sum over directions, whose error is below 1e-5.
pub fn mass_inside(weight: Weight, edge: impl Fn(f64) -> f64) -> f64 {
    const DIRECTIONS: u32 = 1 << 16;
    let rule = gauss_legendre(8);
    let within = |t: f64| rule.iter().map(|(x, share)| share * t * t * x * weight(t * x)).sum::<f64>();
    let angle = |k: u32| TAU * (f64::from(k) + 0.5) / f64::from(DIRECTIONS);
    let sum: f64 = (0..DIRECTIONS).map(|k| within(edge(angle(k)).clamp(0.0, 1.0))).sum();
    sum / f64::from(DIRECTIONS) / within(1.0)
}
