//! Sorts and cell ranges on the device give what the twins give, bit for bit, in either form.

mod common;

use svetlo::device::{Buffer, Device, Program, ProgramSpec};
use svetlo::reference::random::philox4x32;
use svetlo::reference::sort::{cell_ranges, order};
use svetlo::sort::{CellRanges, Fill, Form, SortKey, SortKind, Sorted, Sorter};

const WAYS: [(SortKind, Form); 4] = [
    (SortKind::Radix, Form::Items),
    (SortKind::Radix, Form::Groups),
    (SortKind::Bitonic, Form::Items),
    (SortKind::Bitonic, Form::Groups),
];
const FILLS: [Fill; 2] = [Fill::OnePass, Fill::TwoPass];

/// The ways that a device can go: some leave long loops, see [`Form::of`].
fn ways(device: &Device) -> impl Iterator<Item = (SortKind, Form)> {
    let long = device.info().ends_long_loops();
    WAYS.into_iter().filter(move |(_, form)| !long || *form == Form::Groups)
}

fn words(count: usize, seed: u32) -> Vec<u64> {
    let word = |i: u32| {
        let [a, b, ..] = philox4x32([i, seed, 0, 0], [5, 1]);
        u64::from(a) << 32 | u64::from(b)
    };
    (0..count as u32).map(word).collect()
}

/// Keys of `bits` bits, an eighth of them none.
fn random(count: usize, bits: u32, seed: u32) -> Vec<u32> {
    let below = (1_u64 << bits) - 1;
    let key = |w: u64| if w >> 61 == 0 { u32::MAX } else { (w % below) as u32 };
    words(count, seed).into_iter().map(key).collect()
}

fn check<K: SortKey + Ord + std::fmt::Debug>(
    device: &Device,
    sorter: &mut Sorter<K>,
    keys: &[K],
    none: K,
    bits: u32,
    case: &str,
) {
    let buffer = Buffer::from_slice(device, keys).unwrap();
    let sorted = sorter.sort(device, &buffer, keys.len(), bits).unwrap();
    let expected = order(keys);
    let found = &sorted.indices.read(device).unwrap()[..keys.len()];
    let wrong = (0..keys.len()).find(|&i| found[i] != expected[i]);
    assert_eq!(wrong.map(|i| (i, found[i], expected[i])), None, "{case}: place, found, expected");
    let found = &sorted.keys.read(device).unwrap()[..keys.len()];
    assert!(expected.iter().zip(found).all(|(&i, key)| keys[i as usize] == *key), "{case}: keys");
    assert_eq!(sorted.valid(device).unwrap(), keys.iter().filter(|&&key| key != none).count(), "{case}");
}

#[test]
fn any_number_of_items() {
    let device = common::device();
    for (kind, form) in ways(&device) {
        let mut sorter = Sorter::with_form(&device, kind, form, 40_000).unwrap();
        let around = [8, 64, 256, 1024, 2048, 4096, 16384, 32768].into_iter().flat_map(|n| [n - 1, n, n + 1]);
        for count in [0, 1, 2, 3, 1000].into_iter().chain(around) {
            let keys = random(count, 20, count as u32);
            check(&device, &mut sorter, &keys, u32::MAX, 20, &format!("{kind:?} {form:?}, {count} items"));
        }
    }
}

/// As few as make every form go through several blocks: `scripts/test` runs this under Oclgrind.
#[test]
fn a_few_blocks() {
    let device = common::device();
    for (kind, form) in ways(&device) {
        let count = match (kind, form) {
            (SortKind::Bitonic, Form::Items) => 16_385,
            (SortKind::Bitonic, Form::Groups) => 4_097,
            (SortKind::Radix, _) => 3_000,
        };
        let mut sorter = Sorter::with_form(&device, kind, form, count).unwrap();
        let keys = random(count, 9, 3);
        check(&device, &mut sorter, &keys, u32::MAX, 9, &format!("{kind:?} {form:?}"));
    }
}

