//! Isosurfaces against the twin: hit distance, missed crossings, normals and shading.

mod common;

use common::{Case, EPS, close, largest, noisy, report, smooth, volume_f32};
use glam::DVec3;
use svetlo::reference::isosurface::{first_hit, normal, shade};
use svetlo::scene::Method;
use svetlo::volume::Volume;

/// A perspective view of a box of `n`³ voxels of spacing 1, 16×16 pixels.
fn view(n: usize) -> String {
    let (size, middle) = (n as f64, 0.5 * n as f64);
    format!(
        "[image]\nwidth = 16\nheight = 16\nfilter = \"point\"\n[camera]\nposition = [{}, {}, {}]\n\
         target = [{middle}, {middle}, {middle}]\nfov = 13\n[volume]\nwindow = {{ lo = 0, hi = 1 }}\n",
        3.0 * size,
        1.7 * size,
        -0.9 * size
    )
}

fn surface(n: usize, volume: Volume, iso: f64, rest: &str) -> Case {
    Case::new(&format!("{}[method]\nkind = \"isosurface\"\nvalue = {iso}\n{rest}", view(n)), volume)
}

/// 0.5 + signed distance to a sphere in units of the box, as the procedural field has it.
fn sphere(n: usize) -> Volume {
    let at = |i: usize| (i as f64 + 0.5) / n as f64 - 0.5;
    let value = move |i: usize| 0.8 - DVec3::new(at(i % n), at(i / n % n), at(i / (n * n))).length();
    volume_f32([n; 3], (0..n * n * n).map(value))
}

/// Compares hit or miss and the distance with the twin; returns the hits, and the largest error in voxels of those
/// where an error of the window value moves the hit by less than `steep` voxels per unit.
fn distances(case: &Case, steep: f64) -> (usize, f64) {
    let Method::Isosurface { value, .. } = case.scene.method else { unreachable!() };
    let field = case.field();
    let mut hits = 0;
    let errors = case.film().into_iter().zip(case.rays()).enumerate().filter_map(|(i, (pixel, ray))| {
        let exact = first_hit(&field, &ray, value);
        // A ray that grazes the surface may fall on either side by rounding: it is skipped when the twin disagrees
        // with itself about an iso value that is 1e-5 away.
        let steady = [-1e-5, 1e-5].map(|d| first_hit(&field, &ray, value + d));
        let near = |other: &Option<f64>| match (exact, other) {
            (Some(a), Some(b)) => (a - b).abs() < 1e-2,
            (a, b) => a.is_none() && b.is_none(),
        };
        if !steady.iter().all(near) {
            return None;
        }
        assert_eq!(pixel.hits == 1, exact.is_some(), "pixel {i}: {exact:?}");
        assert_eq!(pixel.mean()[3], f64::from(pixel.hits));
        hits += usize::from(exact.is_some());
        // An error of the field moves the hit by itself over the slope along the ray, which the twin measures too.
        let condition =
            steady.iter().flatten().zip(exact).map(|(b, a)| (a - b).abs() / 1e-5).fold(1.0, f64::max);
        exact.map(|t| ((f64::from(pixel.depth) - t).abs(), condition))
    });
    let errors: Vec<_> = errors.collect();
    // Positions and distances round by up to 4 boxes' length; the field by a few units more.
    let size = *case.volume.dims.iter().max().unwrap() as f64;
    for (error, condition) in &errors {
        let bound = 8.0 * EPS * (4.0 * size + condition * (size + 4.0));
        assert!(*error <= bound, "{error} > {bound} (condition {condition})");
    }
    let steep: Vec<f64> =
        errors.iter().filter(|(_, condition)| *condition < steep).map(|(error, _)| *error).collect();
    assert!(2 * steep.len() > hits, "{} of {hits}", steep.len());
    (hits, largest(steep))
}

#[test]
fn the_sphere_is_hit_within_a_ten_thousandth_of_a_voxel() {
    for n in [8, 32, 64] {
        // The field rises by 1/n per voxel: all rays but those that hit at less than 15° from the surface.
        let (hits, error) = distances(&surface(n, sphere(n), 0.5, ""), 4.0 * n as f64);
        assert!(hits > 50, "{hits}");
        report(&format!("sphere {n}, voxels"), error, 1e-4);
        assert!(error <= 1e-4, "{n}: {error}");
    }
}

#[test]
fn noise_is_hit_where_the_twin_says_so() {
    for (seed, iso) in [(1, 0.5), (2, 0.8), (3, 0.9), (4, 0.2)] {
        let (hits, error) = distances(&surface(8, noisy([8; 3], seed), iso, ""), 20.0);
        assert!(hits > 20, "{hits}");
        report(&format!("noise, iso {iso}, voxels"), error, 1e-4);
    }
    let (hits, error) = distances(&surface(8, smooth([8; 3], 5), 0.5, ""), 50.0);
    assert!(hits > 50 && error < 1e-4, "{hits} {error}");
}

