//! Whole files, changed in the ways that damage takes: always the same ones.

use svetlo::reference::random::philox4x32;

/// Numbers of which the same come in every run.
pub struct Dice {
    key: u32,
    drawn: u32,
}

impl Dice {
    pub fn new(key: u32) -> Self {
        Self { key, drawn: 0 }
    }

    /// A number below `end`, which is at least 1.
    pub fn below(&mut self, end: usize) -> usize {
        self.drawn += 1;
        philox4x32([self.drawn, 0, 0, 0], [self.key, 0x4057])[0] as usize % end
    }
}

/// What is put in place of numbers in texts.
const NUMBERS: [&str; 10] = [
    "0",
    "-1",
    "1e308",
    "nan",
    "1000000",
    "4294967295",
    "9223372036854775807",
    "18446744073709551616",
    "0x7fffffff",
    "1e-320",
];
/// What is put in place of bytes.
const BYTES: [u8; 8] = [0, 1, 0x7f, 0x80, 0xff, b'\n', b' ', b'9'];

/// One of `seeds`, with one to four changes.
pub fn mutated(seeds: &[Vec<u8>], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = seeds[dice.below(seeds.len())].clone();
    for _ in 0..=dice.below(4) {
        let at = dice.below(bytes.len() + 1);
        let end = (at + 1 + dice.below(64)).min(bytes.len());
        match dice.below(8) {
            0 if at < bytes.len() => bytes[at] ^= 1 << dice.below(8),
            1 if at < bytes.len() => bytes[at] = BYTES[dice.below(BYTES.len())],
            2 => bytes.truncate(at),
            3 => drop(bytes.drain(at..end)),
            4 => {
                let part = bytes[at..end].to_vec();
                bytes.splice(at..at, part);
            }
            5 => {
                let other = &seeds[dice.below(seeds.len())];
                let from = dice.below(other.len() + 1);
                bytes.truncate(at);
                bytes.extend(&other[from..]);
            }
            6 => another_number(&mut bytes, at, NUMBERS[dice.below(NUMBERS.len())].as_bytes()),
            _ => {
                // Sizes and offsets of binary headers.
                let size = [0, 1, 0x7fff, 0x7fff_ffff, u32::MAX, 1 << 20][dice.below(6)].to_le_bytes();
                let end = (at + 4).min(bytes.len());
                bytes[at..end].copy_from_slice(&size[..end - at]);
            }
        }
    }
    bytes
}

/// Replaces the first number from `at` on.
fn another_number(bytes: &mut Vec<u8>, at: usize, number: &[u8]) {
    let Some(start) = (at..bytes.len()).find(|&i| bytes[i].is_ascii_digit()) else { return };
    let end = (start..bytes.len()).find(|&i| !bytes[i].is_ascii_digit()).unwrap_or(bytes.len());
    bytes.splice(start..end, number.iter().copied());
}
