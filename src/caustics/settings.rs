//! From the words of the scene to the settings of photons and of their map.

use super::{
    Acceleration, Emission, EmissionSettings, MapSettings, PhotonSettings, Receiver, TargetRectangle,
    Weighting,
};
use crate::render::local::LocalFrame;
use crate::scene::{self, CausticsDirect, GatherKernel, PhotonFlux, SurfaceShape};
use crate::sort::{Fill, SortKind};

/// How the photons of a scene are traced.
pub fn photon_settings(settings: &scene::Caustics, seed: u64) -> PhotonSettings {
    let target = settings.target.map(|target| {
        let scene::Target { centre, edge_u, edge_v } = target;
        TargetRectangle { centre, edge_u, edge_v }
    });
    let emission = match settings.flux {
        PhotonFlux::Exact => Emission::Radiometric,
        PhotonFlux::Equal => Emission::Equal,
    };
    PhotonSettings {
        emission: EmissionSettings {
            photons: settings.photons,
            emission,
            target,
            bounces: settings.bounces > 0,
        },
        depth: settings.depth,
        bounces: settings.bounces,
        seed,
        store_direct: settings.direct == CausticsDirect::Photons,
    }
}

/// How they are gathered.
pub fn map_settings(gather: &scene::Gather) -> MapSettings {
    MapSettings {
        acceleration: match gather.acceleration {
            scene::Acceleration::Voxels => Acceleration::Voxels,
            scene::Acceleration::Planar => Acceleration::Planar,
            scene::Acceleration::Lexicographic => Acceleration::Lexicographic,
            scene::Acceleration::BruteForce => Acceleration::BruteForce,
        },
        sort: match gather.sort {
            scene::Sort::Radix => SortKind::Radix,
            scene::Sort::Bitonic => SortKind::Bitonic,
        },
        fill: match gather.fill {
            scene::Fill::OnePass => Fill::OnePass,
            scene::Fill::TwoPass => Fill::TwoPass,
        },
        weighting: match gather.kernel {
            GatherKernel::Constant => Weighting::Constant,
            GatherKernel::Cone => Weighting::Cone,
            GatherKernel::Smoothstep => Weighting::Smoothstep,
        },
        paper_weights: gather.paper_intensity.is_some(),
        edge_correction: gather.edge_correction,
        ..MapSettings::default()
    }
}

/// How far from a point of a surface photons count at most, scene units, where they are gathered from far away.
///
/// At a chord c a sphere of radius R lies c²/2R out of the tangent plane: at half of R, a quarter of the chord, which is as far
/// as photons count. Up to there nothing is lost, as the area within a chord is that of the plane. Metaballs (`extent`: the
/// largest one of the surface) are taken for spheres of a fifth of their extent. Meshes have edges that nothing corrects for:
/// only strips beside them are too dark.
pub fn reach(shape: &SurfaceShape, extent: f64) -> f64 {
    match shape {
        SurfaceShape::Sphere { radius, .. } => 0.5 * radius,
        SurfaceShape::Metaballs { .. } => 0.1 * extent,
        SurfaceShape::Mesh { .. } => 0.02 * extent,
        _ => f64::INFINITY,
    }
}

/// What gathering knows of a surface, in local units.
pub fn receiver(shape: &SurfaceShape, local: &LocalFrame) -> Receiver {
    let length = |l: f64| l / local.unit;
    match *shape {
        SurfaceShape::Plane { point, normal } => Receiver::plane(local.point(point), normal),
        SurfaceShape::Rectangle { centre, edge_u, edge_v } => {
            let (u, v) = (edge_u / local.unit, edge_v / local.unit);
            Receiver::parallelogram(local.point(centre) - 0.5 * (u + v), u, v)
        }
        SurfaceShape::Disk { centre, normal, radius } => {
            Receiver::disk(local.point(centre), normal, length(radius))
        }
        SurfaceShape::Box { low, high } => Receiver::cuboid(local.point(low), local.point(high)),
        SurfaceShape::Sphere { .. } | SurfaceShape::Metaballs { .. } => Receiver::curved(),
        SurfaceShape::Mesh { .. } => Receiver::mesh(),
    }
}