#[test]
fn thin_double_crossings_inside_a_cell_are_seen() {
    // Diagonally opposite edges of a cell are high: along the other diagonal the field is a parabola that peaks in
    // the middle of the cell, above both ends: v(s) = 2 s (1 − s) with iso just below ½.
    let values = [0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0];
    for iso in [0.3, 0.45, 0.499, 0.4999] {
        let text = format!(
            "[image]\nwidth = 1\nheight = 1\nfilter = \"point\"\n[camera]\nposition = [-1, -1, 1]\ntarget = [1, 1, 1]\n\
             up = [0, 0, 1]\n[volume]\nwindow = {{ lo = 0, hi = 1 }}\n[method]\nkind = \"isosurface\"\nvalue = {iso}\n"
        );
        let film = Case::new(&text, volume_f32([2; 3], values)).film();
        // 2 s (1 − s) = iso, from the voxel centre at (½, ½), which is 1.5·√2 away.
        let s: f64 = 0.5 - f64::sqrt(0.25 - 0.5 * iso);
        let exact = (1.5 + s) * 2.0_f64.sqrt();
        assert_eq!(film[0].hits, 1, "iso {iso}");
        // The slope there is 2 − 4 s: rounding of the field (a few 2^-24) is divided by it.
        close(
            &format!("iso {iso}"),
            f64::from(film[0].depth),
            exact,
            16.0 * EPS * (1.0 + 1.0 / (1.0 - 2.0 * s)) * 4.0,
        );
    }
    let above = Case::new(
        "[image]\nwidth = 1\nheight = 1\nfilter = \"point\"\n[camera]\nposition = [-1, -1, 1]\ntarget = [1, 1, 1]\n\
         up = [0, 0, 1]\n[volume]\nwindow = { lo = 0, hi = 1 }\n[method]\nkind = \"isosurface\"\nvalue = 0.5001\n",
        volume_f32([2; 3], values),
    );
    assert_eq!(above.film()[0].hits, 0);
}

const LIGHTS: [&str; 4] = [
    "",
    "[[light]]\nkind = \"directional\"\ndirection = [-1, -0.3, 0.5]\nirradiance = [3, 2, 1]\n",
    "[[light]]\nkind = \"point\"\nposition = [30, 40, -20]\nintensity = [900, 600, 300]\n",
    "[[light]]\nkind = \"point\"\nposition = [40, 10, -30]\nintensity = 800\n\
     [[light]]\nkind = \"directional\"\ndirection = [0, -1, 0]\nirradiance = [0, 1, 2]\n",
];

#[test]
fn normals_and_shading_are_those_of_the_twin() {
    for lights in LIGHTS {
        for spacing in ["1", "[1, 1.5, 0.7]"] {
            let material =
                "color = [0.8, 0.5, 0.2]\nambient = 0.1\ndiffuse = 0.7\nspecular = 0.4\nshininess = 8\n";
            let text = format!("{}[method]\nkind = \"isosurface\"\nvalue = 0.5\n{material}{lights}", view(8))
                .replace("[volume]", &format!("[volume]\nspacing = {spacing}"));
            let case = Case::new(&text, smooth([8; 3], 5));
            let Method::Isosurface { material, .. } = &case.scene.method else { unreachable!() };
            let field = case.field();
            let mut errors = Vec::new();
            for (pixel, ray) in case.film().into_iter().zip(case.rays()) {
                if pixel.hits == 0 {
                    continue;
                }
                // Shaded where the device hit, so that only the shading is compared.
                let point = ray.at(f64::from(pixel.depth) * case.plan().local.unit);
                let gradient = field.gradient(point).length();
                let normal = normal(&field, point, ray.direction);
                if normal.dot(ray.direction).abs() < 1e-3 {
                    continue; // which side is seen is a matter of rounding
                }
                let exact = shade(material, &case.scene.lights, point, normal, ray.direction);
                for (found, exact) in pixel.mean().into_iter().zip(exact) {
                    // The gradient's six values (up to 1, at places of up to 12 grid units) are rounded, which turns
                    // the normal by that over the gradient's length.
                    let bound = EPS * (6.0 + 12.0) / gradient;
                    close("radiance", found, exact, bound);
                    errors.push((found - exact).abs() / bound);
                }
            }
            // A third of the values of the picture, so that the surface is seen at many angles.
            assert!(errors.len() > 100, "{}", errors.len());
            report(&format!("shading, spacing {spacing}, of its bound"), largest(errors), 1.0);
        }
    }
}

#[test]
fn the_normals_of_the_sphere_point_outwards() {
    // A headlight without ambient and specular terms shows albedo times the cosine between normal and view.
    let n = 32;
    let case = surface(n, sphere(n), 0.5, "color = 1\nambient = 0\ndiffuse = 1\nspecular = 0\n");
    for (pixel, ray) in case.film().into_iter().zip(case.rays()) {
        if pixel.hits == 1 {
            let radial = (ray.at(f64::from(pixel.depth)) - DVec3::splat(0.5 * n as f64)).normalize();
            // Interpolation and central differences are second order: curvature 1/(0.3 n) per voxel, squared.
            let bound = (1.0 / (0.3 * n as f64)).powi(2);
            close("cosine", pixel.mean()[0], -radial.dot(ray.direction), bound);
        }
    }
}

#[test]
fn what_misses_the_surface_is_background() {
    let case = surface(8, volume_f32([8; 3], vec![0.2; 512]), 0.5, "[background]\ncolor = [1, 2, 3]\n");
    for pixel in case.film() {
        assert_eq!((pixel.mean(), pixel.hits), ([1.0, 2.0, 3.0, 0.0], 0));
    }
}
