//! `svetlo check`.

use super::{load_scene, print_line};
use crate::Result;
use crate::device::memory::readable_bytes;
use crate::device::{Catalog, MemoryPlan};
use crate::render::{BRICK_SHIFT, Plan, PlannedVolume, SceneData, announced_memory, method_name};
use crate::scene::{
    Background, Camera, CameraKind, Filter, Method, Phase, ScatteringMedium, Scene, SurfaceMaterial,
};
use crate::volume::Volume;
use glam::DVec3;
use std::fmt::Write;
use std::path::PathBuf;

/// Arguments of `svetlo check`.
#[derive(clap::Args)]
pub struct CheckArgs {
    /// The scene file.
    scene: PathBuf,
    /// Override a value of the scene, such as `image.width=256` (repeatable).
    #[arg(long, value_name = "KEY.PATH=VALUE")]
    set: Vec<String>,
}

/// Validates the scene and its data, and prints the plan.
///
/// # Errors
/// [`crate::Error::Input`] with every problem of the scene, or the first of its data; [`crate::Error::Failed`] when
/// no device here can hold it.
pub fn run(arguments: &CheckArgs) -> Result<()> {
    let scene = load_scene(&arguments.scene, &arguments.set)?;
    let catalog = Catalog::enumerate();
    refuse_what_fits_nowhere(&announced_memory(&scene), &catalog)?;
    let data = SceneData::load(&scene)?;
    let plan = Plan::new(&scene, &data, BRICK_SHIFT)?;
    print_line(&describe(&plan, data.volume.as_ref(), &catalog))
}

/// A field that no device can hold is not worth sampling; without a device, the plan is all there is to say.
fn refuse_what_fits_nowhere(memory: &MemoryPlan, catalog: &Catalog) -> Result<()> {
    let verdicts: Vec<Result<()>> = catalog.devices.iter().map(|device| memory.check(device)).collect();
    if verdicts.iter().any(Result::is_ok) { Ok(()) } else { verdicts.into_iter().next().unwrap_or(Ok(())) }
}

fn describe(plan: &Plan<'_>, volume: Option<&Volume>, catalog: &Catalog) -> String {
    let mut text = String::new();
    let scene = plan.scene;
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<10} {value}");
    };
    line("scene", format!("valid, hash {}", scene.hash));
    line(
        "image",
        format!("{}×{}, {}", scene.image.width, scene.image.height, filter_text(scene.image.filter)),
    );
    line("camera", camera_text(&scene.camera));
    if scene.views.len() > 1 {
        line("views", format!("{}, of which this is the first", scene.views.len()));
    }
    if let (Some(volume), Some(planned)) = (volume, &plan.volume) {
        line("volume", volume_text(volume, planned));
        line("window", format!("{} to {}", planned.window.0 as f32, planned.window.1 as f32));
    }
    if !scene.surfaces.is_empty() {
        line("surfaces", surfaces_text(scene));
    }
    line("background", background_text(&scene.background));
    line("method", method_name(&scene.method).into());
    if let Method::Scattering(_) | Method::LightVolume(_) = scene.method {
        line("medium", medium_text(&scene.scattering));
        line("phase", phase_text(&scene.phase));
    }
    line("stop", stop_text(plan));
    line("program", format!("cl/{} {}", plan.spec.entry, plan.spec.options()));
    for note in plan.notes.iter().chain(&plan.method.details) {
        line("note", note.clone());
    }
    let memory = plan.memory();
    line("memory", readable_bytes(memory.total()));
    for (name, bytes) in memory.items.iter().filter(|(_, bytes)| *bytes >= 1024) {
        line("", format!("{:>10}  {name}", readable_bytes(*bytes)));
    }
    let tiles = u64::from(scene.image.width.div_ceil(8)) * u64::from(scene.image.height.div_ceil(8));
    line("launches", format!("{tiles} tiles of 8×8 pixels a sample; launches grow to about 100 ms"));
    for device in &catalog.devices {
        let verdict = match memory.check(device) {
            Ok(()) => format!("{}: fits", device.name),
            Err(error) => error.to_string(),
        };
        line("device", format!("{} {verdict}", device.selector));
    }
    if catalog.devices.is_empty() {
        line("device", "none found; install an OpenCL runtime to render".into());
    }
    text.trim_end().into()
}

