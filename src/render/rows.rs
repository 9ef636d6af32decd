//! Parts of a render's work on a device: rows of tiles, or whole samples where each has photons of its own.

use super::auxiliary::Auxiliary;
use super::ledger::PathLedger;
use super::plan::Plan;
use super::session::Session;
use super::tiles::{Lag, TILE, lags, tile_counts};
use crate::caustics::PassLedger;
use crate::film::FilmPixel;
use crate::{Error, Result};
use bytemuck::Zeroable;
use std::ops::Range;

/// Rows of tiles of a film, on their way between host and devices.
///
/// Its pixels are those after the samples that they have had: whichever device adds the next ones does what the one
/// before would have done.
#[derive(Clone, Debug)]
pub struct Rows {
    /// The first tile.
    pub first_tile: u32,
    /// How many: whole rows.
    pub tiles: u32,
    /// Pixels in a row of the image.
    pub width: u32,
    /// Where the pixels are in the image.
    pub pixels: Range<usize>,
    /// The pixels.
    pub film: Vec<FilmPixel>,
    /// Their auxiliary images, where there are some.
    pub auxiliary: Vec<Auxiliary>,
    /// What the paths did.
    pub paths: PathLedger,
}

impl Rows {
    /// The rows of tiles `rows` of the plan's image, with nothing in them yet.
    pub fn of(rows: Range<u32>, plan: &Plan<'_>) -> Self {
        let (width, height) = (plan.scene.image.width, plan.scene.image.height);
        let (tiles, pixels) = extent_of_rows(rows, width, height);
        Self {
            first_tile: tiles.start,
            tiles: tiles.end - tiles.start,
            width,
            pixels,
            film: Vec::new(),
            auxiliary: Vec::new(),
            paths: PathLedger::default(),
        }
    }
}

/// Where the rows of tiles `rows` are in an image: tiles and pixels.
pub fn extent_of_rows(rows: Range<u32>, width: u32, height: u32) -> (Range<u32>, Range<usize>) {
    let per_row = width.div_ceil(TILE);
    let pixels = |row: u32| width as usize * (row * TILE).min(height) as usize;
    (rows.start * per_row..rows.end * per_row, pixels(rows.start)..pixels(rows.end))
}

impl Session {
    /// Brings the pixels of `rows` to `goal` samples; those that have as many stay. `false` when `go_on` said no between
    /// launches: then they are as they were.
    ///
    /// # Errors
    /// [`Error::Failed`] when the device fails, or pixels of a tile have had different numbers of samples.
    pub fn compute(&mut self, rows: &mut Rows, goal: u32, go_on: &dyn Fn() -> bool) -> Result<bool> {
        let counts = tile_counts(&rows.film, rows.width as usize);
        let counts = counts.ok_or_else(|| Error::Failed("pixels of a tile differ in samples".into()))?;
        let Rows { first_tile, tiles, ref pixels, .. } = *rows;
        self.film.write(&self.device, pixels.start, &rows.film)?;
        let per_tile =
            if self.paths.as_ref().is_some_and(|paths| paths.tile_items) { 1 } else { TILE * TILE };
        let accounts = (first_tile * per_tile) as usize..((first_tile + tiles) * per_tile) as usize;
        if let Some(paths) = &self.paths {
            paths.ledgers.write(&self.device, accounts.start, &vec![Zeroable::zeroed(); accounts.len()])?;
            if !rows.auxiliary.is_empty() {
                paths.auxiliary.write(&self.device, pixels.start, &rows.auxiliary)?;
            }
        }
        let mut left = lags(&counts, goal);
        left.iter_mut().for_each(|lag| lag.first_tile += first_tile);
        while let Some(mut lag) = left.pop() {
            if !go_on() {
                return Ok(false);
            }
            let (tiles, samples) = lag.launch(self.next_units(), self.most_samples());
            self.launch(lag.first_tile, tiles, lag.samples, samples)?;
            left.extend(lag.after(tiles, samples));
        }
        rows.film = self.film.read_part(&self.device, pixels.start, pixels.len())?;
        if let Some(paths) = &self.paths {
            rows.paths =
                PathLedger::of(&paths.ledgers.read_part(&self.device, accounts.start, accounts.len())?);
            if !rows.auxiliary.is_empty() {
                rows.auxiliary = paths.auxiliary.read_part(&self.device, pixels.start, pixels.len())?;
            }
        }
        Ok(true)
    }

    /// Sample `sample` of all pixels, alone, with the photons of its pass: a film of one sample, and where the photons'
    /// flux went. `None` when `go_on` said no between launches.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device fails.
    pub fn compute_pass(
        &mut self,
        sample: u32,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Option<(Vec<FilmPixel>, PassLedger)>> {
        self.film.write(&self.device, 0, &vec![FilmPixel::zeroed(); self.film.len()])?;
        let Some(passes) = &mut self.passes else { return Ok(None) };
        // Of this pass alone.
        passes.restore(PassLedger { passes: sample, ..PassLedger::default() });
        while !passes.is_ready(sample) {
            if !go_on() {
                return Ok(None);
            }
            passes.step(&self.device, sample)?;
        }
        let photons = *passes.ledger();
        let mut left = vec![Lag { first_tile: 0, tiles: self.tiles, samples: sample, goal: sample + 1 }];
        while let Some(mut lag) = left.pop() {
            if !go_on() {
                return Ok(None);
            }
            let (tiles, samples) = lag.launch(self.next_units(), 1);
            self.launch(lag.first_tile, tiles, lag.samples, samples)?;
            left.extend(lag.after(tiles, samples));
        }
        Ok(Some((self.film.read(&self.device)?, photons)))
    }
}

#[cfg(test)]
mod tests {
    use super::extent_of_rows;

    #[test]
    fn rows_of_tiles_are_tiles_and_pixels() {
        assert_eq!(extent_of_rows(0..1, 19, 10), (0..3, 0..152));
        assert_eq!(extent_of_rows(1..2, 19, 10), (3..6, 152..190));
        assert_eq!(extent_of_rows(0..2, 19, 10), (0..6, 0..190));
    }
}
