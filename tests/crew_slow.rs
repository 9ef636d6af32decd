//! A device that is far slower than the others: what it holds is done by them, and the picture is the same.

mod common;

use common::device;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use svetlo::crew::Crew;
use svetlo::device::{Call, Device, Faults};
use svetlo::film::FilmPixel;
use svetlo::render::{Auxiliary, BRICK_SHIFT, Plan, Rendering, SceneData, Session, Shift};
use svetlo::scene::Scene;

/// Whoever waits longer for others to take over waits for ever: they do so after a second.
const PATIENCE: Duration = Duration::from_secs(60);
const SAMPLES: u32 = 3;
const SIZE: u64 = 43 * 37;

fn scene(name: &str, set: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/scenes/{name}.toml"));
    let sets = ["image.width=43", "image.height=37", "image.filter=box", set].map(String::from);
    Scene::load(&path, &sets).unwrap_or_else(|error| panic!("{error}"))
}

type Picture = (Vec<FilmPixel>, Option<Vec<Auxiliary>>);

fn picture(rendering: &dyn Rendering) -> Picture {
    (rendering.film().unwrap(), rendering.auxiliary().unwrap())
}

/// Goes on until it is `done`; fails after a minute, when the stalled ones go on: threads have to end before the test can.
fn step_until(crew: &mut Crew<'_>, goal: u32, stalled: [&Faults; 2], done: impl Fn(&Crew<'_>) -> bool) {
    let start = Instant::now();
    while !done(crew) {
        if start.elapsed() > PATIENCE {
            stalled.iter().for_each(|faults| faults.go_on());
            panic!("nobody took over what the slow device held: {:?}", crew.progress());
        }
        crew.step(goal).unwrap_or_else(|error| panic!("{error}"));
    }
}

/// What two devices make of which one launches nothing until the picture is done; then both add a sample.
fn with_a_slow_one(
    plan: &Plan<'_>,
    order: fn(Device, Device) -> [Device; 2],
) -> (Picture, Picture, Vec<Shift>) {
    let [slow, quick] = [(); 2].map(|()| Arc::new(Faults::stall(Call::Launch)));
    let [first, second] = [&slow, &quick].map(|faults| device().failing(Arc::clone(faults)).unwrap());
    std::thread::scope(|scope| {
        let mut crew = Crew::start(scope, plan, Vec::from(order(first, second)), None, None).unwrap();
        let both = [&*slow, &*quick];
        // Neither is done with everything before the other has taken something.
        let at_work = |_: &Crew<'_>| both.iter().all(|faults| faults.calls_of(Call::Launch) > 0);
        step_until(&mut crew, SAMPLES, both, at_work);
        quick.go_on();
        step_until(&mut crew, SAMPLES, both, |crew| crew.progress().samples == SAMPLES);
        let (first, shifts) = (picture(&crew), crew.shifts());
        assert!(crew.take_notes().is_empty());
        slow.go_on();
        step_until(&mut crew, SAMPLES + 1, both, |crew| crew.progress().samples > SAMPLES);
        (first, picture(&crew), shifts)
    })
}

fn check(name: &str, set: &str) {
    let scene = scene(name, set);
    let data = SceneData::load(&scene).unwrap();
    let plan = Plan::new(&scene, &data, BRICK_SHIFT).unwrap();
    let mut session = Session::new(device(), &plan).unwrap();
    session.render(SAMPLES).unwrap();
    let expected = picture(&session);
    session.render(SAMPLES + 1).unwrap();
    let after = picture(&session);
    for (order, slow) in [((|a, b| [a, b]) as fn(_, _) -> _, 0), (|a, b| [b, a], 1)] {
        let (first, second, shifts) = with_a_slow_one(&plan, order);
        assert!(first == expected, "{name}: another picture than of one device");
        assert!(second == after, "{name}: what the slow device brought late has changed the picture");
        assert_eq!(shifts[slow].samples, 0, "{name}: the slow device has not been slow");
        assert_eq!(shifts[1 - slow].samples, u64::from(SAMPLES) * SIZE, "{name}");
        assert!(shifts.iter().all(|shift| shift.lost.is_none()), "{name}: slow is not lost");
    }
}

#[test]
fn rows_of_a_slow_device_are_taken_over() {
    check("tiny_emission_absorption", "seed=1");
    check("tiny_multiple_scattering", "film.auxiliary=true");
}

#[test]
fn samples_of_a_slow_device_are_taken_over() {
    check("tiny_caustics", "method.photons=512");
}
