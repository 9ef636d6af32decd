//! Several processes on one picture, in one: threads that have nothing in common but letters.

mod common;

use common::device;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::channel;
use std::sync::{Arc, OnceLock};
use std::time::Duration;
use svetlo::Error;
use svetlo::caustics::PassLedger;
use svetlo::cluster::{Fleet, Identity, Rank, serve};
use svetlo::crew::{Colleague, Crew, Team, join};
use svetlo::device::{DeviceName, Faults};
use svetlo::film::FilmPixel;
use svetlo::post::{Exchange, Letter};
use svetlo::reference::random::philox4x32;
use svetlo::render::{Auxiliary, BRICK_SHIFT, Plan, Rendering, SceneData, Session, Shift, data_hash};
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

/// What must be the same to the last bit.
type Picture = (Vec<FilmPixel>, Option<Vec<Auxiliary>>, Option<[u64; 5]>, Option<PassLedger>);

fn picture(rendering: &dyn Rendering) -> Picture {
    let paths = rendering.ledger().unwrap();
    let counts = paths.map(|l| [l.paths, l.lookups, l.collisions, l.above_majorant, l.unfinished]);
    let photons = rendering.facts().photons;
    (rendering.film().unwrap(), rendering.auxiliary().unwrap(), counts, photons)
}

fn alone(plan: &Plan<'_>, samples: u32) -> Picture {
    let mut session = Session::new(device(), plan).unwrap();
    session.render(samples).unwrap();
    picture(&session)
}

/// So many processes, and threads that carry letters between them for as long as the tests run.
fn processes(count: usize) -> Vec<Arc<Exchange>> {
    let (exchanges, outgoing): (Vec<_>, Vec<_>) = (0..count)
        .map(|_| {
            let (out, outgoing) = channel();
            (Arc::new(Exchange::new(out)), outgoing)
        })
        .unzip();
    for (me, outgoing) in outgoing.into_iter().enumerate() {
        let exchanges = exchanges.clone();
        std::thread::spawn(move || {
            for Letter { peer, port, bytes } in outgoing {
                exchanges[peer as usize].deliver(Letter { peer: me as u32, port, bytes });
            }
        });
    }
    exchanges
}

/// Ranks that render these scenes, of which the first does so with the devices of all, or why it does not.
fn march(
    scenes: Vec<Scene>,
    views: &[usize],
    local_devices: usize,
) -> Result<Vec<(Picture, Vec<Shift>)>, Error> {
    let exchanges = processes(scenes.len());
    static DEVICE: OnceLock<svetlo::device::Device> = OnceLock::new();
    let info = DEVICE.get_or_init(device).info();
    std::thread::scope(|scope| {
        let mut scenes = scenes.into_iter();
        let mine = scenes.next().unwrap();
        let others: Vec<_> = (exchanges.iter().skip(1).zip(scenes))
            .map(|(exchange, scene)| {
                let (host, devices) = (String::from("here"), Ok(vec![info]));
                let rank = Rank { host, scene: Ok(scene), part: None, devices };
                scope.spawn(move || serve(exchange, &rank).unwrap())
            })
            .collect();
        let mut fleet = Fleet::new(&exchanges[0], exchanges.len() as u32);
        let mut pictures = Vec::new();
        let ended = fleet.muster(&Identity::of(&mine, None), &|_, _| true).and_then(|()| {
            let data = SceneData::load(&mine).unwrap();
            views.iter().try_for_each(|&view| {
                fleet.begin(view)?;
                let scene = mine.of_view(&mine.views[view]);
                let plan = Plan::new(&scene, &data, BRICK_SHIFT).unwrap();
                let (colleagues, notes) = fleet.devices(&data_hash(&plan, &data).unwrap(), &|_, _| true)?;
                assert_eq!((colleagues.len(), notes.len()), (exchanges.len() - 1, 0), "{notes:?}");
                let team = Team { devices: (0..local_devices).map(|_| device()).collect(), colleagues };
                pictures.push(render(&plan, team, 30));
                fleet.close()
            })
        });
        assert!(fleet.end(7, Duration::from_secs(60)).is_empty());
        assert!(others.into_iter().all(|rank| rank.join().unwrap() == 7));
        ended.map(|()| pictures)
    })
}

fn render(plan: &Plan<'_>, team: Team<'_>, samples: u32) -> (Picture, Vec<Shift>) {
    std::thread::scope(|scope| {
        let mut crew = Crew::start(scope, plan, team, None, None).unwrap();
        for goal in [1, samples / 2, samples] {
            while crew.progress().samples < goal {
                crew.step(goal).unwrap();
            }
        }
        (picture(&crew), crew.shifts())
    })
}

/// The same bits; photons' flux, too: whole passes are added in their order.
fn assert_same(what: &str, found: &Picture, expected: &Picture) {
    let differing = found.0.iter().zip(&expected.0).filter(|(a, b)| a != b).count();
    assert_eq!(differing, 0, "{what}: pixels that differ");
    assert!(found.1 == expected.1, "{what}: auxiliary images differ");
    assert_eq!(found.2, expected.2, "{what}");
    assert_eq!(found.3.map(|photons| photons.passes), expected.3.map(|photons| photons.passes), "{what}");
}

