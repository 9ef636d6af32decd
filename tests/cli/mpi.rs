//! Several processes that `mpirun` starts: the same bits as one, one message, the right exit code, and no hang.

use crate::support::{Folder, Ran, SCENE, more_samples, run, wait_until};
use std::process::Command;
use svetlo::picture::Picture;

/// Whether there is something to test; says so where there is not.
fn is_there() -> bool {
    if !cfg!(feature = "mpi") {
        println!("skipped: built without the feature `mpi`");
        return false;
    }
    let found = Command::new("mpirun").arg("--version").output().is_ok_and(|ran| ran.status.success());
    if !found {
        println!("skipped: there is no mpirun");
    }
    found
}

/// `mpirun -n RANKS svetlo ARGUMENTS`; `preface`: what a shell does in each process before.
fn mpirun(folder: &Folder, ranks: u32, preface: &str, arguments: &[&str]) -> Command {
    let program = folder.svetlo(arguments);
    let mut command = Command::new("mpirun");
    command.args(["--oversubscribe", "-n", &ranks.to_string()]);
    command.args(["sh", "-c", &format!("{preface}\nexec \"$@\""), "sh"]).arg(program.get_program());
    command.args(program.get_args()).current_dir(folder.path("")).env_remove("SVETLO_DEVICE");
    // Tests may be run by root in a container.
    command.env("OMPI_ALLOW_RUN_AS_ROOT", "1").env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
    command
}

fn succeed(folder: &Folder, ranks: u32, preface: &str, arguments: &[&str]) -> Ran {
    let ran = run(&mut mpirun(folder, ranks, preface, arguments));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    ran
}

/// Says what one rank does in a shell.
fn on_rank(rank: u32, what: &str) -> String {
    format!("if [ \"$OMPI_COMM_WORLD_RANK\" = {rank} ]; then {what}\nfi")
}

/// All planes: pixels and what is kept of the film; and what the header says of the same scene by the same device.
fn assert_same(found: &Picture, expected: &Picture, what: &str) {
    assert_eq!(found.channels.len(), expected.channels.len(), "{what}");
    let pairs = found.channels.iter().zip(&expected.channels);
    let differing: Vec<&str> = pairs.filter(|(a, b)| a != b).map(|(a, _)| a.name.as_str()).collect();
    assert!(differing.is_empty(), "{what}: {differing:?} differ");
    for key in ["samples", "device", "lookups", "paths", "photons", "state_hash", "light_hash", "part"] {
        let key = format!("svetlo.{key}");
        assert_eq!(found.metadata.get(&key), expected.metadata.get(&key), "{what}: {key}");
    }
}

const SCATTERING: &[&str] = &[
    "--set",
    "method={ kind = \"multiple-scattering\", max_order = 4 }",
    "--set",
    "medium.albedo=0.9",
    "--set",
    "light=[{ kind = \"directional\", direction = [1, -2, 1], irradiance = [3, 2, 1] }]",
];
const HYBRID: &[&str] = &[
    "--set",
    "method={ kind = \"hybrid-diffusion\", iterations = 3 }",
    "--set",
    "medium.albedo=0.9",
    "--set",
    "light=[{ kind = \"directional\", direction = [1, -2, 1], irradiance = [3, 2, 1] }]",
];
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

#[test]
fn any_number_of_ranks_makes_the_picture_of_one_process() {
    if !is_there() {
        return;
    }
    let renders =
        [(SCENE, &[][..], "800"), (SCENE, SCATTERING, "800"), (SCENE, HYBRID, "800"), (CAUSTICS, &[], "12")];
    for (scene, sets, samples) in renders {
        let folder = Folder::in_memory();
        folder.write("scene.toml", scene);
        let arguments =
            |output| [&["render", "scene.toml", "--samples", samples, "--json", "-o", output], sets].concat();
        folder.succeed(&arguments("alone.exr"));
        let alone = folder.image("alone.exr");
        for ranks in [1, 2, 4] {
            let ran = succeed(&folder, ranks, "", &arguments("ranks.exr"));
            assert_same(&folder.image("ranks.exr"), &alone, &format!("{sets:?}, {ranks} ranks"));
            let summary: serde_json::Value = serde_json::from_str(&ran.out).expect("one document");
            if ranks == 1 {
                assert!(summary["mpi"].is_null());
                continue;
            }
            assert_eq!(summary["mpi"]["ranks"], ranks);
            let devices = summary["devices"].as_array().unwrap();
            assert_eq!(devices.len(), ranks as usize);
            assert_eq!(
                devices[ranks as usize - 1]["selector"],
                format!("rank {}, {}", ranks - 1, devices[0]["selector"].as_str().unwrap())
            );
        }
        assert_eq!(folder.names(), ["alone.exr", "alone.png", "ranks.exr", "ranks.png", "scene.toml"]);
    }
}

