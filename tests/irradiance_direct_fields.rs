//! Direct light where the medium has to be looked up: ramps in closed form, rough fields against the twin, all that varies.

mod common;
#[path = "common/direct.rs"]
mod direct;

use common::scattering::write_map;
use common::{Case, EPS, close, device, noisy, volume_f32};
use direct::{Homogeneous, How, Run, agrees, agrees_over_seeds, compare, text};
use glam::DVec3;
use std::path::Path;
use std::time::Instant;
use svetlo::irradiance::{Direct, LightGrid, LitMedium};
use svetlo::picture::Environment;
use svetlo::reference::camera::Ray;
use svetlo::reference::emission_absorption::Integrator;
use svetlo::reference::lights::Sky;
use svetlo::reference::quadrature::gauss_legendre;
use svetlo::render::{BRICK_SHIFT, Plan, SceneData, Session};
use svetlo::scene::Scene;

const SUN: &str = "[[light]]\nkind = \"directional\"\ndirection = [0.3, 0.5, -1]\nirradiance = [3, 2, 1]\n";
const LAMP: &str = "[[light]]\nkind = \"point\"\nposition = [3, 3, 40]\nintensity = [900, 800, 700]\n";

/// Towards the sun.
fn sunwards() -> DVec3 {
    -DVec3::new(0.3, 0.5, -1.0).normalize()
}

/// Voxels that rise from 0 to 1 along z: their field is linear between the outermost centres and constant beyond.
struct Ramp {
    shape: Homogeneous,
    /// Voxels along z, and their spacing.
    voxels: usize,
    spacing: f64,
}

impl Ramp {
    /// With extinction linear from `sigma` × 0.1 at 0 to `sigma` at 1, and albedo from `albedo[0]` to `albedo[1]`.
    fn case(dims: [usize; 3], medium: &str, albedo: [f64; 2], rest: &str) -> (Case, Self) {
        let points = format!(
            "{{ value = 0, opacity = 0.1, color = {} }}, {{ value = 1, opacity = 1, color = {} }}",
            albedo[0], albedo[1]
        );
        let spacing = DVec3::new(1.0, 1.0, 0.5);
        let text = text(medium, &points, rest)
            // Many look-ups that take little each: few rare ones that take much have no normal distribution.
            .replace("[method]", "[method]\nmajorant_scale = 64")
            .replace("[volume]", &format!("[volume]\nspacing = {:?}", spacing.to_array()));
        let plane = dims[0] * dims[1];
        let values = (0..plane * dims[2]).map(|i| (i / plane) as f64 / (dims[2] - 1) as f64);
        let case = Case::new(&text, volume_f32(dims, values));
        let shape = Homogeneous::new(&case.volume, spacing, [0.0; 3]);
        (case, Self { shape, voxels: dims[2], spacing: 0.5 })
    }

    /// ∫ f(value) dt along a ray to the end of the box, or to `most`; f at most a cubic polynomial.
    fn integral(&self, point: DVec3, direction: DVec3, most: f64, f: impl Fn(f64) -> f64) -> f64 {
        let length = self.shape.exit(point, direction).min(most);
        let value = |t: f64| {
            let z = (point.z + t * direction.z) / self.spacing - 0.5;
            (z / (self.voxels - 1) as f64).clamp(0.0, 1.0)
        };
        let mut cuts = vec![0.0, length];
        for plane in [0.5, self.voxels as f64 - 0.5] {
            let t = (plane * self.spacing - point.z) / direction.z;
            if t > 0.0 && t < length {
                cuts.push(t);
            }
        }
        cuts.sort_by(f64::total_cmp);
        let rule = gauss_legendre(4);
        let piece = |ends: &[f64]| -> f64 {
            let width = ends[1] - ends[0];
            rule.iter().map(|(x, weight)| weight * width * f(value(ends[0] + x * width))).sum()
        };
        cuts.windows(2).map(piece).sum()
    }
}

