//! Devices that fail: whatever call it is, a render ends with one error that names it, and older pictures stay.

mod common;

use common::device;
use std::path::Path;
use std::sync::{Arc, mpsc};
use std::time::Duration;
use svetlo::device::{Call, Faults};
use svetlo::picture::write_exr;
use svetlo::render::{
    BRICK_SHIFT, Observer, Plan, Rendering, SceneData, Session, Snapshot, Status, data_hash, run,
};
use svetlo::scene::Scene;
use svetlo::{Error, Result};

/// A render takes far less, failed or not; what takes longer hangs.
const HANGS: Duration = Duration::from_secs(120);

/// Who watches a render and wants nothing of it.
struct Silent;

impl Observer for Silent {
    fn progress(&mut self, _: &Status) {}

    fn snapshot(&mut self, _: &dyn Rendering) -> Result<()> {
        Ok(())
    }

    fn interrupted(&self) -> bool {
        false
    }
}

/// A scene with its data.
struct Case {
    scene: Scene,
    data: SceneData,
    data_hash: String,
}

impl Case {
    fn new(name: &str) -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scenes");
        let text = std::fs::read_to_string(folder.join(name)).unwrap();
        let loaded = svetlo::config::parse(name, &text, &[]).unwrap();
        let scene = Scene::from_loaded(&loaded, &folder).unwrap();
        let data = SceneData::load(&scene).unwrap();
        let plan = Plan::new(&scene, &data, BRICK_SHIFT).unwrap();
        let data_hash = data_hash(&plan, &data).unwrap();
        Self { scene, data, data_hash }
    }

    /// From the device to the picture in its file, as `svetlo render` does it.
    fn render(&self, faults: &Arc<Faults>, output: &Path) -> Result<()> {
        let plan = Plan::new(&self.scene, &self.data, BRICK_SHIFT)?;
        let mut session = Session::new(device().failing(Arc::clone(faults))?, &plan)?;
        run(&mut session, &plan, &self.scene.stop, &mut Silent)?;
        let snapshot = Snapshot::take(&session, &plan, &self.data_hash, Duration::ZERO)?;
        write_exr(output, &snapshot.picture)
    }
}

/// What an error names of a call.
fn named(call: Call) -> &'static str {
    match call {
        Call::Open => "clCreateContext",
        Call::Build => "clBuildProgram",
        Call::Kernel => "clCreateKernel '",
        Call::Allocate => "bytes by clCreateBuffer",
        Call::Write => "clEnqueueWriteBuffer",
        Call::Read => "clEnqueueReadBuffer",
        Call::Launch => "launching kernel '",
        Call::Finish => "clFinish",
    }
}

/// Faults of a render that makes so many calls: each of them fails alone, and each is the one that loses the device. Of
/// more than `most`, as many that are spread evenly, and the first and last of each kind.
fn plans(counted: &Faults, most: usize) -> Vec<(Faults, String, &'static str)> {
    let alone = Call::ALL.iter().flat_map(|&call| {
        let last = counted.calls_of(call);
        (1..=last)
            .map(move |n| (Faults::fail(call, n), format!("{call} {n}"), named(call), n == 1 || n == last))
    });
    let last = counted.calls();
    let lost =
        (1..=last).map(|n| (Faults::lose(n), format!("lost at {n}"), "status -36", n == 1 || n == last));
    let all: Vec<_> = alone.chain(lost).collect();
    let (count, most) = (all.len(), all.len().min(most));
    let spread = |i: usize| (i + 1) * most / count > i * most / count;
    let kept = all.into_iter().enumerate().filter(|(i, (.., end))| *end || spread(*i));
    kept.map(|(_, (faults, what, needle, _))| (faults, what, needle)).collect()
}

/// Makes calls of a render fail in turn, alone and for good: at most about so many.
fn calls_fail(name: &'static str, most: usize) {
    let (beat, beats) = mpsc::channel();
    let worker = std::thread::spawn(move || {
        let case = Case::new(name);
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("picture.exr");
        let counted = Arc::new(Faults::default());
        case.render(&counted, &output).unwrap();
        let mut whole = std::fs::read(&output).unwrap();
        let device = device().info().name.clone();
        for call in Call::ALL {
            assert!(counted.calls_of(call) > 0, "{name}: no call to {call}");
        }
        let plans = plans(&counted, most);
        let (failures, mut missed) = (plans.len(), 0);
        println!("{name}: {} calls, {failures} failures", counted.calls());
        for (faults, what, needle) in plans {
            let what = format!("{name}: {what}");
            let faults = Arc::new(faults);
            let rendered = case.render(&faults, &output);
            beat.send(()).unwrap();
            if !faults.struck() {
                // There were fewer launches this time, as each took longer.
                rendered.unwrap_or_else(|error| panic!("{what}: {error}"));
                missed += 1;
                whole = std::fs::read(&output).unwrap();
                continue;
            }
            let error = rendered.expect_err(&what);
            assert!(matches!(error, Error::Failed(_)), "{what}: {error}");
            assert_eq!(error.exit_code(), 1);
            let text = error.to_string();
            for needle in [&device, needle] {
                assert!(text.contains(needle), "{what}: no {needle:?} in {text}");
            }
            assert_eq!(text.lines().count(), 1, "{what}: {text}");
            assert!(std::fs::read(&output).unwrap() == whole, "{what}: the picture is another");
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "{what}: files are left over");
        }
        assert!(2 * missed < failures, "{name}: {missed} of {failures} failures did not come");
        // A fault that never comes changes nothing.
        case.render(&Arc::new(Faults::lose(100 * counted.calls())), &output).unwrap();
    });
    loop {
        match beats.recv_timeout(HANGS) {
            Ok(()) => {}
            Err(mpsc::RecvTimeoutError::Timeout) => panic!("{name}: hangs"),
            // A panic of the worker is the test's.
            Err(mpsc::RecvTimeoutError::Disconnected) => {
                return worker.join().unwrap_or_else(|cause| std::panic::resume_unwind(cause));
            }
        }
    }
}

#[test]
fn every_call_of_a_projection() {
    calls_fail("tiny_mip.toml", usize::MAX);
}

#[test]
fn calls_of_scattering() {
    calls_fail("tiny_multiple_scattering.toml", 24);
}

#[test]
fn calls_of_a_light_volume() {
    calls_fail("tiny_hybrid_coarse.toml", 24);
}

#[test]
fn calls_of_caustics() {
    calls_fail("tiny_caustics.toml", 24);
}

/// As above, every call of all: minutes.
#[test]
#[ignore = "takes minutes"]
fn every_call_of_all() {
    for name in ["tiny_multiple_scattering.toml", "tiny_hybrid_coarse.toml", "tiny_caustics.toml"] {
        calls_fail(name, usize::MAX);
    }
}