#[test]
fn a_million_items() {
    let device = common::device();
    let keys = random((1 << 20) + 1, 25, 1);
    for (kind, form) in ways(&device) {
        let mut sorter = Sorter::with_form(&device, kind, form, keys.len()).unwrap();
        check(&device, &mut sorter, &keys, u32::MAX, 25, &format!("{kind:?} {form:?}"));
    }
}

#[test]
fn special_orders() {
    let device = common::device();
    let count = 20_000_u32;
    let cases: [(&str, Vec<u32>); 7] = [
        ("one cell", vec![77; count as usize]),
        ("none is valid", vec![u32::MAX; count as usize]),
        ("one is valid", (0..count).map(|i| if i == 9_999 { 0 } else { u32::MAX }).collect()),
        ("sorted", (0..count).collect()),
        ("reversed", (0..count).rev().collect()),
        ("two keys by turns", (0..count).map(|i| i % 2).collect()),
        (
            "the largest cell",
            (0..count).map(|i| (1 << 16) - 2 + i % 2 * (u32::MAX - (1 << 16) + 2)).collect(),
        ),
    ];
    for (kind, form) in ways(&device) {
        let mut sorter = Sorter::with_form(&device, kind, form, count as usize).unwrap();
        for (name, keys) in &cases {
            check(&device, &mut sorter, keys, u32::MAX, 16, &format!("{kind:?} {form:?}, {name}"));
        }
    }
}

#[test]
fn any_number_of_bits() {
    let device = common::device();
    for (kind, form) in ways(&device) {
        let mut sorter = Sorter::with_form(&device, kind, form, 5000).unwrap();
        let mut wide = Sorter::with_form(&device, kind, form, 5000).unwrap();
        for bits in 1..=32 {
            let keys = random(5000, bits, 100 + bits);
            check(&device, &mut sorter, &keys, u32::MAX, bits, &format!("{kind:?} {form:?}, {bits} bits"));
        }
        for bits in [1, 17, 32, 33, 41, 48, 63, 64] {
            let below = ((1_u128 << bits) - 1) as u64;
            // Few values of either word, so that both decide.
            let value = |w: u64| (w & 0x0007_0000_0007_0007_u64.rotate_left(bits / 2)) % below;
            let key = |w: u64| if w >> 61 == 0 { u64::MAX } else { value(w) };
            let keys: Vec<u64> = words(5000, bits).into_iter().map(key).collect();
            check(
                &device,
                &mut wide,
                &keys,
                u64::MAX,
                bits,
                &format!("{kind:?} {form:?}, {bits} of 64 bits"),
            );
        }
    }
}

fn sorted_cells<'a>(
    device: &Device,
    sorter: &'a mut Sorter<u32>,
    keys: &[u32],
) -> (Sorted<'a, u32>, Vec<u32>) {
    let buffer = Buffer::from_slice(device, keys).unwrap();
    let sorted = sorter.sort(device, &buffer, keys.len(), 32).unwrap();
    let mut keys = sorted.keys.read(device).unwrap();
    keys.truncate(sorted.count);
    (sorted, keys)
}

/// One table filled again and again: with few items and with many, so that both ways of clearing are gone.
#[test]
fn ranges_of_cells() {
    let device = common::device();
    let cells = 4096;
    for fill in FILLS {
        let mut sorter = Sorter::new(&device, SortKind::Radix, 20_000).unwrap();
        let mut table = CellRanges::new(&device, cells, fill, 20_000).unwrap();
        for (round, count) in [300, 0, 200, 511, 512, 20_000, 1, 2, 3, 100].into_iter().enumerate() {
            let cell = |w: u64| if w >> 61 == 0 { u32::MAX } else { (w % (cells as u64 + 2)) as u32 };
            let keys: Vec<u32> = words(count, 40 + round as u32).into_iter().map(cell).collect();
            let (sorted, keys) = sorted_cells(&device, &mut sorter, &keys);
            table.fill(&device, &sorted).unwrap();
            let expected = cell_ranges(&keys, cells);
            assert_eq!(table.ranges().read(&device).unwrap(), expected, "{fill:?}, round {round}");
        }
    }
}

