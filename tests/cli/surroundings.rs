//! What surrounds a run: no runtime, full disks, closed pipes, folders that cannot be written.

use crate::support::{Folder, Ran, interrupt, run, wait_until};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

#[test]
fn without_a_runtime_the_package_to_install_is_named_at_once() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("vendors")).unwrap();
    let bare = |arguments: &[&str]| {
        let begin = Instant::now();
        let ran = run(folder.svetlo(arguments).env("OCL_ICD_VENDORS", folder.path("vendors")));
        (ran, begin.elapsed())
    };
    let (ran, elapsed) = bare(&["render", "scene.toml"]);
    ran.fails_with(1, "apt-get install pocl-opencl-icd");
    // It takes hundredths of a second; the rest is for a busy machine.
    assert!(elapsed < Duration::from_secs(5), "{elapsed:?}");
    assert_eq!(folder.names(), ["scene.toml", "vendors"]);
    bare(&["devices"]).0.fails_with(1, "pocl-opencl-icd");
    let (checked, _) = bare(&["check", "scene.toml"]);
    assert_eq!(checked.code, Some(0), "a check needs no device: {}", checked.err);
    assert!(checked.out.contains("none found"), "{}", checked.out);
    let (listed, _) = bare(&["devices", "--json"]);
    assert_eq!(listed.code, Some(1));
    assert!(serde_json::from_str::<serde_json::Value>(&listed.out).is_ok());
}

/// Runs through a shell: `set_up` is shell text that ends before the command.
fn in_shell(folder: &Folder, set_up: &str, arguments: &[&str]) -> Ran {
    let svetlo = folder.svetlo(arguments);
    let mut shell = Command::new("sh");
    shell.arg("-c").arg(format!("{set_up} exec \"$0\" \"$@\"")).arg(svetlo.get_program());
    shell.args(arguments).current_dir(folder.path("")).env_remove("SVETLO_DEVICE");
    run(&mut shell)
}

#[test]
fn a_disk_that_takes_no_more_leaves_the_old_image() {
    let folder = Folder::new();
    let arguments =
        ["render", "scene.toml", "--set", "image.width=128", "--set", "image.height=128", "--quiet"];
    // The first run also fills the caches, which the limit would stop too.
    folder.succeed(&arguments);
    let before = std::fs::read(folder.path("scene.exr")).unwrap();
    in_shell(&folder, "ulimit -f 8;", &arguments).fails_with(1, "raise the file size limit (ulimit -f)");
    assert_eq!(std::fs::read(folder.path("scene.exr")).unwrap(), before);
    assert_eq!(folder.names(), ["scene.exr", "scene.png", "scene.toml"]);
}

/// The first view is too large for the limit, the second one, of nothing, is not.
#[test]
fn a_view_that_cannot_be_written_keeps_no_other_from_being_made() {
    let folder = Folder::new();
    let sets = ["image.width=128", "image.height=128", "camera.views=[{}, {target=[0.5, 0.6, -9]}]"];
    let sets = sets.iter().flat_map(|set| ["--set", set]);
    let arguments: Vec<_> =
        ["render", "scene.toml", "-o", "v.exr", "--quiet"].into_iter().chain(sets).collect();
    // The first run also fills the caches, which the limit would stop too.
    folder.succeed(&arguments);
    let before = std::fs::read(folder.path("v.0001.exr")).unwrap();
    std::fs::remove_file(folder.path("v.0002.exr")).unwrap();
    let ran = in_shell(&folder, "ulimit -f 40;", &arguments);
    ran.fails_with(1, "error: 1 of 2 views failed: ");
    assert!(ran.err.contains("v.0001.exr: cannot be written (File too large"), "{}", ran.err);
    assert!(ran.err.contains("(the other views are rendered)"), "{}", ran.err);
    assert_eq!(std::fs::read(folder.path("v.0001.exr")).unwrap(), before);
    folder.image("v.0002.exr");

    let ran = run(folder.svetlo(&arguments).env("SVETLO_FAULT", "launch=1"));
    ran.fails_with(1, "error: 1 of 2 views failed: ");
}

