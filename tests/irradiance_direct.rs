//! Direct light in the cells of light volumes, against closed forms in homogeneous boxes and in empty ones.

mod common;
#[path = "common/direct.rs"]
mod direct;

use common::{Case, EPS, close, volume_f32};
use direct::{Homogeneous, How, Run, agrees, exactly, text};
use glam::DVec3;
use std::f64::consts::PI;
use svetlo::reference::lights::rectangle_solid_angle;
use svetlo::reference::quadrature::gauss_legendre;
use svetlo::volume::Volume;

const SUN: &str = "[[light]]\nkind = \"directional\"\ndirection = [1, 2, -0.5]\nirradiance = [3, 2, 1]\n";
const LAMP: &str = "[[light]]\nkind = \"point\"\nposition = [2.2, 9, 1]\nintensity = [30, 20, 60]\n";
const SKY: &str = "[background]\ncolor = [0.5, 1, 2]\n";

fn flat(dims: [usize; 3]) -> Volume {
    volume_f32(dims, vec![0.4; dims.iter().product()])
}

/// A box of one extinction (relative to `color`) in some light.
fn homogeneous(dims: [usize; 3], sigma: f64, color: [f64; 3], light: &str) -> (Case, Homogeneous) {
    let medium = format!("sigma_max = {sigma}\nextinction_color = {color:?}");
    let case = Case::new(&text(&medium, "{ value = 0, opacity = 1, color = 1 }", light), flat(dims));
    let twin = Homogeneous::new(&case.volume, DVec3::ONE, color.map(|c| c * sigma));
    (case, twin)
}

fn times(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| a[c] * b[c])
}

fn plus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| a[c] + b[c])
}

fn sun(twin: &Homogeneous, point: DVec3) -> [f64; 3] {
    let towards = -DVec3::new(1.0, 2.0, -0.5).normalize();
    times([3.0, 2.0, 1.0], twin.transmittance(point, towards, f64::INFINITY))
}

fn lamp(twin: &Homogeneous, at: DVec3, intensity: [f64; 3], point: DVec3) -> [f64; 3] {
    let way = at - point;
    let left = twin.transmittance(point, way.normalize(), way.length());
    times(intensity.map(|i| i / way.length_squared()), left)
}

/// Roundings of a transmittance and a light: the way's length errs by 4 of the box's diagonal, and the optical depth by as
/// many of it; 16 more for the light and the exponential function.
fn ulps(twin: &Homogeneous) -> f64 {
    let thickest = twin.sigma.into_iter().fold(0.0, f64::max);
    16.0 + 8.0 * thickest * (twin.size.length() + 4.0)
}

fn truth(run: &Run, light: impl Fn(DVec3) -> [f64; 3]) -> Vec<[f64; 3]> {
    run.centres.iter().map(|&point| light(point)).collect()
}

#[test]
fn one_light_without_extent_in_a_homogeneous_box_has_no_noise() {
    let sizes = [[7, 5, 9], [1, 1, 1], [1, 6, 4], [13, 1, 2]];
    for (dims, sigma) in sizes.into_iter().zip([0.3, 0.0, 0.45, 0.05]) {
        let color = [1.0, 0.5, 0.2];
        let (case, twin) = homogeneous(dims, sigma, color, SUN);
        let run = How::passes(5).run(&case);
        assert!(run.exact && run.passes == 1 && run.error == 0.0);
        exactly(&format!("sun, {dims:?}"), &run.fluence, &truth(&run, |p| sun(&twin, p)), ulps(&twin));
        let (case, twin) = homogeneous(dims, sigma, color, LAMP);
        let run = How::passes(2).run(&case);
        let at = DVec3::new(2.2, 9.0, 1.0);
        // Squared distances to the lamp err by their own roundings and, near it, by those of the places.
        let exact = truth(&run, |p| lamp(&twin, at, [30.0, 20.0, 60.0], p));
        let nearest = run.centres.iter().map(|p| p.distance(at)).fold(f64::INFINITY, f64::min);
        let ulps = ulps(&twin) + 8.0 * at.length() / nearest;
        exactly(&format!("lamp, {dims:?}"), &run.fluence, &exact, ulps);
    }
}

#[test]
fn coarser_cells_see_light_from_their_own_centres() {
    for coarsening in [2, 3, 4, 64] {
        let (case, twin) = homogeneous([9, 6, 5], 0.05, [1.0; 3], SUN);
        let run = How::passes(1).coarse(coarsening).run(&case);
        assert_eq!(
            run.centres.len(),
            [9_usize, 6, 5].map(|n| n.div_ceil(coarsening)).iter().product::<usize>()
        );
        exactly(&format!("{coarsening}"), &run.fluence, &truth(&run, |p| sun(&twin, p)), ulps(&twin));
    }
}