/// The extinction of a ramp relative to the largest.
fn rising(value: f64) -> f64 {
    0.1 + 0.9 * value
}

fn truth(run: &Run, light: impl Fn(DVec3) -> [f64; 3]) -> Vec<[f64; 3]> {
    run.centres.iter().map(|&point| light(point)).collect()
}

#[test]
fn a_ramp_attenuates_as_its_closed_form_tells() {
    let color = [1.0, 0.5, 0.1];
    // One light at a time: how often each of several is drawn varies next to nothing, and then by one.
    for (dims, coarsening, sigma, light) in [
        ([5, 4, 33], 1, 0.3, SUN),
        ([9, 11, 40], 2, 0.2, LAMP),
        ([13, 10, 64], 4, 0.1, SUN),
        ([1, 1, 64], 1, 0.3, LAMP),
        ([1, 12, 20], 1, 0.45, SUN),
    ] {
        let medium = format!("sigma_max = {sigma}\nextinction_color = {color:?}");
        let (case, ramp) = Ramp::case(dims, &medium, [1.0; 2], light);
        let run = How::passes(1024).coarse(coarsening).run(&case);
        let exact = truth(&run, |p| {
            let way = DVec3::new(3.0, 3.0, 40.0) - p;
            let (towards, length, shine) = if light == SUN {
                (sunwards(), f64::INFINITY, [3.0, 2.0, 1.0])
            } else {
                (way.normalize(), way.length(), [900.0, 800.0, 700.0].map(|i| i / way.length_squared()))
            };
            let depth = sigma * ramp.integral(p, towards, length, rising);
            std::array::from_fn(|c| shine[c] * (-color[c] * depth).exp())
        });
        agrees(&format!("{dims:?} by {coarsening}"), &run, &exact);
        assert!(run.cost.lookups > 0 && run.error < 0.01, "{:?} {}", run.cost, run.error);
    }
}

/// Power is neither made nor lost where a medium begins within cells that are thick.
#[test]
fn what_cells_take_is_what_the_light_loses_at_interfaces_too() {
    let light = "[[light]]\nkind = \"directional\"\ndirection = [0, 0, 1]\nirradiance = 1\n";
    let points = "{ value = 0, opacity = 0 }, { value = 1, opacity = 1 }";
    for sigma in [2.0, 10.0, 50.0] {
        let values = (0..6 * 6 * 8).map(|i| if i / 36 < 4 { 0.0 } else { 1.0 });
        let text = text(&format!("sigma_max = {sigma}"), points, light);
        let case = Case::new(&text, volume_f32([6, 6, 8], values));
        let run = How::passes(1024).run(&case);
        // The volume averages of the cells, from two points per voxel: linear between centres, so they are exact.
        let field = case.field();
        let mean = |p: DVec3| {
            let at = |z: f64| sigma * field.value(DVec3::new(p.x, p.y, p.z + z));
            0.5 * (at(-0.25) + at(0.25))
        };
        let (mut found, mut variance) = (0.0, 0.0);
        for (cell, &p) in run.fluence.iter().zip(&run.centres) {
            found += mean(p) * f64::from(cell[0]) / 36.0;
            variance += mean(p).powi(2) * f64::from(cell[3]) / 36.0_f64.powi(2);
        }
        println!("sigma {sigma}: {found:.4} ± {:.4}", variance.sqrt());
        // All of it is taken but e^{-4 sigma}. The empty cell next to the medium has a mean of an eighth of it: below
        // half a mean free path, its centre stands for it, and is at most a quarter of that too bright.
        let exact = -f64::exp_m1(-4.0 * sigma);
        let edge = if sigma < 4.0 { 0.125 * sigma * 0.25 * 0.125 * sigma } else { 0.0 };
        assert!((found - exact).abs() < 0.01 + edge + 5.0 * variance.sqrt(), "{sigma}: {found} of {exact}");
    }
}

