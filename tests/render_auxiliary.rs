//! Auxiliary images of scattering renders against closed forms: what camera rays meet first.
//!
//! Tolerances: 6 standard errors of a mean over the samples where a pixel is random, with the deviation of one path
//! known from the closed form or bounded; a few roundings of float32 where it is not.

mod common;

use common::{Case, EPS, close, volume_f32};
use glam::DVec3;
use svetlo::picture::{Picture, Samples};
use svetlo::render::Snapshot;
use svetlo::volume::Volume;

const SIZE: usize = 8;

/// A medium of `medium` and `transfer` between the planes z = 0 and z = 8, seen along +z by parallel rays from z = −4.
fn scene(volume: Volume, text: &str, method: &str) -> Case {
    let text = format!(
        "[image]\nwidth = 4\nheight = 4\n[camera]\nkind = \"orthographic\"\nposition = [4, 4, -4]\ntarget = [4, 4, 0]\n\
         height = 4\n[volume]\nwindow = {{ lo = 0, hi = 1 }}\n[film]\nauxiliary = true\n{text}\n[method]\n{method}\n"
    );
    Case::new(&text, volume)
}

fn constant(value: f64) -> Volume {
    volume_f32([SIZE; 3], vec![value; SIZE.pow(3)])
}

/// A field of the voxels' centres.
fn field(value: impl Fn(DVec3) -> f64) -> Volume {
    let centre = |i: usize| {
        DVec3::new((i % SIZE) as f64, (i / SIZE % SIZE) as f64, (i / SIZE / SIZE) as f64) + DVec3::splat(0.5)
    };
    volume_f32([SIZE; 3], (0..SIZE.pow(3)).map(|i| value(centre(i))))
}

fn picture(case: &Case, samples: u32) -> Picture {
    let mut session = case.session();
    session.render(samples).unwrap();
    Snapshot::take(&session, &case.plan(), "", std::time::Duration::ZERO).unwrap().picture
}

fn plane(picture: &Picture, name: &str) -> Vec<f64> {
    match picture.channel(name) {
        Some(Samples::F32(values)) => values.iter().map(|&value| f64::from(value)).collect(),
        other => panic!("{name}: {other:?}"),
    }
}

fn mean(picture: &Picture, name: &str) -> f64 {
    let values = plane(picture, name);
    values.iter().sum::<f64>() / values.len() as f64
}

/// One colour and one opacity at every value.
fn uniform(opacity: f64, color: &str) -> String {
    format!("[transfer]\npoints = [{{ value = 0, opacity = {opacity}, color = {color} }}]\n")
}

/// Mean and deviation of the depth of collisions in a slab of optical depth `tau` and thickness 8.
fn collision_depths(tau: f64) -> (f64, f64) {
    let taken = -(-tau).exp_m1();
    let first = (taken - tau * (-tau).exp()) / taken;
    let second = (2.0 * taken - (tau * tau + 2.0 * tau) * (-tau).exp()) / taken;
    let per_depth = SIZE as f64 / tau;
    (first * per_depth, (second - first * first).sqrt() * per_depth)
}

/// By look-ups, analog, and in closed form.
const METHODS: [&str; 4] = [
    "kind = \"multiple-scattering\"\nmajorant_scale = 1.5",
    "kind = \"multiple-scattering\"\ntransmittance = \"analog\"",
    "kind = \"single-scattering\"\npaths = 3",
    "kind = \"single-scattering\"\ntransmittance = \"ratio\"\nmajorant_scale = 1.5",
];

#[test]
fn a_homogeneous_slab_has_the_transmittance_and_depths_of_the_exponential() {
    const SAMPLES: u32 = 128;
    for method in METHODS {
        for tau in [0.05_f64, 1.0, 6.0] {
            let medium = format!("{}[medium]\nsigma_max = {}\n", uniform(1.0, "[0.9, 0.6, 0.3]"), tau / 8.0);
            let case = scene(constant(0.5), &medium, method);
            let picture = picture(&case, SAMPLES);
            // 16 pixels; with one path the deviation is at most that of all or nothing.
            let paths = f64::from(SAMPLES) * 16.0;
            let through = (-tau).exp();
            let taken = 1.0 - through;
            let sigma = (through * taken / paths).sqrt();
            let what = format!("tau {tau}, {method}");
            close(&what, mean(&picture, "transmittance"), through, 6.0 * sigma + 4.0 * EPS);
            for (name, albedo) in [("albedo.R", 0.9), ("albedo.G", 0.6), ("albedo.B", 0.3)] {
                close(&what, mean(&picture, name), albedo * taken, 6.0 * albedo * sigma + 16.0 * EPS);
            }
            // What is taken and what is left of the mean ray are 1, to the rounding of the two means.
            close(&what, mean(&picture, "transmittance") + mean(&picture, "A"), 1.0, 16.0 * EPS);
            let (depth, deviation) = collision_depths(tau);
            // Ratio tracking keeps one place per path, weighted by what the path takes: at least `taken` of the paths
            // count fully, and weights between 0 and 1 at most double the variance of their mean.
            let bound = 6.0 * deviation * (2.0 / (paths * taken)).sqrt();
            close(&what, mean(&picture, "Z"), 4.0 + depth, bound + 12.0 * 16.0 * EPS);
            assert!(plane(&picture, "normal.X").iter().all(|&x| x == 0.0), "{what}");
        }
    }
}

