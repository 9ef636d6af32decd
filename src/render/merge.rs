//! Merging: parts of one picture, as EXR images, to the picture of all their samples.
//!
//! Images are read one after another, in the order of their parts. Sums are kept to 2⁻¹⁰⁰ (see [`Moments`]), and what
//! floats cannot hold of them is written where parts are missing yet: in whatever order and groups parts are merged, the
//! image comes out the same.

use super::auxiliary::{self, AuxiliaryMeans, AuxiliaryRest};
use super::kept::{self, Kept, Rest};
use super::ledger::PathLedger;
use super::merge_header::{Header, Ledgers};
use super::output;
use super::parts::Parts;
use super::tiles::Standing;
use crate::caustics::PassLedger;
use crate::film::{FilmPixel, FilmRest, FilmSummary, Moments, weighted};
use crate::picture::{Picture, Tonemap, read_exr, read_exr_header};
use crate::{Error, Result};
use bytemuck::Zeroable;
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// Parts added up.
pub struct Merged {
    /// The picture, with metadata and state.
    pub picture: Picture,
    /// The film as a whole.
    pub summary: FilmSummary,
    /// What the paths did, when the method follows paths.
    pub paths: Option<PathLedger>,
    /// Where the flux of photons went, for caustics.
    pub photons: Option<PassLedger>,
    /// The parts in it.
    pub parts: Parts,
    /// The curve of the preview, as the scene of the first part asks for it.
    pub tonemap: Tonemap,
    /// What the user should know, one sentence each.
    pub notes: Vec<String>,
}

/// Adds up the parts in these images, as [`svetlo render --part`](super::Share) or a merge wrote them.
///
/// # Errors
/// [`Error::Input`] that names the image that is no part, is damaged, of another picture, or holds a part that another
/// one holds, too.
pub fn merge(paths: &[PathBuf]) -> Result<Merged> {
    let mut inputs = headers(paths)?;
    inputs.sort_by_key(|(_, header)| header.parts.first());
    let mut sums: Option<Sums> = None;
    for (path, header) in &inputs {
        // It may have been replaced since: a part that is still being rendered is.
        let picture = read_exr(path)?;
        let refuse = |what: String| refusal(path, &what);
        let now = Header::read(&picture).map_err(refuse)?;
        if !now.parts.are_those_of(&header.parts) || header.difference(&now).is_some() {
            return Err(refuse("it became another picture while it was read; merge again".into()));
        }
        let one = Image::read(picture, now).map_err(refuse)?;
        match &mut sums {
            None => sums = Some(Sums::of(one)),
            Some(sums) => sums.add(one).map_err(refuse)?,
        }
    }
    sums.map_or_else(|| Err(Error::Input("there are no parts to merge".into())), Sums::finish)
}

fn refusal(path: &Path, what: &str) -> Error {
    Error::Input(format!("{}: cannot be merged: {what}", path.display()))
}

/// The headers of all images, which must be parts of one picture, each another.
fn headers(paths: &[PathBuf]) -> Result<Vec<(&Path, Header)>> {
    let mut all: Vec<(&Path, Header)> = Vec::new();
    for path in paths {
        let header = Header::read(&read_exr_header(path)?).map_err(|what| refusal(path, &what))?;
        for (other, known) in &all {
            if let Some(what) = known.difference(&header) {
                return Err(refusal(path, &format!("it and {} {what}", other.display())));
            }
            if let Some(part) = known.parts.common(&header.parts) {
                return Err(refusal(
                    path,
                    &format!("part {part} of {} is in {}, too", header.parts.of(), other.display()),
                ));
            }
        }
        all.push((path, header));
    }
    Ok(all)
}

/// What an image adds.
struct Image {
    header: Header,
    kept: Kept,
    ledgers: Ledgers,
}

impl Image {
    fn read(picture: Picture, mut header: Header) -> Result<Self, String> {
        let kept = kept::read(&picture, header.units, header.has_auxiliary)?;
        let ledgers = Ledgers::read(&picture.metadata)?;
        check_counts(&kept.pixels, &mut header)?;
        Ok(Self { header, kept, ledgers })
    }
}

/// Sums over parts.
struct Sums {
    header: Header,
    film: Vec<Moments>,
    auxiliary: Option<Vec<AuxiliaryMeans>>,
    ledgers: Ledgers,
}

