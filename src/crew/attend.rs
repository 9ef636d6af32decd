//! The crew's end of a line to a member of another process: what the member asks for is done at its seat here.

use super::desk::{Desk, LightOrder, Order};
use super::message::{
    Answer, Call, LightShape, counted, get_rows, get_sample, misfit, pixels, put_rows, put_sample,
};
use super::queue::Sample;
use super::seat::Seat;
use crate::post::{Line, Packet, Reader};
use crate::render::Plan;
use crate::{Error, Result};
use std::sync::atomic::Ordering;
use std::time::Duration;

/// How long a letter is waited for until it is seen whether the work in hand is still wanted.
const GLANCE: Duration = Duration::from_millis(20);

/// Serves a member until the end, or until it is lost.
pub(super) fn attend(seat: &Seat<'_>, plan: &Plan<'_>, line: &Line<'_>) {
    let mut attendant = Attendant { seat, plan, line, adding: None };
    let work = std::panic::AssertUnwindSafe(|| attendant.serve());
    let ended = std::panic::catch_unwind(work)
        .unwrap_or_else(|_| Err(Error::Failed("its thread panicked: a mistake of this program".into())));
    if let Err(error) = ended {
        if let Some(sample) = attendant.adding {
            // Its turn is still to come; what has failed is said below.
            let _ = seat.end_adding(sample, Err(Error::Interrupted), 0);
        }
        seat.lose(&error);
    }
}

struct Attendant<'a, 's> {
    seat: &'a Seat<'s>,
    plan: &'a Plan<'a>,
    line: &'a Line<'a>,
    /// What the member is adding to the film.
    adding: Option<Sample>,
}

impl Attendant<'_, '_> {
    fn serve(&mut self) -> Result<()> {
        // Pieces of work that were given, and whether the last is still in hand.
        let (mut pieces, mut in_hand) = (0, false);
        while !self.seat.closing().load(Ordering::Relaxed) {
            let Some(bytes) = self.line.receive(GLANCE)? else {
                if in_hand && !self.seat.go_on() {
                    in_hand = false;
                    self.tell(&Answer::Drop { piece: pieces })?;
                }
                continue;
            };
            let mut reader = Reader::new(&bytes);
            match reader.head()? {
                Call::Order { pace } => {
                    pieces += 1;
                    in_hand = true;
                    if !self.order(pace, pieces)? {
                        return Ok(());
                    }
                }
                Call::BeginAdding => self.adding = self.begin_adding()?,
                Call::EndAdding { failure, launches } => {
                    let sample = self.adding.take().ok_or_else(|| misfit("letter"))?;
                    let film = match failure {
                        None => reader.array().and_then(|film| counted(film, pixels(self.plan))),
                        Some(failure) => Err(Error::Failed(failure)),
                    };
                    self.seat.end_adding(sample, film, launches)?;
                }
                Call::Lost(reason) => return Err(reason.map_or(Error::Interrupted, Error::Failed)),
                call => self.obey(call, &mut reader)?,
            }
        }
        Ok(())
    }

    fn tell(&self, answer: &Answer) -> Result<()> {
        self.line.send(Packet::of(answer).into_bytes())
    }

    /// Gives the next piece of work; `false` at the end.
    fn order(&self, pace: u64, piece: u64) -> Result<bool> {
        let order = self.seat.order(pace)?;
        let goes_on = !matches!(order, Order::Leave);
        match order {
            Order::Rows(unit, rows) => {
                self.line.send(put_rows(Packet::of(&Answer::Rows { piece, unit }), &rows).into_bytes())?;
            }
            Order::Pass(sample) => self.tell(&Answer::Pass { piece, sample })?,
            Order::Add => self.tell(&Answer::Add)?,
            Order::Leave => self.tell(&Answer::Leave)?,
        }
        Ok(goes_on)
    }

    fn begin_adding(&self) -> Result<Option<Sample>> {
        let Some((film, number, sample)) = self.seat.begin_adding()? else {
            self.tell(&Answer::Adding(None))?;
            return Ok(None);
        };
        let packet = Packet::of(&Answer::Adding(Some(number))).with(&film);
        self.line.send(put_sample(packet, &sample).into_bytes())?;
        Ok(Some(sample))
    }

    fn light(&self) -> Result<()> {
        let plain = |compute| Packet::of(&Answer::Light { compute, shape: None });
        let packet = match self.seat.light()? {
            None => Packet::of(&Answer::Leave),
            Some(LightOrder::None) => plain(false),
            Some(LightOrder::Compute) => plain(true),
            Some(LightOrder::Given(light)) => {
                let shape = Some(LightShape::of(&light));
                LightShape::put(&light, Packet::of(&Answer::Light { compute: false, shape }))
            }
        };
        self.line.send(packet.into_bytes())
    }

    fn obey(&self, call: Call, reader: &mut Reader<'_>) -> Result<()> {
        match call {
            Call::Light => self.light(),
            Call::LightProgress(share) => self.seat.light_progress(share),
            Call::LightDone { shape, facts, launches, elapsed } => {
                self.seat.light_done(shape.get(reader, self.plan)?, facts, launches, elapsed)
            }
            Call::Built { time, cached } => self.seat.built(time, cached),
            Call::RowsDone { unit, elapsed, launches } => {
                let rows = get_rows(reader, &unit, self.plan)?;
                self.seat.rows_done(&unit, &rows, elapsed, launches)
            }
            Call::PassDone { number, passes, facts, elapsed } => {
                let sample = get_sample(reader, passes, self.plan)?;
                self.seat.pass_done(number, sample, facts, elapsed)
            }
            Call::Order { .. } | Call::BeginAdding | Call::EndAdding { .. } | Call::Lost(_) => {
                Err(misfit("letter"))
            }
        }
    }
}
