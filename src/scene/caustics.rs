//! Settings of caustics.

use super::camera::direction;
use super::context::Context;
use super::surface::{Surface, SurfaceMaterial, SurfaceShape};
use crate::config::types::{
    AccelerationConfig, DirectConfig, FillConfig, FluxConfig, GatherConfig, KernelConfig, MethodConfig,
    SortConfig, WeightsConfig,
};
use glam::DVec3;

/// Edges of a target at less than a right angle (cosine of the angle) span no rectangle.
const LARGEST_COSINE: f64 = 1e-6;

/// Caustics of mirrors and glass on diffuse surfaces, by photons.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Caustics {
    /// Photons per pass, of all lights together.
    pub photons: u32,
    /// Radius of gathering in the first pass, scene units, > 0; chosen by the renderer if `None`.
    pub radius: Option<f64>,
    /// How the radius shrinks from pass to pass, 0 < alpha ≤ 1; 1: it stays.
    pub alpha: f64,
    /// Most times that light is reflected by mirrors or glass, or refracted, ≥ 1.
    pub depth: u32,
    /// Most times that photons are reflected by diffuse surfaces.
    pub bounces: u32,
    /// Radius of gathering in the first pass of what those bring, scene units, > 0; chosen by the renderer if `None`.
    pub bounce_radius: Option<f64>,
    /// How direct light comes into the picture.
    pub direct: DirectConfig,
    /// How much light a photon carries.
    pub flux: FluxConfig,
    /// Where photons are sent to; chosen for each light if `None`.
    pub target: Option<Target>,
    /// How their light is gathered.
    pub gather: Gather,
}

/// A rectangle that photons are sent to, in scene units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Its middle.
    pub centre: DVec3,
    /// One edge from end to end.
    pub edge_u: DVec3,
    /// The other edge, perpendicular to `edge_u`.
    pub edge_v: DVec3,
}

/// How the light of photons is gathered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gather {
    /// How a photon's share falls with its distance.
    pub kernel: KernelConfig,
    /// Irradiance that a photon adds at its place, W/m², where weights are as published; normalised if `None`.
    pub paper_intensity: Option<f64>,
    /// Whether edges of receivers are corrected for.
    pub edge_correction: bool,
    /// How the photons near a point are found.
    pub acceleration: AccelerationConfig,
    /// How they are sorted.
    pub sort: SortConfig,
    /// How voxels find their photons.
    pub fill: FillConfig,
}

pub(super) fn caustics(config: &MethodConfig, cx: &mut Context<'_>) -> Option<Caustics> {
    let MethodConfig::Caustics {
        photons,
        radius,
        alpha,
        depth,
        bounces,
        bounce_radius,
        direct,
        emission,
        gather,
    } = config
    else {
        return None;
    };
    let target = emission.target.as_ref().map(|target| {
        let [u, v] = [("edge_u", target.edge_u), ("edge_v", target.edge_v)]
            .map(|(key, edge)| direction(edge, &format!("method.emission.target.{key}"), cx));
        if let (Some(u), Some(v)) = (u, v)
            && u.dot(v).abs() > LARGEST_COSINE
        {
            cx.wrong(
                "method.emission.target.edge_v",
                "`method.emission.target.edge_v` must be perpendicular to `edge_u`",
                "they span no rectangle",
            );
        }
        let [centre, edge_u, edge_v] = [target.centre, target.edge_u, target.edge_v].map(DVec3::from_array);
        Target { centre, edge_u, edge_v }
    });
    Some(Caustics {
        photons: *photons,
        radius: *radius,
        alpha: *alpha,
        depth: *depth,
        bounces: bounced(*bounces, *direct, gather, cx),
        bounce_radius: *bounce_radius,
        direct: *direct,
        flux: emission.flux,
        target,
        gather: gathering(gather, emission.flux, cx),
    })
}

/// Reports receivers that cells on planes could not hold.
pub(super) fn refuse_curved(
    config: &MethodConfig,
    surfaces: &[Surface],
    materials: &[SurfaceMaterial],
    cx: &mut Context<'_>,
) {
    let MethodConfig::Caustics { gather, .. } = config else { return };
    let flat = |shape: &SurfaceShape| {
        matches!(
            shape,
            SurfaceShape::Plane { .. } | SurfaceShape::Rectangle { .. } | SurfaceShape::Disk { .. }
        )
    };
    let receives = |surface: &Surface| materials.get(surface.material).is_some_and(|of| !of.is_specular());
    let curved = surfaces.iter().position(|surface| receives(surface) && !flat(&surface.shape));
    if let (AccelerationConfig::Planar, Some(index)) = (gather.acceleration, curved) {
        cx.wrong(
            "method.gather.acceleration",
            "`method.gather.acceleration = \"planar\"` needs receivers that are planes, rectangles or disks",
            format!("`surface.{index}` is diffuse and has no plane of its own"),
        );
    }
}

/// Where the scene does not say. In the open little is left after one; a closed room of albedo a has a^5 of its light beyond.
const BOUNCES: u32 = 4;

fn bounced(bounces: Option<u32>, direct: DirectConfig, gather: &GatherConfig, cx: &mut Context<'_>) -> u32 {
    let published = gather.weights == WeightsConfig::Paper;
    if published && bounces.is_some_and(|bounces| bounces > 0) {
        cx.wrong(
            "method.bounces",
            "`method.bounces` must be 0 with `method.gather.weights = \"paper\"`",
            "as published, photons end at the first diffuse surface",
        );
    }
    bounces.unwrap_or(if published || direct == DirectConfig::None { 0 } else { BOUNCES })
}

fn gathering(config: &GatherConfig, flux: FluxConfig, cx: &mut Context<'_>) -> Gather {
    let paper_intensity = match config.weights {
        WeightsConfig::Normalised => {
            let reason = "needs `method.gather.weights = \"paper\"`";
            cx.useless("method.gather.intensity", reason, "normalised weights have no scale of their own");
            None
        }
        WeightsConfig::Paper => {
            if config.intensity.is_none() {
                cx.wrong(
                    "method.gather.weights",
                    "weights \"paper\" need `method.gather.intensity`",
                    "what does a photon add at its place?",
                );
            }
            if flux != FluxConfig::Equal {
                cx.wrong(
                    "method.gather.weights",
                    "weights \"paper\" need `method.emission.flux = \"equal\"`",
                    "as published, all photons are alike",
                );
            }
            config.intensity.or(Some(0.0))
        }
    };
    Gather {
        kernel: config.kernel,
        paper_intensity,
        edge_correction: config.edge_correction,
        acceleration: config.acceleration,
        sort: config.sort,
        fill: config.fill,
    }
}
