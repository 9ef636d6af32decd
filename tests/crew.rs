//! Several devices on one picture: the same bits as one, whatever falls to whom and whatever fails.

mod common;

use common::{EPS, device};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use svetlo::caustics::PassLedger;
use svetlo::crew::Crew;
use svetlo::device::{Device, Faults};
use svetlo::film::FilmPixel;
use svetlo::reference::random::philox4x32;
use svetlo::render::{
    Auxiliary, BRICK_SHIFT, PathLedger, Plan, Progress, Rendering, SavedFilm, SceneData, Session, Shift,
    Spent,
};
use svetlo::scene::Scene;

/// Scenes of every kind of work: rows of tiles, with paths and auxiliary images, with a light volume, and whole samples.
const SCENES: [(&str, &str); 4] = [
    ("tiny_emission_absorption", ""),
    ("tiny_multiple_scattering", "film.auxiliary=true"),
    ("tiny_hybrid_coarse", ""),
    ("tiny_caustics", "method.photons=512"),
];

fn scene(name: &str, set: &str) -> Scene {
    let path: PathBuf =
        [env!("CARGO_MANIFEST_DIR"), "tests/scenes", &format!("{name}.toml")].iter().collect();
    let mut sets: Vec<String> =
        ["image.width=43", "image.height=37", "image.filter=box"].map(String::from).into();
    sets.extend((!set.is_empty()).then(|| set.to_owned()));
    Scene::load(&path, &sets).unwrap_or_else(|error| panic!("{error}"))
}

/// A picture and what is kept beside it.
#[derive(Clone, PartialEq)]
struct Picture {
    film: Vec<FilmPixel>,
    auxiliary: Option<Vec<Auxiliary>>,
    paths: Option<PathLedger>,
    photons: Option<PassLedger>,
}

fn picture(rendering: &dyn Rendering) -> Picture {
    Picture {
        film: rendering.film().unwrap(),
        auxiliary: rendering.auxiliary().unwrap(),
        paths: rendering.ledger().unwrap(),
        photons: rendering.facts().photons,
    }
}

/// The same bits; sums of weights over all paths are added in another order.
fn assert_same(what: &str, found: &Picture, expected: &Picture) {
    let differing = found.film.iter().zip(&expected.film).filter(|(a, b)| a != b).count();
    assert_eq!(differing, 0, "{what}: pixels that differ");
    assert!(found.auxiliary == expected.auxiliary, "{what}: auxiliary images differ");
    let counts = |p: PassLedger| (p.passes, p.flux.photons, p.flux.stored_photons, p.bounced.stored_photons);
    assert_eq!(found.photons.map(counts), expected.photons.map(counts), "{what}");
    if let (Some(found), Some(expected)) = (found.paths, expected.paths) {
        assert_eq!(
            [found.paths, found.lookups, found.collisions, found.above_majorant, found.unfinished],
            [
                expected.paths,
                expected.lookups,
                expected.collisions,
                expected.above_majorant,
                expected.unfinished
            ],
            "{what}"
        );
        // Each addend may be rounded once when it comes to the low part of a sum.
        let apart = (found.escaped - expected.escaped).abs();
        assert!(apart <= EPS * expected.escaped.abs(), "{what}: escaped weight differs by {apart}");
    }
}

fn alone(plan: &Plan<'_>, samples: u32) -> Picture {
    let mut session = Session::new(device(), plan).unwrap();
    session.render(samples).unwrap();
    picture(&session)
}

/// What a crew of such devices makes, or why it could not, with notes and what each has done.
fn together(
    plan: &Plan<'_>,
    devices: Vec<Device>,
    saved: Option<SavedFilm>,
    goals: &[u32],
) -> (Result<Picture, String>, Vec<String>, Vec<Shift>) {
    std::thread::scope(|scope| {
        let mut crew = Crew::start(scope, plan, devices, None, saved).unwrap();
        let mut notes = Vec::new();
        for &goal in goals {
            while crew.progress().samples < goal {
                if let Err(error) = crew.step(goal) {
                    return (Err(error.to_string()), notes, crew.shifts());
                }
                notes.extend(crew.take_notes());
            }
            let Progress { samples, tiles, .. } = crew.progress();
            assert_eq!((samples, tiles), (goal, 0));
        }
        // One may be lost at the very end: what the shifts know has its note by then.
        let shifts = crew.shifts();
        notes.extend(crew.take_notes());
        (Ok(picture(&crew)), notes, shifts)
    })
}

#[test]
fn the_picture_is_that_of_one_device() {
    for (name, set) in SCENES {
        let scene = scene(name, set);
        let data = SceneData::load(&scene).unwrap();
        let plan = Plan::new(&scene, &data, BRICK_SHIFT).unwrap();
        let expected = alone(&plan, 6);
        for members in 1..4 {
            let devices = (0..members).map(|_| device()).collect();
            let (found, notes, shifts) = together(&plan, devices, None, &[1, 4, 6]);
            assert_same(name, &found.unwrap(), &expected);
            assert_eq!((notes.len(), shifts.len()), (0, members));
            let computed: u64 = shifts.iter().map(|shift| shift.samples).sum();
            assert_eq!(computed, 6 * 43 * 37);
        }
    }
}

