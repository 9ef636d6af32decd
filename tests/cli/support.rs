//! A folder with a small scene, and runs of the binary in it.

use assert_cmd::cargo::cargo_bin;
use std::ffi::OsStr;
use std::path::PathBuf;
use std::process::{Child, Command, Output};
use std::time::{Duration, Instant};
use svetlo::picture::{Picture, read_exr};

/// A sphere, a few pixels large; its samples differ, so seeds and sample counts show.
pub const SCENE: &str = r#"
[image]
width = 24
height = 16
[camera]
position = [0.5, 0.5, -2]
target = [0.5, 0.5, 0.5]
[volume]
field = { kind = "sphere" }
dims = [8, 8, 8]
spacing = 0.125
[medium]
sigma_max = 5
[method]
kind = "emission-absorption"
[stop]
samples = 3
"#;

/// A folder of one test, removed with it.
pub struct Folder(tempfile::TempDir);

/// What a run printed, as text, and its exit code.
pub struct Ran {
    /// The exit code; `None` after a signal.
    pub code: Option<i32>,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl Folder {
    /// A folder that holds `scene.toml`.
    pub fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("a temporary folder"));
        folder.write("scene.toml", SCENE);
        folder
    }

    /// The same in memory where the system has a place for that: syncing to a disk that others use may take seconds.
    pub fn in_memory() -> Self {
        let folder = tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir());
        let folder = Self(folder.expect("a temporary folder"));
        folder.write("scene.toml", SCENE);
        folder
    }

    /// A file in the folder.
    pub fn path(&self, name: impl AsRef<std::path::Path>) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).expect("the temporary folder is writable");
    }

    /// The binary, to be run in the folder on the default device.
    pub fn svetlo<A: AsRef<OsStr>>(&self, arguments: &[A]) -> Command {
        let mut command = Command::new(cargo_bin("svetlo"));
        command.current_dir(self.0.path()).args(arguments).env_remove("SVETLO_DEVICE");
        command
    }

    /// Runs the binary to its end.
    pub fn run<A: AsRef<OsStr>>(&self, arguments: &[A]) -> Ran {
        run(&mut self.svetlo(arguments))
    }

    /// Runs the binary, which must succeed.
    pub fn succeed<A: AsRef<OsStr>>(&self, arguments: &[A]) -> Ran {
        let ran = self.run(arguments);
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        ran
    }

    /// An EXR image of the folder.
    pub fn image(&self, name: &str) -> Picture {
        read_exr(&self.path(name)).expect("a whole image")
    }

    /// The names of all files, hidden ones too, sorted.
    pub fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).expect("the folder exists");
        let mut names: Vec<_> = entries
            .map(|entry| entry.expect("readable").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }
}

/// Runs a command to its end.
pub fn run(command: &mut Command) -> Ran {
    let Output { status, stdout, stderr } = command.output().expect("the binary starts");
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    Ran { code: status.code(), out: text(stdout), err: text(stderr) }
}

/// Sends Ctrl-C.
pub fn interrupt(child: &Child) {
    signal(child, "INT");
}

/// Sends a signal, such as `TERM`.
pub fn signal(child: &Child, name: &str) {
    let status = Command::new("kill").args(["-s", name, &child.id().to_string()]).status();
    assert!(status.expect("kill exists").success());
}

/// A number of samples that no pixel of an unfinished image has yet: it and the rest make one render.
pub fn more_samples(folder: &Folder, name: &str) -> String {
    let image = folder.image(name);
    let counts = image.channel("samples").expect("a plane of counts").to_f32();
    let most = counts.iter().copied().fold(0.0, f32::max);
    (most as u32 + 20).to_string()
}

/// Waits until `done` holds; fails after half a minute.
pub fn wait_until(mut done: impl FnMut() -> bool) -> Duration {
    let begin = Instant::now();
    while !done() {
        assert!(begin.elapsed() < Duration::from_secs(30), "waited in vain");
        std::thread::sleep(Duration::from_millis(2));
    }
    begin.elapsed()
}

impl Ran {
    /// A failure as the contract has it: this exit code, nothing on stdout, one message that holds `needle`, no panic.
    pub fn fails_with(&self, code: i32, needle: &str) {
        assert_eq!(self.code, Some(code), "expected {needle:?} in\n{}", self.err);
        assert!(self.err.contains(needle), "no {needle:?} in\n{}", self.err);
        assert!(!self.err.contains("panicked"), "{}", self.err);
        let errors = self.err.lines().filter(|line| line.starts_with("error")).count();
        assert_eq!(errors, 1, "{}", self.err);
        assert_eq!(self.out, "", "{}", self.err);
    }
}
