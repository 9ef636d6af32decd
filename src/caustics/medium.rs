//! The volume between surfaces: it takes light from photons and rays, and scatters it. The kernels are
//! `cl/caustics/medium.cl`, `cl/caustics/collisions.cl` and `cl/render/caustics_medium.cl`.
//!
//! Light that comes from a light and is scattered once is seen by shadow rays. Light that was at a mirror or glass before is
//! scattered any number of times, up to the limit on depth, and so photons are stored where that happens. Other light is
//! scattered once only, as surfaces reflect it once only. Bodies of glass displace the medium.

use super::emission::Emitter;
use super::target::{Part, Parts};
use crate::device::{Arg, Buffer, Device, ProgramSpec};
use crate::irradiance::LitMedium;
use crate::render::Plan;
use crate::render::caustics::MEDIUM_TABLES;
use crate::render::local::LocalFrame;
use crate::render::method::{DeviceFrame, MethodInput, MethodSetup};
use crate::render::scattering;
use crate::scene::{Acceleration, Caustics, Orders, Scattering, Transmittance};
use crate::{Error, Result};
use glam::DVec3;
use std::sync::Arc;

/// What of the scattering methods' definitions says how the medium is read.
const DEFINES: [&str; 9] = [
    "PHASE_ISOTROPIC",
    "PHASE_HG",
    "PHASE_RAYLEIGH",
    "PHASE_TWO_LOBE",
    "TF_2D",
    "CONSTANT_SIGMA",
    "SIGMA_RAMP",
    "CONSTANT_ALBEDO",
    "TRANSMITTANCE_RESIDUAL",
];

/// The medium of a scene of surfaces, as single scattering reads it.
///
/// # Errors
/// [`Error::Input`] where the medium has colours of extinction or glows, or photons are gathered as in no volume; and as
/// the scattering methods.
pub fn medium_setup(
    input: &MethodInput<'_>,
    settings: &Caustics,
    frame: &mut DeviceFrame,
) -> Result<MethodSetup> {
    let scene = input.scene;
    let refused = |what: &str| Err(Error::Input(format!("caustics in a volume: {what}")));
    if scene.scattering.extinction_color.is_some() {
        return refused(
            "the extinction must be the same for all colours: leave `medium.extinction_color` out",
        );
    }
    if scattering::emission(&scene.transfer, input.window)?.is_some() {
        return refused("the medium must not glow: leave the emission of [transfer] out");
    }
    if settings.gather.acceleration == Acceleration::Planar {
        return refused(
            "`method.gather.acceleration` must not be \"planar\", whose cells lie on surfaces; \"voxels\" would do",
        );
    }
    if settings.gather.paper_intensity.is_some() {
        return refused("`method.gather.weights` must be \"normalised\": those as published are of surfaces");
    }
    // Where majorants are tight, ratio tracking is all or nothing: most of the light between surfaces needs better.
    let tracking = Scattering {
        orders: Orders::Single,
        transmittance: Transmittance::ResidualRatio,
        majorant_scale: 1.0,
        paths: None,
    };
    scattering::prepare(input, tracking, frame)
}

/// Adds the definitions of kernels that read this medium; VOXEL is the plan's.
pub fn specialise_medium(spec: ProgramSpec, medium: &MethodSetup) -> ProgramSpec {
    let defines = medium.spec.defines.iter().filter(|(name, _)| DEFINES.contains(name));
    let spec = spec.define("MEDIUM", "1").define("WIDTH", "1");
    defines.fold(spec, |spec, (name, value)| spec.define(name, value))
}

/// The medium on a device, for photons.
pub struct PhotonMedium {
    buffers: LitMedium,
    defines: ProgramSpec,
}

impl PhotonMedium {
    /// Uploads the medium of `plan`, whose voxels are on the device already.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device lacks memory.
    pub fn new(
        device: &Device,
        plan: &Plan<'_>,
        medium: &MethodSetup,
        voxels: Arc<Buffer<u8>>,
    ) -> Result<Self> {
        let spec = ProgramSpec::new("caustics/photons.cl").define("VOXEL", plan.volume()?.grid.device_type());
        Ok(Self {
            buffers: LitMedium::around(device, plan, medium, voxels)?,
            defines: specialise_medium(spec, medium),
        })
    }

    /// Adds the definitions of kernels that read it.
    pub fn specialise(&self, spec: ProgramSpec) -> ProgramSpec {
        self.defines.defines.iter().fold(spec, |spec, (name, value)| spec.define(name, value))
    }

    /// Frame and `MEDIUM_ARGUMENTS` of `cl/caustics/medium.cl`.
    pub fn arguments(&self) -> Vec<Arg<'_>> {
        self.buffers.arguments(MEDIUM_TABLES)
    }
}

/// Has parallel light begin before the box of the volume, which takes of it on its way.
pub(super) fn begin_before(emitters: &mut [Emitter], frame: &LocalFrame) {
    let size = frame.size();
    let corner = |i: u32| size * DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
    let parts = (0..8).map(|i| Part::Point(corner(i))).collect();
    let box_of_volume = Parts { parts, unbounded: false };
    for emitter in emitters.iter_mut().filter(|emitter| emitter.is_parallel()) {
        let [x, y, z, begins] = emitter.place;
        let direction = DVec3::new(x.into(), y.into(), z.into());
        emitter.place[3] = begins.min(box_of_volume.begins_along(direction) as f32);
    }
}