#[test]
fn readers_that_went_away_do_no_harm() {
    let folder = Folder::new();
    for arguments in [&["schema"][..], &["devices"], &["check", "scene.toml"], &["render", "scene.toml"]] {
        let mut child =
            folder.svetlo(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop((child.stdout.take(), child.stderr.take()));
        assert_eq!(child.wait().unwrap().code(), Some(0), "{arguments:?}");
    }
    folder.image("scene.exr");
}

#[test]
#[cfg(target_os = "linux")]
fn output_that_nobody_can_store() {
    let folder = Folder::new();
    let full = || std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let ran = run(folder.svetlo(&["schema"]).stdout(full()));
    ran.fails_with(1, "cannot write to stdout");
    let status = folder.svetlo(&["render", "scene.toml"]).stderr(full()).status().unwrap();
    assert_eq!(status.code(), Some(0), "progress is not worth an image");
    folder.image("scene.exr");
}

#[test]
fn renders_without_a_cache() {
    let folder = Folder::new();
    folder.write("file", "");
    for (variable, value) in [
        ("SVETLO_CACHE_DIR", folder.path("file/cache")),
        ("SVETLO_CACHE_DIR", "".into()),
        ("XDG_CACHE_HOME", folder.path("cache")),
    ] {
        let ran = run(folder.svetlo(&["render", "scene.toml", "--quiet"]).env(variable, &value));
        assert_eq!(ran.code, Some(0), "{variable} = {value:?}: {}", ran.err);
    }
    let ran = run(folder
        .svetlo(&["render", "scene.toml", "--quiet"])
        .env_remove("HOME")
        .env_remove("XDG_CACHE_HOME"));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
}

#[test]
fn what_killed_processes_left_in_the_cache_is_swept() {
    let folder = Folder::new();
    let cache = folder.path("cache");
    std::fs::create_dir(&cache).unwrap();
    std::fs::write(cache.join(".svetlo-dead.part"), "half a program").unwrap();
    std::fs::write(cache.join("notes"), "of the user").unwrap();
    let ran = run(folder.svetlo(&["render", "scene.toml", "--quiet"]).env("SVETLO_CACHE_DIR", &cache));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let names: Vec<_> = std::fs::read_dir(&cache).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    let programs = names.iter().filter(|name| name.to_string_lossy().ends_with(".clbin")).count();
    if programs == 0 {
        return; // This runtime gives no binaries.
    }
    assert_eq!(names.len(), programs + 1, "{names:?}");
    assert!(cache.join("notes").exists());
}

#[test]
fn a_damaged_cache_is_rebuilt() {
    let folder = Folder::new();
    let cache = folder.path("cache");
    let render = || {
        let ran = run(folder
            .svetlo(&["render", "scene.toml", "--quiet", "--json"])
            .env("SVETLO_CACHE_DIR", &cache));
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        serde_json::from_str::<serde_json::Value>(&ran.out).unwrap()["build_cached"].as_bool().unwrap()
    };
    assert!(!render());
    let entries = || std::fs::read_dir(&cache).into_iter().flatten().map(|entry| entry.unwrap().path());
    let Some(entry) = entries().next() else { return }; // This runtime gives no binaries.
    assert!(render());
    let mut bytes = std::fs::read(&entry).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&entry, bytes).unwrap();
    assert!(!render());
}

/// A mapping of the data would end the render by SIGBUS.
#[test]
fn data_that_shrink_during_a_render_do_no_harm() {
    let folder = Folder::in_memory();
    let data = std::fs::File::create(folder.path("data.raw")).unwrap();
    data.set_len(64 << 20).unwrap();
    let sets = "volume={file=\"data.raw\",dims=[512,512,256],type=\"uint8\",window={lo=-1,hi=1}}";
    let render = |output: &'static str, more: &'static [&'static str]| {
        [&["render", "scene.toml", "--quiet", "-o", output, "--set", sets], more].concat()
    };
    let mut child =
        folder.svetlo(&render("a.exr", &["--samples", "1000000", "--snapshot", "20ms"])).spawn().unwrap();
    wait_until(|| folder.path("a.exr").exists());
    data.set_len(0).unwrap();
    let written = || std::fs::metadata(folder.path("a.exr")).unwrap().modified().unwrap();
    let before = written();
    wait_until(|| written() != before);
    interrupt(&child);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    folder.image("a.exr");
    folder.run(&render("b.exr", &[])).fails_with(2, "expected 67108864 bytes of voxels");
}