#[test]
fn reduced_light_is_attenuated_by_the_transport_extinction() {
    // Thin enough cells for their light to be that of their centres.
    for (g, albedo) in [(0.9, [0.9; 2]), (0.5, [0.2, 1.0]), (-0.5, [1.0, 0.3]), (-0.5, [0.8; 2])] {
        let rest = format!("{SUN}[phase]\nkind = \"henyey-greenstein\"\ng = {g}\n");
        let (mut case, ramp) =
            Ramp::case([3, 4, 21], "sigma_max = 0.48\nalbedo = [1, 0.9, 0.2]", albedo, &rest);
        let reduced = |run: &Run| run.reduced.clone().expect("g is not 0");
        let exact = |p: DVec3, channel: usize| {
            let transport = |v: f64| {
                let albedo = [1.0, 0.9, 0.2][channel] * (albedo[0] + v * (albedo[1] - albedo[0]));
                rising(v) * (1.0 - g * albedo)
            };
            let depth = 0.48 * ramp.integral(p, sunwards(), f64::INFINITY, transport);
            [3.0, 2.0, 1.0][channel] * (-depth).exp()
        };
        let what = format!("g {g}, albedo {albedo:?}");
        agrees_over_seeds(&what, &mut case, How::passes(32), reduced, &[1, 2], &exact);
        let exact = |p: DVec3| {
            let depth = 0.48 * ramp.integral(p, sunwards(), f64::INFINITY, rising);
            [3.0, 2.0, 1.0].map(|irradiance| irradiance * (-depth).exp())
        };
        let run = How::passes(1024).run(&case);
        agrees(&format!("g {g}, the light itself"), &run, &truth(&run, exact));
    }
}

#[test]
fn reduced_light_in_a_homogeneous_box_has_no_noise() {
    let rest = format!("{SUN}[phase]\nkind = \"two-lobe\"\ng = [0.9, -0.4]\nweight = 0.6\n");
    let color = [1.0, 0.5, 0.2];
    let medium = format!("sigma_max = 0.4\nextinction_color = {color:?}\nalbedo = [1, 0.5, 0]");
    let volume = volume_f32([6, 5, 4], vec![0.5; 120]);
    let case = Case::new(&text(&medium, "{ value = 0, opacity = 1, color = 1 }", &rest), volume);
    let run = How::passes(1).run(&case);
    let g = 0.6 * 0.9 - 0.4 * 0.4;
    let sigma = std::array::from_fn(|c| 0.4 * color[c] * (1.0 - g * [1.0, 0.5, 0.0][c]));
    let twin = Homogeneous::new(&case.volume, DVec3::ONE, sigma);
    let exact = truth(&run, |p| {
        let left = twin.transmittance(p, sunwards(), f64::INFINITY);
        std::array::from_fn(|c| [3.0, 2.0, 1.0][c] * left[c])
    });
    // A dozen roundings of each of an optical depth below 4, of the light, and of the function.
    direct::exactly("reduced", run.reduced.as_ref().unwrap(), &exact, 16.0 + 12.0 * 4.0);
}

