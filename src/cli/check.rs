//! `svetlo check`.

use super::print_line;
use crate::Result;
use crate::device::Catalog;
use crate::device::memory::readable_bytes;
use crate::render::{BRICK_SHIFT, Plan, load_volume, method_name};
use crate::scene::{Filter, Scene};
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
/// [`crate::Error::Input`] with every problem of the scene, or the first of its data.
pub fn run(arguments: &CheckArgs) -> Result<()> {
    let scene = Scene::load(&arguments.scene, &arguments.set)?;
    let volume = load_volume(&scene.volume)?;
    let plan = Plan::new(&scene, &volume, BRICK_SHIFT)?;
    print_line(&describe(&plan, &volume))
}

fn describe(plan: &Plan<'_>, volume: &crate::volume::Volume) -> String {
    let mut text = String::new();
    let scene = plan.scene;
    let [x, y, z] = volume.dims;
    let spacing = plan.local.spacing * plan.local.unit;
    let size = plan.local.size() * plan.local.unit;
    let mut line = |name: &str, value: String| {
        let _ = writeln!(text, "{name:<10} {value}");
    };
    line("scene", format!("valid, hash {}", scene.hash));
    line(
        "image",
        format!("{}×{}, {}", scene.image.width, scene.image.height, filter_text(scene.image.filter)),
    );
    line(
        "volume",
        format!(
            "{x}×{y}×{z} {}, spacing {spacing}, box {} to {}",
            volume.voxel_type().name(),
            plan.local.origin,
            plan.local.origin + size
        ),
    );
    line("window", format!("{} to {}", plan.window.0, plan.window.1));
    line("method", method_name(&scene.method).into());
    line("stop", stop_text(plan));
    line("program", format!("cl/{} {}", plan.spec.entry, plan.spec.options()));
    for note in &plan.notes {
        line("note", note.clone());
    }
    let memory = plan.memory();
    line("memory", readable_bytes(memory.total()));
    for (name, bytes) in memory.items.iter().filter(|(_, bytes)| *bytes >= 1024) {
        line("", format!("{:>10}  {name}", readable_bytes(*bytes)));
    }
    let tiles = u64::from(scene.image.width.div_ceil(8)) * u64::from(scene.image.height.div_ceil(8));
    line("launches", format!("{tiles} tiles of 8×8 pixels a sample; launches grow to about 100 ms"));
    let catalog = Catalog::enumerate();
    for device in &catalog.devices {
        let verdict = match memory.check(device) {
            Ok(()) => "fits".into(),
            Err(error) => error.to_string(),
        };
        line("device", format!("{} {}: {verdict}", device.selector, device.name));
    }
    if catalog.devices.is_empty() {
        line("device", "none found; install an OpenCL runtime to render".into());
    }
    text.trim_end().into()
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
