//! Maximum intensity projection against the twin: exact for every voxel type and shape.

mod common;

use common::{Case, EPS, close, noise, report};
use glam::DVec3;
use svetlo::reference::mip::maximum;
use svetlo::volume::{Volume, Voxels};

/// A volume of each voxel type, noise over the type's whole range.
fn volumes(dims: [usize; 3], seed: u32) -> [(&'static str, Volume); 5] {
    let values = noise(dims.iter().product(), seed);
    let scaled = |low: f64, high: f64| values.iter().map(move |v| low + v * (high - low));
    let u8s: Vec<u8> = scaled(0.0, 255.99).map(|v| v as u8).collect();
    let i8s: Vec<i8> = scaled(-128.0, 127.0).map(|v| v.round() as i8).collect();
    let u16s: Vec<u16> = scaled(0.0, 65535.0).map(|v| v as u16).collect();
    let i16s: Vec<i16> = scaled(-32768.0, 32767.0).map(|v| v as i16).collect();
    let f32s: Vec<f32> = scaled(-3.0, 5.0).map(|v| v as f32).collect();
    [
        ("u8", Voxels::U8(u8s)),
        ("i8", Voxels::I8(i8s)),
        ("u16", Voxels::U16(u16s)),
        ("i16", Voxels::I16(i16s)),
        ("f32", Voxels::F32(f32s)),
    ]
    .map(|(name, voxels)| (name, Volume::new(dims, DVec3::new(1.0, 1.25, 0.8), voxels).unwrap()))
}

/// A view of the middle of the box from a corner, its sides or along an axis.
fn text(dims: [usize; 3], direction: [f64; 3], window: &str) -> String {
    let size = DVec3::from_array(dims.map(|n| n as f64)) * DVec3::new(1.0, 1.25, 0.8);
    let eye = 0.5 * size + 3.0 * size.max_element() * DVec3::from_array(direction).normalize();
    format!(
        "[image]\nwidth = 9\nheight = 10\nfilter = \"point\"\n[camera]\nposition = {:?}\ntarget = {:?}\nfov = 25\n\
         up = [0.1, 1, 0.3]\n[volume]\n{window}\n[background]\ncolor = [0.25, 0.5, 0.75]\n[method]\nkind = \"mip\"\n",
        eye.to_array(),
        (0.5 * size).to_array()
    )
}

/// The film against the twin; returns the largest error of the value.
fn check(case: &Case, what: &str) -> f64 {
    let (field, film) = (case.field(), case.film());
    let voxels = *case.volume.dims.iter().max().unwrap() as f64;
    let mut worst: f64 = 0.0;
    for (i, (pixel, ray)) in film.iter().zip(case.rays()).enumerate() {
        let what = format!("{what}, pixel {i}");
        let Some((most, _)) = maximum(&field, &ray) else {
            assert_eq!((pixel.mean(), pixel.hits), ([0.25, 0.5, 0.75, 0.0], 0), "{what}: background");
            continue;
        };
        // Positions round by (voxels + padding)·2^-24 eight times: the ray's point, its direction (three), the time,
        // their product and sum, the grid's scale. Between independent voxels the window value changes by at most 1 per
        // voxel and axis. The maximum is an extremum or an end, and errs by no more.
        let bound = 8.0 * 3.0 * (voxels + 4.0) * EPS + 8.0 * EPS;
        close(&what, pixel.mean()[0], most.clamp(0.0, 1.0), bound);
        worst = worst.max((pixel.mean()[0] - most.clamp(0.0, 1.0)).abs());
        assert_eq!((pixel.mean()[3], pixel.hits), (1.0, 1), "{what}");
        // The depth is a place where the field is that large. Distances are up to 4 boxes long, in local units.
        let depth = f64::from(pixel.depth) * case.plan().local.unit;
        let there = field.value(ray.at(depth));
        close(
            &format!("{what}: value at depth {depth}"),
            there,
            most,
            3.0 * 6.0 * 8.0 * (voxels + 4.0) * EPS + bound,
        );
    }
    worst
}

#[test]
fn equals_the_twin_for_every_voxel_type_and_shape() {
    let mut worst: f64 = 0.0;
    for dims in [[1, 1, 1], [1, 5, 7], [6, 1, 1], [4, 3, 1], [3, 5, 7], [17, 9, 11]] {
        for (name, volume) in volumes(dims, 7) {
            let case = Case::new(&text(dims, [0.7, 0.4, -1.0], ""), volume);
            worst = worst.max(check(&case, &format!("{name} {dims:?}")));
        }
    }
    report("mip", worst, 12.0 * 21.0 * EPS);
}

#[test]
fn equals_the_twin_from_all_sides() {
    let dims = [5, 6, 7];
    let directions = [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
        [-1.0, -2.0, -0.5],
        [1.0, 1.0, 1.0],
    ];
    for direction in directions {
        let [.., (name, volume)] = volumes(dims, 8);
        check(&Case::new(&text(dims, direction, ""), volume), &format!("{name} from {direction:?}"));
    }
}

#[test]
fn values_beyond_the_window_are_clipped() {
    let dims = [4, 5, 6];
    let [.., (name, volume)] = volumes(dims, 9);
    let case = Case::new(&text(dims, [1.0, 0.2, 0.3], "window = { lo = 0, hi = 2 }"), volume);
    check(&case, name);
    assert!(case.film().iter().any(|pixel| pixel.mean()[0] == 1.0), "some are");
}

#[test]
fn floats_may_be_of_any_magnitude() {
    // float32 holds neither the squares of such numbers nor interpolated values between neighbours of 10^6.
    let dims = [4, 5, 6];
    for (low, high) in [(1e6, 1e6 + 1.0), (0.0, 1e-27), (0.0, 1e-40), (0.0, 1e25), (-3e38, 3e38)] {
        let values: Vec<f32> = noise(120, 9).iter().map(|v| (low + v * (high - low)) as f32).collect();
        let volume = Volume::new(dims, DVec3::new(1.0, 1.25, 0.8), Voxels::F32(values)).unwrap();
        check(&Case::new(&text(dims, [1.0, 0.2, 0.3], ""), volume), &format!("{low} to {high}"));
    }
}

#[test]
fn the_maximum_is_that_of_the_data_whatever_the_slope_of_the_file() {
    let dims = [4, 5, 6];
    for (name, mut volume) in volumes(dims, 9) {
        (volume.slope, volume.intercept) = (-0.5, 20.0);
        check(&Case::new(&text(dims, [1.0, 0.2, 0.3], ""), volume), name);
    }
}

#[test]
fn a_colour_map_colours_the_maximum() {
    let dims = [4, 5, 6];
    let [.., (_, volume)] = volumes(dims, 9);
    let text = text(dims, [1.0, 0.2, 0.3], "") + "colormap = \"viridis\"\n";
    let case = Case::new(&text, volume);
    let field = case.field();
    for (pixel, ray) in case.film().iter().zip(case.rays()) {
        let Some((most, _)) = maximum(&field, &ray) else { continue };
        let exact = svetlo::transfer::map_color(svetlo::scene::ColorMap::Viridis, most);
        for (found, exact) in pixel.mean().into_iter().zip(exact) {
            // The map has knots and the device's table 1024 entries, so that a bend of the map may be cut off: by a
            // quarter of an interval's change, and linear colours change by less than 8 over the whole map. The value
            // itself is right to 1e-6 (see above).
            close("colour", found, exact, 8.0 * (0.25 / 1023.0 + 1e-6));
        }
    }
}
