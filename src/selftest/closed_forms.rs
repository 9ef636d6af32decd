//! Checks of the methods without chance: emission-absorption, maximum intensity, isosurfaces.

use super::workbench::{Case, EPS, Measurement, Workbench, maximum, noise, volume};
use crate::Result;
use crate::film::FilmPixel;
use crate::reference::camera::{Ray, central_ray};
use crate::reference::emission_absorption::Integrator;
use crate::reference::field::Field;
use crate::reference::isosurface::first_hit;
use crate::reference::medium::Medium;
use crate::reference::mip::maximum as largest_value;

/// Voxels per edge of the noisy volumes.
const N: usize = 12;

/// A view of them from a corner; all rays hit the box.
const CORNER: &str = "[image]\nwidth = 16\nheight = 16\nfilter = \"point\"\n[camera]\nposition = [31, 25, -19]\n\
                      target = [6, 6, 6]\nfov = 12\n[volume]\nwindow = { lo = 0, hi = 1 }\n";

/// A parallel view of an n³ box along z, `height` of its middle.
fn along_z(n: usize, height: f64) -> String {
    let middle = 0.5 * n as f64;
    format!(
        "[image]\nwidth = 16\nheight = 16\nfilter = \"point\"\n[camera]\nkind = \"orthographic\"\n\
         position = [{middle}, {middle}, {}]\ntarget = [{middle}, {middle}, 0]\nheight = {height}\n\
         [volume]\nwindow = {{ lo = 0, hi = 1 }}\n",
        3 * n
    )
}

/// L = c L₀ (1 − e^(−τ)) + e^(−τ) L_background (Max 1995), per cell and by steps, and the opacity of uneven layers.
pub fn emission_absorption(bench: &Workbench) -> Result<Vec<Measurement>> {
    let (color, l0, background) = ([1.0, 0.5, 0.25], 3.0, 0.7);
    let mut measurements = Vec::new();
    for (name, quadrature, parts) in
        [("per cell", "", 8.0), ("by steps", "quadrature = \"step\"\nstep = 0.37\njitter = true", 23.0)]
    {
        let mut worst: f64 = 0.0;
        for tau in [1e-3, 1.0, 4.0, 20.0] {
            let text = format!(
                "{}[transfer]\npoints = [{{ value = 0.5, opacity = 1, color = {color:?} }}]\n\
                 [medium]\nsigma_max = {}\n[background]\ncolor = {background}\n\
                 [method]\nkind = \"emission-absorption\"\nradiance = {l0}\ntermination = 0\n{quadrature}\n",
                along_z(8, 4.0),
                tau / 8.0
            );
            let rendered = bench.render(&Case::new(&text, volume([8; 3], vec![0.3; 512])?)?, 1)?;
            for (channel, color) in color.into_iter().enumerate() {
                let exact = color * l0 * -f64::exp_m1(-tau) + f64::exp(-tau) * background;
                worst = maximum(worst, rendered.largest_error(channel..channel + 1, exact));
            }
        }
        measurements.push(Measurement::within(
            format!("constant medium, {name}: largest error of radiance up to 3"),
            worst,
            0.0,
            8.0 * parts * EPS * (l0 + background) / std::f64::consts::E,
            format!("8 roundings in each of {parts} parts, through T τ ≤ 1/e"),
        ));
    }
    measurements.push(layers(bench)?);
    measurements.push(random_voxels(bench)?);
    Ok(measurements)
}

/// Between voxel centres the extinction is linear, beyond them constant: the optical depth is the sum of the voxels.
fn layers(bench: &Workbench) -> Result<Measurement> {
    let n = 24;
    let heights: Vec<f64> = noise(n, 31).iter().map(|v| f64::from(*v as f32)).collect();
    let tau = 0.1 * heights.iter().sum::<f64>();
    let text = format!(
        "{}[medium]\nsigma_max = 0.1\n[transfer]\nresolution = 2\n\
         [method]\nkind = \"emission-absorption\"\ntermination = 0\n",
        along_z(n, 12.0)
    );
    let uneven = volume([n; 3], (0..n * n * n).map(|i| heights[i / (n * n)]))?;
    let rendered = bench.render(&Case::new(&text, uneven)?, 1)?;
    Ok(Measurement::within(
        "uneven layers, per cell: largest error of opacity",
        rendered.largest_error(3..4, -f64::exp_m1(-tau)),
        0.0,
        8.0 * (n + 1) as f64 * EPS / std::f64::consts::E,
        "8 roundings in each of 25 cells, through T τ ≤ 1/e",
    ))
}

