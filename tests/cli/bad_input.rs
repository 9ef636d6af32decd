//! Scenes and their pictures that are wrong: each gets the documented exit code and one message, and leaves no file.

use crate::support::{Folder, SCENE};

/// Renders and checks the scene with overrides; both must fail in the same way.
fn refused(folder: &Folder, sets: &[&str], needle: &str) {
    let before = folder.names();
    for command in ["render", "check"] {
        let sets = sets.iter().flat_map(|set| ["--set", set]);
        let arguments: Vec<&str> = [command, "scene.toml"].into_iter().chain(sets).collect();
        folder.run(&arguments).fails_with(2, needle);
    }
    assert_eq!(folder.names(), before);
}

#[test]
fn unknown_keys_and_wrong_types_are_shown_with_file_and_line() {
    let folder = Folder::new();
    folder.write("scene.toml", SCENE.replace("spacing = 0.125", "spacin = 0.125"));
    refused(&folder, &[], "scene.toml:11:1");
    refused(&folder, &[], "`spacing`");
    folder.write("scene.toml", SCENE.replace("width = 24", "width = \"24\""));
    refused(&folder, &[], "scene.toml:3:9");
    folder.write("scene.toml", SCENE.replace("[medium]", "[medium"));
    refused(&folder, &[], "scene.toml:12:");
}

#[test]
fn all_problems_are_reported_at_once() {
    let folder = Folder::new();
    folder.write(
        "scene.toml",
        SCENE.replace("width = 24", "width = 0").replace("sigma_max = 5", "sigma_max = -5"),
    );
    let ran = folder.run(&["check", "scene.toml"]);
    assert_eq!(ran.code, Some(2));
    assert!(ran.err.contains("scene.toml:3:9") && ran.err.contains("scene.toml:13:13"), "{}", ran.err);
    assert!(ran.err.ends_with("2 problems in scene.toml\n"), "{}", ran.err);
}

#[test]
fn views_beyond_float32_are_refused() {
    let folder = Folder::new();
    for sets in [&["camera.aperture=1e300"][..], &["camera.aperture=0.1", "camera.focus=1e-40"]] {
        refused(&folder, sets, "the lens is too large for its focus");
    }
    for set in ["volume.spacing=1e-300", "volume.spacing=[1e-30, 1, 1e30]"] {
        refused(&folder, &[set], "the view is too large for the voxels");
    }
}

#[test]
fn an_empty_scene_says_what_is_needed() {
    let folder = Folder::new();
    folder.write("scene.toml", "");
    let ran = folder.run(&["render", "scene.toml"]);
    assert_eq!(ran.code, Some(2));
    for key in ["`camera`", "`method`"] {
        assert!(ran.err.contains(key), "{}", ran.err);
    }
}

#[test]
fn scenes_that_are_no_text_files() {
    let folder = Folder::new();
    folder.write("binary.toml", [b'#', 0xff, 0xfe]);
    for (scene, needle) in [
        ("none.toml", "there is no such file"),
        (".", "it is a directory"),
        ("binary.toml", "not UTF-8"),
        ("-", "not from standard input"),
    ] {
        folder.run(&["render", scene]).fails_with(2, needle);
        folder.run(&["check", scene]).fails_with(2, needle);
    }
}

#[test]
fn values_out_of_range() {
    let folder = Folder::new();
    for (sets, needle) in [
        (&["image.width=0"][..], "at least 1 and at most 65536"),
        (&["image.width=1000000"], "at least 1 and at most 65536"),
        (&["image.width=65536", "image.height=65536"], "at most 268435456"),
        (&["volume.window={ lo = 1, hi = 1 }"], "`hi` must be more than `lo`"),
        (&["volume.window={ lo = 2, hi = 1 }"], "`hi` must be more than `lo`"),
        (&["volume.window={ centre = 1, width = 0 }"], "more than 0"),
        (&["volume.dims=[0, 8, 8]"], "at least 1"),
        (&["volume.dims=[4096, 4096, 4096]"], "at most 4294967296 voxels"),
        (&["volume.dims=[8, 8]"], "volume.dims"),
        (&["camera.target=[0.5, 0.5, -2]"], "camera"),
        (&["camera.up=[0, 0, 1]"], "parallel"),
        (&["method.step=0.5"], "step"),
        (&["stop.samples=0"], "at least 1"),
        (&["stop.time=0s"], "longer than zero"),
        (&["stop.error=0%"], "more than 0"),
        (&["method.kind=ray-tracing"], "isosurface"),
    ] {
        refused(&folder, sets, needle);
    }
}

