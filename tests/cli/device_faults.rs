//! Devices that fail (`SVETLO_FAULT`): one message, the exit code, and what was on disk stays.

use crate::support::{Folder, Ran, run};
use svetlo::device::{Call, Catalog};

/// Renders with faults.
fn render(folder: &Folder, fault: &str) -> Ran {
    run(folder.svetlo(&["render", "scene.toml", "--quiet", "--seed", "2"]).env("SVETLO_FAULT", fault))
}

#[test]
fn a_device_that_fails_ends_the_render_and_no_picture() {
    let folder = Folder::new();
    folder.succeed(&["render", "scene.toml", "--quiet"]);
    let read = |name| std::fs::read(folder.path(name)).unwrap();
    let (image, preview, names) = (read("scene.exr"), read("scene.png"), folder.names());
    let device = Catalog::enumerate().select(None).unwrap().clone();
    let first = Call::ALL.map(|call| format!("{call}=1"));
    let lost = [1, 2, 5, 9, 13, 17].map(|n| format!("lost={n}"));
    for fault in first.iter().chain(&lost) {
        let ran = render(&folder, &format!("{fault}@{}", device.selector));
        ran.fails_with(1, &device.name);
        assert!(ran.err.contains("OpenCL status -"), "{fault}: {}", ran.err);
        assert!(
            read("scene.exr") == image && read("scene.png") == preview,
            "{fault}: the pictures are others"
        );
        assert_eq!(folder.names(), names, "{fault}");
    }
}

#[test]
fn faults_of_other_devices_and_faults_that_never_come_do_nothing() {
    let folder = Folder::new();
    for fault in ["lost=1@97:0", "launch=1000000", ""] {
        assert_eq!(render(&folder, fault).code, Some(0), "{fault}");
    }
}

#[test]
fn a_fault_that_is_none_is_wrong_input() {
    let folder = Folder::new();
    for fault in ["launch", "launch=0", "luanch=1", "lost=1@", "read=1,"] {
        render(&folder, fault).fails_with(2, "is no fault; write CALL=N or CALL=N@SELECTOR");
    }
}
