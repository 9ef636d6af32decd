//! Programs: every variant builds, errors are readable, the binary cache cannot hurt.

mod common;

use std::path::Path;
use svetlo::device::{Buffer, Device, Program, ProgramSpec};
use svetlo::render::variants::{FAMILIES, is_listed};

#[test]
fn variants_build_with_every_pair_of_features() {
    let device = common::device();
    for family in &FAMILIES {
        let specs = family.covering_variants();
        println!("{}: {} builds", family.entry, specs.len());
        for spec in specs {
            let program = Program::build(&device, &spec).unwrap();
            program.kernel(&device, family.kernel).unwrap();
        }
    }
}

#[test]
fn the_programs_of_scenes_stand_in_the_table() {
    let methods = [
        "kind = \"mip\"",
        "kind = \"isosurface\"\nvalue = 0.5",
        "kind = \"emission-absorption\"",
        "kind = \"emission-absorption\"\nradiance = 0",
        "kind = \"emission-absorption\"\nquadrature = \"step\"\njitter = false",
        "kind = \"emission-absorption\"\nquadrature = \"step\"",
        "kind = \"emission-absorption\"\nquadrature = \"step\"\ncompositing = \"linear\"\nradiance = 0",
        "kind = \"hybrid-diffusion\"",
        "kind = \"hybrid-diffusion\"\n[phase]\nkind = \"rayleigh\"",
    ];
    let transfers = [
        "",
        "[transfer]\nkind = \"2d\"\nshapes = [{ shape = \"ellipse\", centre = [0.5, 0.5], size = [1, 1] }]",
    ];
    let cameras = ["fov = 20", "aperture = 0.1"];
    let backgrounds = ["", "[background]\nenvironment = \"configs/data/studio_512x256.exr\""];
    for method in methods {
        for transfer in transfers {
            for (camera, background) in cameras.into_iter().zip(backgrounds) {
                let case = common::Case::new(
                    &format!(
                        "[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\n{camera}\n[volume]\n{transfer}\n\
                         {background}\n[medium]\nsigma_max = 1\n[method]\n{method}\n"
                    ),
                    common::noisy([2, 2, 2], 1),
                );
                let spec = case.plan().spec;
                assert!(is_listed(&spec), "cl/{} {}", spec.entry, spec.options());
            }
        }
    }
    assert!(!is_listed(&ProgramSpec::new("render/mip.cl").define("VOXEL", "double")));
}

