//! Parts of pictures: each has its share of the whole's samples, and merged they are the whole.

mod common;

use common::{EPS, device};
use std::path::{Path, PathBuf};
use std::time::Duration;
use svetlo::film::FilmPixel;
use svetlo::picture::{Samples, read_exr, write_exr};
use svetlo::render::{
    BRICK_SHIFT, Merged, PathLedger, Plan, Saved, SceneData, Session, Share, Snapshot, data_hash, merge,
};
use svetlo::scene::Scene;

/// Samples of the whole pictures.
const SAMPLES: u32 = 8;

const CAMERA: &str = "[image]\nwidth = 19\nheight = 11\n[camera]\nposition = [0.4, 0.6, -2]\ntarget = [0.5, 0.5, 0.5]\n\
    fov = 30\n";
const CLOUD: &str = "[volume]\nfield = { kind = \"cloud\" }\ndims = [8, 8, 8]\nspacing = 0.125\n\
    [medium]\nsigma_max = 9\n[[light]]\nkind = \"directional\"\ndirection = [1, 2, 3]\nirradiance = [3, 2, 1]\n\
    [background]\ncolor = [0.3, 0.2, 0.1]\n";
const MATERIALS: &str = "[[material]]\nname = \"white\"\nkind = \"diffuse\"\ncolor = 0.8\n[[material]]\nname = \"glass\"\n\
    kind = \"dielectric\"\nior = 1.5\n[[surface]]\nkind = \"plane\"\npoint = [0, 0, 1]\nnormal = [0, 0, -1]\n\
    material = \"white\"\n[[surface]]\nkind = \"sphere\"\ncentre = [0.5, 0.5, 0.4]\nradius = 0.3\nmaterial = \"glass\"\n\
    [[light]]\nkind = \"point\"\nposition = [1, -1, -2]\nintensity = 5\n";

fn method(body: &str) -> String {
    format!("{CAMERA}{CLOUD}[method]\n{body}\n")
}

fn emission_absorption() -> String {
    method("kind = \"emission-absorption\"\nquadrature = \"step\"\nstep = 0.1\njitter = true")
}

fn scattering() -> String {
    method("kind = \"multiple-scattering\"\nmax_order = 4\n[film]\nauxiliary = true")
}

fn caustics() -> String {
    format!("{CAMERA}{MATERIALS}[method]\nkind = \"caustics\"\nphotons = 1024\nradius = 0.1\nbounces = 1\n")
}

struct Case {
    scene: Scene,
    data: SceneData,
    folder: tempfile::TempDir,
}

impl Case {
    fn new(text: &str) -> Self {
        let loaded = svetlo::config::parse("test.toml", text, &[]).unwrap_or_else(|e| panic!("{e}\n{text}"));
        let scene = Scene::from_loaded(&loaded, Path::new("/")).unwrap_or_else(|e| panic!("{e}\n{text}"));
        let data = SceneData::load(&scene).unwrap();
        Self { scene, data, folder: tempfile::tempdir().unwrap() }
    }

    fn plan(&self, part: Option<Share>) -> Plan<'_> {
        Plan::new(&self.scene, &self.data, BRICK_SHIFT).unwrap().of_part(part).unwrap()
    }

    fn session(&self, part: Option<Share>) -> Session {
        Session::new(device(), &self.plan(part)).unwrap()
    }

    fn whole(&self) -> Session {
        let mut session = self.session(None);
        session.render(SAMPLES).unwrap();
        session
    }

    /// Writes what a session has so far.
    fn save(&self, session: &Session, part: Option<Share>, name: &str) -> PathBuf {
        let path = self.folder.path().join(name);
        let plan = self.plan(part);
        let data = data_hash(&plan, &self.data).unwrap();
        let snapshot = Snapshot::take(session, &plan, &data, Duration::from_millis(1500)).unwrap();
        write_exr(&path, &snapshot.picture).unwrap();
        path
    }

    /// Renders a part of the whole's samples to a file.
    fn part(&self, number: u32, of: u32) -> PathBuf {
        let share = Share::new(number, of);
        let mut session = self.session(share);
        session.limit_launches(u64::from(number));
        session.render(share.unwrap().count(SAMPLES.into())).unwrap();
        self.save(&session, share, &format!("{number}-of-{of}.exr"))
    }

    fn parts(&self, of: u32) -> Vec<PathBuf> {
        (1..=of).map(|number| self.part(number, of)).collect()
    }

    /// Continues the image at `path`.
    fn resume(&self, path: &Path, part: Option<Share>, samples: u32) -> Session {
        let plan = self.plan(part);
        let data = data_hash(&plan, &self.data).unwrap();
        let saved = Saved::open(path, &self.scene).unwrap().expect("the file is there");
        let mut session = Session::new(device(), &plan).unwrap();
        session.restore(&saved.film(&plan, &data).unwrap()).unwrap();
        session.render(samples).unwrap();
        session
    }
}

