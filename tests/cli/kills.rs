//! Renders that are killed at random moments and resumed: the same bits as without, and whole images at every moment.

use crate::support::{Folder, SCENE};
use std::collections::BTreeMap;
use std::process::{Child, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use svetlo::picture::{Picture, Samples, read_exr, read_png};

const SCATTERING: &str = "method={ kind = \"multiple-scattering\", max_order = 4 }";
const HYBRID: &str = "method={ kind = \"hybrid-diffusion\", iterations = 3 }";
const MEDIUM: &str = "medium.albedo=0.9";
const SUN: &str = "light=[{ kind = \"directional\", direction = [1, -2, 1], irradiance = [3, 2, 1] }]";
const AUXILIARY: &str = "film.auxiliary=true";
/// A glass sphere over a plane, with light that is gathered and light that is passed on.
const CAUSTICS: &str = r#"
image = { width = 24, height = 16 }
camera = { position = [0, -4, 2], target = [0, 0, 0.4], up = [0, 0, 1] }
material = [{ name = "white", kind = "diffuse", color = 0.8 }, { name = "glass", kind = "dielectric", ior = 1.5 }]
surface = [
    { kind = "plane", point = [0, 0, 0], normal = [0, 0, 1], material = "white" },
    { kind = "sphere", centre = [0, 0, 0.6], radius = 0.5, material = "glass" },
]
light = [{ kind = "point", position = [1, -1, 3], intensity = 5 }]
method = { kind = "caustics", photons = 2048, radius = 0.1 }
"#;

/// Scene, overrides, and samples that take about half a second on two cores.
type Render = (&'static str, &'static [&'static str], &'static str);
const RENDERS: [Render; 4] = [
    (SCENE, &[], "6000"),
    (SCENE, &[SCATTERING, MEDIUM, SUN, AUXILIARY], "1000"),
    (CAUSTICS, &[], "30"),
    (SCENE, &[HYBRID, MEDIUM, SUN], "3000"),
];

/// Numbers in [0, 1): the same moments in every run, as far as the machine is as quick.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        // Knuth's MMIX generator; its upper bits are the good ones.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn start(folder: &Folder, render: &Render, output: &str, more: &[&str]) -> Child {
    let sets = render.1.iter().flat_map(|set| ["--set", set]);
    let arguments: Vec<&str> =
        ["render", "scene.toml", "--samples", render.2, "--quiet", "--snapshot", "50ms", "-o", output]
            .into_iter()
            .chain(sets)
            .chain(more.iter().copied())
            .collect();
    folder.svetlo(&arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Lets a render run for a time, or to its end; whether it came there.
fn ends_within(mut child: Child, time: Duration) -> bool {
    let begin = Instant::now();
    while begin.elapsed() < time {
        if child.try_wait().unwrap().is_some() {
            let ended = child.wait_with_output().unwrap();
            assert_eq!(ended.status.code(), Some(0), "{}", String::from_utf8_lossy(&ended.stderr));
            return true;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    let killed = child.wait_with_output().unwrap();
    // It may just have come to its end.
    assert!(matches!(killed.status.code(), None | Some(0)), "{}", String::from_utf8_lossy(&killed.stderr));
    killed.status.success()
}

/// Kills a render of about `whole` at random moments and resumes it until it is done; how often it was killed.
fn kill_and_resume(
    folder: &Folder,
    render: &Render,
    output: &str,
    whole: Duration,
    chance: &mut Chance,
) -> usize {
    let mut kills = 0;
    while !ends_within(start(folder, render, output, &["--resume"]), whole.mul_f64(chance.next())) {
        kills += 1;
    }
    kills
}

/// Reads an image and its preview again and again, as a viewer does; how often.
fn poll(folder: &Folder, output: &str, done: &AtomicBool) -> usize {
    let image = folder.path(output);
    let preview = image.with_extension("png");
    let mut reads = 0;
    while !done.load(Ordering::Relaxed) {
        if image.exists() {
            read_exr(&image).expect("the image is whole at every moment");
            reads += 1;
        }
        if preview.exists() {
            read_png(&preview).expect("the preview is whole at every moment");
        }
    }
    reads
}

fn bits(picture: &Picture) -> BTreeMap<&str, Vec<u32>> {
    let words = |samples: &Samples| match samples {
        Samples::F32(values) => values.iter().map(|value| value.to_bits()).collect(),
        Samples::U32(values) => values.clone(),
    };
    picture.channels.iter().map(|channel| (channel.name.as_str(), words(&channel.data))).collect()
}

/// All pixels and states are the same bits, and so is all that the header says but times, and how launches were cut.
fn assert_same(resumed: &Picture, whole: &Picture) {
    assert!(bits(resumed) == bits(whole), "pixels differ");
    let number = |picture: &Picture, key: &str| -> f64 {
        picture.metadata.get(key).map_or(0.0, |text| text.parse().expect("a number"))
    };
    let sums = ["paths", "photons_emitted", "bounced_emitted"];
    let sums: f64 = sums.iter().map(|key| number(whole, &format!("svetlo.{key}"))).sum();
    let keys = |picture: &Picture| picture.metadata.keys().cloned().collect::<Vec<_>>();
    assert_eq!(keys(resumed), keys(whole));
    let assert_near = |key: &str| {
        let (a, b) = (number(resumed, key), number(whole, key));
        assert!((a - b).abs() <= f64::from(f32::EPSILON) * sums, "{key}: {a} {b}");
    };
    for (key, value) in &whole.metadata {
        let other = &resumed.metadata[key];
        match key.trim_start_matches("svetlo.") {
            "seconds_wall" | "seconds_device" | "seconds_build" | "launches" => {}
            // Weights of paths and fluxes of photons are summed as pairs of float32, to which sums of launches are added
            // that are rounded to float32: how launches were cut shows in the last digits.
            "escaped" | "absorbed" | "cut" | "gained" => assert_near(key),
            flux if flux.starts_with("photons_") || flux.starts_with("bounced_") => assert_near(key),
            _ => assert_eq!(value, other, "{key}"),
        }
    }
}

/// Kills until each of the renders was killed and resumed `rounds` times; how often in all.
fn torment(rounds: usize, seed: u64) -> usize {
    let mut chance = Chance(seed);
    let mut total = 0;
    for (number, render) in RENDERS.iter().enumerate() {
        let folder = Folder::in_memory();
        folder.write("scene.toml", render.0);
        // Once for the programs, which later runs find in the cache.
        assert!(ends_within(start(&folder, render, "whole.exr", &[]), Duration::from_secs(60)));
        let begin = Instant::now();
        assert!(ends_within(start(&folder, render, "whole.exr", &[]), Duration::from_secs(60)));
        let time = begin.elapsed();
        let whole = folder.image("whole.exr");
        let (mut round, mut reads) = (0, 0);
        while round < rounds {
            let output = format!("{round}.exr");
            let done = AtomicBool::new(false);
            let (kills, seen) = std::thread::scope(|scope| {
                let reader = scope.spawn(|| poll(&folder, &output, &done));
                let kills = kill_and_resume(&folder, render, &output, time, &mut chance);
                done.store(true, Ordering::Relaxed);
                (kills, reader.join().unwrap())
            });
            assert_same(&folder.image(&output), &whole);
            // A run that came to its end has cleaned up after those before it.
            assert!(!folder.names().iter().any(|name| name.starts_with('.')), "{:?}", folder.names());
            round += kills.min(1);
            (total, reads) = (total + kills, reads + seen);
        }
        assert!(reads > 0, "render {number} was never seen on its way");
        println!("render {number}: {time:.2?}, {rounds} times killed and resumed, {reads} images read");
    }
    total
}

#[test]
fn renders_that_are_killed_come_to_the_same_bits() {
    assert!(torment(1, 5) >= RENDERS.len());
}

/// Some minutes; see CONTRIBUTING.
#[test]
#[ignore = "takes minutes"]
fn a_hundred_renders_that_are_killed_come_to_the_same_bits() {
    println!("{} kills", torment(100 / RENDERS.len(), 7));
}
