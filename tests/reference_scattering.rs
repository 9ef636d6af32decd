//! The plain path tracer against closed forms, before it judges the kernels. Needs no device.

mod common;

use common::scattering::{Measured, Twin, family, of_twin, write_map};
use common::{Case, noisy, volume_f32};
use glam::DVec3;
use std::f64::consts::PI;
use svetlo::reference::camera::Ray;
use svetlo::reference::quadrature::gauss_legendre;
use svetlo::reference::scattering::{Estimate, HomogeneousBox, phase_value};
use svetlo::reference::slab::Slab;
use svetlo::scene::{Light, Phase};

/// An orthographic view of one place, 8×8 pixels: `from` and `to` in scene units.
fn view(from: [f64; 3], to: [f64; 3], up: [f64; 3]) -> String {
    format!(
        "[image]\nwidth = 8\nheight = 8\n[camera]\nkind = \"orthographic\"\nposition = {from:?}\ntarget = {to:?}\n\
         up = {up:?}\nheight = 1e-6\n"
    )
}

/// A homogeneous unit cube of σ = 3, albedo 0.8 and g = 0.4 in single scattering.
const CUBE: &str = "[volume]\nwindow = { lo = 0, hi = 1 }\n[medium]\nsigma_max = 3\nalbedo = 0.8\n[phase]\n\
                    kind = \"henyey-greenstein\"\ng = 0.4\n\
                    [transfer]\nresolution = 2\npoints = [{ value = 0, opacity = 1, color = 1 }]\n\
                    [method]\nkind = \"single-scattering\"\n";

fn cube() -> HomogeneousBox {
    let phase = Phase::HenyeyGreenstein { g: 0.4 };
    HomogeneousBox { low: DVec3::ZERO, high: DVec3::ONE, sigma_t: 3.0, albedo: 0.8, phase }
}

const FROM: [f64; 3] = [-0.7, 0.2, 1.5];
const TO: [f64; 3] = [0.4, 0.5, 0.6];

fn ray() -> Ray {
    Ray::towards(DVec3::from_array(FROM), DVec3::from_array(TO))
}

fn mean(image: &[Estimate], channel: usize) -> Measured {
    of_twin(image, channel)
}

/// One number of each of three channels.
#[track_caller]
fn agree(what: &str, image: &[Estimate], exact: [f64; 3]) {
    for (channel, exact) in exact.into_iter().enumerate() {
        // The truths themselves are good to 3·10⁻⁹.
        mean(image, channel).agrees(what, exact, family(3), 3e-9);
    }
}

#[test]
fn point_and_parallel_lights_agree_with_the_quadrature() {
    let lights = [
        ("kind = \"directional\"\ndirection = [1, -2, 0.3]\nirradiance = [1, 2, 0.5]", {
            let direction = DVec3::new(1.0, -2.0, 0.3).normalize();
            Light::Directional { direction, irradiance: [1.0, 2.0, 0.5] }
        }),
        ("kind = \"point\"\nposition = [2, 1.5, 0.1]\nintensity = [1, 2, 0.5]", {
            Light::Point { position: DVec3::new(2.0, 1.5, 0.1), intensity: [1.0, 2.0, 0.5] }
        }),
        // 0.26 from the ray at least, inside the medium.
        ("kind = \"point\"\nposition = [0.5, 0.8, 0.7]\nintensity = [1, 2, 0.5]", {
            Light::Point { position: DVec3::new(0.5, 0.8, 0.7), intensity: [1.0, 2.0, 0.5] }
        }),
    ];
    for (text, light) in lights {
        let text = format!("{}{CUBE}[[light]]\n{text}\n", view(FROM, TO, [0.0, 1.0, 0.0]));
        let case = Case::new(&text, volume_f32([1, 1, 1], [0.5]));
        agree("light", &Twin::new(&case).image(4000), cube().single_scattering(&ray(), &light));
    }
}

