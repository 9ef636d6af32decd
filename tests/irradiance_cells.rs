//! The medium in the cells of a light volume against its twin in double precision.

mod common;

use common::{Case, EPS, close, device, noisy, report, smooth, volume_f32};
use glam::DVec3;
use std::f64::consts::PI;
use svetlo::device::Buffer;
use svetlo::irradiance::{Cells, LightGrid, LitMedium};
use svetlo::reference::field::Field;
use svetlo::reference::medium::Medium;
use svetlo::scene::Transfer;
use svetlo::transfer::{TransferFunction1d, TransferFunction2d};
use svetlo::volume::Volume;

const VIEW: &str = "[camera]\nposition = [20, 4, 3]\ntarget = [3, 4, 3]\nfov = 30\n\
                    [method]\nkind = \"single-scattering\"\n";

const ONE_D: &str = "resolution = 6\npoints = [{ value = 0.2, opacity = 0, color = [1, 0.3, 0.1] },\n\
                     { value = 0.6, opacity = 0.9, color = [0.9, 0.9, 0.5] }, { value = 0.8, opacity = 0.2, color = [0.1, 0.8, 1] }]";
const GLOWING: &str = "resolution = 6\npoints = [{ value = 0.2, opacity = 0, color = [1, 0.3, 0.1] },\n\
                       { value = 0.6, opacity = 0.9, color = [0.9, 0.9, 0.5], emission = [3, 1, 0] },\n\
                       { value = 0.8, opacity = 0.4, color = 0, emission = [0, 0, 5] }]";
const TWO_D: &str = "kind = \"2d\"\nresolution = [9, 7]\ngradient_max = 0.6\nshapes = [\n\
                     { shape = \"ellipse\", centre = [0.5, 0.4], size = [0.9, 0.9], color = [0.9, 0.8, 0.3], opacity = 0.9, softness = 0.7 },\n\
                     { shape = \"triangle\", centre = [0.7, 0.5], size = [0.5, 1], color = [0.2, 0.6, 1], opacity = 0.7, softness = 0.3 }]";

/// Voxels half a scene unit wide on the shortest axis, so that local units are others than the scene's.
fn case(transfer: &str, medium: &str, volume: Volume) -> Case {
    let text = format!(
        "{VIEW}[volume]\nspacing = [0.5, 0.8, 0.6]\nwindow = {{ lo = 0, hi = 1 }}\n[transfer]\n{transfer}\n\
         [medium]\nsigma_max = 1.6\n{medium}\n"
    );
    Case::new(&text, volume)
}

/// Scattering, absorption and emitted power of every cell, per local unit.
fn on_the_device(case: &Case, coarsening: usize) -> (LightGrid, [Vec<[f32; 4]>; 3]) {
    let (device, plan) = (device(), case.plan());
    let medium = LitMedium::new(&device, &plan, &plan.method).unwrap();
    let grid = LightGrid::new(&plan.local, coarsening);
    let cells = Cells::new(&device, &medium, &grid).unwrap();
    let read = |buffer: &Buffer<[f32; 4]>| buffer.read(&device).unwrap();
    let glow = cells.glow.as_ref().map_or_else(|| vec![[0.0; 4]; grid.cells()], read);
    (grid, [read(&cells.scattering), read(&cells.absorption), glow])
}

/// The same at a point in scene units.
fn at_point(
    case: &Case,
    (field, medium, emission): (&Field, &Medium, Option<&Medium>),
    unit: f64,
    point: DVec3,
) -> [[f64; 3]; 3] {
    let value = field.value(point);
    let gradient = if medium.gradients > 1 { field.gradient(point).length() } else { 0.0 };
    let [r, g, b, sigma] = medium.at(value, gradient);
    let glow = emission.map_or([0.0; 4], |emission| emission.at(value, gradient));
    let scene = case.scene.scattering;
    let extinction = scene.extinction_color.unwrap_or([1.0; 3]);
    let scattering: [f64; 3] = std::array::from_fn(|c| unit * extinction[c] * scene.albedo[c] * [r, g, b][c]);
    let absorption = std::array::from_fn(|c| unit * extinction[c] * sigma - scattering[c]);
    [scattering, absorption, std::array::from_fn(|c| 4.0 * PI * absorption[c] * glow[c])]
}

fn emission(case: &Case, medium: &Medium) -> Option<Medium> {
    let table = match &case.scene.transfer {
        Transfer::OneD(settings) => TransferFunction1d::from_settings(settings, (0.0, 1.0)).emission,
        Transfer::TwoD(settings) => TransferFunction2d::from_settings(settings).unwrap().emission,
    };
    let entries = table?.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect();
    Some(Medium { entries, ..medium.clone() })
}