#[test]
fn light_flows_from_the_lights() {
    let rest = format!("{SUN}[phase]\nkind = \"rayleigh\"\n");
    let (case, _) = Ramp::case([4, 3, 18], "sigma_max = 0.5", [1.0; 2], &rest);
    let run = How::passes(40).run(&case);
    assert!(run.reduced.is_none(), "Rayleigh's mean cosine is 0");
    for flow in run.flow.as_ref().unwrap() {
        let flow = DVec3::new(flow[0].into(), flow[1].into(), flow[2].into());
        // Two means over 40 passes, each rounded 40 times in 2^-24 of it.
        close("one light", flow.distance(-sunwards()), 0.0, 80.0 * EPS);
        assert!(flow.length() <= 1.0 + 4.0 * EPS);
    }
    // Two suns, one of which the box attenuates more, and the channels differently.
    let other = "[[light]]\nkind = \"directional\"\ndirection = [1, 0, 0]\nirradiance = [1, 2, 6]\n";
    let medium = "sigma_max = 0.2\nextinction_color = [1, 0.5, 0.1]";
    let rest = format!("{SUN}{other}[phase]\nkind = \"henyey-greenstein\"\ng = 0.3\n");
    let volume = volume_f32([6, 4, 5], vec![0.5; 120]);
    let mut case = Case::new(&text(medium, "{ value = 0, opacity = 1, color = 1 }", &rest), volume);
    let twin = Homogeneous::new(&case.volume, DVec3::ONE, [0.2, 0.1, 0.02]);
    let exact = |p: DVec3| {
        let shine = |towards: DVec3, irradiance: [f64; 3]| {
            let left = twin.transmittance(p, towards, f64::INFINITY);
            (0..3).map(|c| irradiance[c] * left[c]).sum::<f64>()
        };
        let (a, b) = (shine(sunwards(), [3.0, 2.0, 1.0]), shine(DVec3::NEG_X, [1.0, 2.0, 6.0]));
        (b * DVec3::X - a * sunwards()) / (a + b)
    };
    let flow = |run: &Run| run.flow.clone().unwrap();
    // A ratio of means is off by its relative variance: 1024 passes leave that far below its spread.
    agrees_over_seeds("two suns", &mut case, How::passes(1024), flow, &[0, 2], &|p, channel| {
        exact(p)[channel]
    });
    // From all sides: nothing flows, but for noise.
    let rest = "[background]\ncolor = 1\n[phase]\nkind = \"rayleigh\"\n";
    let (case, _) = Ramp::case([2, 2, 2], "sigma_max = 0", [1.0; 2], rest);
    let run = How::passes(4096).run(&case);
    let largest = run.flow.unwrap().into_iter().flatten().map(f32::abs).fold(0.0, f32::max);
    // Unstratified: each of the components has a variance of 1/3 per pass; 24 components.
    assert!(largest < 4.0 * (1.0_f32 / 3.0 / 4096.0).sqrt(), "{largest}");
}

/// A rough field with a bent transfer function, in the light of a sun.
fn rough(transfer: &str) -> Case {
    let text = format!(
        "[camera]\nposition = [0, 0, -9]\ntarget = [0, 0, 0]\n[volume]\norigin = [0, 0, 0]\nspacing = [1, 1.5, 0.7]\n\
         window = {{ lo = 0.1, hi = 0.9 }}\n[medium]\nsigma_max = 0.3\n[transfer]\n{transfer}\n{SUN}\
         [method]\nkind = \"single-scattering\"\n"
    );
    Case::new(&text, noisy([21, 10, 19], 3))
}

const BENT: &str = "resolution = 17\npoints = [{ value = 0.3, opacity = 0 }, { value = 0.6, opacity = 0.6 }, \
    { value = 0.7, opacity = 0.1 }, { value = 1, opacity = 1 }]";
const TWO_D: &str = "kind = \"2d\"\nresolution = [16, 8]\ngradient_max = 1\n\
    shapes = [{ shape = \"rectangle\", centre = [0.6, 0.5], size = [0.7, 0.8], opacity = 0.8 }]";

#[test]
fn rough_fields_attenuate_as_the_twin_tells() {
    for (what, transfer) in [("bent", BENT), ("2-D", TWO_D)] {
        let case = rough(transfer);
        let (field, medium) = (case.field(), case.medium());
        let integrator = Integrator::new(&field, &medium);
        // Every seventh cell: the twin takes long.
        let run = How::passes(1024).run(&case);
        let mut cells = Vec::new();
        for (found, &centre) in run.fluence.iter().zip(&run.centres).step_by(7) {
            let ray = Ray { origin: centre, direction: sunwards(), start: 0.0 };
            let exact = 2.0 * integrator.ray(&ray).transmittance();
            let mean = found[..3].iter().map(|&v| f64::from(v)).sum::<f64>() / 3.0;
            cells.push([mean, f64::from(found[3]).sqrt(), exact]);
        }
        compare(what, &cells, 1024.0 / 16.0 - 1.0);
    }
}

