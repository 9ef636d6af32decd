//! What happens to disks, folders and terminals while a render runs: it goes on, loses nothing that was written, and
//! says what is wrong in one line.

use crate::support::{Folder, interrupt, signal, wait_until};
use std::fs;
use std::process::{Child, Command, Stdio};

const SAMPLES: &str = "1000000000";

/// An endless render of `out/scene.exr` whose stderr goes to a file.
struct Run {
    folder: Folder,
    child: Child,
}

/// Arguments of the endless render, for the binary itself and for shells.
const ARGUMENTS: [&str; 7] =
    ["render", "scene.toml", "--samples", SAMPLES, "--snapshot", "50ms", "-oout/scene.exr"];

/// A test that fails leaves no endless render behind.
impl Drop for Run {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Run {
    fn start(change: impl FnOnce(&Folder, &mut Command)) -> Self {
        let folder = Folder::in_memory();
        fs::create_dir(folder.path("out")).unwrap();
        fs::create_dir(folder.path("tmp")).unwrap();
        let mut command = folder.svetlo(&ARGUMENTS);
        change(&folder, &mut command);
        command.env("TMPDIR", folder.path("tmp")).stdin(Stdio::null()).stdout(Stdio::null());
        let stderr = fs::File::create(folder.path("stderr")).unwrap();
        let child = command.stderr(stderr).spawn().unwrap();
        let run = Self { folder, child };
        run.wait_for_a_new_image();
        run
    }

    fn said(&self) -> String {
        fs::read_to_string(self.folder.path("stderr")).unwrap()
    }

    fn wait_for_a_new_image(&self) {
        let image = self.folder.path("out/scene.exr");
        let changed = || fs::metadata(&image).and_then(|found| found.modified()).ok();
        let before = changed();
        wait_until(|| changed().is_some() && changed() != before);
    }

    /// Waits until stderr holds `text`, which it may hold once only.
    fn wait_for(&mut self, text: &str) {
        wait_until(|| self.said().contains(text) || self.child.try_wait().unwrap().is_some());
        assert_eq!(self.said().matches(text).count(), 1, "{text}\n{}", self.said());
    }