/// Power that the box takes from the light, by all its cells: Σ σ φ V; and its standard error.
fn taken(run: &Run, twin: &Homogeneous) -> [f64; 2] {
    let volume = twin.size.element_product() / run.fluence.len() as f64;
    let [sum, variance] = run.fluence.iter().fold([0.0; 2], |[sum, variance], cell| {
        let mean = cell[..3].iter().map(|&v| f64::from(v)).sum::<f64>() / 3.0;
        [sum + mean, variance + f64::from(cell[3])]
    });
    [twin.sigma[0] * volume * sum, twin.sigma[0] * volume * variance.sqrt()]
}

#[test]
fn a_lamp_in_the_volume_loses_to_the_cells_what_does_not_leave_the_box() {
    // In a cell, between four, at a corner of eight, on the box's side.
    let middle = DVec3::new(1.5, 2.5, 1.5);
    for at in [middle, DVec3::new(1.7, 2.0, 1.6), DVec3::splat(2.0), DVec3::new(1.3, 2.2, 0.0)] {
        for sigma in [0.1, 0.3, 1.0, 4.0] {
            let light =
                format!("[[light]]\nkind = \"point\"\nposition = {:?}\nintensity = 2\n", at.to_array());
            let (case, twin) = homogeneous([3, 4, 3], sigma, [1.0; 3], &light);
            let run = How::passes(256).run(&case);
            assert!(!run.exact && run.fluence.iter().flatten().all(|v| v.is_finite()));
            let [found, error] = taken(&run, &twin);
            // In the directions that leave at once, on a side, nothing is taken.
            let inside = DVec3::new(at.x, at.y, at.z.max(1e-9));
            let exact = 2.0 * (4.0 * PI - twin.sphere(inside, sigma));
            println!("{at}, sigma {sigma}: {found:.4} ± {error:.4}, exact {exact:.4}");
            assert!(error < 0.03 * exact, "{error}");
            // Cells two edges away and more, whose centres stand for a part of them, curve by a percent.
            assert!((found - exact).abs() < 0.01 * exact + 5.0 * error, "{found} {exact} ± {error}");
        }
    }
}

#[test]
fn thick_cells_have_the_mean_of_their_light() {
    let light = "[[light]]\nkind = \"directional\"\ndirection = [0, 0, 1]\nirradiance = 1\n";
    for sigma in [0.5, 0.6, 0.7, 1.0, 2.5, 10.0, 20.0] {
        let (case, twin) = homogeneous([6, 7, 5], sigma, [1.0; 3], light);
        let run = How::passes(1024).run(&case);
        // What is left of ten mean free paths is rare beyond what variances tell.
        if (1.0..3.0).contains(&sigma) {
            let mean = |z: f64| (-sigma * (z - 0.5)).exp() * -f64::exp_m1(-sigma) / sigma;
            agrees(&format!("sigma {sigma}"), &run, &truth(&run, |p| [mean(p.z); 3]));
        }
        let [found, error] = taken(&run, &twin);
        let exact = 42.0 * -f64::exp_m1(-5.0 * sigma);
        // The centre of a cell of 0.6 mean free paths is 1/67 below its mean, of which 1/7 is known already.
        assert!((found / exact - 1.0).abs() < 0.014 + 5.0 * error / exact, "{sigma}: {found} of {exact}");
    }
}

#[test]
fn a_single_cell_has_the_light_that_is_asked_for_and_no_more() {
    let (case, _) = homogeneous([1, 1, 1], 0.1, [1.0; 3], SUN);
    let run = How::passes(1).run(&case);
    assert!(run.reduced.is_none() && run.flow.is_none());
}

#[test]
fn an_empty_volume_has_all_of_the_background_and_none_of_the_dark() {
    // Without extinction by the medium, and by the values.
    let ramp = "{ value = 0, opacity = 0 }, { value = 1, opacity = 1 }";
    for (points, sigma) in [("{ value = 0, opacity = 1 }", 0.0), (ramp, 7.0)] {
        let volume = || volume_f32([5, 4, 3], vec![0.0; 60]);
        let medium = format!("sigma_max = {sigma}");
        let run = How::passes(3).run(&Case::new(&text(&medium, points, SKY), volume()));
        assert_eq!((run.exact, run.cost.lookups, run.passes), (true, 0, 1));
        let all = [0.5, 1.0, 2.0].map(|radiance| 4.0 * PI * radiance);
        exactly("4 pi L", &run.fluence, &truth(&run, |_| all), 2.0);
        let both = How::passes(2).run(&Case::new(&text(&medium, points, &format!("{SUN}{SKY}")), volume()));
        exactly("with the sun", &both.fluence, &truth(&both, |_| plus(all, [3.0, 2.0, 1.0])), 4.0);
        let run =
            How::passes(3).run(&Case::new(&text(&medium, points, "[background]\ncolor = 0\n"), volume()));
        assert_eq!((run.exact, run.cost.rays, run.error), (true, 0, 0.0));
        assert!(run.fluence.iter().flatten().all(|&v| v == 0.0));
    }
}