#[test]
fn a_rectangle_agrees_with_the_quadrature_over_its_points() {
    let (centre, u, v) = (DVec3::new(0.3, 0.6, 1.8), DVec3::new(0.8, 0.0, 0.1), DVec3::new(0.2, -0.9, 0.0));
    let text = format!(
        "{}{CUBE}[[light]]\nkind = \"rectangle\"\ncentre = {:?}\nedge_u = {:?}\nedge_v = {:?}\nradiance = [2, 1, 4]\n",
        view(FROM, TO, [0.0, 1.0, 0.0]),
        centre.to_array(),
        u.to_array(),
        v.to_array()
    );
    // It shines towards u × v, down into the cube; the ray passes behind it.
    assert!(u.cross(v).z < 0.0);
    let rule = gauss_legendre(12);
    let (ray, cube) = (ray(), cube());
    let mut exact = 0.0;
    for (a, weight_a) in &rule {
        for (b, weight_b) in &rule {
            let place = centre + (a - 0.5) * u + (b - 0.5) * v;
            // The point's intensity towards the ray changes along it: thin slices of the ray, each of its own.
            for slice in 0..400 {
                let (near, far) = (0.45, 1.9);
                let [start, end] = [slice, slice + 1].map(|k| near + (far - near) * f64::from(k) / 400.0);
                let point = ray.at(0.5 * (start + end));
                if !(point.cmpge(DVec3::ZERO).all() && point.cmple(DVec3::ONE).all()) {
                    continue;
                }
                let to = place - point;
                let solid_angle = -u.cross(v).dot(to.normalize()) / to.length_squared();
                let before = inside_before(point, ray.direction);
                let towards = inside_before(point, -to.normalize()).min(to.length());
                let phase = phase_value(&cube.phase, ray.direction.dot(to.normalize()));
                let scattered = cube.sigma_t * cube.albedo * phase * solid_angle.max(0.0);
                exact += weight_a
                    * weight_b
                    * (end - start)
                    * scattered
                    * (-cube.sigma_t * (before + towards)).exp();
            }
        }
    }
    let case = Case::new(&text, volume_f32([1, 1, 1], [0.5]));
    let image = Twin::new(&case).image(4000);
    for (channel, radiance) in [2.0, 1.0, 4.0].into_iter().enumerate() {
        // 400 slices: the ends of the chord are met to a slice, 0.4 % of it, and within it to half a slice.
        mean(&image, channel).agrees("rectangle", radiance * exact, family(3), 0.004 * radiance * exact);
    }
}

/// Length of the way inside the unit cube that leads to `point` along `direction`.
fn inside_before(point: DVec3, direction: DVec3) -> f64 {
    let ways = (0..3).map(|axis| match direction[axis] {
        d if d > 0.0 => point[axis] / d,
        d if d < 0.0 => (point[axis] - 1.0) / d,
        _ => f64::INFINITY,
    });
    ways.fold(f64::INFINITY, f64::min)
}

#[test]
fn a_camera_sees_the_front_of_a_rectangle_through_the_medium() {
    for (direction, expected) in [(1.0, (-1.5_f64).exp()), (-1.0, 0.0)] {
        let text = format!(
            "{}{}[[light]]\nkind = \"rectangle\"\ncentre = [0.5, 0.5, 0.5]\nedge_u = [0.2, 0, 0]\n\
             edge_v = [0, {}, 0]\nradiance = 7\n",
            view([0.5, 0.5, 3.0], [0.5, 0.5, 0.5], [0.0, 1.0, 0.0]),
            CUBE.replace("albedo = 0.8", "albedo = 0"),
            0.2 * direction
        );
        let case = Case::new(&text, volume_f32([1, 1, 1], [0.5]));
        let image = Twin::new(&case).image(2);
        assert!((image[0].mean[0] - 7.0 * expected).abs() < 1e-9, "{:?} {expected}", image[0]);
    }
}