#[test]
fn ranges_of_special_orders() {
    let device = common::device();
    let cases: [(usize, Vec<u32>); 5] = [
        (1, vec![0; 1000]),
        (1, vec![u32::MAX; 1000]),
        (70, vec![69; 500]),
        (1000, (0..1000).collect()),
        (64, (0..1000).map(|i| i % 64 / 8 * 9).collect()),
    ];
    for fill in FILLS {
        for (cells, keys) in &cases {
            let mut sorter = Sorter::new(&device, SortKind::Bitonic, keys.len()).unwrap();
            let (sorted, keys) = sorted_cells(&device, &mut sorter, keys);
            let mut table = CellRanges::new(&device, *cells, fill, keys.len()).unwrap();
            table.fill(&device, &sorted).unwrap();
            assert_eq!(table.ranges().read(&device).unwrap(), cell_ranges(&keys, *cells), "{fill:?} {cells}");
        }
    }
}

#[test]
fn cells_are_found_in_sorted_keys() {
    let device = common::device();
    let mut sorter = Sorter::<u32>::new(&device, SortKind::Radix, 3000).unwrap();
    for count in [0, 1, 2, 3000] {
        let cells: Vec<u32> = (0..1100).collect();
        let keys: Vec<u32> = words(count, 9).into_iter().map(|w| (w % 1000) as u32).collect();
        let (sorted, keys) = sorted_cells(&device, &mut sorter, &keys);
        let kernel = "__kernel void probe(__global const uint *keys, uint count, __global uint *first, uint cells) {\n\
                      uint i = (uint)get_global_id(0);\n\
                      if (i < cells) first[i] = sorted_first(keys, count, first[i]);\n}\n";
        let program = Program::build_probe(&device, &ProgramSpec::new("sort/search.cl"), kernel).unwrap();
        let first = Buffer::from_slice(&device, &cells).unwrap();
        let arguments =
            [sorted.keys.into(), (count as u32).into(), (&first).into(), (cells.len() as u32).into()];
        program.kernel(&device, "probe").unwrap().run(&device, &arguments, cells.len()).unwrap();
        let expected: Vec<_> =
            cells.iter().map(|&cell| keys.partition_point(|&key| key < cell) as u32).collect();
        assert_eq!(first.read(&device).unwrap(), expected, "{count} items");
    }
}

/// Elements by what each method has to keep: the result, 8 bytes each; pairs twice, or one element; counters of tiles or
/// chunks are less than a tenth.
#[test]
fn memory_is_that_of_keys_and_pairs() {
    let device = common::device();
    let items = 1 << 20;
    let total = |kind| Sorter::<u32>::memory(device.info(), kind, items).total() as f64 / items as f64;
    assert_eq!(total(SortKind::Bitonic), 16.0);
    assert!((24.0..26.4).contains(&total(SortKind::Radix)), "{}", total(SortKind::Radix));
    assert_eq!(Sorter::<u64>::memory(device.info(), SortKind::Bitonic, items).total(), 24 * items as u64);
    assert_eq!(CellRanges::memory(1 << 24, items).total(), (8 << 24) + 4 * items as u64);
}

#[test]
fn what_does_not_fit_is_refused() {
    let device = common::device();
    let mut sorter = Sorter::<u32>::new(&device, SortKind::Radix, 10).unwrap();
    let keys = Buffer::from_slice(&device, &[1_u32; 12]).unwrap();
    for (count, bits, expected) in [
        (11, 8, "cannot sort 11 keys of 8 bits: this sorter takes up to 10 keys of 1 to 32 bits"),
        (3, 33, "cannot sort 3 keys of 33 bits: this sorter takes up to 10 keys of 1 to 32 bits"),
        (3, 0, "cannot sort 3 keys of 0 bits: this sorter takes up to 10 keys of 1 to 32 bits"),
    ] {
        assert_eq!(sorter.sort(&device, &keys, count, bits).err().unwrap().to_string(), expected);
    }
    let sorted = sorter.sort(&device, &keys, 10, 8).unwrap();
    let error = CellRanges::new(&device, 4, Fill::OnePass, 9).unwrap().fill(&device, &sorted).err().unwrap();
    assert_eq!(error.to_string(), "cannot find the cells of 10 items, only of 9");
}