#[test]
fn the_background_lights_from_all_sides() {
    let (case, twin) = homogeneous([9, 8, 7], 0.25, [1.0, 0.5, 0.1], SKY);
    // The quadrature: without extinction it knows the sphere.
    close("4 pi", twin.sphere(DVec3::new(0.5, 3.0, 2.0), 0.0), 4.0 * PI, 1e-8);
    let run = How::passes(1024).run(&case);
    let radiance = [0.5, 1.0, 2.0];
    let exact = truth(&run, |p| std::array::from_fn(|c| radiance[c] * twin.sphere(p, twin.sigma[c])));
    agrees("background", &run, &exact);
    assert!(!run.exact && run.cost.rays == 504 * 1024 && run.cost.lookups == 0, "{:?}", run.cost);
    // Stratification is worth something: without it a pass would have the spread of the transmittance over directions.
    let spread = run.centres.iter().zip(&exact).map(|(&p, exact)| {
        // The mean over the channels of L T, squared, over the sphere, by pairs of channels.
        let pair =
            |a: usize, b: usize| radiance[a] * radiance[b] * twin.sphere(p, twin.sigma[a] + twin.sigma[b]);
        let square: f64 = (0..9).map(|k| pair(k / 3, k % 3)).sum::<f64>() / 9.0;
        let mean = exact.iter().sum::<f64>() / 3.0;
        [4.0 * PI * square - mean * mean, mean * mean]
    });
    let [variance, square] = spread.fold([0.0; 2], |sum, x| [sum[0] + x[0], sum[1] + x[1]]);
    let unstratified = (variance / square / f64::from(run.passes)).sqrt();
    println!("unstratified {unstratified:.2e}, stratified {:.2e}", run.error);
    assert!(run.error < 0.6 * unstratified, "{:.2e} {unstratified:.2e}", run.error);
}

#[test]
fn lights_add_up() {
    let window = "[[light]]\nkind = \"rectangle\"\ncentre = [4, 12, 3]\nedge_u = [6, 0, 0]\nedge_v = [0, 1, 5]\nradiance = [4, 2, 1]\n";
    let (case, twin) = homogeneous([8, 7, 5], 0.15, [0.6, 1.0, 0.3], &format!("{SUN}{LAMP}{window}{SKY}"));
    let run = How::passes(1024).run(&case);
    let at = DVec3::new(2.2, 9.0, 1.0);
    let [centre, u, v] = [DVec3::new(4.0, 12.0, 3.0), DVec3::X * 6.0, DVec3::new(0.0, 1.0, 5.0)];
    let nodes = gauss_legendre(12);
    let rectangle = |p: DVec3, twin: &Homogeneous| {
        let mut sum = [0.0; 3];
        for &(a, wa) in &nodes {
            for &(b, wb) in &nodes {
                let way = centre + (a - 0.5) * u + (b - 0.5) * v - p;
                let facing = -u.cross(v).dot(way) / way.length().powi(3);
                let left = twin.transmittance(p, way.normalize(), way.length());
                sum = plus(sum, left.map(|left| wa * wb * facing * left));
            }
        }
        times([4.0, 2.0, 1.0], sum)
    };
    // The quadrature without extinction is a solid angle.
    let clear = Homogeneous { size: twin.size, sigma: [0.0; 3] };
    let p = DVec3::new(3.5, 6.5, 2.5);
    close("solid angle", rectangle(p, &clear)[2], rectangle_solid_angle(centre, u, v, p), 1e-6);
    let radiance = [0.5, 1.0, 2.0];
    let exact = truth(&run, |p| {
        let background = std::array::from_fn(|c| radiance[c] * twin.sphere(p, twin.sigma[c]));
        let lights = plus(sun(&twin, p), lamp(&twin, at, [30.0, 20.0, 60.0], p));
        plus(plus(background, lights), rectangle(p, &twin))
    });
    agrees("all lights", &run, &exact);
    assert_eq!(run.cost.rays, 2 * 280 * 1024);
    let roundings = EPS * 64.0;
    assert!(run.error > roundings);
}