#[test]
fn parts_views_and_light_files_are_those_of_one_process() {
    if !is_there() {
        return;
    }
    let folder = Folder::in_memory();
    let views = "camera.views=[{}, { position = [3, 0.5, 0.5] }]";
    let arguments = |more: &[&'static str]| {
        let first = ["render", "scene.toml", "--quiet", "--samples", "300", "--part", "2/3", "--set", views];
        [&first[..], HYBRID, more].concat()
    };
    folder.succeed(&arguments(&["-o", "a.exr", "--save-light", "a.nrrd"]));
    succeed(&folder, 2, "", &arguments(&["-o", "b.exr", "--save-light", "b.nrrd"]));
    succeed(&folder, 2, "", &arguments(&["-o", "c.exr", "--load-light", "a.nrrd"]));
    folder.succeed(&arguments(&["-o", "d.exr", "--load-light", "a.nrrd"]));
    for [output, expected] in [["b", "a"], ["c", "d"]] {
        for view in ["0001", "0002"] {
            let image = |name: &str| folder.image(&format!("{name}.{view}.exr"));
            assert_same(&image(output), &image(expected), output);
        }
    }
    let light = |name| std::fs::read(folder.path(name)).unwrap();
    assert!(light("a.nrrd") == light("b.nrrd"));
}

/// Takes seconds, so that something can happen meanwhile.
const LONG: &[&str] = &[
    "render",
    "scene.toml",
    "-o",
    "out.exr",
    "--set",
    "image.width=96",
    "--set",
    "image.height=64",
    "--snapshot",
    "50ms",
];

#[test]
fn a_device_that_is_lost_on_a_rank_is_left_out() {
    if !is_there() {
        return;
    }
    let folder = Folder::in_memory();
    let arguments = [LONG, SCATTERING, &["--samples", "200"]].concat();
    let lost =
        [on_rank(1, "export SVETLO_FAULT=lost=40"), on_rank(2, "export SVETLO_FAULT=open=1")].join("\n");
    let ran = succeed(&folder, 3, &lost, &arguments);
    let found = folder.image("out.exr");
    let note = ran.err.lines().find(|line| line.contains("is left out from now on: ")).expect("a note");
    assert!(note.starts_with("note: ") && note.contains("(rank 1, "), "{note}");
    assert!(ran.err.contains("note: rank 2 (") && ran.err.contains("): left out: "), "{}", ran.err);
    folder.succeed(&arguments);
    assert_same(&found, &folder.image("out.exr"), "with one device of three");
}

#[test]
fn ranks_that_are_killed_or_told_to_end_leave_an_image_to_go_on_with() {
    if !is_there() {
        return;
    }
    let folder = Folder::in_memory();
    let shared = [LONG, SCATTERING, &["--quiet", "--samples"]].concat();
    for (victim, signal, code) in [("rank", "KILL", 137), ("mpirun", "TERM", 1)] {
        // Nobody comes to the end of it.
        let endless = [&shared[..], &["10000000"]].concat();
        let mut command = mpirun(&folder, 3, &on_rank(1, "echo $$ > rank"), &endless);
        let child = command.stderr(std::process::Stdio::piped()).spawn().unwrap();
        std::fs::write(folder.path("mpirun"), child.id().to_string()).unwrap();
        wait_until(|| folder.path("out.exr").exists());
        let id = std::fs::read_to_string(folder.path(victim)).unwrap();
        assert!(Command::new("kill").args(["-s", signal, id.trim()]).status().unwrap().success());
        let ended = child.wait_with_output().unwrap();
        assert_eq!(ended.status.code(), Some(code), "{}", String::from_utf8_lossy(&ended.stderr));
        let samples = more_samples(&folder, "out.exr");
        let further = [&shared[..], &[&samples]].concat();
        succeed(&folder, 2, "", &[&further[..], &["--resume"]].concat());
        let resumed = folder.image("out.exr");
        folder.succeed(&further);
        assert_same(&resumed, &folder.image("out.exr"), &format!("after {signal}"));
        std::fs::remove_file(folder.path("out.exr")).unwrap();
    }
}

