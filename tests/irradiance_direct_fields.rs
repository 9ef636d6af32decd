//! Direct light where the medium has to be looked up.

mod common;
#[path = "common/direct.rs"]
mod direct;

use common::{Case, device};
use direct::How;
use std::path::Path;
use std::time::Instant;
use svetlo::irradiance::{Direct, LightGrid, LitMedium};
use svetlo::render::{BRICK_SHIFT, Plan, Session, load_volume};
use svetlo::scene::Scene;

/// What a look-up costs, beside one of the path tracer in the same medium. Run alone, with `--ignored --nocapture`.
#[test]
#[ignore = "measures"]
fn cost_of_look_ups() {
    let device = device();
    let single = "method={kind=\"single-scattering\"}".to_owned();
    for (name, overrides) in [
        ("sun", vec!["background={color=0}".to_owned()]),
        ("sky", vec!["light=[]".to_owned()]),
        ("sun and sky", vec![]),
        ("sun, isotropic", vec!["background={color=0}".to_owned(), "phase={kind=\"isotropic\"}".to_owned()]),
        ("sun, thin, isotropic", vec!["medium.sigma_max=5".into(), "background={color=0}".to_owned(), "phase={kind=\"isotropic\"}".to_owned()]),
    ] {
        let overrides: Vec<String> = overrides.into_iter().chain([single.clone()]).collect();
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/cloud_scattering.toml");
        let scene = Scene::load(&path, &overrides).unwrap();
        let volume = load_volume(&scene.volume).unwrap();
        let plan = Plan::new(&scene, &volume, BRICK_SHIFT).unwrap();
        let medium = LitMedium::new(&device, &plan, &plan.method).unwrap();
        let grid = LightGrid::new(&plan.local, 2);
        let mut direct = Direct::new(&device, &medium, &grid, &scene.phase).unwrap();
        direct.step(&device, &medium, 1).unwrap();
        while !direct.is_done(1) {
            direct.step(&device, &medium, 1).unwrap();
        }
        let before = direct.cost(&device).unwrap();
        let passes = 32;
        let start = Instant::now();
        while !direct.is_done(1 + passes) {
            direct.step(&device, &medium, 1 + passes).unwrap();
        }
        let seconds = start.elapsed().as_secs_f64();
        let after = direct.cost(&device).unwrap();
        let (lookups, rays) = ((after.lookups - before.lookups) as f64, (after.rays - before.rays) as f64);
        let light = direct.means(&device).unwrap();
        let error = light.relative_error(&device).unwrap();
        println!(
            "direct, {name}: {:.2} look-ups per ray, {:.2} ns per look-up, {:.1} ns per ray, {:.2e} cells/s, error {error:.3e}, efficiency {:.1}",
            lookups / rays,
            seconds * 1e9 / lookups,
            seconds * 1e9 / rays,
            grid.cells() as f64 * f64::from(passes) / seconds,
            1.0 / (error * error * seconds)
        );
        if name == "sun and sky" || name.starts_with("sun, ") {
            let mut session = Session::new(common::device(), &plan).unwrap();
            session.render(1).unwrap();
            let before = session.ledger().unwrap().unwrap();
            let start = Instant::now();
            session.render(3).unwrap();
            let seconds = start.elapsed().as_secs_f64();
            let after = session.ledger().unwrap().unwrap();
            let lookups = (after.lookups - before.lookups) as f64;
            println!("render_scattering, single: {:.2} ns per look-up", seconds * 1e9 / lookups);
        }
    }
    let _ = How::passes(1);
    let _: Option<Case> = None;
}
