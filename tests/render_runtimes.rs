//! All OpenCL runtimes make the same pictures, whether they follow paths side by side or one by one.
//!
//! These tests compare devices of several runtimes in one process: `scripts/test` runs them where there are several.

mod common;

use common::scattering::{all_finite, family, write_map};
use common::{Case, smooth};
use svetlo::device::{Catalog, Device, DeviceInfo};
use svetlo::film::FilmPixel;
use svetlo::picture::write_exr;
use svetlo::render::{Saved, Session, Snapshot, data_hash};

const SIDE: u32 = 12;
const SAMPLES: u32 = 48;

/// Films of a scene on every device there is, with their names.
fn films(text: &str, seed: impl Fn(usize) -> usize) -> Vec<(String, Vec<FilmPixel>)> {
    let catalog = Catalog::enumerate();
    assert!(catalog.devices.len() > 1, "there is one device only: nothing to compare");
    let film = |(k, info): (usize, &svetlo::device::DeviceInfo)| {
        let case = Case::new(&format!("seed = {}\n{text}", seed(k)), smooth([11, 9, 10], 4));
        let mut session = Session::new(Device::open(info).unwrap(), &case.plan()).unwrap();
        session.render(SAMPLES).unwrap();
        let film = session.film().unwrap();
        all_finite(&film);
        (format!("{}, {}", info.platform, info.name), film)
    };
    catalog.devices.iter().enumerate().map(film).collect()
}

/// Differences of two films and what their variances say they should be, per value that has any.
fn differences(a: &[FilmPixel], b: &[FilmPixel]) -> Vec<(f64, f64)> {
    let of_pixel = |(a, b): (&FilmPixel, &FilmPixel)| {
        let (values, variances) = ([a.mean(), b.mean()], [a.variance().unwrap(), b.variance().unwrap()]);
        [0, 1, 2].map(|c| {
            let variance = (variances[0][c] + variances[1][c]) / f64::from(SAMPLES);
            (values[0][c] - values[1][c], variance.sqrt())
        })
    };
    a.iter()
        .zip(b)
        .flat_map(of_pixel)
        .filter(|&(difference, sigma)| difference != 0.0 || sigma > 0.0)
        .collect()
}

/// The differences of two films as a share of their noise, in the root mean square.
fn ratio(a: &[FilmPixel], b: &[FilmPixel]) -> f64 {
    let values = differences(a, b);
    let sum = |f: fn(&(f64, f64)) -> f64| values.iter().map(f).sum::<f64>();
    (sum(|v| v.0 * v.0) / sum(|v| 0.5 * v.1 * v.1)).sqrt()
}

fn scene(method: &str) -> String {
    format!(
        "[image]\nwidth = {SIDE}\nheight = {SIDE}\n[camera]\nposition = [24, 19, -17]\ntarget = [5, 4, 5]\nfov = 20\n\
         [volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = 1.2\n\
         [transfer]\npoints = [{{ value = 0.3, opacity = 0, color = [1, 0.6, 0.3] }}, {{ value = 0.8, opacity = 1, color = 0.9 }}]\n\
         [[light]]\nkind = \"directional\"\ndirection = [0.3, -1, 0.8]\nirradiance = [1, 2, 3]\n{method}"
    )
}

/// What the kernels can be made of: all of their larger parts.
fn scenes() -> Vec<String> {
    let map = write_map(std::path::Path::new(env!("CARGO_TARGET_TMPDIR")), 8, 4, |x, y| {
        if (x, y) == (2, 1) { [12.0; 3] } else { [0.2, 0.3, 0.9 - 0.1 * x as f32] }
    });
    let sky = format!("[background]\nenvironment = '{}'\n", map.display());
    let glass = "[background]\ncolor = [0.2, 0.5, 1]\n";
    [
        format!("{glass}[method]\nkind = \"single-scattering\"\n"),
        format!("{sky}sampling = \"importance\"\n[method]\nkind = \"multiple-scattering\"\n[phase]\nkind = \"rayleigh\"\n"),
        format!(
            "{glass}[[light]]\nkind = \"point\"\nposition = [5, 5, 6]\nintensity = 3\n\
             [[light]]\nkind = \"rectangle\"\ncentre = [3, 12, 1]\nedge_u = [6, 0, 1]\nedge_v = [0, -1, 5]\nradiance = 2\n\
             [method]\nkind = \"multiple-scattering\"\n[phase]\nkind = \"henyey-greenstein\"\ng = 0.7\n"
        ),
        format!("{glass}[method]\nkind = \"single-scattering\"\ntransmittance = \"residual-ratio\"\n"),
    ]
    .map(|method| scene(&method))
    .to_vec()
}