fn volume_text(volume: &Volume, planned: &PlannedVolume<'_>) -> String {
    let [x, y, z] = volume.dims;
    let local = &planned.local;
    format!(
        "{x}×{y}×{z} {}, spacing {}, box {} to {}",
        volume.voxel_type().name(),
        point(local.spacing * local.unit),
        point(local.origin),
        point(local.origin + local.size() * local.unit)
    )
}

/// How many surfaces there are of each kind of material.
fn surfaces_text(scene: &Scene) -> String {
    let count = |what: &str, wanted: fn(&SurfaceMaterial) -> bool| {
        let of = scene.surfaces.iter().filter(|surface| wanted(&scene.materials[surface.material])).count();
        (of > 0).then(|| format!("{of} {what}"))
    };
    let kinds = [
        count("diffuse", |material| matches!(material, SurfaceMaterial::Diffuse { .. })),
        count("mirror", |material| matches!(material, SurfaceMaterial::Mirror { .. })),
        count("glass", |material| matches!(material, SurfaceMaterial::Dielectric { .. })),
    ];
    kinds.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

fn point(p: DVec3) -> String {
    triple(p.to_array())
}

fn triple([x, y, z]: [f64; 3]) -> String {
    // Float32 is plenty here, and 0.3 stays 0.3.
    format!("({}, {}, {})", x as f32, y as f32, z as f32)
}

fn camera_text(camera: &Camera) -> String {
    let kind = match camera.kind {
        CameraKind::Perspective { fov, aperture, focus } => {
            let lens = if aperture > 0.0 {
                format!(", lens radius {} focused at {}", aperture as f32, focus as f32)
            } else {
                String::new()
            };
            format!("perspective, {}° high{lens}", fov.to_degrees() as f32)
        }
        CameraKind::Orthographic { height } => format!("orthographic, {} high", height as f32),
    };
    format!("{kind}, from {} to {}", point(camera.position), point(camera.target))
}

fn background_text(background: &Background) -> String {
    match background {
        Background::Constant(color) => format!("radiance {}", triple(*color)),
        Background::Environment { path, intensity, .. } => format!("{} × {intensity}", path.display()),
    }
}

fn medium_text(medium: &ScatteringMedium) -> String {
    let extinction =
        medium.extinction_color.map_or(String::new(), |c| format!(", extinction × {}", triple(c)));
    format!("albedo {} × the transfer function's colours{extinction}", triple(medium.albedo))
}

fn phase_text(phase: &Phase) -> String {
    match *phase {
        Phase::Isotropic => "isotropic".into(),
        Phase::HenyeyGreenstein { g } => format!("Henyey-Greenstein, g {g}"),
        Phase::Rayleigh => "Rayleigh".into(),
        Phase::TwoLobe { g: [first, second], weight } => {
            format!("Henyey-Greenstein, {weight} of g {first} and {} of g {second}", (1.0 - weight) as f32)
        }
    }
}

fn filter_text(filter: Filter) -> &'static str {
    match filter {
        Filter::Box => "mean over each pixel's area",
        Filter::Point => "rays through pixel centres",
    }
}

fn stop_text(plan: &Plan<'_>) -> String {
    if plan.is_deterministic() {
        return "after 1 sample: all samples of a pixel are the same".into();
    }
    let stop = &plan.scene.stop;
    let rules = [
        stop.samples.map(|n| format!("{n} samples")),
        stop.time.map(|time| format!("{time:?}")),
        stop.error.map(|error| format!("estimated error {:.3} %", error * 100.0)),
    ];
    format!("at {}", rules.into_iter().flatten().collect::<Vec<_>>().join(" or "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scattering_medium_in_words() {
        let grey = ScatteringMedium { albedo: [0.9; 3], extinction_color: None };
        assert_eq!(medium_text(&grey), "albedo (0.9, 0.9, 0.9) × the transfer function's colours");
        let coloured = ScatteringMedium { albedo: [1.0; 3], extinction_color: Some([1.0, 0.8, 0.5]) };
        assert!(medium_text(&coloured).ends_with("colours, extinction × (1, 0.8, 0.5)"));
    }

    #[test]
    fn a_phase_function_in_words() {
        assert_eq!(phase_text(&Phase::HenyeyGreenstein { g: -0.3 }), "Henyey-Greenstein, g -0.3");
        let two = Phase::TwoLobe { g: [0.9, -0.5], weight: 0.7 };
        assert_eq!(phase_text(&two), "Henyey-Greenstein, 0.7 of g 0.9 and 0.3 of g -0.5");
    }
}