#[test]
fn slabs_reflect_and_transmit_as_adding_doubling_says() {
    let folder = tempfile::tempdir().unwrap();
    let map =
        write_map(folder.path(), 1, 4096, |_, y| if y < 2048 { [1.0, 0.0, 1.0] } else { [0.0, 1.0, 1.0] });
    for (tau, albedo, g, mu) in [(2.0, 0.9, 0.75, 1.0), (1.0, 0.5, 0.0, 0.6), (0.5, 1.0, -0.5, 0.3)] {
        let sine = f64::sqrt(1.0 - mu * mu);
        let text = format!(
            "{}[volume]\norigin = \"centre\"\nspacing = [2e4, 1, 2e4]\nwindow = {{ lo = 0, hi = 1 }}\n\
             [medium]\nsigma_max = {tau}\nalbedo = {albedo}\n[phase]\nkind = \"henyey-greenstein\"\ng = {g}\n\
             [transfer]\nresolution = 2\npoints = [{{ value = 0, opacity = 1, color = 1 }}]\n\
             [background]\nenvironment = '{}'\n[method]\nkind = \"multiple-scattering\"\n",
            view([5.0 * sine, 5.0 * mu, 0.0], [0.0; 3], [0.0, 0.0, 1.0]),
            map.display()
        );
        let case = Case::new(&text, volume_f32([1, 1, 1], [0.5]));
        let exact = Slab { tau, albedo, g }.responses(&[mu])[0];
        let (r, t) = (exact.reflected, exact.transmitted);
        agree(&format!("slab {tau} {albedo} {g} {mu}"), &Twin::new(&case).image(3000), [r, t, r + t]);
    }
}

#[test]
fn channels_have_their_own_extinction_and_media_in_equilibrium_do_not_show() {
    let absorber = format!(
        "{}{}[background]\ncolor = [1, 2, 3]\n",
        view([0.5, 0.5, 3.0], [0.5, 0.5, 0.5], [0.0, 1.0, 0.0]),
        CUBE.replace("albedo = 0.8", "albedo = 0\nextinction_color = [1, 0.5, 0]")
    );
    let case = Case::new(&absorber, volume_f32([1, 1, 1], [0.5]));
    let image = Twin::new(&case).image(4000);
    agree("absorber", &image, [(-3.0_f64).exp(), 2.0 * (-1.5_f64).exp(), 3.0]);
    // Everything that light can come from has radiance 1, and so has all that is seen.
    let glowing = format!(
        "{}[volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = 2\nalbedo = [0.9, 0.6, 0.2]\n\
         extinction_color = [1, 0.5, 2]\n[phase]\nkind = \"two-lobe\"\ng = [0.8, -0.4]\nweight = 0.7\n\
         [transfer]\nresolution = 3\npoints = [{{ value = 0, opacity = 1, color = [1, 0.2, 0.5], emission = 1 }},\n\
         {{ value = 1, opacity = 0, color = [0.1, 1, 1], emission = 1 }}]\n[background]\ncolor = 1\n\
         [method]\nkind = \"multiple-scattering\"\n",
        view([-3.0, 9.0, 7.0], [2.0, 2.0, 2.0], [0.0, 1.0, 0.0])
    );
    let case = Case::new(&glowing, noisy([4, 5, 3], 3));
    agree("equilibrium", &Twin::new(&case).image(500), [1.0; 3]);
    // A sphere of emission 1 in a black vacuum that does not scatter: opacity.
    let glow = absorber
        .replace("color = 1 }", "color = 1, emission = 1 }")
        .replace("color = [1, 2, 3]", "color = 0");
    let case = Case::new(&glow, volume_f32([1, 1, 1], [0.5]));
    agree("glow", &Twin::new(&case).image(4000), [1.0 - (-3.0_f64).exp(), 1.0 - (-1.5_f64).exp(), 0.0]);
}

#[test]
fn phase_functions_are_those_of_the_scene() {
    // Rayleigh scattering at right angles is 3/(16π), whatever else.
    assert!((phase_value(&Phase::Rayleigh, 0.0) - 3.0 / (16.0 * PI)).abs() < 1e-15);
    let text = format!(
        "{}{}[[light]]\nkind = \"directional\"\ndirection = [1, 0, 0]\nirradiance = 1\n",
        view([0.5, 0.5, 3.0], [0.5, 0.5, 0.5], [0.0, 1.0, 0.0]),
        CUBE.replace("kind = \"henyey-greenstein\"\ng = 0.4", "kind = \"rayleigh\"")
    );
    let case = Case::new(&text, volume_f32([1, 1, 1], [0.5]));
    let exact = 0.8 * 3.0 / (16.0 * PI) * (1.0 - (-3.0_f64).exp()) * (-1.5_f64).exp();
    agree("rayleigh", &Twin::new(&case).image(2000), [exact; 3]);
}
