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
        let emission = EmissionSettings { photons, emission: Emission::Radiometric, target: None };
        Self {
            surfaces,
            materials,
            lights: lights.into_iter().collect(),
            settings: PhotonSettings { emission, depth: 5, seed: 7, store_direct: false },
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

    fn stored(&self, photon: &Photon) -> Option<Stored> {
        let surface = photon.flux[3].to_bits().checked_sub(1)? as usize;
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

pub fn mean(flux: [f64; 3]) -> f64 {
    flux.iter().sum::<f64>() / 3.0
}