impl Sums {
    /// Those of one image.
    fn of(image: Image) -> Self {
        let Image { header, kept, ledgers } = image;
        let pixels = kept.pixels.len();
        let auxiliary = header.has_auxiliary.then(|| vec![AuxiliaryMeans::default(); pixels]);
        let mut sums = Self { header, film: vec![Moments::default(); pixels], auxiliary, ledgers };
        sums.add_pixels(&kept);
        sums
    }

    /// Adds another image's.
    fn add(&mut self, image: Image) -> Result<(), String> {
        let Image { header, kept, ledgers } = image;
        self.header.parts.add(&header.parts);
        if self.header.parts.most_samples() > u64::from(u32::MAX) {
            return Err("with it, the parts have more than 2^32 - 1 samples".into());
        }
        self.add_pixels(&kept);
        self.ledgers.add(&ledgers);
        Ok(())
    }

    fn add_pixels(&mut self, kept: &Kept) {
        let rest = kept.rest.as_ref();
        if let (Some(means), Some(extra)) = (&mut self.auxiliary, &kept.auxiliary) {
            let rest = rest.and_then(|rest| rest.auxiliary.as_ref());
            let counts = self.film.par_iter().zip(&kept.pixels);
            means.par_iter_mut().zip(extra).zip(counts).enumerate().for_each(
                |(index, ((sum, more), (film, pixel)))| {
                    let none = AuxiliaryRest::zeroed();
                    let more = auxiliary::means(more, rest.map_or(&none, |rest| &rest[index]));
                    for (x, y) in sum.iter_mut().zip(more) {
                        *x = weighted(*x, film.count(), y, pixel.count);
                    }
                },
            );
        }
        let rest = rest.map(|rest| &rest.pixels);
        self.film.par_iter_mut().zip(&kept.pixels).enumerate().for_each(|(index, (sum, pixel))| {
            let none = FilmRest::zeroed();
            *sum = sum.plus(&Moments::of(pixel, rest.map_or(&none, |rest| &rest[index])));
        });
    }

    /// The picture.
    fn finish(self) -> Result<Merged> {
        let Self { header, film, auxiliary, ledgers } = self;
        let (pixels, film_rest): (Vec<FilmPixel>, Vec<FilmRest>) =
            film.par_iter().map(Moments::pixel).unzip();
        drop(film);
        let (extra, auxiliary_rest) = match &auxiliary {
            Some(means) => {
                let (pixels, rest): (Vec<_>, Vec<_>) = means.par_iter().map(auxiliary::of_means).unzip();
                (Some(pixels), Some(rest))
            }
            None => (None, None),
        };
        let missing = header.parts.missing();
        let rest = Rest { pixels: film_rest, auxiliary: auxiliary_rest };
        let rest = (!missing.is_empty()).then_some(rest);
        let Header { units, size: (width, height), .. } = header;
        let mut picture = output::planes(&pixels, width, height, units);
        if let Some(extra) = &extra {
            auxiliary::add_channels(&mut picture, extra, units.unit);
        }
        let mut summary = FilmSummary::of(&pixels);
        picture.metadata = header.metadata;
        let (paths, photons) = ledgers.describe(&mut picture.metadata, &header.parts, &mut summary)?;
        let notes = ledgers.note().into_iter().collect();
        picture.metadata.remove(kept::REST.0);
        let hash = kept::add(&mut picture, &pixels, extra.as_deref(), rest.as_ref(), units);
        picture.metadata.insert("svetlo.state_hash".into(), hash);
        Ok(Merged { picture, summary, paths, photons, parts: header.parts, tonemap: header.tonemap, notes })
    }
}

/// Checks that the pixels have as many samples as the header says, and finds out how many more some of a single part
/// have.
fn check_counts(pixels: &[FilmPixel], header: &mut Header) -> Result<(), String> {
    let parts = &mut header.parts;
    let right = if header.is_merged {
        let attempts = pixels.iter().map(|pixel| u64::from(pixel.count) + u64::from(pixel.rejected));
        let (least, most) = attempts.fold((u64::MAX, 0), |(least, most), n| (least.min(n), most.max(n)));
        least >= parts.samples() && most <= parts.most_samples()
    } else {
        let standing = Standing::of(pixels, header.size.0 as u32)
            .ok_or("the sample counts of its pixels are none that a render stops at")?;
        parts.set_more(standing.most - standing.samples);
        u64::from(standing.samples) == parts.samples()
    };
    if right { Ok(()) } else { Err("svetlo.samples in its header is not what its pixels have".into()) }
}
