//! Which rows of tiles have which samples, and who does what next.

use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Rows of tiles, and the samples that they are to get.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Unit {
    /// The rows.
    pub rows: Range<u32>,
    /// Samples that they have had.
    pub first_sample: u32,
    /// Samples that they get.
    pub samples: u32,
}

/// The rows of tiles of an image.
#[derive(Clone, Debug)]
pub(super) struct Board {
    rows: Vec<Row>,
    /// Tiles in a row.
    width: u32,
}

#[derive(Clone, Copy, Debug)]
struct Row {
    samples: u32,
    taken: bool,
    /// Who had it last.
    by: Option<usize>,
}

impl Board {
    /// Rows of `width` tiles, with the samples that each has had.
    pub fn new(samples: impl IntoIterator<Item = u32>, width: u32) -> Self {
        let rows = samples.into_iter().map(|samples| Row { samples, taken: false, by: None }).collect();
        Self { rows, width }
    }

    /// Takes work of about `pace` tile-samples towards `goal` samples everywhere, for `me`, one of `members`; `None` where
    /// there is none that nobody has.
    ///
    /// Rows with the fewest samples come first, but those that `me` had come last: a slow member would keep what it holds
    /// up. Towards the end the pieces become small, so that all end together. With
    /// a `depth`, there are so few rows that they get as many samples at once, but for the first: a picture with
    /// samples everywhere comes before all. Nobody takes so many rows that others have none, or so many samples of few
    /// rows that the picture becomes uneven.
    pub fn take(&mut self, me: usize, pace: u64, members: usize, goal: u32, depth: u32) -> Option<Unit> {
        let width = u64::from(self.width);
        let left: u64 = self.rows.iter().map(|row| u64::from(goal.saturating_sub(row.samples)) * width).sum();
        let size = pace.min(left / (2 * members.max(1) as u64));
        let free = |row: &Row| !row.taken && row.samples < goal;
        let (_, behind, first) = (self.rows.iter().enumerate().filter(|(_, row)| free(row)))
            .map(|(index, row)| (row.by == Some(me), row.samples, index))
            .min()?;
        let alike = (self.rows[first].by == Some(me), behind);
        let depth = if behind == 0 { 1 } else { depth.clamp(1, goal - behind) };
        // Half of the rows are free when all members have theirs: rows that are behind find somebody soon.
        let share = if members > 1 { self.rows.len().div_ceil(2 * members) } else { self.rows.len() };
        let most = usize::try_from(size / (width * u64::from(depth))).unwrap_or(usize::MAX).clamp(1, share);
        let run = self.rows[first..].iter().take(most);
        let count = run.take_while(|row| free(row) && (row.by == Some(me), row.samples) == alike).count();
        let tiles = width * count as u64;
        let even = (4 * (size / (width * share as u64))).max(2 * u64::from(depth));
        let samples = (size / tiles).min(even).clamp(1, u64::from(goal - behind)) as u32;
        self.rows[first..first + count].iter_mut().for_each(|row| (row.taken, row.by) = (true, Some(me)));
        Some(Unit { rows: first as u32..(first + count) as u32, first_sample: behind, samples })
    }

    /// The work is done.
    pub fn done(&mut self, unit: &Unit) {
        self.release(unit, unit.samples);
    }

    /// The work was not done.
    pub fn give_back(&mut self, unit: &Unit) {
        self.release(unit, 0);
    }

    fn release(&mut self, unit: &Unit, samples: u32) {
        for row in &mut self.rows[unit.rows.start as usize..unit.rows.end as usize] {
            row.taken = false;
            row.samples += samples;
        }
    }

