//! The tiles of an image, and how many samples each has where they differ.

use crate::film::FilmPixel;

/// Pixels per edge of a tile: mirrors `TILE_SHIFT` in `cl/render/frame.cl`.
pub const TILE: u32 = 8;

/// Neighbouring tiles that have fewer samples than others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lag {
    /// The first of the tiles.
    pub first_tile: u32,
    /// How many.
    pub tiles: u32,
    /// Samples that each has.
    pub samples: u32,
    /// Samples that the others have.
    pub goal: u32,
}

impl Lag {
    /// Tiles and samples of a launch of so many tile-samples that brings them nearer to the others.
    pub(super) fn launch(&self, units: u64, most_samples: u32) -> (u32, u32) {
        let tiles = u32::try_from(units).unwrap_or(u32::MAX).clamp(1, self.tiles);
        let samples = u32::try_from(units / u64::from(tiles)).unwrap_or(u32::MAX);
        (tiles, samples.clamp(1, (self.goal - self.samples).min(most_samples)))
    }

    /// What is left after a launch for the first `tiles`.
    pub(super) fn after(&mut self, tiles: u32, samples: u32) -> impl Iterator<Item = Self> {
        let nearer = Self { tiles, samples: self.samples + samples, ..*self };
        let rest = Self { first_tile: self.first_tile + tiles, tiles: self.tiles - tiles, ..*self };
        [rest, nearer].into_iter().filter(|lag| lag.tiles > 0 && lag.samples < lag.goal)
    }
}

/// Where a film stands.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Standing {
    /// Samples that every pixel has had.
    pub samples: u32,
    /// The most that a pixel has had.
    pub most: u32,
    /// Tiles that have had more than every pixel.
    pub tiles: u32,
    /// Those that have had fewer than some, unless the first ones have one more and all others none: then there is
    /// nothing to catch up with.
    pub lag: Vec<Lag>,
}

impl Standing {
    /// That of a film `width` pixels wide; `None` where the pixels of a tile differ.
    pub fn of(film: &[FilmPixel], width: u32) -> Option<Self> {
        let counts = tile_counts(film, width as usize)?;
        let samples = counts.iter().copied().min().unwrap_or(0);
        let goal = counts.iter().copied().max().unwrap_or(0);
        let tiles = counts.iter().filter(|&&count| count > samples).count();
        let first_ones = goal == samples + 1 && counts[..tiles].iter().all(|&count| count == goal);
        let lag = if goal == samples || first_ones { Vec::new() } else { lags(&counts, goal) };
        Some(Self { samples, most: goal, tiles: u32::try_from(tiles).ok()?, lag })
    }
}

/// Runs of tiles with the same number of samples, fewer than `goal`.
pub(super) fn lags(counts: &[u32], goal: u32) -> Vec<Lag> {
    let mut first_tile = 0;
    let mut lags = Vec::new();
    for run in counts.chunk_by(|a, b| a == b) {
        let tiles = run.len() as u32;
        if run[0] < goal {
            lags.push(Lag { first_tile, tiles, samples: run[0], goal });
        }
        first_tile += tiles;
    }
    lags
}

/// Samples that were tried in each tile; `None` where its pixels differ.
pub(super) fn tile_counts(film: &[FilmPixel], width: usize) -> Option<Vec<u32>> {
    let edge = TILE as usize;
    let per_row = width.div_ceil(edge);
    let height = film.len() / width.max(1);
    let mut counts: Vec<Option<u32>> = vec![None; per_row * height.div_ceil(edge)];
    for (index, pixel) in film.iter().enumerate() {
        let count = pixel.count.checked_add(pixel.rejected)?;
        let known = counts[index / width / edge * per_row + index % width / edge].get_or_insert(count);
        if *known != count {
            return None;
        }
    }
    counts.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    /// A film of 19×10 pixels (3×2 tiles) with these sample counts.
    fn film(count: impl Fn(usize, usize) -> u32) -> Vec<FilmPixel> {
        let pixel = |i: usize| FilmPixel { count: count(i % 19, i / 19), ..FilmPixel::zeroed() };
        (0..190).map(pixel).collect()
    }

    fn by_tile(counts: [u32; 6]) -> Vec<FilmPixel> {
        film(|x, y| counts[y / 8 * 3 + x / 8])
    }

    #[test]
    fn counts_tell_samples_and_tiles() {
        for tiles in 0..6 {
            let found = Standing::of(&by_tile(std::array::from_fn(|tile| 7 + u32::from(tile < tiles))), 19);
            let most = if tiles > 0 { 8 } else { 7 };
            assert_eq!(found, Some(Standing { samples: 7, most, tiles: tiles as u32, lag: Vec::new() }));
        }
    }

    #[test]
    fn rejected_samples_were_tried_too() {
        let mut film = film(|_, _| 5);
        (film[30].count, film[30].rejected) = (3, 2);
        assert_eq!(Standing::of(&film, 19), Some(Standing { samples: 5, most: 5, ..Standing::default() }));
    }

    #[test]
    fn tiles_with_fewer_samples_are_found() {
        let found = Standing::of(&by_tile([9, 7, 7, 8, 9, 7]), 19).unwrap();
        let lag = |first_tile, tiles, samples| Lag { first_tile, tiles, samples, goal: 9 };
        assert_eq!((found.samples, found.tiles), (7, 3));
        assert_eq!(found.lag, [lag(1, 2, 7), lag(3, 1, 8), lag(5, 1, 7)]);
    }

    #[test]
    fn pixels_of_a_tile_have_the_same_number() {
        assert_eq!(Standing::of(&film(|x, y| 7 + u32::from((x, y) == (0, 0))), 19), None);
        assert_eq!(Standing::of(&film(|x, y| if (x, y) == (18, 9) { 0 } else { 7 }), 19), None);
        let mut film = film(|_, _| u32::MAX);
        film[0].rejected = 1;
        assert_eq!(Standing::of(&film, 19), None);
    }

    #[test]
    fn tiles_that_are_behind_catch_up_whatever_the_launches() {
        for units in [1, 2, 5, 6, 7, 100] {
            for most in [1, 3, u32::MAX] {
                let mut counts = [2_u32, 2, 2, 4, 4, 9];
                let mut left = lags(&counts, 9);
                let mut launches = 0;
                while let Some(mut lag) = left.pop() {
                    let (tiles, samples) = lag.launch(units, most);
                    assert!(samples <= most && u64::from(tiles) * u64::from(samples) <= units.max(1));
                    for count in &mut counts[lag.first_tile as usize..][..tiles as usize] {
                        assert_eq!(*count, lag.samples);
                        *count += samples;
                    }
                    left.extend(lag.after(tiles, samples));
                    launches += 1;
                }
                assert_eq!(counts, [9; 6]);
                assert!(launches <= 31);
            }
        }
    }
}
