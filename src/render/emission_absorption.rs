//! Emission-absorption: the kernel is `cl/render/emission_absorption.cl`.

use super::medium::{BRICK_STRAIGHT, MediumTable};
use super::method::{DeviceFrame, HostBuffer, MethodInput, MethodSetup};
use crate::device::ProgramSpec;
use crate::scene::{Compositing, Quadrature, Transfer};
use crate::{Error, Result, device_struct};

device_struct! {
    "types/method.cl",
    /// Parameters of emission-absorption, and of the projection of light volumes; see `cl/types/method.cl`.
    pub struct EmissionAbsorption {
        /// Extinction per channel relative to sigma_t, the largest 1.
        pub extinction: [f32; 4],
        /// Mean cosines of the phase function's lobes, the share of the first, and the mean cosine of all.
        pub phase: [f32; 4],
        /// Step size in local units.
        pub step: f32,
        /// Rays stop below this transmittance; 0 is never.
        pub min_transmittance: f32,
        /// The same as an optical depth; infinite is never.
        pub max_depth: f32,
        /// Factor of the transfer function's colours.
        pub radiance: f32,
        /// Values (in entries of the table) below this one have no extinction.
        pub empty_value: f32,
        /// Padding.
        pub pad_0: u32,
        /// Padding.
        pub pad_1: u32,
        /// Padding.
        pub pad_2: u32,
    }
}

/// Settings of the method, from the scene.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// Radiance that the transfer function's colours are scaled by.
    pub radiance: f64,
    /// How the integral along a ray is computed.
    pub quadrature: Quadrature,
    /// Smallest transmittance that is followed.
    pub termination: f64,
}

/// Kernels count steps in float32 numbers.
fn check_steps(steps: f64) -> Result<()> {
    const MOST: f64 = 16_777_216.0;
    if steps > MOST {
        return Err(Error::Input(format!(
            "the diagonal of the volume takes {steps:.3e} steps, at most 2^24 are possible: increase `method.step`"
        )));
    }
    Ok(())
}

/// Makes the method ready.
///
/// # Errors
/// [`crate::Error::Input`] when a 2-D table cannot be read, or a ray would take too many steps.
pub fn prepare(input: &MethodInput<'_>, settings: Settings, frame: &mut DeviceFrame) -> Result<MethodSetup> {
    let scene = input.scene;
    let table = MediumTable::new(&scene.transfer, &scene.medium, input.window, input.local.unit)?;
    frame.table_size = table.size as u32;
    frame.table_rows = table.rows as u32;
    frame.gradient_scale = table.gradient_scale;
    let two_d = matches!(scene.transfer, Transfer::TwoD(_));

    let (step, jitter, linear) = match settings.quadrature {
        Quadrature::Cell => (None, false, false),
        Quadrature::Step { step, jitter, compositing } => {
            check_steps(input.local.size().length() / step)?;
            (Some(step), jitter, matches!(compositing, Compositing::Linear))
        }
    };
    // Opacity is what the linear form gets wrong, so the shortcut of summing optical depth would hide it.
    let sigma_only = !linear && (table.is_black() || settings.radiance == 0.0);
    let spec = ProgramSpec::new("render/emission_absorption.cl")
        .feature("TF_2D", two_d)
        .feature("STEP", step.is_some())
        .feature("JITTER", jitter)
        .feature("LINEAR_COMPOSITING", linear)
        .feature("TRANSMITTANCE_ONLY", sigma_only);
    let parameters = EmissionAbsorption {
        extinction: [1.0, 1.0, 1.0, 0.0],
        phase: [0.0; 4],
        step: step.unwrap_or(1.0) as f32,
        min_transmittance: settings.termination as f32,
        max_depth: -settings.termination.ln() as f32,
        radiance: settings.radiance as f32,
        empty_value: table.empty_value() as f32,
        pad_0: 0,
        pad_1: 0,
        pad_2: 0,
    };
    let classes = table.classify(input.bricks, input.grid);
    let bricks = input.bricks.ranges.len();
    let occupied = classes[..bricks].iter().filter(|&&class| class >= BRICK_STRAIGHT).count();
    let kinks = table.kinks();
    let details = vec![format!(
        "{occupied} of {bricks} bricks can hold extinction; the largest is {:.6} per scene unit",
        table.max_sigma() / input.local.unit
    )];
    Ok(MethodSetup {
        spec,
        kernel: "render_emission_absorption",
        parameters: HostBuffer::new("method parameters", &[parameters]),
        tables: vec![
            HostBuffer { name: "brick classes", bytes: classes },
            HostBuffer { name: "transfer function", bytes: table.device_entries(sigma_only) },
            HostBuffer::new("kinks before each entry", &table.kinks_before(&kinks)),
            HostBuffer::new("kinks of the transfer function", &kinks),
        ],
        value_units: table.intervals(),
        random: jitter,
        lanes: step.is_some() || two_d,
        paths: false,
        has_depth: false,
        notes: Vec::new(),
        details,
        light: None,
        caustics: None,
    })
}