    /// Ends the render with Ctrl-C, which must give this exit code; what it said.
    fn end(&mut self, code: i32) -> String {
        interrupt(&self.child);
        assert_eq!(self.child.wait().unwrap().code(), Some(code), "{}", self.said());
        let said = self.said();
        assert!(!said.contains("panicked"), "{said}");
        said
    }
}

/// Renders as many samples as an image has and five more, resumed and from the start: the same pixels.
fn continue_and_compare(folder: &Folder, image: &str) {
    let samples: u64 = folder.image(image).metadata["svetlo.samples"].parse().unwrap();
    let total = (samples + 5).to_string();
    let render = |output: &str, more: &[&str]| {
        folder.succeed(
            &[&["render", "scene.toml", "--samples", &total, "--quiet", "-o", output], more].concat(),
        );
        folder.image(output)
    };
    let (resumed, whole) = (render(image, &["--resume"]), render("whole.exr", &[]));
    assert_eq!(resumed.metadata["svetlo.state_hash"], whole.metadata["svetlo.state_hash"]);
}

/// Limits the size of files that the render may write: 2000 bytes hold all that it says, but no image.
fn limit_files(run: &Run, soft: &str) {
    let pid = run.child.id().to_string();
    let done = Command::new("prlimit").args(["--pid", &pid, &format!("--fsize={soft}:unlimited")]).status();
    assert!(done.unwrap().success());
}

fn has(program: &str) -> bool {
    let found = Command::new(program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    found.is_ok_and(|status| status.success())
}

#[test]
fn an_image_that_is_refused_for_a_while_is_written_later() {
    if !has("prlimit") {
        return println!("skipped: there is no prlimit");
    }
    let mut run = Run::start(|_, _| {});
    limit_files(&run, "2000");
    run.wait_for("out/scene.exr: cannot be written (File too large");
    run.wait_for("(the render goes on and tries again)");
    run.folder.image("out/scene.exr");
    limit_files(&run, "unlimited");
    run.wait_for("is written again");
    run.wait_for_a_new_image();
    let said = run.end(130);
    assert_eq!(said.matches("warning: ").count(), 1, "{said}");
    assert!(said.contains("interrupted after "), "{said}");
    continue_and_compare(&run.folder, "out/scene.exr");
}

#[test]
fn an_image_that_is_refused_to_the_end_fails_and_the_last_one_stays() {
    if !has("prlimit") {
        return println!("skipped: there is no prlimit");
    }
    let mut run = Run::start(|_, _| {});
    limit_files(&run, "2000");
    let said = run.end(1);
    let error = said.lines().find(|line| line.starts_with("error: ")).expect("an error");
    assert!(error.contains("out/scene.exr: cannot be written (File too large"), "{error}");
    assert!(error.contains("; nor can it be kept elsewhere: "), "{error}");
    assert_eq!(fs::read_dir(run.folder.path("tmp")).unwrap().count(), 0);
    assert_eq!(fs::read_dir(run.folder.path("out")).unwrap().count(), 2, "no temporary file stays");
    continue_and_compare(&run.folder, "out/scene.exr");
}

#[test]
fn a_folder_that_is_gone_may_come_back() {
    // The render was started in the folder that goes.
    let mut run = Run::start(|folder, command| {
        let scene = folder.path("scene.toml");
        *command = folder.svetlo(&[&["render"], &ARGUMENTS[2..6], &["-oscene.exr"]].concat());
        command.arg(scene).current_dir(folder.path("out"));
    });
    fs::remove_dir_all(run.folder.path("out"))
        .or_else(|_| fs::remove_dir_all(run.folder.path("out")))
        .unwrap();
    run.wait_for("scene.exr: cannot be written (");
    fs::create_dir(run.folder.path("out")).unwrap();
    run.wait_for("is written again");
    run.end(130);
    continue_and_compare(&run.folder, "out/scene.exr");
}

#[test]
fn an_image_whose_folder_is_gone_for_good_is_kept_elsewhere() {
    let mut run = Run::start(|_, _| {});
    fs::rename(run.folder.path("out"), run.folder.path("moved")).unwrap();
    run.wait_for("out/scene.exr: cannot be written (");
    let before = run.folder.image("moved/scene.exr");
    let said = run.end(1);
    let error = said.lines().find(|line| line.starts_with("error: ")).expect("an error");
    let (_, rest) = error.split_once("; the image is kept as ").expect("where the image is");
    let (kept, _) = rest.split_once(": move it there, and --resume goes on from it").expect("what to do");
    fs::rename(kept, run.folder.path("moved/scene.exr")).unwrap();
    let samples =
        |picture: &svetlo::picture::Picture| picture.metadata["svetlo.samples"].parse::<u64>().unwrap();
    assert!(samples(&run.folder.image("moved/scene.exr")) > samples(&before));
    continue_and_compare(&run.folder, "moved/scene.exr");
}

#[test]
fn a_disk_that_is_full_for_a_while_is_waited_for() {
    // A disk of its own, in a namespace of its own, reached through /proc.
    let unshared = ["--user", "--map-root-user", "--mount"];
    let allowed =
        Command::new("unshare").args(unshared).args(["mount", "-t", "tmpfs", "none", "/mnt"]).output();
    if !allowed.is_ok_and(|ran| ran.status.success()) {
        return println!("skipped: no disk can be mounted here");
    }
    let folder = Folder::in_memory();
    fs::create_dir(folder.path("out")).unwrap();
    let program = folder.svetlo(&ARGUMENTS);
    let mut command = Command::new("unshare");
    command.args(unshared).args(["sh", "-c", "mount -t tmpfs -o size=256k none out && exec \"$@\"", "sh"]);
    command.arg(program.get_program()).args(program.get_args()).current_dir(folder.path(""));
    let stderr = fs::File::create(folder.path("stderr")).unwrap();
    fs::create_dir(folder.path("tmp")).unwrap();
    command.env("TMPDIR", folder.path("tmp")).env_remove("SVETLO_DEVICE");
    let child = command.stdout(Stdio::null()).stderr(stderr).spawn().unwrap();
    let disk = format!("/proc/{}/root{}", child.id(), folder.path("out").display());
    let image = format!("{disk}/scene.exr");
    wait_until(|| fs::metadata(&image).is_ok());
    let mut run = Run { folder, child };
    let ballast = format!("{disk}/ballast");
    let filled = fs::write(&ballast, vec![0; 1 << 20]).unwrap_err();
    assert_eq!(filled.kind(), std::io::ErrorKind::StorageFull);
    run.wait_for("cannot be written (No space left on device");
    run.wait_for("free some space or choose another disk (the render goes on and tries again)");
    svetlo::picture::read_exr(image.as_ref()).expect("the last image is whole");
    fs::remove_file(&ballast).unwrap();
    run.wait_for("is written again");
    // Full again, and to the end: there is room elsewhere.
    fs::write(&ballast, vec![0; 1 << 20]).unwrap_err();
    let said = run.end(1);
    assert!(said.contains("; the image is kept as "), "{said}");
    let kept = fs::read_dir(run.folder.path("tmp")).unwrap().next().unwrap().unwrap().file_name();
    continue_and_compare(&run.folder, &format!("tmp/{}/scene.exr", kept.to_string_lossy()));
}

#[test]
fn a_folder_that_becomes_read_only_is_waited_for() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, chown};
    use std::os::unix::process::CommandExt;
    const NOBODY: u32 = 65534;
    let folder = Folder::in_memory();
    // Modes do not bind root, who can be somebody else instead.
    let is_root = fs::metadata(folder.path("scene.toml")).unwrap().uid() == 0;
    let as_nobody = |command: &mut Command, folder: &Folder| {
        if is_root {
            command.uid(NOBODY).gid(NOBODY);
        }
        command.env("SVETLO_CACHE_DIR", folder.path("cache")).env("POCL_CACHE_DIR", folder.path("cache"));
    };
    let mut trial = folder.svetlo(&["--version"]);
    as_nobody(&mut trial, &folder);
    if !trial.output().is_ok_and(|ran| ran.status.success()) {
        return println!("skipped: root runs this, and nobody else may run the program");
    }
    let mut run = Run::start(|folder, command| {
        fs::create_dir(folder.path("cache")).unwrap();
        for name in ["", "out", "tmp", "cache"] {
            let path = folder.path(name);
            if is_root {
                chown(&path, Some(NOBODY), Some(NOBODY)).unwrap();
            }
        }
        as_nobody(command, folder);
    });
    let mode = |mode| fs::set_permissions(run.folder.path("out"), fs::Permissions::from_mode(mode)).unwrap();
    mode(0o555);
    wait_until(|| run.said().contains("make the folder"));
    mode(0o755);
    run.wait_for("is written again");
    run.wait_for("cannot be written (permission denied");
    run.end(130);
}