fn bits(film: &[FilmPixel]) -> &[u32] {
    bytemuck::cast_slice(film)
}

/// The merged film, by way of a file that is continued by nothing.
fn film(case: &Case, merged: &Merged) -> Vec<FilmPixel> {
    let path = case.folder.path().join("merged.exr");
    write_exr(&path, &merged.picture).unwrap();
    case.resume(&path, None, SAMPLES).film().unwrap()
}

/// How far the mean of a film may be off: the device's update divides and subtracts in float32, each with an error of
/// at most 2.5 units in the last place (OpenCL's division), 7 EPS of what a sample differs by from the mean so far. Their
/// mean is at most sqrt(2 M2 / n).
fn mean_bound(pixel: &FilmPixel, c: usize) -> f64 {
    let m2 = f64::from(pixel.m2[c]) + f64::from(pixel.m2_low[c]);
    7.0 * EPS * (2.0 * m2 / f64::from(pixel.count)).sqrt() + 2_f64.powi(-46) * pixel.mean()[c].abs()
}

/// Checks a merged film against that of the whole; returns how many of the means are equal as float32.
fn compare(found: &[FilmPixel], whole: &[FilmPixel], name: &str) -> f64 {
    let mut equal = 0;
    for (found, whole) in found.iter().zip(whole) {
        assert_eq!(
            (found.count, found.rejected, found.hits),
            (whole.count, whole.rejected, whole.hits),
            "{name}"
        );
        assert_eq!(found.lookups(), whole.lookups(), "{name}");
        for c in 0..4 {
            let (a, b) = (found.mean()[c], whole.mean()[c]);
            // Parts have such errors, too.
            let bound = 2.0 * mean_bound(whole, c);
            assert!((a - b).abs() <= bound, "{name}: mean {a}, not {b} ± {bound}");
            equal += u32::from(a as f32 == b as f32);
            let m2 = |pixel: &FilmPixel| f64::from(pixel.m2[c]) + f64::from(pixel.m2_low[c]);
            // Each term has two such deviations, and those of the means: 4 × 7 EPS, twice for the deviations' mean, and
            // as much in the parts.
            assert!((m2(found) - m2(whole)).abs() <= 112.0 * EPS * m2(whole), "{name}: {found:?} {whole:?}");
        }
        // A float32 mean takes a rounding per sample.
        let bound = 4.0 * f64::from(SAMPLES) * EPS * f64::from(whole.depth);
        assert!((f64::from(found.depth) - f64::from(whole.depth)).abs() <= bound, "{name}: depth");
    }
    f64::from(equal) / (4.0 * whole.len() as f64)
}

fn counts(ledger: &PathLedger) -> [u64; 5] {
    [ledger.paths, ledger.lookups, ledger.collisions, ledger.above_majorant, ledger.unfinished]
}

