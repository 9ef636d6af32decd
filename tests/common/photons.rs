//! Scenes of a few surfaces and their photons.
//!
//! Each test file uses a part of this.
#![allow(dead_code)]

use glam::DVec3;
use std::sync::Arc;
use svetlo::caustics::*;
use svetlo::device::Device;
use svetlo::render::local::LocalFrame;
use svetlo::scene::{Light, Surface, SurfaceMaterial, SurfaceShape};
use svetlo::surfaces::{SurfaceArrays, SurfaceBuffers, load};

/// White paper that absorbs nothing.
pub const PAPER: SurfaceMaterial = SurfaceMaterial::Diffuse { color: [1.0; 3] };
/// Crown glass.
pub const GLASS: SurfaceMaterial =
    SurfaceMaterial::Dielectric { cauchy: [1.5, 0.0, 0.0], absorption: [0.0; 3] };

/// Surfaces, lights and how photons are traced.
#[derive(Clone)]
pub struct Scene {
    pub surfaces: Vec<Surface>,
    pub materials: Vec<SurfaceMaterial>,
    pub lights: Vec<Light>,
    pub settings: PhotonSettings,
    /// Scene units per local unit, and where its frame begins: not those of the scene, so that mistakes show.
    pub frame: LocalFrame,
}

/// A photon as the tests see it, in scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stored {
    pub position: DVec3,
    pub direction: DVec3,
    pub flux: [f64; 3],
    pub surface: usize,
}

impl Scene {
    /// Shapes with their materials, and lights.
    pub fn new(
        parts: impl IntoIterator<Item = (SurfaceShape, SurfaceMaterial)>,
        lights: impl IntoIterator<Item = Light>,
        photons: u32,
    ) -> Self {
        let (mut surfaces, mut materials) = (Vec::new(), Vec::new());
        for (shape, material) in parts {
            surfaces.push(Surface { shape, material: materials.len() });
            materials.push(material);
        }
        let emission =
            EmissionSettings { photons, emission: Emission::Radiometric, target: None, bounces: false };
        Self {
            surfaces,
            materials,
            lights: lights.into_iter().collect(),
            settings: PhotonSettings { emission, depth: 5, bounces: 0, seed: 7, store_direct: false },
            frame: LocalFrame {
                origin: DVec3::new(-3.0, -2.5, -4.0),
                unit: 0.25,
                dims: [32; 3],
                spacing: DVec3::ONE,
            },
        }
    }

    pub fn through(mut self, centre: DVec3, edge_u: DVec3, edge_v: DVec3) -> Self {
        self.settings.emission.target = Some(TargetRectangle { centre, edge_u, edge_v });
        self
    }

    /// Through the target of an emitter, so many times as wide.
    pub fn around(self, emitter: &Emitter, factor: f64) -> Self {
        let vector = |v: [f32; 4]| DVec3::new(v[0].into(), v[1].into(), v[2].into());
        let [mut corner, mut u, mut v] = [emitter.corner, emitter.edge_u, emitter.edge_v].map(vector);
        if emitter.way == 0 {
            corner = corner.x * u + corner.y * v + corner.z * vector(emitter.normal) + vector(emitter.place);
            u *= f64::from(emitter.edge_u[3]);
            v *= f64::from(emitter.edge_v[3]);
        }
        let LocalFrame { origin, unit, .. } = self.frame;
        // Edges have been rounded.
        let v = v - v.dot(u) / u.length_squared() * u;
        self.through(origin + unit * (corner + 0.5 * (u + v)), factor * unit * u, factor * unit * v)
    }

    pub fn emitters(&self) -> Vec<Emitter> {
        emitters(&self.lights, &self.arrays(), &self.frame, &self.settings.emission).unwrap()
    }

    pub fn arrays(&self) -> SurfaceArrays {
        let meshes = load(&self.surfaces, &self.materials).unwrap();
        SurfaceArrays::new(&self.surfaces, &self.materials, &meshes, &self.frame).unwrap()
    }