#[test]
fn termination_and_the_end_of_the_terminal_are_interrupts() {
    for name in ["TERM", "HUP"] {
        let mut run = Run::start(|_, _| {});
        signal(&run.child, name);
        assert_eq!(run.child.wait().unwrap().code(), Some(130), "{name}");
        assert!(run.said().contains("interrupted after "), "{}", run.said());
        continue_and_compare(&run.folder, "out/scene.exr");
    }
}

#[test]
fn the_end_of_a_terminal_that_is_ignored_stays_ignored() {
    let mut run = Run::start(|folder, command| {
        let program = folder.svetlo(&ARGUMENTS);
        *command = Command::new("sh");
        command.args(["-c", "trap '' HUP; exec \"$@\"", "sh"]).arg(program.get_program());
        command.args(program.get_args()).current_dir(folder.path("")).env_remove("SVETLO_DEVICE");
    });
    signal(&run.child, "HUP");
    run.wait_for_a_new_image();
    run.wait_for_a_new_image();
    let said = run.end(130);
    assert!(said.contains("interrupted after "), "{said}");
}

#[test]
fn a_second_render_of_the_same_image_is_noticed_and_no_image_is_mixed() {
    let mut run = Run::start(|_, _| {});
    let mut second =
        run.folder.svetlo(&ARGUMENTS).args(["--seed", "2"]).stderr(Stdio::null()).spawn().unwrap();
    run.wait_for("out/scene.exr since this render last saw it");
    for _ in 0..20 {
        run.folder.image("out/scene.exr");
    }
    interrupt(&second);
    assert_eq!(second.wait().unwrap().code(), Some(130));
    run.end(130);
    assert_eq!(run.folder.image("out/scene.exr").metadata["svetlo.seed"], "1");
    assert_eq!(fs::read_dir(run.folder.path("out")).unwrap().count(), 2);
}

#[test]
fn leftovers_of_killed_renders_are_removed_by_the_next() {
    let folder = Folder::in_memory();
    folder.write(".svetlo-killed.part", "half an image");
    folder.succeed(&["render", "scene.toml", "--quiet"]);
    assert_eq!(folder.names(), ["scene.exr", "scene.png", "scene.toml"]);
}