#[test]
fn a_volume_beyond_the_device_is_refused_before_it_is_sampled() {
    let folder = Folder::new();
    let listed = folder.succeed(&["devices", "--json"]).out;
    let devices: serde_json::Value = serde_json::from_str(&listed).unwrap();
    let limits = devices["devices"].as_array().unwrap().iter().map(|d| d["max_allocation"].as_u64().unwrap());
    if limits.max().unwrap() >= 16 << 30 {
        return; // A device that takes the largest field there is.
    }
    // 16 GiB of float32: sampling them takes minutes.
    let large = ["scene.toml", "--set", "volume.dims=[2048, 2048, 1024]"];
    for command in ["render", "check"] {
        let begin = std::time::Instant::now();
        let ran = folder.run(&[&[command], &large[..]].concat());
        ran.fails_with(1, "the voxels would take 16.0 GiB, but the device's ");
        assert!(begin.elapsed().as_secs() < 10, "{:?}", begin.elapsed());
    }
    assert_eq!(folder.names(), ["scene.toml"]);
}

#[test]
fn an_image_beyond_the_device_is_refused_with_both_numbers() {
    let folder = Folder::new();
    let listed = folder.succeed(&["devices", "--json"]).out;
    let devices: serde_json::Value = serde_json::from_str(&listed).unwrap();
    if devices["devices"][0]["max_allocation"].as_u64().unwrap() >= 24 << 30 {
        return; // A device that takes the largest image there is.
    }
    let ran =
        folder.run(&["render", "scene.toml", "--set", "image.width=16384", "--set", "image.height=16384"]);
    ran.fails_with(1, "the film would take ");
    assert!(ran.err.contains("but the device's "), "{}", ran.err);
    assert_eq!(folder.names(), ["scene.toml"]);
}

#[test]
fn environment_maps_that_cannot_be_read() {
    let folder = Folder::new();
    folder.succeed(&["render", "scene.toml", "-o", "good.exr", "--quiet"]);
    let good = std::fs::read(folder.path("good.exr")).unwrap();
    folder.write("text.exr", "no image at all");
    folder.write("cut.exr", &good[..good.len() / 2]);
    folder.write("huge.exr", enlarged(good));
    std::fs::create_dir(folder.path("folder.exr")).unwrap();
    for (map, needle) in [
        ("none.exr", "there is no file \"none.exr\""),
        ("folder.exr", "is a directory"),
        ("text.exr", "text.exr: not an EXR file"),
        ("cut.exr", "cut.exr: "),
        ("huge.exr", "claims 100001×100001 pixels"),
    ] {
        refused(&folder, &[&format!("background.environment={map}")], needle);
    }
}

/// The EXR file with a header that claims 100001 × 100001 pixels.
fn enlarged(mut exr: Vec<u8>) -> Vec<u8> {
    // Values stand behind name, type and a size of 4 bytes.
    let mut patch = |attribute: &[u8], offset: usize, value: i32| {
        let at =
            exr.windows(attribute.len()).position(|bytes| bytes == attribute).expect("a written attribute");
        let at = at + attribute.len() + 4 + offset;
        exr[at..at + 4].copy_from_slice(&value.to_le_bytes());
    };
    patch(b"dataWindow\0box2i\0", 8, 100_000);
    patch(b"dataWindow\0box2i\0", 12, 100_000);
    patch(b"chunkCount\0int\0", 0, 100_001_i32.div_euclid(16) + 1);
    exr
}

#[test]
fn tables_of_transfer_functions_that_cannot_be_read() {
    let folder = Folder::new();
    folder.write("text.png", "no picture at all");
    folder.write("table.jpg", "");
    for (table, needle) in [
        ("none.png", "there is no file \"none.png\""),
        ("text.png", "text.png"),
        ("table.jpg", "must end in .png or .exr"),
    ] {
        refused(&folder, &["transfer.kind=2d", &format!("transfer.table={table}")], needle);
    }
}