/// With the same random numbers, paths differ only where rounding turns a decision: one in 10⁵ or so, and a path that
/// turned off changes its pixel by the noise of one path. A twentieth of the noise is one path in 800.
#[test]
#[ignore = "needs several runtimes"]
fn the_same_random_numbers_make_the_same_picture() {
    for text in scenes() {
        let films = films(&text, |_| 1);
        for (name, film) in &films[1..] {
            let ratio = ratio(&films[0].1, film);
            println!("{name}: differs from {} by {ratio:.1e} of the noise", films[0].0);
            assert!(ratio < 0.05, "{name} differs from {} by {ratio} of the noise in\n{text}", films[0].0);
        }
    }
}

/// Half of the samples on one device, and through a file the other half on another.
fn continued(case: &Case, first: &DeviceInfo, second: &DeviceInfo) -> Vec<FilmPixel> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.exr");
    let plan = case.plan();
    let data = data_hash(&plan, &case.volume).unwrap();
    let mut session = Session::new(Device::open(first).unwrap(), &plan).unwrap();
    session.render(SAMPLES / 2).unwrap();
    let snapshot = Snapshot::take(&session, &plan, &data, std::time::Duration::ZERO).unwrap();
    write_exr(&path, &snapshot.picture).unwrap();
    let saved = Saved::open(&path, &case.scene).unwrap().expect("the file is there");
    assert!(saved.origin().note(&[second.names()]).expect("a note").contains("was begun elsewhere"));
    let mut session = Session::new(Device::open(second).unwrap(), &plan).unwrap();
    session.restore(&saved.film(&plan, &data).unwrap()).unwrap();
    session.render(SAMPLES).unwrap();
    session.film().unwrap()
}

/// A render that is stopped on one device and resumed on another is the same picture, as in the test above.
#[test]
#[ignore = "needs several runtimes"]
fn a_render_that_goes_on_elsewhere_is_the_same_picture() {
    let catalog = Catalog::enumerate();
    let case = Case::new(&format!("seed = 1\n{}", scenes()[1]), smooth([11, 9, 10], 4));
    let mut session = Session::new(Device::open(&catalog.devices[0]).unwrap(), &case.plan()).unwrap();
    session.render(SAMPLES).unwrap();
    let whole = session.film().unwrap();
    for [first, second] in [[0, 1], [1, 0]].map(|pair| pair.map(|device| &catalog.devices[device])) {
        let film = continued(&case, first, second);
        assert!(film.iter().all(|pixel| pixel.count == SAMPLES));
        let ratio = ratio(&whole, &film);
        assert!(ratio < 0.05, "from {} to {}: {ratio} of the noise", first.name, second.name);
    }
}

/// With random numbers of their own, no value differs by more than its noise explains: the largest of all z-scores, which
/// has a bound for the whole family of comparisons (Bonferroni), and their mean square.
#[test]
#[ignore = "needs several runtimes"]
fn other_random_numbers_make_the_same_picture_within_noise() {
    for text in scenes() {
        let films = films(&text, |device| device + 1);
        for (name, film) in &films[1..] {
            let z: Vec<f64> = differences(&films[0].1, film).iter().map(|(d, sigma)| d / sigma).collect();
            let largest = z.iter().fold(0.0_f64, |most, z| most.max(z.abs()));
            let square = z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64;
            let k = family(z.len());
            println!(
                "{name} against {}: worst of {} {largest:.2} σ of {k:.2}, z² {square:.3}",
                films[0].0,
                z.len()
            );
            assert!(largest < k, "{name}: {largest} σ in\n{text}");
            // Channels of a pixel go together: a third of the values are independent. Student's t of 47 degrees of
            // freedom and more has the mean square 47/45 at most.
            let deviation = (2.0 / (z.len() as f64 / 3.0)).sqrt();
            assert!((square - 1.0).abs() < 0.05 + 4.0 * deviation, "{name}: z² {square} in\n{text}");
        }
    }
}
