//! Light volumes: what computes them is in [`crate::irradiance`], the projection is `cl/render/light_volume.cl`.

use super::emission_absorption::EmissionAbsorption;
use super::majorants::sampled;
use super::medium::{BRICK_STRAIGHT, MediumTable};
use super::method::{DeviceFrame, HostBuffer, MethodInput, MethodSetup};
use super::scattering;
use crate::Result;
use crate::device::ProgramSpec;
use crate::irradiance::{self, LightGrid};
use crate::scene::{
    DirectLight, LightVolume, Orders, Phase, ScatteredLight, Scattering, Transfer, Transmittance,
};

/// What computes a light volume, made ready on the host.
pub struct LightSetup {
    /// The settings.
    pub settings: LightVolume,
    /// The medium and its lights as kernels that track light read them.
    pub transport: MethodSetup,
    /// The phase function, as far as the model knows it.
    pub phase: Phase,
    /// Cells of unscattered light, and of the volume that is projected.
    pub direct_grid: LightGrid,
    /// Cells of scattered light.
    pub scattered_grid: LightGrid,
}

impl LightSetup {
    /// Whether the light volume keeps directions.
    pub fn is_directed(&self) -> bool {
        !self.phase.is_isotropic()
    }
}

/// The phase function that the model knows: steps in time scatter into all directions alike.
pub(super) fn modelled(phase: Phase, settings: &LightVolume) -> Phase {
    match settings.scattered {
        ScatteredLight::Steady(_) => phase,
        ScatteredLight::Steps { .. } => Phase::Isotropic,
    }
}

/// Refuses what the model cannot do; what it leaves out, one sentence each.
fn check(input: &MethodInput<'_>, settings: &LightVolume) -> Result<Vec<String>> {
    let scene = input.scene;
    let grid = LightGrid::new(input.local, settings.direct_coarsening);
    let mut notes = Vec::new();
    if settings.direct == DirectLight::Convection {
        irradiance::refusal(scene)?;
        notes.extend(irradiance::unlit_by(&scene.background));
    }
    if let ScatteredLight::Steps { courant, spreading, .. } = settings.scattered {
        if settings.direct == DirectLight::Convection {
            irradiance::check_courant(courant, &scene.lights, &grid, input.local)?;
        }
        irradiance::check_diffusion(spreading, &grid)?;
        if !scene.phase.is_isotropic() {
            notes.push("the paper's model scatters into all directions alike: [phase] is not used".into());
        }
    }
    Ok(notes)
}

/// What to say of a medium, with these extinctions at points all over the box, whose light comes to its surface in cells of
/// more than a mean free path.
fn thickness(sigmas: &[f64], grid: &LightGrid) -> Option<String> {
    let edge = grid.cell.max_element();
    let medium = sigmas.iter().filter(|&&sigma| sigma > 0.0).count();
    let thick = sigmas.iter().filter(|&&sigma| sigma * edge > THICK).count();
    let thickest = edge * sigmas.iter().copied().fold(0.0, f64::max);
    (thick > 0).then(|| {
        format!(
            "cells of direct light are up to {thickest:.2} mean free paths thick, {:.1} % of the medium's more than {THICK}: what \
             lights their surfaces is not resolved, and pictures come out too dark or too bright (by a twentieth at 2, by a \
             half at 10); the method multiple-scattering is right, and finer voxels would do",
            100.0 * thick as f64 / medium as f64
        )
    })
}

/// Mean free paths in a cell that are worth a note.
const THICK: f64 = 1.0;

/// Makes the method ready.
///
/// # Errors
/// [`crate::Error::Input`] when a 2-D table cannot be read, or the medium is too dense to track light through it.
pub fn prepare(
    input: &MethodInput<'_>,
    settings: LightVolume,
    frame: &mut DeviceFrame,
) -> Result<MethodSetup> {
    let scene = input.scene;
    let mut notes = check(input, &settings)?;
    // Kernels of light volumes read the medium as single scattering does.
    let tracking = Scattering {
        orders: Orders::Single,
        transmittance: Transmittance::Auto,
        majorant_scale: 1.0,
        paths: None,
    };
    let transport = scattering::prepare(input, tracking, frame)?;
    let table = MediumTable::new(&scene.transfer, &scene.medium, input.window, input.local.unit)?;
    let chromatic = scene.scattering.extinction_color;
    let largest = chromatic.map_or(1.0, |color| color.into_iter().fold(0.0, f64::max));
    let extinction = chromatic.unwrap_or([1.0; 3]).map(|e| e / largest);
    let albedo = scene.scattering.albedo;
    let emission = scattering::emission(&scene.transfer, input.window)?;
    let two_d = matches!(scene.transfer, Transfer::TwoD(_));
    let phase = modelled(scene.phase, &settings);
    let directed = !phase.is_isotropic();
    let mut spec = ProgramSpec::new("render/light_volume.cl")
        .feature("TF_2D", two_d)
        .feature("CHROMATIC", chromatic.is_some())
        .feature("EMISSION", emission.is_some())
        .feature("DIRECTED", directed);
    if directed {
        spec = spec.define(scattering::phase_define(phase), "1");
    } else {
        spec = spec.define("PHASE_ISOTROPIC", "1");
    }
    let [g0, g1, weight, _] = scattering::phase_parameters(phase);
    let [r, g, b] = extinction.map(|e| e as f32);
    let parameters = EmissionAbsorption {
        extinction: [r, g, b, 0.0],
        phase: [g0, g1, weight, phase.mean_cosine() as f32],
        step: 1.0,
        min_transmittance: settings.termination as f32,
        max_depth: -settings.termination.ln() as f32,
        radiance: 1.0,
        empty_value: table.empty_value() as f32,
        pad_0: 0,
        pad_1: 0,
        pad_2: 0,
    };
    let classes = table.classify(input.bricks, input.grid);
    let bricks = input.bricks.ranges.len();
    let occupied = classes[..bricks].iter().filter(|&&class| class >= BRICK_STRAIGHT).count();
    let kinks = table.kinks();
    let [direct_grid, scattered_grid] = [settings.direct_coarsening, settings.coarsening]
        .map(|coarsening| LightGrid::new(input.local, coarsening));
    let sigmas = sampled(input.grid, &table).into_iter().map(|sigma| sigma * largest);
    notes.extend(thickness(&sigmas.collect::<Vec<f64>>(), &direct_grid));
    let cells = |grid: &LightGrid| format!("{}×{}×{}", grid.dims[0], grid.dims[1], grid.dims[2]);
    let details = vec![
        format!("{occupied} of {bricks} bricks can hold extinction"),
        format!(
            "direct light in {} cells, scattered light in {} cells",
            cells(&direct_grid),
            cells(&scattered_grid)
        ),
    ];
    Ok(MethodSetup {
        spec,
        kernel: "render_light_volume",
        parameters: HostBuffer::new("method parameters", &[parameters]),
        tables: vec![
            HostBuffer { name: "brick classes", bytes: classes },
            HostBuffer {
                name: "transfer function",
                bytes: table.device_sources(albedo, extinction, largest, emission.as_deref()),
            },
            HostBuffer::new("kinks before each entry", &table.kinks_before(&kinks)),
            HostBuffer::new("kinks of the transfer function", &kinks),
        ],
        value_units: table.intervals(),
        random: false,
        lanes: false,
        paths: false,
        has_depth: false,
        notes,
        details,
        light: Some(Box::new(LightSetup {
            settings,
            transport,
            phase: scene.phase,
            direct_grid,
            scattered_grid,
        })),
        caustics: None,
    })
}