#[test]
fn three_parts_are_the_whole() {
    for (name, text) in [
        ("emission", emission_absorption()),
        ("scattering", scattering()),
        ("caustics", caustics()),
        ("mip", method("kind = \"mip\"")),
        ("isosurface", method("kind = \"isosurface\"\nvalue = 0.3")),
    ] {
        let case = Case::new(&text);
        let whole = case.whole();
        let merged = merge(&case.parts(3)).unwrap();
        assert!(merged.notes.is_empty() && merged.parts.is_whole(), "{:?}", merged.notes);
        let share = compare(&film(&case, &merged), &whole.film().unwrap(), name);
        println!("{name}: {share:.4} of the means are the same float32");
        // Errors of 2 x 2^-24 of the deviation over sqrt(n), beside roundings of the mean: seldom one that shows.
        assert!(share > 0.8, "{name}: {share}");
        if let (Some(found), Some(expected)) = (&merged.paths, whole.ledger().unwrap()) {
            assert_eq!(counts(found), counts(&expected));
            for (a, b) in [
                (found.escaped, expected.escaped),
                (found.cut, expected.cut),
                (found.gained, expected.gained),
            ] {
                assert!((a - b).abs() <= f64::from(f32::EPSILON) * expected.paths as f64, "{name}: {a} {b}");
            }
        }
        if let (Some(found), Some(expected)) = (&merged.photons, whole.photons()) {
            assert_eq!((found.passes, found.flux.photons), (SAMPLES, expected.flux.photons));
            assert_eq!(found.bounced.stored_photons, expected.bounced.stored_photons);
            assert_eq!(found.flux.stored_photons, expected.flux.stored_photons);
            assert!((found.flux.stored / expected.flux.stored - 1.0).abs() < 1e-6, "{found:?} {expected:?}");
        }
        assert_eq!(merged.paths.is_some(), name == "scattering");
        assert_eq!(merged.photons.is_some(), name == "caustics");
        auxiliary(&case, &whole, &merged);
    }
}

/// The auxiliary images, as channels.
fn auxiliary(case: &Case, whole: &Session, merged: &Merged) {
    let whole = read_exr(&case.save(whole, None, "whole.exr")).unwrap();
    for channel in &whole.channels {
        if channel.name.starts_with("state.") || channel.name.starts_with("variance.") {
            continue;
        }
        let found = merged.picture.channel(&channel.name).expect("the same channels");
        let (found, expected) = (found.to_f32(), channel.data.to_f32());
        let largest = expected.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
        for (a, b) in found.iter().zip(&*expected) {
            // Float32 means, and a quotient of two of them that may be a hundredth each.
            let bound = 100.0 * 4.0 * f64::from(SAMPLES) * EPS * f64::from(largest);
            assert!((f64::from(*a) - f64::from(*b)).abs() <= bound, "{}: {a} {b}", channel.name);
        }
    }
}

/// Parts of one sample each are the samples; their mean is exact, and that of other parts is that of theirs.
#[test]
fn parts_have_every_nth_sample_of_the_whole() {
    let case = Case::new(&scattering());
    let samples: Vec<Vec<FilmPixel>> = (1..=SAMPLES)
        .map(|number| {
            let mut session = case.session(Share::new(number, SAMPLES));
            session.render(1).unwrap();
            session.film().unwrap()
        })
        .collect();
    let mean_of = |pixel: usize, c: usize, chosen: &dyn Fn(usize) -> bool| {
        let chosen: Vec<f64> = (0..SAMPLES as usize)
            .filter(|&k| chosen(k))
            .map(|k| f64::from(samples[k][pixel].mean[c]))
            .collect();
        chosen.iter().sum::<f64>() / chosen.len() as f64
    };
    assert!((0..samples[0].len()).any(|pixel| samples[0][pixel].mean != samples[1][pixel].mean));
    for (number, of) in [(1, 3), (2, 3), (3, 3)] {
        let share = Share::new(number, of);
        let mut session = case.session(share);
        session.render(share.unwrap().count(SAMPLES.into())).unwrap();
        for (index, pixel) in session.film().unwrap().iter().enumerate() {
            for c in 0..4 {
                let expected = mean_of(index, c, &|k| k % of as usize == number as usize - 1);
                assert!((pixel.mean()[c] - expected).abs() <= mean_bound(pixel, c), "{number}/{of}: {index}");
            }
        }
    }
    let merged = merge(&case.parts(SAMPLES)).unwrap();
    for (index, pixel) in film(&case, &merged).iter().enumerate() {
        for c in 0..4 {
            let expected = mean_of(index, c, &|_| true);
            // Of the float64 sum.
            assert!((pixel.mean()[c] - expected).abs() <= 2_f64.powi(-46) * expected.abs(), "{index}");
        }
    }
}