#[test]
fn launches_and_lanes_do_not_change_the_light() {
    let mut case = rough(BENT);
    case.scene = common::scene(&format!(
        "[camera]\nposition = [0, 0, -9]\ntarget = [0, 0, 0]\n[volume]\nwindow = {{ lo = 0.1, hi = 0.9 }}\n\
         [medium]\nsigma_max = 0.7\n[transfer]\n{BENT}\n{SUN}{LAMP}[background]\ncolor = [1, 0.5, 0.2]\n\
         [phase]\nkind = \"henyey-greenstein\"\ng = 0.6\n[method]\nkind = \"single-scattering\"\n"
    ));
    let how = How::passes(37);
    let whole = how.run(&case);
    for launch in [1, 5, 23, 100] {
        assert_eq!(How { launch, ..how }.run(&case), whole, "launches of {launch}");
    }
    assert_eq!(whole.cost.rays, 2 * 37 * 21 * 10 * 19);
    // One ray at a time draws the same numbers: but for roundings, the same light.
    let single = How { lanes: Some(1), ..how }.run(&case);
    let difference = |a: &[[f32; 4]], b: &[[f32; 4]]| {
        common::rms(a.iter().zip(b).flat_map(|(a, b)| (0..3).map(|c| f64::from(a[c] - b[c]))))
    };
    let size = common::rms(whole.fluence.iter().flat_map(|v| v[..3].iter().map(|&x| f64::from(x))));
    let changed = difference(&whole.fluence, &single.fluence) / size;
    println!("one lane and many differ by {changed:.1e}, the standard error is {:.1e}", whole.error);
    assert!(changed < 0.1 * whole.error, "{changed}");
    let changed = difference(whole.reduced.as_ref().unwrap(), single.reduced.as_ref().unwrap()) / size;
    assert!(changed < 0.1 * whole.error, "{changed}");
    assert!(whole.cost.lookups.abs_diff(single.cost.lookups) * 1000 < whole.cost.lookups);
}

#[test]
fn environments_light_from_their_texels() {
    let folder = tempfile::tempdir().unwrap();
    let value = common::noise(3 * 8 * 4, 5);
    let file = write_map(folder.path(), 8, 4, |x, y| {
        std::array::from_fn(|c| (0.1 + 8.0 * value[3 * (8 * y + x) + c].powi(4)) as f32)
    });
    let map = Environment::read(&file).unwrap();
    let sky = Sky { map: &map, intensity: 1.5, rotation: 0.7 };
    for sampling in ["importance", "escape"] {
        for sigma in [0.0, 0.4] {
            let rest = format!(
                "[background]\nenvironment = {:?}\nintensity = 1.5\nrotation = {}\nsampling = \"{sampling}\"\n",
                file.to_str().unwrap(),
                0.7_f64.to_degrees()
            );
            let color = [1.0, 0.5, 0.1];
            let medium = format!("sigma_max = {sigma}\nextinction_color = {color:?}");
            let volume = volume_f32([3, 4, 2], vec![0.5; 24]);
            let case = Case::new(&text(&medium, "{ value = 0, opacity = 1, color = 1 }", &rest), volume);
            let twin = Homogeneous::new(&case.volume, DVec3::ONE, color.map(|c| c * sigma));
            let run = How::passes(1024).run(&case);
            assert!(!run.exact);
            // Per half texel the map is smooth, but the way out has kinks at the box's edges, so that halving the step
            // quarters the error: what is left is far below the noise.
            let exact = truth(&run, |p| lit_by(&sky, &twin, p, 8));
            let finer = truth(&run, |p| lit_by(&sky, &twin, p, 16));
            for (a, b) in exact.iter().flatten().zip(finer.iter().flatten()) {
                close("quadrature", *a, *b, 3e-4 * b);
            }
            agrees(&format!("{sampling}, sigma {sigma}"), &run, &finer);
            if sigma == 0.0 {
                close("the sphere", finer[0][1], sky.fluence()[1], 1e-9 * finer[0][1]);
            }
        }
    }
}