#[test]
fn the_picture_is_that_of_one_process() {
    for (name, set) in SCENES {
        let one = scene(name, set);
        let data = SceneData::load(&one).unwrap();
        let expected = alone(&Plan::new(&one, &data, BRICK_SHIFT).unwrap(), 30);
        // Without a device of rank 0, all is done by others: the light, and adding samples to the film.
        for (ranks, local_devices) in [(2, 1), (3, 0)] {
            let scenes = (0..ranks).map(|_| scene(name, set)).collect();
            let pictures = march(scenes, &[0], local_devices).unwrap();
            let (found, shifts) = &pictures[0];
            assert_same(&format!("{name}, {ranks} ranks"), found, &expected);
            assert_eq!(shifts.len(), ranks - 1 + local_devices);
            assert_eq!(shifts.iter().map(|shift| shift.samples).sum::<u64>(), 30 * 43 * 37);
            assert_eq!(
                shifts.last().unwrap().selector,
                format!("rank {}, {}", ranks - 1, device().info().selector)
            );
        }
    }
}

#[test]
fn every_view_is_rendered_by_all() {
    let views = "camera.views=[{}, { position = [3, 0.5, 0.5] }]";
    let of_views = || scene("tiny_emission_absorption", views);
    let pictures = march(vec![of_views(), of_views()], &[0, 1], 0).unwrap();
    let one = of_views();
    let data = SceneData::load(&one).unwrap();
    for (view, (found, _)) in one.views.iter().zip(&pictures) {
        let scene = one.of_view(view);
        let expected = alone(&Plan::new(&scene, &data, BRICK_SHIFT).unwrap(), 30);
        assert_same("a view", found, &expected);
    }
    assert!(pictures[0].0 != pictures[1].0);
}

#[test]
fn who_renders_something_else_is_refused() {
    let name = "tiny_multiple_scattering";
    let refusal = |set: &str| {
        let error = march(vec![scene(name, ""), scene(name, ""), scene(name, set)], &[0], 1).err().unwrap();
        assert!(matches!(error, Error::Input(_)));
        error.to_string()
    };
    let error = refusal("seed=99");
    assert!(
        error.starts_with("rank 2 (here) does not render the same as rank 0: its hash of the scene is "),
        "{error}"
    );
    let error = refusal("film.auxiliary=true");
    assert!(error.contains("its film.auxiliary is true, that of rank 0 false"), "{error}");
}

/// Devices of another process that are lost at any call, with or without one that is here.
#[test]
fn a_device_that_is_lost_elsewhere_is_left_out() {
    for (index, (name, set)) in SCENES.into_iter().enumerate() {
        let scene = scene(name, set);
        let data = SceneData::load(&scene).unwrap();
        let plan = Plan::new(&scene, &data, BRICK_SHIFT).unwrap();
        let expected = alone(&plan, 8);
        for round in 0..6_u32 {
            let call = 2 + u64::from(philox4x32([index as u32, round, 0, 0], [3, 7])[0] % 60);
            let exchanges = processes(2);
            let closing = Arc::new(AtomicBool::new(false));
            let colleague = |port| Colleague {
                name: DeviceName { selector: format!("rank 1, {port}"), ..device().info().names() },
                line: exchanges[0].line(1, port),
            };
            let far: Vec<_> = if round % 2 == 0 {
                vec![device().failing(Faults::lose(call)).unwrap()]
            } else {
                vec![device().failing(Faults::lose(call)).unwrap(), device()]
            };
            let colleagues = (1..=far.len() as u64).map(colleague).collect();
            let devices = if round % 2 == 0 { vec![device()] } else { Vec::new() };
            let (found, _) = std::thread::scope(|scope| {
                for (port, device) in (1..).zip(far) {
                    let (exchange, plan, closing) = (&exchanges[1], &plan, Arc::clone(&closing));
                    scope.spawn(move || join(exchange.line(0, port), plan, device, closing));
                }
                let found = render(&plan, Team { devices, colleagues }, 8);
                closing.store(true, std::sync::atomic::Ordering::Relaxed);
                found
            });
            assert_same(&format!("{name}, lost at call {call}"), &found, &expected);
        }
    }
}

#[test]
fn who_sends_what_makes_no_sense_is_left_out() {
    let scene = scene("tiny_multiple_scattering", "");
    let data = SceneData::load(&scene).unwrap();
    let plan = Plan::new(&scene, &data, BRICK_SHIFT).unwrap();
    let expected = alone(&plan, 8);
    let exchanges = processes(2);
    let name = DeviceName { selector: "rank 1, 0:0".into(), ..device().info().names() };
    exchanges[1].send(Letter { peer: 0, port: 1, bytes: b"garbage".to_vec() }).unwrap();
    let colleagues = vec![Colleague { name, line: exchanges[0].line(1, 1) }];
    let (found, shifts) = render(&plan, Team { devices: vec![device()], colleagues }, 8);
    assert_same("with a stranger", &found, &expected);
    assert_eq!(shifts[1].lost.as_deref(), Some("a letter of another process is not whole"));
}