/// Independent voxels seen from a corner, against the integral of the cubics in float64.
fn random_voxels(bench: &Workbench) -> Result<Measurement> {
    let text = format!(
        "{CORNER}[medium]\nsigma_max = 0.2\n[method]\nkind = \"emission-absorption\"\ntermination = 0\n"
    );
    let case = Case::new(&text, volume([N; 3], noise(N * N * N, 8))?)?;
    let (field, rays) = field_and_rays(&case)?;
    let plan = case.plan()?;
    let medium =
        Medium::new(&case.scene.transfer, &case.scene.medium, plan.volume()?.window, plan.local.unit)?;
    let integrator = Integrator::new(&field, &medium);
    let rendered = bench.render(&case, 1)?;
    let error = |(pixel, ray): (&FilmPixel, &Ray)| {
        (pixel.mean()[3] - (1.0 - integrator.ray(ray).transmittance())).abs()
    };
    // A ray crosses up to 3·12 cells; positions up to 16 on three axes move its values by so many roundings.
    let roundings = 8.0 * (3 * N) as f64 + 4.0 * 3.0 * (N + 4) as f64;
    Ok(Measurement::within(
        "random voxels, per cell: largest error of opacity",
        rendered.film.iter().zip(&rays).map(error).fold(0.0, maximum),
        0.0,
        roundings * EPS / std::f64::consts::E,
        "8 roundings in each of 36 cells, 4 of positions on three axes, through T τ ≤ 1/e",
    ))
}

/// The field and the rays through the pixels' centres, as the twins see them.
fn field_and_rays(case: &Case) -> Result<(Field, Vec<Ray>)> {
    let plan = case.plan()?;
    let field = Field::new(
        &case.volume,
        plan.local.origin,
        plan.local.spacing * plan.local.unit,
        plan.volume()?.window,
    );
    let image = case.scene.image;
    let pixels = (0..image.height).flat_map(|y| (0..image.width).map(move |x| [x, y]));
    Ok((field, pixels.map(|pixel| central_ray(&case.scene.camera, &image, pixel)).collect()))
}

/// Independent voxels seen from a corner, against the maxima of the cubics in float64.
pub fn mip(bench: &Workbench) -> Result<Vec<Measurement>> {
    let case =
        Case::new(&format!("{CORNER}[method]\nkind = \"mip\"\n"), volume([N; 3], noise(N * N * N, 4))?)?;
    let (field, rays) = field_and_rays(&case)?;
    let rendered = bench.render(&case, 1)?;
    let error = |(pixel, ray): (&FilmPixel, &Ray)| {
        let exact = largest_value(&field, ray).map_or(f64::NAN, |(value, _)| value);
        (pixel.mean()[0] - exact).abs()
    };
    Ok(vec![Measurement::within(
        "largest error of the maximum",
        rendered.film.iter().zip(&rays).map(error).fold(0.0, maximum),
        0.0,
        (12.0 * (N as f64 + 4.0) + 8.0) * EPS,
        "4 roundings of positions up to 16 on three axes, slopes up to 1",
    )])
}

/// The middle of a sphere, where rays meet it at no more than 30° from the normal.
pub fn isosurface(bench: &Workbench) -> Result<Vec<Measurement>> {
    let n: usize = 8;
    let text = "[image]\nwidth = 16\nheight = 16\nfilter = \"point\"\n[camera]\nkind = \"orthographic\"\n\
                position = [16, 13, -10]\ntarget = [4, 4, 4]\nheight = 2.25\n[volume]\nwindow = { lo = 0, hi = 1 }\n\
                [method]\nkind = \"isosurface\"\nvalue = 0.5\n";
    let place = |i: usize| (i as f64 + 0.5) / n as f64 - 0.5;
    let radius = |i: usize| glam::DVec3::new(place(i % n), place(i / n % n), place(i / (n * n))).length();
    // The surface of radius 0.3; the value falls by 1/n per voxel.
    let case = Case::new(text, volume([n; 3], (0..n * n * n).map(|i| 0.8 - radius(i)))?)?;
    let (field, rays) = field_and_rays(&case)?;
    let rendered = bench.render(&case, 1)?;
    let error = |(pixel, ray): (&FilmPixel, &Ray)| match first_hit(&field, ray, 0.5) {
        Some(exact) if pixel.hits == 1 => (f64::from(pixel.depth) - exact).abs(),
        _ => f64::NAN,
    };
    let worst = rendered.film.iter().zip(&rays).map(error).fold(0.0, maximum);
    let size = n as f64;
    // 42° at the picture's corners; interpolation flattens the field a little.
    let slope = 0.6 / size;
    Ok(vec![Measurement::within(
        "sphere: largest error of the hit, in voxels",
        worst,
        0.0,
        8.0 * EPS * (4.0 * size + (size + 4.0) / (size * slope)),
        "8 roundings of distances up to 4 boxes, and of the field over its slope",
    )])
}