    /// Samples that every row has, and tiles that have more.
    pub fn standing(&self) -> (u32, u32) {
        let least = self.rows.iter().map(|row| row.samples).min().unwrap_or(0);
        let ahead = self.rows.iter().filter(|row| row.samples > least).count();
        (least, ahead as u32 * self.width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_that_are_behind_come_first() {
        let mut board = Board::new([3, 1, 1, 2, 1], 4);
        let unit = |rows, first_sample, samples| Some(Unit { rows, first_sample, samples });
        assert_eq!(board.standing(), (1, 8));
        assert_eq!(board.take(0, 1000, 1, 5, 1), unit(1..3, 1, 4));
        assert_eq!(board.take(0, 1, 1, 5, 1), unit(4..5, 1, 1));
        assert_eq!(board.take(0, 4, 1, 5, 1), unit(3..4, 2, 1));
        assert_eq!(board.take(0, 4, 1, 3, 1), None);
        board.give_back(&unit(4..5, 1, 1).unwrap());
        board.done(&unit(1..3, 1, 4).unwrap());
        assert_eq!(board.standing(), (1, 16));
        // Who had a row lets others have it first.
        assert_eq!(board.clone().take(0, 4, 1, 5, 1), unit(0..1, 3, 1));
        assert_eq!(board.take(1, 4, 1, 5, 1), unit(4..5, 1, 1));
    }

    #[test]
    fn who_is_far_takes_fewer_rows_for_more_samples() {
        let unit = |rows, first_sample, samples| Some(Unit { rows, first_sample, samples });
        let board = Board::new([2; 10], 4);
        assert_eq!(board.clone().take(0, 160, 1, 100, 1), unit(0..10, 2, 4));
        assert_eq!(board.clone().take(0, 160, 1, 100, 16), unit(0..2, 2, 20));
        // No more than there are left, and not before all have the first.
        assert_eq!(board.clone().take(0, 160, 1, 6, 16), unit(0..5, 2, 4));
        assert_eq!(Board::new([0; 10], 4).take(0, 160, 1, 100, 16), unit(0..10, 0, 4));
    }

    #[test]
    fn nobody_is_left_without_rows() {
        for members in 2..6 {
            for had in [0, 7] {
                let mut board = Board::new([had; 13], 7);
                for member in 0..members {
                    assert!(
                        board.take(member, 1_000_000, members, u32::MAX, 1).is_some(),
                        "{member} of {members}"
                    );
                }
            }
        }
    }

    /// Where there is no end to come, rows stay together though one member is fifty times as fast as another, and
    /// though what is free lies in single rows.
    #[test]
    fn rows_stay_together() {
        let mut board = Board::new([0; 40], 10);
        let paces = [5000, 100];
        let mut slow = board.take(1, paces[1], 2, u32::MAX, 1).unwrap();
        for turn in 1..2000 {
            let unit = board.take(0, paces[0], 2, u32::MAX, 1).unwrap();
            // 5000 tile-samples are 50 samples of the ten rows that are its share.
            assert!(unit.samples <= 200, "{unit:?}");
            board.done(&unit);
            if turn % 5 == 0 {
                board.done(&slow);
                slow = board.take(1, paces[1], 2, u32::MAX, 1).unwrap();
            }
            let samples = || board.rows.iter().map(|row| row.samples);
            let (least, most) = (samples().min().unwrap(), samples().max().unwrap());
            assert!(most - least <= 400, "{least} to {most} after {turn}");
        }
    }

    /// Whoever takes what, every row gets every sample once and in order, and all end at the goal.
    #[test]
    fn all_samples_are_done_once_and_in_order() {
        for members in 1..5 {
            let mut board = Board::new([0; 13], 7);
            let (mut held, mut had) = (std::collections::VecDeque::new(), [0_u32; 13]);
            let mut units = 0;
            for goal in [1, 4, 64] {
                loop {
                    let member = units % members;
                    // Some are fifty times as fast as others.
                    match board.take(member, [9, 450, 60, 1][member], members, goal, [1, 5, 16][units % 3]) {
                        Some(unit) if held.len() < members => held.push_back(unit),
                        Some(unit) => board.give_back(&unit),
                        None if held.is_empty() => break,
                        None => {}
                    }
                    if held.len() == members || board.clone().take(member, 1, 1, goal, 1).is_none() {
                        let Some(unit) = held.pop_front() else { break };
                        units += 1;
                        if units % 5 == 0 {
                            board.give_back(&unit);
                            continue;
                        }
                        for row in unit.rows.clone() {
                            assert_eq!(had[row as usize], unit.first_sample);
                            had[row as usize] += unit.samples;
                        }
                        board.done(&unit);
                    }
                }
                assert_eq!((had, board.standing()), ([goal; 13], (goal, 0)));
            }
        }
    }
}