/// The programs of scattering scenes, as a CPU with vectors and as any other device builds them.
#[test]
fn the_programs_of_scattering_scenes_stand_in_the_table() {
    let methods = [
        "kind = \"single-scattering\"",
        "kind = \"multiple-scattering\"\nmax_order = 3",
        "kind = \"multiple-scattering\"\ntransmittance = \"analog\"\nmajorant_scale = 2",
        "kind = \"multiple-scattering\"\ntransmittance = \"residual-ratio\"",
        "kind = \"single-scattering\"\ntransmittance = \"ray-marching\"",
    ];
    let ramp = "points = [{ value = 0, opacity = 0 }, { value = 1, opacity = 1 }]";
    let flat = "points = [{ value = 0, opacity = 1, color = [0.9, 0.5, 0.1] }]";
    let glow = "points = [{ value = 0, opacity = 0 }, { value = 0.5, opacity = 0.2, color = 0.5, emission = 1 }, \
                { value = 1, opacity = 1 }]";
    let shapes = "kind = \"2d\"\nshapes = [{ shape = \"ellipse\", centre = [0.5, 0.5], size = [1, 1] }]";
    let phases = [
        "",
        "[phase]\nkind = \"henyey-greenstein\"\ng = 0.5\n",
        "[phase]\nkind = \"rayleigh\"\n",
        "[phase]\nkind = \"two-lobe\"\ng = [0.5, -0.2]\nweight = 0.5\n",
    ];
    let lights = [
        "",
        "[[light]]\nkind = \"point\"\nposition = [0.5, 0.5, 0.5]\nintensity = 3\n",
        "[[light]]\nkind = \"rectangle\"\ncentre = [0, 5, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 0, 1]\n\
         radiance = [1, 2, 3]\n[film]\nauxiliary = true\n",
    ];
    let backgrounds = [
        "[background]\ncolor = 1\n",
        "[background]\ncolor = [1, 0.5, 0]\n",
        "[background]\nenvironment = \"configs/data/studio_512x256.exr\"\nsampling = \"importance\"\n",
    ];
    let media = ["", "extinction_color = [1, 0.5, 0.2]\n"];
    let mut seen = std::collections::BTreeSet::new();
    for (i, method) in methods.iter().enumerate() {
        for transfer in [ramp, flat, glow, shapes] {
            for (j, background) in backgrounds.iter().enumerate() {
                for (k, medium) in media.iter().enumerate() {
                    let (phase, light) = (phases[(i + j + k) % 4], lights[(i + 2 * j + k) % 3]);
                    let case = common::Case::new(
                        &format!(
                            "[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\n[volume]\n{phase}{light}\
                             {background}[transfer]\n{transfer}\n[medium]\nsigma_max = 1\n{medium}\
                             [method]\n{method}\n"
                        ),
                        common::noisy([2, 2, 2], 1),
                    );
                    let spec = case.plan().spec;
                    for spec in
                        [spec.clone().define("WIDTH", 1), spec.define("WIDTH", 8).define("PIXELS", 64)]
                    {
                        assert!(is_listed(&spec), "cl/{} {}", spec.entry, spec.options());
                        seen.extend(spec.defines);
                    }
                }
            }
        }
    }
    // The scenes reach every feature of the kernel but those of the camera.
    let wanted = FAMILIES[3].covering_variants().into_iter().flat_map(|spec| spec.defines);
    let missing: Vec<_> = wanted
        .filter(|(name, _)| !["WIDTH", "VOXEL", "THIN_LENS"].contains(name))
        .filter(|define| !seen.contains(define))
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[test]
fn a_build_failure_names_device_options_file_and_line() {
    let device = common::device();
    let spec = ProgramSpec::new("volume/sampling.cl").define("VOXEL", "no_such_type");
    let error = Program::build(&device, &spec).err().expect("must not build").to_string();
    let line = include_str!("../cl/volume/sampling.cl")
        .lines()
        .position(|line| line.contains("const VOXEL"))
        .unwrap();
    for part in [
        device.info().name.as_str(),
        "the kernels do not build",
        "-D VOXEL=no_such_type",
        &format!("cl/volume/sampling.cl:{}", line + 1),
        "no_such_type",
    ] {
        assert!(error.contains(part), "{part} is missing in: {error}");
    }
}

#[test]
fn a_missing_kernel_or_argument_is_an_error() {
    let device = common::device();
    let source = "__kernel void one(__global uint *out) { out[get_global_id(0)] = 1u; }";
    let program = Program::build_source(&device, source, "").unwrap();
    assert!(program.kernel(&device, "two").err().unwrap().to_string().contains("no kernel 'two'"));
    let error = program.kernel(&device, "one").unwrap().run(&device, &[], 1).unwrap_err().to_string();
    assert!(error.contains("takes 1 arguments, 0 were given"), "{error}");
}

/// What a tiny program computes, and whether it came from the cache.
fn answer(device: &Device) -> (u32, bool) {
    let source = "__kernel void answer(__global uint *out) { if (get_global_id(0) == 0) out[0] = 42u; }";
    let program = Program::build_source(device, source, "").unwrap();
    let buffer = Buffer::<u32>::zeroed(device, 1).unwrap();
    program.kernel(device, "answer").unwrap().run(device, &[(&buffer).into()], 1).unwrap();
    (buffer.read(device).unwrap()[0], program.cached)
}

/// Run by [`a_damaged_cache_is_rebuilt`] in a process of its own, with a cache folder of its own.
fn damage_the_cache(folder: &Path) {
    let device = common::device();
    assert_eq!(answer(&device), (42, false));
    let entry = std::fs::read_dir(folder).unwrap().next().unwrap().unwrap().path();
    assert_eq!(answer(&device), (42, true));
    let whole = std::fs::read(&entry).unwrap();
    let mut garbled = whole.clone();
    let middle = garbled.len() / 2;
    garbled[middle] ^= 0x10;
    let halves = [&whole[..middle], &whole[..16], &[]].map(<[u8]>::to_vec);
    for damaged in halves.into_iter().chain([garbled]) {
        std::fs::write(&entry, damaged).unwrap();
        assert_eq!(answer(&device), (42, false), "rebuilt");
        assert_eq!(answer(&device), (42, true), "and stored again");
    }
    std::fs::remove_file(&entry).unwrap();
    std::fs::create_dir(&entry).unwrap();
    assert_eq!(answer(&device), (42, false), "a folder in the place of an entry");
}

/// As [`damage_the_cache`], with an entry that is whole by its checksum but no program of this driver.
fn replace_a_program_by_nonsense(folder: &Path) {
    let device = common::device();
    assert_eq!(answer(&device), (42, false));
    let entry = std::fs::read_dir(folder).unwrap().next().unwrap().unwrap().path();
    let nonsense = [0x5a_u8; 100];
    let sum = <sha2::Sha256 as sha2::Digest>::digest(nonsense);
    std::fs::write(&entry, [sum.as_slice(), &nonsense].concat()).unwrap();
    assert_eq!(answer(&device), (42, false));
}

/// Runs a test of this file in a process of its own with an empty cache folder; `work` is what it does there.
fn with_own_cache(test: &str, work: fn(&Path)) -> Option<bool> {
    const MARK: &str = "SVETLO_TEST_OWN_CACHE";
    if std::env::var_os(MARK).is_some() {
        work(Path::new(&std::env::var("SVETLO_CACHE_DIR").unwrap()));
        return None;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut child = std::process::Command::new(std::env::current_exe().unwrap());
    child.args(["--exact", test, "--nocapture"]).env(MARK, "1").env("SVETLO_CACHE_DIR", folder.path());
    Some(child.status().unwrap().success())
}

#[test]
fn a_damaged_cache_is_rebuilt() {
    let passed = with_own_cache("a_damaged_cache_is_rebuilt", damage_the_cache);
    assert_ne!(passed, Some(false));
}

/// Drivers that end the process when they are given a binary that is not theirs: platform name, and why.
const CANNOT_REFUSE_BINARIES: [(&str, &str); 1] =
    [("rusticl", "Mesa 22.3 asserts the binary's version inside clCreateProgramWithBinary")];

#[test]
fn a_binary_that_the_driver_does_not_know_is_rebuilt() {
    let Some(passed) =
        with_own_cache("a_binary_that_the_driver_does_not_know_is_rebuilt", replace_a_program_by_nonsense)
    else {
        return;
    };
    let platform = common::device().info().platform.clone();
    let excused = CANNOT_REFUSE_BINARIES.iter().find(|(name, _)| *name == platform);
    assert_eq!(passed, excused.is_none(), "{platform}: {excused:?}");
}
