//! The state of a render in its image: the film, the auxiliary images, and what merged films hold besides.

use super::auxiliary::{self, Auxiliary, AuxiliaryRest};
use super::fingerprint::Fingerprint;
use super::state::{self, Part};
use crate::film::{FilmPixel, FilmRest};
use crate::picture::Picture;

/// What an image keeps of each pixel, bit for bit.
pub(super) struct Kept {
    /// The film, row by row from the top.
    pub pixels: Vec<FilmPixel>,
    /// The auxiliary images, where there are some.
    pub auxiliary: Option<Vec<Auxiliary>>,
    /// What merged films hold that their floats cannot, where more is to be merged.
    pub rest: Option<Rest>,
}

/// What the floats of merged films cannot hold.
pub(super) struct Rest {
    /// Of the film.
    pub pixels: Vec<FilmRest>,
    /// Of the auxiliary images.
    pub auxiliary: Option<Vec<AuxiliaryRest>>,
}

/// What the distances in an image are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Units {
    /// Scene units per local unit.
    pub unit: f64,
    /// Whether `Z` is that of the film.
    pub has_depth: bool,
}

/// The key in the header of an image that keeps a [`Rest`], and what it says.
pub(super) const REST: (&str, &str) =
    ("svetlo.rest", "state.rest.* is what floats cannot hold of the sums, for merging in any order");

const NOTHING: &(dyn Fn(&Picture, &str) -> Option<Vec<u32>> + Sync) = &|_, _| None;

fn film_rest<'a>() -> Part<'a> {
    Part { prefix: "state.rest.", layout: FilmRest::LAYOUT, predict: NOTHING }
}

fn auxiliary_rest<'a>() -> Part<'a> {
    Part { prefix: "state.rest.auxiliary.", layout: AuxiliaryRest::LAYOUT, predict: NOTHING }
}

/// Adds the state to a picture that has all other channels; returns its hash. `rest`: also what floats cannot hold.
pub(super) fn add(
    picture: &mut Picture,
    film: &[FilmPixel],
    extra: Option<&[Auxiliary]>,
    rest: Option<&Rest>,
    units: Units,
) -> String {
    let Units { unit, has_depth } = units;
    let mut sum = Fingerprint::new();
    let predict =
        |picture: &Picture, word: &str| state::predict_film(picture, word, has_depth.then_some(unit));
    state::add_planes(picture, &state::film_part(&predict), film, &mut sum);
    if let Some(extra) = extra {
        let predict = |picture: &Picture, word: &str| auxiliary::predict(picture, word, unit);
        state::add_planes(picture, &auxiliary::part(&predict), extra, &mut sum);
    }
    if let Some(rest) = rest {
        state::add_planes(picture, &film_rest(), &rest.pixels, &mut sum);
        if let Some(extra) = &rest.auxiliary {
            state::add_planes(picture, &auxiliary_rest(), extra, &mut sum);
        }
        picture.metadata.insert(REST.0.into(), REST.1.into());
    }
    sum.finish()
}

/// The state that [`add`] added.
///
/// # Errors
/// That it is not as it was written.
pub(super) fn read(picture: &Picture, units: Units, has_auxiliary: bool) -> Result<Kept, String> {
    let Units { unit, has_depth } = units;
    let mut sum = Fingerprint::new();
    let predict =
        |picture: &Picture, word: &str| state::predict_film(picture, word, has_depth.then_some(unit));
    let pixels = state::read_planes(picture, &state::film_part(&predict), &mut sum);
    let auxiliary = has_auxiliary.then(|| {
        let predict = |picture: &Picture, word: &str| auxiliary::predict(picture, word, unit);
        state::read_planes(picture, &auxiliary::part(&predict), &mut sum)
    });
    let rest = picture.metadata.contains_key(REST.0).then(|| Rest {
        pixels: state::read_planes(picture, &film_rest(), &mut sum),
        auxiliary: has_auxiliary.then(|| state::read_planes(picture, &auxiliary_rest(), &mut sum)),
    });
    if picture.metadata.get("svetlo.state_hash") != Some(&sum.finish()) {
        return Err("its channels are not as svetlo wrote them: some were changed or are missing".into());
    }
    Ok(Kept { pixels, auxiliary, rest })
}