#[test]
fn a_rank_that_stands_still_holds_nobody_up_for_ever() {
    if !is_there() {
        return;
    }
    let folder = Folder::in_memory();
    let shared = [LONG, SCATTERING, &["--quiet"]].concat();
    // It stops itself as soon as there is an image.
    let stop = "{ while [ ! -e out.exr ]; do sleep 0.02; done; kill -s STOP $$; } &\n";
    let ran = succeed(&folder, 3, &on_rank(2, stop), &[&shared[..], &["--time", "1s"]].concat());
    // And of others, if it stopped in the middle of a letter.
    let warned = ran.err.contains("warning: no answer from ") && ran.err.contains("rank 2 (");
    assert!(warned, "{}", ran.err);
    let samples = more_samples(&folder, "out.exr");
    let further = [&shared[..], &["--samples", &samples]].concat();
    folder.succeed(&[&further[..], &["--resume"]].concat());
    let resumed = folder.image("out.exr");
    folder.succeed(&further);
    assert_same(&resumed, &folder.image("out.exr"), "without rank 2");
}

#[test]
fn what_is_wrong_is_said_once_and_is_the_exit_code() {
    if !is_there() {
        return;
    }
    let folder = Folder::in_memory();
    let fails = |preface: &str, arguments: &[&str], needle: &str| {
        let ran = run(&mut mpirun(&folder, 3, preface, arguments));
        ran.fails_with(2, needle);
    };
    fails("", &["render", "scene.toml", "--frob"], "unexpected argument '--frob'");
    fails("", &["render", "none.toml"], "none.toml");
    fails("", &["render", "scene.toml", "-o", "nowhere/out.exr"], "create the folder nowhere first");
    fails("", &["render", "scene.toml", "--device", "abacus"], "no OpenCL device matches 'abacus'");
    fails(
        "",
        &["merge", "a.exr", "b.exr", "-o", "c.exr"],
        "svetlo merge was started as 3 processes: only svetlo render shares",
    );
    for rank in [0, 2] {
        let other = on_rank(rank, "set -- \"$@\" --frob");
        fails(&other, &["render", "scene.toml"], "unexpected argument '--frob'");
    }
    let other = on_rank(2, "set -- \"$@\" --seed 5");
    fails(&other, &["render", "scene.toml"], "rank 2 (");
    // Nobody has begun anything.
    assert_eq!(folder.names(), ["scene.toml"]);
    let gone = on_rank(1, "cd /");
    fails(&gone, &["render", "scene.toml"], "): cannot read the scene scene.toml");
}

/// Without MPI, all processes would write the same image.
#[test]
fn processes_that_cannot_work_together_refuse() {
    if cfg!(feature = "mpi") {
        return println!("skipped: built with the feature `mpi`");
    }
    let folder = Folder::in_memory();
    let launched = |size: &str, arguments: &[&str]| {
        run(folder.svetlo(arguments).env("OMPI_COMM_WORLD_SIZE", size).env("OMPI_COMM_WORLD_RANK", "0"))
    };
    let what = "svetlo render was started as 2 processes: this svetlo was built without MPI";
    launched("2", &["render", "scene.toml"]).fails_with(2, what);
    launched("2", &["merge", "a.exr", "-o", "b.exr"])
        .fails_with(2, "svetlo merge was started as 2 processes");
    assert_eq!(folder.names(), ["scene.toml"]);
    assert_eq!(launched("1", &["render", "scene.toml"]).code, Some(0));
    let mut apart = folder.svetlo(&["render", "scene.toml"]);
    let apart = run(apart.env("OMPI_COMM_WORLD_SIZE", "2").env("SVETLO_MPI", "off"));
    assert_eq!(apart.code, Some(0), "{}", apart.err);
}
