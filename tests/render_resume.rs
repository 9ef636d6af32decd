//! A film that went through a file: the render continues as if it had never stopped.

mod common;

use common::{Case, device, smooth};
use std::time::Duration;
use svetlo::film::FilmPixel;
use svetlo::picture::write_exr;
use svetlo::render::{PathLedger, Saved, Session, Snapshot, data_hash};

const JITTER: &str = "kind = \"emission-absorption\"\nquadrature = \"step\"\nstep = 0.7\njitter = true\n";
/// Coloured, cut, with shadow rays: everything that a path counts.
const SCATTERING: &str = "kind = \"multiple-scattering\"\nmax_order = 3\n[film]\nauxiliary = true\n\
    [[light]]\nkind = \"directional\"\ndirection = [1, 2, 3]\nirradiance = [3, 2, 1]\n";
const METHODS: [(&str, &str); 5] = [
    ("kind = \"emission-absorption\"\n", ""),
    (JITTER, ""),
    ("kind = \"mip\"\n", "aperture = 2\nfocus = 20\n"),
    ("kind = \"isosurface\"\nvalue = 0.5\n", ""),
    (SCATTERING, ""),
];

/// 27×19 pixels are 4×3 tiles, cut at two edges.
const TILES: u32 = 12;

fn case(method: &str, lens: &str) -> Case {
    let text = format!(
        "[image]\nwidth = 27\nheight = 19\n[camera]\nposition = [4, 5, -16]\ntarget = [4, 4, 4]\nfov = 30\n{lens}\
         [volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = 0.4\n[method]\n{method}"
    );
    Case::new(&text, smooth([8; 3], 3))
}

fn bits(film: &[FilmPixel]) -> &[u32] {
    bytemuck::cast_slice(film)
}

fn auxiliary_bits(session: &Session) -> Option<Vec<u32>> {
    session.auxiliary().unwrap().map(|pixels| bytemuck::cast_slice(&pixels).to_vec())
}

/// Counts are equal; weights to the rounding of each sample's sum to float32 when it is added.
fn assert_same_ledger(a: Option<PathLedger>, b: Option<PathLedger>) {
    let (Some(a), Some(b)) = (a, b) else { return assert_eq!(a, b) };
    let counts = |l: &PathLedger| [l.paths, l.lookups, l.collisions, l.above_majorant, l.unfinished];
    assert_eq!(counts(&a), counts(&b));
    for (x, y) in [(a.escaped, b.escaped), (a.absorbed, b.absorbed), (a.cut, b.cut), (a.gained, b.gained)] {
        assert!((x - y).abs() <= f64::from(f32::EPSILON) * a.paths as f64, "{a:?} {b:?}");
    }
}

/// Writes the session's film to a file and continues it in another session.
fn through_a_file(case: &Case, session: &Session) -> Session {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.exr");
    let plan = case.plan();
    let data = data_hash(&plan, &case.volume).unwrap();
    let snapshot = Snapshot::take(session, &plan, &data, Duration::from_millis(1500)).unwrap();
    write_exr(&path, &snapshot.picture).unwrap();
    let saved = Saved::open(&path, &case.scene).unwrap().expect("the file is there");
    let film = saved.film(&plan, &data).unwrap();
    assert_eq!(film.spent.wall, Duration::from_millis(1500));
    let (now, then) = (film.spent.progress, session.progress());
    assert_eq!((now.samples, now.tiles, now.launches), (then.samples, then.tiles, then.launches));
    // The header has microseconds.
    assert!(now.device_time.abs_diff(then.device_time) < Duration::from_micros(1));
    assert_eq!(bits(&film.pixels), bits(&session.film().unwrap()));
    let mut next = Session::new(device(), &plan).unwrap();
    next.restore(&film).unwrap();
    assert_eq!(auxiliary_bits(&next), auxiliary_bits(session));
    assert_same_ledger(next.ledger().unwrap(), session.ledger().unwrap());
    next
}

#[test]
fn wherever_it_stopped_and_however_launches_are_cut_the_film_is_the_same() {
    for (method, lens) in METHODS {
        let case = case(method, lens);
        let mut uncut = case.session();
        uncut.render(4).unwrap();
        let whole = uncut.film().unwrap();
        assert_eq!(uncut.ledger().unwrap().is_some(), method == SCATTERING);
        assert_eq!(uncut.auxiliary().unwrap().is_some(), method == SCATTERING);
        // Launches of 5 tiles end within samples, of 12 between them, of 30 after two.
        for (before, steps, after) in
            [(5, 4, 1000), (5, 1, 7), (12, 2, 5), (30, 1, 1), (1, 3 * TILES + 11, 1)]
        {
            let mut session = case.session();
            session.limit_launches(before);
            for _ in 0..steps {
                session.step(4).unwrap();
            }
            let stopped = session.progress();
            assert_eq!(stopped.tiles != 0, before < 12, "{stopped:?}");
            let mut next = through_a_file(&case, &session);
            next.limit_launches(after);
            next.render(4).unwrap();
            assert_eq!(bits(&next.film().unwrap()), bits(&whole), "{stopped:?}\n{method}");
            assert_eq!(auxiliary_bits(&next), auxiliary_bits(&uncut), "{stopped:?}");
            assert_same_ledger(next.ledger().unwrap(), uncut.ledger().unwrap());
        }
    }
}

#[test]
fn a_render_may_stop_after_every_launch() {
    let case = case(JITTER, "");
    let mut session = case.session();
    while session.progress().samples < 3 {
        session.limit_launches(7);
        session.step(3).unwrap();
        session = through_a_file(&case, &session);
    }
    assert_eq!(bits(&session.film().unwrap()), bits(&case.film_of(3)));
    assert!(session.progress().launches >= u64::from(3 * TILES / 7));
}
