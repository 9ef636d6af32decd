//! Sorts of (key, number) pairs and the ranges of cells, as photon maps need them.
//!
//! `cargo bench --bench sort [FILTER]`. The device is the default one, or what `SVETLO_DEVICE` selects. Each row: the
//! median, least and most milliseconds of a sort or fill that is waited for, then its launches and the bytes that it
//! moves. Keys are random words; for ranges, photons that lie on a plane of 256³ cells, in a disk of some 20 000 cells.

mod timing;

use std::time::{Duration, Instant};
use svetlo::device::{Buffer, Catalog, Device};
use svetlo::reference::random::{philox4x32, uniform};
use svetlo::sort::{CellRanges, Fill, SortKey, SortKind, Sorter, Work};
use timing::{Times, Wanted, count};

/// Runs measured after one warm-up.
const RUNS: usize = 15;
const SIDE: usize = 256;

fn main() -> svetlo::Result<()> {
    let wanted = Wanted::from_arguments();
    let selector = std::env::var("SVETLO_DEVICE").ok();
    let catalog = Catalog::enumerate();
    let info = catalog.select(selector.as_deref())?;
    println!("device {} ({}, driver {})", info.name, info.platform, info.driver);
    println!("{:<36} {:>9} {:>8} {:>8} {:>8} {:>14}", "", "median ms", "min", "max", "launches", "bytes");
    let device = Device::open(info)?;
    for power in [14, 16, 18, 20] {
        for (name, kind, bits) in [
            ("bitonic", SortKind::Bitonic, 32),
            ("radix", SortKind::Radix, 32),
            ("radix, 25 bits", SortKind::Radix, 25),
        ] {
            let row = format!("{name}: 2^{power}");
            if wanted.has(&row) {
                let below = if bits == 32 { u32::MAX } else { (1 << bits) - 1 };
                let keys: Vec<u32> = words(1 << power).map(|[word, _]| word % below).collect();
                sort(&device, &row, kind, &keys, bits)?;
            }
        }
        let row = format!("radix of u64: 2^{power}");
        if wanted.has(&row) {
            let keys: Vec<u64> = words(1 << power).map(|[a, b]| u64::from(a) << 32 | u64::from(b)).collect();
            sort(&device, &row, SortKind::Radix, &keys, 64)?;
        }
        for (name, of) in [("fill", Fill::OnePass), ("fill in two passes", Fill::TwoPass)] {
            let row = format!("{name}: 2^{power}");
            if wanted.has(&row) {
                fill(&device, &row, of, &words(1 << power).map(on_a_plane).collect::<Vec<_>>())?;
            }
        }
        let row = format!("fill, scattered: 2^{power}");
        if wanted.has(&row) {
            let keys: Vec<u32> = words(1 << power).map(|[word, _]| word % SIDE.pow(3) as u32).collect();
            fill(&device, &row, Fill::OnePass, &keys)?;
        }
    }
    Ok(())
}

fn words(count: usize) -> impl Iterator<Item = [u32; 2]> {
    (0..count as u32).map(|i| {
        let [a, b, ..] = philox4x32([i, 0, 0, 0], [3, 0]);
        [a, b]
    })
}

/// The cell of a photon that fell on a disk.
fn on_a_plane(words: [u32; 2]) -> u32 {
    let [radius, angle] = words.map(uniform);
    let (sin, cos) = (std::f64::consts::TAU * angle).sin_cos();
    let [x, y] = [cos, sin].map(|s| (SIDE as f64 * (0.5 + 0.31 * radius.sqrt() * s)) as usize);
    ((SIDE / 3 * SIDE + y) * SIDE + x) as u32
}

fn sort<K: SortKey>(device: &Device, row: &str, kind: SortKind, keys: &[K], bits: u32) -> svetlo::Result<()> {
    let buffer = Buffer::from_slice(device, keys)?;
    let mut sorter = Sorter::new(device, kind, keys.len())?;
    let mut work = Work::default();
    let times = Times::of(RUNS, || -> svetlo::Result<Duration> {
        let start = Instant::now();
        work = sorter.sort(device, &buffer, keys.len(), bits)?.work;
        device.finish()?;
        Ok(start.elapsed())
    })?;
    print(row, &times, work);
    Ok(())
}

fn fill(device: &Device, row: &str, fill: Fill, keys: &[u32]) -> svetlo::Result<()> {
    let buffer = Buffer::from_slice(device, keys)?;
    let mut sorter = Sorter::new(device, SortKind::Radix, keys.len())?;
    let sorted = sorter.sort(device, &buffer, keys.len(), 25)?;
    let mut ranges = CellRanges::new(device, SIDE.pow(3), fill, keys.len())?;
    let mut work = Work::default();
    let times = Times::of(RUNS, || -> svetlo::Result<Duration> {
        device.finish()?;
        let start = Instant::now();
        work = ranges.fill(device, &sorted)?;
        device.finish()?;
        Ok(start.elapsed())
    })?;
    print(row, &times, work);
    Ok(())
}

fn print(row: &str, times: &Times, work: Work) {
    println!("{row:<36} {times} {:>8} {:>14}", work.launches, count(work.bytes));
}