/// A film that a session left within a sample, or that a crew left with rows ahead of others, goes on elsewhere.
#[test]
fn it_goes_on_where_another_stopped() {
    for (name, set) in SCENES {
        let scene = scene(name, set);
        let data = SceneData::load(&scene).unwrap();
        let plan = Plan::new(&scene, &data, BRICK_SHIFT).unwrap();
        let expected = alone(&plan, 5);
        let mut session = Session::new(device(), &plan).unwrap();
        session.limit_launches(7);
        session.render(2).unwrap();
        session.step(5).unwrap();
        session.step(5).unwrap();
        let progress = session.progress();
        let saved = SavedFilm {
            pixels: session.film().unwrap(),
            auxiliary: session.auxiliary().unwrap(),
            paths: session.ledger().unwrap(),
            photons: session.photons().copied(),
            spent: Spent { progress, ..Spent::default() },
            ..SavedFilm::empty(&plan)
        };
        let (found, ..) = together(&plan, vec![device(), device()], Some(saved), &[5]);
        assert_same(name, &found.unwrap(), &expected);
    }
}

#[test]
fn a_device_that_is_lost_at_any_call_is_left_out() {
    lose_devices(5);
}

#[test]
#[ignore = "takes minutes: cargo test --test crew -- --ignored"]
fn devices_are_lost_at_a_thousand_moments() {
    lose_devices(250);
}

/// One of two devices is lost in so many renders of each scene.
fn lose_devices(rounds: u32) {
    for (index, (name, set)) in SCENES.into_iter().enumerate() {
        let scene = scene(name, set);
        let data = SceneData::load(&scene).unwrap();
        let plan = Plan::new(&scene, &data, BRICK_SHIFT).unwrap();
        let expected = alone(&plan, 3);
        let counted = Arc::new(Faults::default());
        let watched = device().failing(Arc::clone(&counted)).unwrap();
        together(&plan, vec![watched], None, &[3]).0.unwrap();
        for round in 0..rounds {
            let draw = philox4x32([index as u32, round, 0, 0], [1, 7])[0];
            let call = 2 + u64::from(draw) % counted.calls();
            let weak = device().failing(Faults::lose(call)).unwrap();
            let devices = if round % 2 == 0 { vec![weak, device()] } else { vec![device(), weak] };
            let (found, notes, shifts) = together(&plan, devices, None, &[3]);
            assert_same(&format!("{name}, lost at call {call}"), &found.unwrap(), &expected);
            // One that has had less to do than alone may have met its end too late.
            let lost = shifts.iter().filter(|shift| shift.lost.is_some()).count();
            assert!((lost..=1).contains(&notes.len()), "{lost} lost: {notes:?}");
            assert!(notes.iter().all(|note| note.contains("is left out from now on: ")), "{notes:?}");
        }
    }
}

#[test]
fn without_any_device_left_it_fails_with_all_reasons() {
    let scene = scene("tiny_multiple_scattering", "");
    let data = SceneData::load(&scene).unwrap();
    let plan = Plan::new(&scene, &data, BRICK_SHIFT).unwrap();
    let weak = |call| device().failing(Faults::lose(call)).unwrap();
    let (found, ..) = together(&plan, vec![weak(9), weak(30)], None, &[3]);
    let error = found.err().unwrap();
    assert!(error.starts_with("no device is left that works: "), "{error}");
    assert_eq!(error.matches("CL_INVALID_COMMAND_QUEUE").count(), 2, "{error}");
}

/// An uneven film of a crew is whole for a session.
#[test]
fn a_session_evens_out_what_a_crew_left() {
    let scene = scene("tiny_multiple_scattering", "");
    let data = SceneData::load(&scene).unwrap();
    let plan = Plan::new(&scene, &data, BRICK_SHIFT).unwrap();
    let expected = alone(&plan, 9).film;
    let (early, late) = (alone(&plan, 2).film, alone(&plan, 6).film);
    let rows: Vec<FilmPixel> =
        (0..43 * 37).map(|pixel| if pixel / 43 / 8 % 2 == 0 { early[pixel] } else { late[pixel] }).collect();
    let path = std::env::temp_dir().join(format!("svetlo-crew-{}.exr", std::process::id()));
    let mut session = Session::new(device(), &plan).unwrap();
    let saved = SavedFilm {
        pixels: rows,
        paths: Some(PathLedger::default()),
        spent: Spent { progress: Progress { samples: 2, ..Progress::default() }, ..Spent::default() },
        ..SavedFilm::empty(&plan)
    };
    session.restore(&saved).unwrap();
    let hash = "of no data";
    let snapshot = svetlo::render::Snapshot::take(&session, &plan, hash, std::time::Duration::ZERO).unwrap();
    svetlo::picture::write_exr(&path, &snapshot.picture).unwrap();
    let reread =
        svetlo::render::Saved::open(Path::new(&path), &scene).unwrap().unwrap().film(&plan, hash).unwrap();
    std::fs::remove_file(&path).unwrap();
    assert_eq!((reread.spent.progress.samples, reread.lag.len()), (2, 3));
    let mut session = Session::new(device(), &plan).unwrap();
    session.restore(&reread).unwrap();
    session.render(9).unwrap();
    assert!(session.film().unwrap() == expected);
}
