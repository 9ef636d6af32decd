//! The self-test passes on this device, and finds what is broken.

use svetlo::device::{Catalog, DeviceInfo, ProgramSpec};
use svetlo::selftest::{CHECKS, Check, Status, Verdict, passed, run, run_altered};

fn device() -> DeviceInfo {
    let selector = std::env::var("SVETLO_DEVICE").ok();
    Catalog::enumerate().select(selector.as_deref()).unwrap().clone()
}

#[test]
fn every_check_passes_here() {
    let mut seen = Vec::new();
    let verdicts = run(&device(), &mut |verdict| seen.push(verdict.clone())).unwrap();
    assert_eq!(seen, verdicts);
    let failed: Vec<&Verdict> = verdicts.iter().filter(|verdict| verdict.status == Status::Failed).collect();
    assert!(passed(&verdicts), "{failed:#?}");
    for check in CHECKS {
        assert!(verdicts.iter().any(|verdict| verdict.check == check.name), "{}", check.name);
    }
    // The grid's slab is looked up, not solved.
    let grid = verdicts.iter().find(|verdict| verdict.check == "grid").unwrap();
    assert!(!grid.quantity.contains(" 0.0 null collisions"), "{grid:?}");
    for verdict in &verdicts {
        println!("{:<20} {:.3} s", verdict.check, verdict.seconds);
    }
}

/// The check of this name alone.
fn only(name: &str) -> [&'static Check; 1] {
    [CHECKS.iter().find(|check| check.name == name).expect("a check")]
}

/// What is done to a program before it is built.
type Alter = fn(ProgramSpec) -> ProgramSpec;

/// Kernels that go wrong as devices do: the check that finds it, and what stands in the kernels instead of what.
const FAULTS: [(&str, Alter); 24] = [
    // One round too few; an odd constant; the wrong logarithm.
    ("random", |spec| match spec.entry {
        "common/exponential.cl" => spec,
        _ => spec.patch("round < PHILOX_ROUNDS", "round + 1 < PHILOX_ROUNDS"),
    }),
    ("random", |spec| match spec.entry {
        "common/exponential.cl" => spec.patch("k * M_LN2_F", "k * 0.6931f"),
        _ => spec,
    }),
    // Sums in plain float32.
    ("film", |spec| spec.patch("(*high - (sum - part)) + (y - part)", "(float4)(0.0f)")),
    ("emission-absorption", |spec| spec.patch("exp(-tau)", "exp2(-tau)")),
    // Half a voxel to the side.
    ("emission-absorption", |spec| spec.patch("p.a = y0.x", "p.a = 0.5f * (y0.x + y0.y)")),
    ("mip", |spec| spec.patch("copysign(sqrt(discriminant), p.c)", "sqrt(discriminant)")),
    ("isosurface", |spec| spec.patch("#define ROOT_STEPS 24", "#define ROOT_STEPS 1")),
    ("furnace", |spec| spec.patch("throughput * (1.0f - albedo[c])", "throughput * (1.001f - albedo[c])")),
    ("slab", |spec| spec.patch("exp(-tau)", "exp2(-tau)")),
    // Rays that forget what they passed, collisions that are too rare, a number used for two things.
    ("grid", |spec| spec.patch("PICK(f->depth, f->depth - depth, on)", "f->depth")),
    ("tracking", |spec| spec.patch("&row) / f->majorant", "&row) / (1.02f * f->majorant)")),
    ("tracking", |spec| spec.patch("uniform_lanes(random[1])", "uniform_lanes(random[0])")),
    ("sunlight", |spec| spec.patch("path->pending[c] * through_of(f, c)", "path->pending[c]")),
    ("audit", |spec| spec.patch("Reals rate = bound * f->scale;", "Reals rate = 0.9f * bound * f->scale;")),
    // Collisions that are too rare on the way to a light; the arithmetic mean between two cells.
    ("direct-light", |spec| match spec.entry {
        "irradiance/direct.cl" => {
            spec.patch("(sigma - f->minorant) * inverse;", "0.9f * (sigma - f->minorant) * inverse;")
        }
        _ => spec,
    }),
    // Cells that nobody works on; light that comes from the cell itself.
    ("convection", |spec| match spec.entry {
        "irradiance/convection.cl" => spec.patch("z - grid->dims.z) >= 0", "z - grid->dims.z) >= -1"),
        _ => spec,
    }),
    ("diffusion", |spec| spec.patch("2.0f * a * b / (a + b)", "0.5f * (a + b)")),
    // Numbers that stay behind when keys move; ranges that end too soon.
    ("sort", |spec| match spec.entry {
        "sort/radix_items.cl" | "sort/radix_groups.cl" => {
            spec.patch("indices[at] = pair.y", "indices[at] = at")
        }
        _ => spec,
    }),
    ("sort", |spec| match spec.entry {
        "sort/ranges.cl" => spec.patch("+ 1] = i + 1;", "+ 1] = i;"),
        _ => spec,
    }),
    // Glass that reflects too rarely, flux that gets lost, the weights of another kernel.
    ("caustics", |spec| match spec.entry {
        "caustics/photons.cl" => spec.patch("u >= at.reflectance", "u >= 0.5f * at.reflectance"),
        _ => spec,
    }),
    ("caustics", |spec| match spec.entry {
        "caustics/photons.cl" => spec.patch("fate->met.y = flux;", "fate->met.y = 0.999f * flux;"),
        _ => spec,
    }),
    ("caustics", |spec| match spec.entry {
        "render/caustics.cl" => spec.patch("return 1.0f - sqrt(t2);", "return 1.0f - t2;"),
        _ => spec,
    }),
    // Random numbers that count from the launch.
    ("launches", |spec| match spec.entry {
        "render/scattering.cl" => spec,
        _ => spec.patch("(uint)pixel, sample, keys", "(uint)pixel, sample - first_sample, keys"),
    }),
    // What llvmpipe does.
    ("loops", |spec| match spec.entry {
        "render/scattering.cl" => spec,
        _ => spec.patch("for (;;) {", "for (uint turn = 0u; turn < 65535u; ++turn) {"),
    }),
];

#[test]
fn broken_kernels_are_found() {
    let device = device();
    for (i, (check, fault)) in FAULTS.into_iter().enumerate() {
        let verdicts = run_altered(&device, &only(check), fault, &mut |_| {}).unwrap();
        let failed = verdicts.iter().find(|verdict| verdict.status == Status::Failed);
        let failed = failed.unwrap_or_else(|| panic!("fault {i} passes the check {check}: {verdicts:#?}"));
        println!(
            "{check}: {:?}, expected {} ± {:.1e}: {:?}",
            failed.measured, failed.expected, failed.tolerance, failed.problem
        );
        // It ran: what failed is what came out.
        assert!(failed.quantity != "checks that ran", "fault {i}: {failed:#?}");
    }
}

#[test]
fn paths_that_the_device_does_not_follow_are_noticed() {
    let cut: Alter = |spec| match spec.entry {
        "render/scattering.cl" => spec.patch("for (;;) {", "for (uint turn = 0u; turn < 65535u; ++turn) {"),
        _ => spec,
    };
    let verdicts = run_altered(&device(), &only("loops"), cut, &mut |_| {}).unwrap();
    let status: Vec<Status> = verdicts.iter().map(|verdict| verdict.status).collect();
    assert_eq!(status[1], Status::Limited, "{verdicts:#?}");
    assert!(verdicts[1].problem.as_ref().unwrap().contains("the renderer notices"), "{verdicts:#?}");
}
