//! What a member of a crew asks of the others, wherever they are.

use super::board::Unit;
use super::queue::Sample;
use crate::caustics::PassFacts;
use crate::film::FilmPixel;
use crate::irradiance::{LightData, LightFacts};
use crate::render::Rows;
use crate::{Error, Result};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// What a member is to do next.
pub(super) enum Order {
    /// These rows, from their state on.
    Rows(Unit, Box<Rows>),
    /// This sample of all pixels.
    Pass(u32),
    /// To add what has come in to the film.
    Add,
    /// Nothing more.
    Leave,
}

/// What a member that can start needs to know of light in the volume.
pub(super) enum LightOrder {
    /// There is none.
    None,
    /// It computes it.
    Compute,
    /// It is computed.
    Given(Arc<LightData>),
}

/// Where a member gets its work and leaves what it has done: a place at the crew's board, in this process
/// ([`Seat`](super::seat::Seat)) or by a line to another ([`Far`](super::far::Far)).
///
/// All of it fails only when the line does.
pub(super) trait Desk {
    /// Set when nothing more is wanted.
    fn closing(&self) -> &Arc<AtomicBool>;

    /// How long a piece of work should take.
    fn piece(&self) -> Duration;

    /// What is to be done about the light; waits while another member computes it. `None` at the end.
    fn light(&self) -> Result<Option<LightOrder>>;

    /// So much of the light is computed.
    fn light_progress(&self, share: f32) -> Result<()>;

    /// The light is computed.
    fn light_done(
        &self,
        data: LightData,
        facts: Option<LightFacts>,
        launches: u64,
        elapsed: Duration,
    ) -> Result<()>;

    /// The programs are built.
    fn built(&self, time: Duration, cached: bool) -> Result<()>;

    /// What to do next, `pace` being the tile-samples that are done in a piece; waits where there is nothing to do.
    fn order(&self, pace: u64) -> Result<Order>;

    /// Whether what is in hand is still wanted.
    fn go_on(&self) -> bool;

    /// These rows are done.
    fn rows_done(&self, unit: &Unit, rows: &Rows, elapsed: Duration, launches: u64) -> Result<()>;

    /// A sample of all pixels is rendered.
    fn pass_done(
        &self,
        number: u32,
        sample: Sample,
        facts: Option<PassFacts>,
        elapsed: Duration,
    ) -> Result<()>;

    /// A film and the sample that is to be added to it, where it is the turn of one that has come in.
    fn begin_adding(&self) -> Result<Option<(Vec<FilmPixel>, u32, Sample)>>;

    /// The film with that sample added, or the sample, as it could not be.
    ///
    /// # Errors
    /// The reason why it could not be.
    fn end_adding(&self, sample: Sample, film: Result<Vec<FilmPixel>>, launches: u64) -> Result<()>;

    /// The member does no more; what it had in hand is for others.
    fn lose(&self, error: &Error);
}