/// The same header and channels, bit for bit, whatever the order of the parts, and whichever of them were merged before.
#[test]
fn neither_order_nor_grouping_shows() {
    for text in [scattering(), caustics()] {
        let case = Case::new(&text);
        let parts = case.parts(4);
        let file = |chosen: &[&PathBuf], name: &str| {
            let paths: Vec<PathBuf> = chosen.iter().map(|path| path.to_path_buf()).collect();
            let path = case.folder.path().join(name);
            write_exr(&path, &merge(&paths).unwrap().picture).unwrap();
            path
        };
        let [a, b, c, d] = [&parts[0], &parts[1], &parts[2], &parts[3]];
        let whole = read_exr(&file(&[a, b, c, d], "whole.exr")).unwrap();
        let same = |path: PathBuf| {
            let picture = read_exr(&path).unwrap();
            assert_eq!(picture.metadata, whole.metadata, "{}", path.display());
            for (found, expected) in picture.channels.iter().zip(&whole.channels) {
                assert!(found == expected, "{} of {}", found.name, path.display());
            }
            assert_eq!(picture.channels.len(), whole.channels.len());
        };
        same(file(&[d, b, c, a], "other.exr"));
        same(file(&[&file(&[c, a], "ac.exr"), d, b], "three.exr"));
        same(file(&[&file(&[b, d], "bd.exr"), &file(&[a, c], "ac.exr")], "two.exr"));
        let three = file(&[&file(&[d], "d.exr"), &file(&[c, b], "bc.exr")], "bcd.exr");
        same(file(&[&three, a], "last.exr"));
    }
}

#[test]
fn an_interrupted_part_goes_on_and_one_within_a_sample_is_merged() {
    let case = Case::new(&scattering());
    let share = Share::new(2, 3);
    let mut whole = case.session(share);
    whole.render(3).unwrap();
    let mut session = case.session(share);
    session.limit_launches(2);
    while session.progress().samples < 1 || session.progress().tiles < 4 {
        session.step(3).unwrap();
    }
    let path = case.save(&session, share, "2-of-3.exr");
    let merged = merge(&[case.part(1, 3), path.clone()]).unwrap();
    assert_eq!(merged.parts.to_string(), "1,2/3: 3,1+");
    let Some(Samples::U32(samples)) = merged.picture.channel("samples") else { panic!("counts") };
    assert_eq!((samples[0], samples[19 * 11 - 1]), (5, 4));
    assert_eq!(bits(&case.resume(&path, share, 3).film().unwrap()), bits(&whole.film().unwrap()));
}

#[test]
fn a_merged_whole_goes_on_as_one() {
    for text in [emission_absorption(), caustics()] {
        let case = Case::new(&text);
        // The first five samples in two parts.
        let paths: Vec<PathBuf> = [(1, 3), (2, 2)]
            .map(|(number, samples)| {
                let share = Share::new(number, 2);
                let mut session = case.session(share);
                session.render(samples).unwrap();
                case.save(&session, share, &format!("{number}-of-2.exr"))
            })
            .into();
        let path = case.folder.path().join("merged.exr");
        write_exr(&path, &merge(&paths).unwrap().picture).unwrap();
        let session = case.resume(&path, None, SAMPLES);
        compare(&session.film().unwrap(), &case.whole().film().unwrap(), "continued");
        assert_eq!(session.photons().map(|ledger| ledger.passes), case.whole().photons().map(|l| l.passes));
        // It is a whole picture then.
        let path = case.save(&session, None, "continued.exr");
        assert!(merge(&[path]).err().unwrap().to_string().contains("it is a whole picture"));
    }
}

#[test]
fn light_volumes_are_the_same_in_all_parts() {
    let case = Case::new(&method("kind = \"hybrid-diffusion\"\niterations = 2\ncoarsening = 2"));
    let merged = merge(&case.parts(2)).unwrap();
    compare(&film(&case, &merged), &case.whole().film().unwrap(), "hybrid");
    assert_eq!(merged.picture.metadata["svetlo.light_source"], "computed");
}