/// ∫ L T dω by a product rule with n nodes per half texel and axis.
fn lit_by(sky: &Sky<'_>, twin: &Homogeneous, point: DVec3, n: usize) -> [f64; 3] {
    let rule = gauss_legendre(n);
    let (width, height) = (2 * sky.map.width, 2 * sky.map.height);
    let mut sum = [0.0; 3];
    for row in 0..height {
        for &(v, wv) in &rule {
            let y = 0.5 * (row as f64 + v);
            let polar = std::f64::consts::PI * y / sky.map.height as f64;
            for column in 0..width {
                for &(u, wu) in &rule {
                    let place = [0.5 * (column as f64 + u), y];
                    let left = twin.transmittance(point, sky.direction(place), f64::INFINITY);
                    let radiance = sky.radiance(place);
                    let area = std::f64::consts::TAU / width as f64 * std::f64::consts::PI / height as f64;
                    (0..3).for_each(|c| sum[c] += wu * wv * area * polar.sin() * radiance[c] * left[c]);
                }
            }
        }
    }
    sum
}

#[test]
fn steep_media_end_their_rays() {
    // A million times as thick in one half as in the other.
    let values = (0..16 * 16 * 16).map(|i| if i % 16 < 8 { 0.0 } else { 1.0 });
    let points = "{ value = 0, opacity = 1e-6, color = 1 }, { value = 1, opacity = 1, color = 1 }";
    let rest = format!("{SUN}[background]\ncolor = 1\n[phase]\nkind = \"henyey-greenstein\"\ng = 0.9\n");
    let case = Case::new(&text("sigma_max = 1000", points, &rest), volume_f32([16; 3], values));
    let run = How::passes(16).run(&case);
    let all = run.fluence.iter().chain(run.reduced.as_ref().unwrap());
    assert!(all.flat_map(|v| &v[..3]).all(|v| v.is_finite() && *v >= 0.0));
    // Deep inside there is nothing, on the clear side light.
    let deepest = run.centres.iter().position(|p| p.distance(DVec3::new(14.5, 8.5, 8.5)) < 0.1).unwrap();
    assert_eq!(run.fluence[deepest][..3], [0.0; 3]);
    assert!(run.fluence[0][0] > 3.0, "{:?}", run.fluence[0]);
}

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
        (
            "sun, thin, isotropic",
            vec![
                "medium.sigma_max=5".into(),
                "background={color=0}".to_owned(),
                "phase={kind=\"isotropic\"}".to_owned(),
            ],
        ),
    ] {
        let overrides: Vec<String> = overrides.into_iter().chain([single.clone()]).collect();
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/cloud_scattering.toml");
        let scene = Scene::load(&path, &overrides).unwrap();
        let loaded = SceneData::load(&scene).unwrap();
        let plan = Plan::new(&scene, &loaded, BRICK_SHIFT).unwrap();
        let medium = LitMedium::new(&device, &plan, &plan.method).unwrap();
        let grid = LightGrid::new(&plan.local, 2);
        let mut direct = Direct::new(&device, &medium, &grid, &scene.phase).unwrap();
        direct.step(&device, &medium, 1).unwrap();
        while !direct.is_done(1) {
            direct.step(&device, &medium, 1).unwrap();
        }
        let before = direct.cost(&device).unwrap();
        let passes = 64;
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
        if name == "sun and sky" {
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
}
