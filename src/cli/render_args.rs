//! The command line of `svetlo render`.

use crate::config::formats::{parse_duration, parse_percentage};
use crate::render::Share;
use std::path::PathBuf;
use std::time::Duration;

/// Arguments of `svetlo render`.
#[derive(clap::Args)]
pub struct RenderArgs {
    /// The scene file.
    pub scene: PathBuf,
    /// The image to write; the preview goes beside it as .png [default: the scene's name with .exr, here]. A scene with
    /// several views writes OUT.0001.exr, OUT.0002.exr and so on.
    #[arg(short, long, value_name = "OUT.exr")]
    pub output: Option<PathBuf>,
    /// Override a value of the scene, such as `image.width=256` (repeatable).
    #[arg(long, value_name = "KEY.PATH=VALUE")]
    pub set: Vec<String>,
    /// The device: a selector of `svetlo devices`, a kind (cpu, gpu) or part of a name. Repeat it for several that share the
    /// work, or say all, or all:gpu [env: SVETLO_DEVICE, several with commas between].
    #[arg(long, value_name = "SELECTOR")]
    pub device: Vec<String>,
    /// Stop after N samples per pixel; given here, --samples, --time and --error replace all stop rules of the scene.
    #[arg(long, value_name = "N", allow_negative_numbers = true,
        value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub samples: Option<u64>,
    /// Stop after this time, such as 500ms, 30s, 2m.
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    pub time: Option<Duration>,
    /// Stop when the estimated relative error is below this, such as 1%.
    #[arg(long, value_name = "ERROR", value_parser = parse_percentage)]
    pub error: Option<f64>,
    /// Seed of the random numbers; overrides the scene's.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// Continue the render whose image is at the output, bit for bit as if it had never stopped. --samples is the
    /// total then, --error that of the whole, --time that of this run. Without an image there, start anew.
    #[arg(long)]
    pub resume: bool,
    /// Rewrite the image and its preview after this time, and again and again, such as 10m [default: after 1s, then every
    /// 5s, or less often where that would take more than a twentieth of the time].
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    pub snapshot: Option<Duration>,
    /// Write the light volume (hybrid-diffusion, convection-diffusion) to this file, too.
    #[arg(long, value_name = "LIGHT.nrrd", conflicts_with = "load_light")]
    pub save_light: Option<PathBuf>,
    /// Take the light volume from this file instead of computing it: the scene may differ in camera, image and stop
    /// rules alone.
    #[arg(long, value_name = "LIGHT.nrrd")]
    pub load_light: Option<PathBuf>,
    /// Render part I of N, for `svetlo merge` to add up: the samples I, I + N, I + 2N … of the picture, as a picture of its
    /// own. --samples and --error stay those of the whole picture: a part stops with its share of the samples, or where N
    /// parts like it have that error together. [default output: the scene's name with .I-of-N.exr]
    #[arg(long, value_name = "I/N", value_parser = clap::value_parser!(Share))]
    pub part: Option<Share>,
    /// Print nothing but errors.
    #[arg(long)]
    pub quiet: bool,
    /// Print a JSON summary to stdout at the end, and nothing else there.
    #[arg(long)]
    pub json: bool,
}

impl RenderArgs {
    /// The overrides of the scene.
    pub fn sets(&self) -> Vec<String> {
        self.set.iter().cloned().chain(self.seed.map(|seed| format!("seed={seed}"))).collect()
    }
}