#[test]
fn what_rays_miss_is_nothing() {
    let text = format!("{}[medium]\nsigma_max = 1\n", uniform(1.0, "1"));
    let mut case = scene(constant(1.0), &text, METHODS[0]);
    case.scene.camera.position.x += 20.0;
    case.scene.camera.target.x += 20.0;
    let picture = picture(&case, 2);
    for name in ["albedo.R", "albedo.G", "albedo.B", "normal.X", "normal.Y", "normal.Z", "Z"] {
        assert!(plane(&picture, name).iter().all(|&value| value == 0.0), "{name}");
    }
    assert!(plane(&picture, "transmittance").iter().all(|&value| value == 1.0));
}

#[test]
fn normals_of_a_ramp_point_down_it() {
    let slopes = [DVec3::X, DVec3::NEG_Y, DVec3::Z, DVec3::new(0.6, -0.64, 0.48)];
    for slope in slopes {
        // Nothing but the middle of the box has extinction: away from the border, where the gradient is one-sided.
        let centre = DVec3::splat(4.0);
        let text = "[transfer]\npoints = [{ value = 0.46, opacity = 0 }, { value = 0.5, opacity = 1 }, \
                    { value = 0.54, opacity = 0 }]\n[medium]\nsigma_max = 40\n";
        let mut case = scene(field(|p| 0.5 + 0.05 * slope.dot(p - centre)), text, METHODS[0]);
        // The camera looks at the middle from an end of the slope.
        case.scene.camera.position = centre - 8.0 * slope;
        case.scene.camera.target = centre;
        case.scene.camera.up = slope.any_orthogonal_vector();
        let svetlo::scene::CameraKind::Orthographic { height } = &mut case.scene.camera.kind else {
            panic!()
        };
        *height = 0.5;
        let picture = picture(&case, 4);
        let taken = plane(&picture, "A");
        let normals = ["normal.X", "normal.Y", "normal.Z"].map(|name| plane(&picture, name));
        for i in 0..16 {
            assert!(taken[i] > 0.9, "{}", taken[i]);
            let normal = DVec3::from_array(std::array::from_fn(|c| normals[c][i])) / taken[i];
            // Values near 0.5 are rounded to 2^-25 (6 of them take part in each difference of 0.1).
            let error = (normal + slope).length();
            assert!(error < 6.0 * EPS / 0.1 + 16.0 * EPS, "{slope}: {normal}, error {error:e}");
        }
    }
}

#[test]
fn albedo_is_that_of_the_first_collision_through_two_colours() {
    // Red before z = 4, blue behind; opacity is the same everywhere, or not.
    for opacity in [1.0_f64, 0.5] {
        let text = format!(
            "[transfer]\nresolution = 2001\npoints = [{{ value = 0, opacity = {opacity}, color = [1, 0.1, 0] }}, \
             {{ value = 0.4995, opacity = {opacity}, color = [1, 0.1, 0] }}, \
             {{ value = 0.5005, opacity = 1, color = [0, 0.2, 0.8] }}, \
             {{ value = 1, opacity = 1, color = [0, 0.2, 0.8] }}]\n[medium]\nsigma_max = 0.25\n"
        );
        // A steep step: values cross 0.5 at z = 4, in 0.001 of a voxel.
        let volume = || field(|p| if p.z < 4.0 { 0.0 } else { 1.0 });
        for method in [METHODS[0], METHODS[2]] {
            const SAMPLES: u32 = 128;
            let case = scene(volume(), &text, method);
            let picture = picture(&case, SAMPLES);
            let front = (-opacity).exp();
            let (red, blue) = (1.0 - front, front * -(-1.0_f64).exp_m1());
            let paths = f64::from(SAMPLES) * 16.0;
            let expected = [red, 0.1 * red + 0.2 * blue, 0.8 * blue];
            let most = [1.0, 0.2, 0.8];
            for (c, name) in ["albedo.R", "albedo.G", "albedo.B"].into_iter().enumerate() {
                // The deviation of one path is at most half the range; the ramp between the colours is 0.001 thick.
                let bound = 6.0 * 0.5 * most[c] / paths.sqrt() + 0.25 * 1e-3;
                close(&format!("{name}, {opacity}, {method}"), mean(&picture, name), expected[c], bound);
            }
        }
    }
}

#[test]
fn the_images_do_not_depend_on_launches_and_are_only_there_when_wanted() {
    let text = "[transfer]\npoints = [{ value = 0, opacity = 0.2 }, { value = 1, opacity = 1, color = [1, 0.5, 0.2] }]\n\
                [medium]\nsigma_max = 0.4\n";
    let mut case = scene(common::smooth([SIZE; 3], 5), text, METHODS[0]);
    (case.scene.image.width, case.scene.image.height) = (19, 17);
    let plan = case.plan();
    let images = |limit: u64| {
        let mut session = case.session();
        session.limit_launches(limit);
        session.render(3).unwrap();
        session.auxiliary().unwrap().unwrap()
    };
    let whole = images(1000);
    assert_eq!(whole.len(), 19 * 17);
    assert!(whole.iter().any(|pixel| pixel.normal[0] != 0.0));
    for limit in [1, 4] {
        let same = bytemuck::cast_slice::<_, u32>(&images(limit)) == bytemuck::cast_slice::<_, u32>(&whole);
        assert!(same, "{limit}");
    }
    assert!(
        plan.memory().items.iter().any(|(name, bytes)| *name == "auxiliary images" && *bytes == 19 * 17 * 48)
    );
    case.scene.film.auxiliary = false;
    let without = picture(&case, 1);
    for name in ["albedo.R", "normal.X", "transmittance", "Z"] {
        assert_eq!(without.channel(name), None);
    }
    assert_eq!(without.metadata.get("svetlo.auxiliary"), None);
}