    pub fn tracer(&self, device: &Device) -> svetlo::Result<PhotonTracer> {
        let arrays = self.arrays();
        let buffers = Arc::new(SurfaceBuffers::new(device, &arrays)?);
        PhotonTracer::new(device, &self.lights, &arrays, buffers, &self.frame, &self.settings)
    }

    /// What some passes store, and their ledger.
    pub fn passes(&self, count: u32) -> (Vec<Stored>, PhotonLedger) {
        let device = crate::common::device();
        let mut tracer = self.tracer(&device).unwrap();
        let mut all = Vec::new();
        for pass in 0..count {
            tracer.trace(&device, pass, 0, tracer.capacity()).unwrap();
            let photons = tracer.photons().read(&device).unwrap();
            all.extend(photons.iter().filter_map(|photon| self.stored(photon)));
        }
        (all, tracer.ledger(&device).unwrap())
    }

    /// The ledger of some passes.
    pub fn ledger(&self, passes: u32) -> PhotonLedger {
        self.passes(passes).1
    }

    /// The same with another limit on reflections and refractions.
    pub fn to_depth(&self, depth: u32) -> Self {
        let mut scene = self.clone();
        scene.settings.depth = depth;
        scene
    }

    pub fn stored(&self, photon: &Photon) -> Option<Stored> {
        let surface = photon.surface()? as usize;
        let [x, y, z, packed] = photon.position;
        let unit = self.frame.unit;
        Some(Stored {
            position: self.frame.origin + unit * DVec3::new(x.into(), y.into(), z.into()),
            direction: unpacked(packed.to_bits()),
            flux: [0, 1, 2].map(|c| unit * unit * f64::from(photon.flux[c])),
            surface,
        })
    }
}

/// A direction from 32 bits.
pub fn unpacked(packed: u32) -> DVec3 {
    let [x, y] = [packed & 0xffff, packed >> 16].map(|side| (f64::from(side) - 32768.0) / 32767.0);
    let z = 1.0 - x.abs() - y.abs();
    let fold = |a: f64, b: f64| (1.0 - b.abs()) * if a < 0.0 { -1.0 } else { 1.0 };
    let [x, y] = if z < 0.0 { [fold(x, y), fold(y, x)] } else { [x, y] };
    DVec3::new(x, y, z).normalize()
}

/// A diffuse plane at height z, facing up.
pub fn floor(z: f64) -> (SurfaceShape, SurfaceMaterial) {
    (SurfaceShape::Plane { point: DVec3::new(0.0, 0.0, z), normal: DVec3::Z }, PAPER)
}

pub fn sphere(centre: DVec3, radius: f64) -> SurfaceShape {
    SurfaceShape::Sphere { centre, radius }
}

/// Shines on everything below with irradiance 1.
pub fn sun() -> Light {
    Light::Directional { direction: DVec3::NEG_Z, irradiance: [1.0; 3] }
}

pub fn truths() -> serde_json::Value {
    serde_json::from_str(include_str!("../truths.json")).unwrap()
}

pub fn number(value: &serde_json::Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("truths.json lacks {key}"))
}

/// The flux of a bump (1 - (distance from the ring of radius r / width)^2)^2 around the axis through `middle`, and that of
/// an irradiance E(r) by the midpoint rule.
pub fn bump(
    photons: &[Stored],
    middle: DVec3,
    r: f64,
    width: f64,
    irradiance: impl Fn(f64) -> f64,
) -> [f64; 2] {
    let weight = |at: f64| (1.0 - ((at - r) / width).powi(2)).max(0.0).powi(2);
    let found = photons.iter().map(|p| weight(p.position.distance(middle)) * p.flux[0]).sum();
    let low = f64::max(r - width, 0.0);
    let step = (r + width - low) / 2000.0;
    let at = |i: u32| low + step * (f64::from(i) + 0.5);
    let exact =
        (0..2000).map(|i| irradiance(at(i)) * weight(at(i)) * std::f64::consts::TAU * at(i) * step).sum();
    [found, exact]
}

pub fn mean(flux: [f64; 3]) -> f64 {
    flux.iter().sum::<f64>() / 3.0
}
