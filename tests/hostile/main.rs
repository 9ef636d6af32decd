//! Files that lie, are damaged or are no files: readers return with an error, soon, and allocate no more than the file
//! justifies.

mod allocations;
#[path = "../volume_files/corpus.rs"]
#[allow(dead_code)]
mod corpus;
mod liars;
mod mutations;
#[cfg(unix)]
mod places;
mod seeds;
mod targets;

use allocations::measured;
use mutations::{Dice, mutated};
use std::path::Path;
use std::time::{Duration, Instant};
use targets::TARGETS;

/// What takes longer, hangs: each takes milliseconds, but other tests run beside it. The fuzzer's limit is 5 s.
const HANGS: Duration = Duration::from_secs(30);
/// Mutations of each target in a run of the tests.
const MUTATIONS: u32 = 100;

/// The most that a reader may allocate at a time for a file of so many bytes.
fn allocated_for(length: usize) -> usize {
    4 * length + (64 << 20)
}

/// Gives a target its bytes; it must return in time and within memory.
#[track_caller]
fn answered(name: &str, data: &[u8]) {
    let start = Instant::now();
    let (_, allocated) = measured(|| targets::run(name, data));
    let shown = || String::from_utf8_lossy(&data[..data.len().min(300)]).into_owned();
    assert!(start.elapsed() < HANGS, "{name}: {:?} for {:?}", start.elapsed(), shown());
    assert!(allocated.largest <= allocated_for(data.len()), "{name}: {allocated:?} for {:?}", shown());
}

#[test]
fn whole_files_and_mutations_of_them_are_answered() {
    for (number, (name, _)) in TARGETS.into_iter().enumerate() {
        let seeds = seeds::of(name);
        seeds.iter().for_each(|seed| answered(name, seed));
        let mut dice = Dice::new(number as u32);
        for _ in 0..MUTATIONS {
            answered(name, &mutated(&seeds, &mut dice));
        }
    }
}

/// Mutations for `SVETLO_MUTATE` seconds each, of the targets that `SVETLO_TARGET` names or of all.
#[test]
#[ignore = "runs as long as it is told to"]
fn more_mutations() {
    let wanted = std::env::var("SVETLO_TARGET").unwrap_or_default();
    let seconds = std::env::var("SVETLO_MUTATE").ok().and_then(|text| text.parse().ok()).unwrap_or(10);
    for (number, (name, _)) in TARGETS.into_iter().enumerate() {
        if !wanted.is_empty() && wanted != name {
            continue;
        }
        let seeds = seeds::of(name);
        let mut dice = Dice::new(1000 + number as u32);
        let (start, mut runs) = (Instant::now(), 0_u64);
        while start.elapsed() < Duration::from_secs(seconds) {
            answered(name, &mutated(&seeds, &mut dice));
            runs += 1;
        }
        println!("{name}: {runs} mutations in {seconds} s");
    }
}

/// Writes what libFuzzer begins with, to `tests/fuzz/corpus`.
#[test]
#[ignore = "writes files"]
fn write_seeds() {
    for (name, _) in TARGETS {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus").join(name);
        std::fs::create_dir_all(&folder).unwrap();
        for (number, seed) in seeds::of(name).iter().enumerate() {
            std::fs::write(folder.join(format!("seed{number:03}")), seed).unwrap();
        }
    }
}