#[test]
fn cells_are_the_means_of_the_points_that_the_twin_sees() {
    for (name, transfer, medium, volume) in [
        ("one-dimensional", ONE_D, "albedo = [1, 0.9, 0.5]", noisy([5, 4, 6], 3)),
        ("a ramp", "resolution = 2", "albedo = 0.9", noisy([5, 4, 6], 4)),
        ("two-dimensional", TWO_D, "", smooth([5, 4, 6], 5)),
        ("glowing", GLOWING, "albedo = 0.7", noisy([5, 4, 6], 6)),
        ("chromatic", ONE_D, "extinction_color = [0.5, 2, 0]", noisy([5, 4, 6], 7)),
        ("glowing and chromatic", GLOWING, "extinction_color = [0.2, 1, 3]", noisy([5, 4, 6], 8)),
        ("thin", ONE_D, "", noisy([1, 7, 1], 9)),
    ] {
        let case = case(transfer, medium, volume);
        let plan = case.plan();
        let (field, table) = (case.field(), case.medium());
        let glow = emission(&case, &table);
        let twin = (&field, &table, glow.as_ref());
        for coarsening in [1, 2, 4] {
            let (grid, found) = on_the_device(&case, coarsening);
            let [nx, ny, _] = grid.dims;
            let points =
                std::array::from_fn::<_, 3, _>(|axis| 2 * plan.local.dims[axis].div_ceil(grid.dims[axis]));
            let mut worst = 0.0_f64;
            for index in 0..grid.cells() {
                let cell =
                    DVec3::new((index % nx) as f64, (index / nx % ny) as f64, (index / nx / ny) as f64);
                let mut mean = [[0.0; 3]; 3];
                for k in 0..points.iter().product() {
                    let place = [k % points[0], k / points[0] % points[1], k / points[0] / points[1]];
                    let place = DVec3::from_array(std::array::from_fn(|a| {
                        (place[a] as f64 + 0.5) / points[a] as f64
                    }));
                    let point = plan.local.origin + (cell + place) * grid.cell * plan.local.unit;
                    for (sum, part) in mean.iter_mut().zip(at_point(&case, twin, plan.local.unit, point)) {
                        (0..3).for_each(|c| sum[c] += part[c] / points.iter().product::<usize>() as f64);
                    }
                }
                for (which, what) in ["scattering", "absorption", "glow"].into_iter().enumerate() {
                    for c in 0..3 {
                        // Places are known to two roundings of a coordinate of 8, over which the table's steepest
                        // piece (0.9 within 0.4, over 0.8 in two dimensions) and its emission (5) change.
                        let bound =
                            2.0 * EPS * 8.0 * if which == 2 { 4.0 * PI * 5.0 } else { 1.0 } * 1.6 * 3.0;
                        let value = f64::from(found[which][index][c]);
                        close(&format!("{name}, {what} of {cell}"), value, mean[which][c], bound);
                        worst = worst.max((value - mean[which][c]).abs() / bound);
                    }
                }
            }
            report(&format!("{name} / {coarsening}, of the bound"), worst, 1.0);
        }
    }
}

#[test]
fn a_constant_medium_is_that_in_every_cell() {
    let case = case(
        "resolution = 2\npoints = [{ value = 0, opacity = 0 }, { value = 1, opacity = 1 }]",
        "albedo = [0.25, 0.5, 1]",
        volume_f32([3, 5, 2], [0.5; 30]),
    );
    for coarsening in [1, 3] {
        let (_, [scattering, absorption, glow]) = on_the_device(&case, coarsening);
        // 0.5 of 1.6 per scene unit, of which the shortest spacing is half. A sum over the points rounds as often.
        let bound = (2 * coarsening).pow(3) as f64 * EPS;
        for (c, albedo) in [0.25, 0.5, 1.0].into_iter().enumerate() {
            for (s, a) in scattering.iter().zip(&absorption) {
                close("scattering", s[c].into(), 0.4 * albedo, 0.4 * bound);
                close("absorption", a[c].into(), 0.4 * (1.0 - albedo), 0.4 * bound);
            }
        }
        assert!(glow.into_iter().flatten().all(|power| power == 0.0));
    }
}

#[test]
fn nothing_is_in_an_empty_volume() {
    let case = case(ONE_D, "", volume_f32([4, 4, 4], [0.0; 64]));
    let (_, fields) = on_the_device(&case, 1);
    assert!(fields.into_iter().flatten().flatten().all(|number| number == 0.0));
}
