//! A member's place at the board of a crew in another process.

use super::board::Unit;
use super::desk::{Desk, LightOrder, Order};
use super::message::{
    Answer, Call, LightShape, counted, get_rows, get_sample, misfit, pixels, put_rows, put_sample,
};
use super::queue::Sample;
use crate::caustics::PassFacts;
use crate::film::FilmPixel;
use crate::irradiance::{LightData, LightFacts};
use crate::post::{Line, Packet, Reader};
use crate::render::{Plan, Rows};
use crate::{Error, Result};
use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// How long an answer is waited for until it is seen whether one is still wanted.
const GLANCE: Duration = Duration::from_millis(50);
/// How long a piece of work should take: its way takes little of it then.
const PIECE: Duration = Duration::from_millis(500);

/// The place of one member, at the end of a line that [`attend`](super::attend::attend) serves.
pub(super) struct Far<'a> {
    line: Line<'a>,
    plan: &'a Plan<'a>,
    closing: Arc<AtomicBool>,
    /// The piece of work in hand.
    piece: Cell<u64>,
    /// Whether it is still wanted.
    wanted: Cell<bool>,
    /// Whether there is something to be added to the film: a member that is far adds when it is told to.
    adds: Cell<bool>,
}

impl<'a> Far<'a> {
    pub fn new(line: Line<'a>, plan: &'a Plan<'a>, closing: Arc<AtomicBool>) -> Self {
        let (piece, wanted, adds) = (Cell::new(0), Cell::new(false), Cell::new(false));
        Self { line, plan, closing, piece, wanted, adds }
    }

    fn tell(&self, call: &Call) -> Result<()> {
        self.line.send(Packet::of(call).into_bytes())
    }

    /// The answer to what was asked, and the letter it came in; `None` at the end.
    fn answer(&self) -> Result<Option<(Answer, Vec<u8>)>> {
        while !self.closing.load(Ordering::Relaxed) {
            let Some(bytes) = self.line.receive(GLANCE)? else { continue };
            match Reader::new(&bytes).head()? {
                // It came too late.
                Answer::Drop { .. } => {}
                answer => return Ok(Some((answer, bytes))),
            }
        }
        Ok(None)
    }

    fn begin(&self, piece: u64) {
        self.piece.set(piece);
        self.wanted.set(true);
    }
}

/// What follows the head of a letter.
fn arrays(bytes: &[u8]) -> Result<Reader<'_>> {
    let mut reader = Reader::new(bytes);
    reader.head::<serde::de::IgnoredAny>()?;
    Ok(reader)
}

impl Desk for Far<'_> {
    fn closing(&self) -> &Arc<AtomicBool> {
        &self.closing
    }

    fn piece(&self) -> Duration {
        PIECE
    }

    fn light(&self) -> Result<Option<LightOrder>> {
        self.tell(&Call::Light)?;
        let Some((answer, bytes)) = self.answer()? else { return Ok(None) };
        match answer {
            Answer::Light { compute: true, .. } => Ok(Some(LightOrder::Compute)),
            Answer::Light { shape: None, .. } => Ok(Some(LightOrder::None)),
            Answer::Light { shape: Some(shape), .. } => {
                let light = shape.get(&mut arrays(&bytes)?, self.plan)?;
                Ok(Some(LightOrder::Given(Arc::new(light))))
            }
            Answer::Leave => Ok(None),
            _ => Err(misfit("letter")),
        }
    }

    fn light_progress(&self, share: f32) -> Result<()> {
        self.tell(&Call::LightProgress(share))
    }

    fn light_done(
        &self,
        data: LightData,
        facts: Option<LightFacts>,
        launches: u64,
        elapsed: Duration,
    ) -> Result<()> {
        let call = Call::LightDone { shape: LightShape::of(&data), facts, launches, elapsed };
        self.line.send(LightShape::put(&data, Packet::of(&call)).into_bytes())
    }

    fn built(&self, time: Duration, cached: bool) -> Result<()> {
        self.tell(&Call::Built { time, cached })
    }

    fn order(&self, pace: u64) -> Result<Order> {
        self.tell(&Call::Order { pace })?;
        let Some((answer, bytes)) = self.answer()? else { return Ok(Order::Leave) };
        match answer {
            Answer::Rows { piece, unit } => {
                let rows = get_rows(&mut arrays(&bytes)?, &unit, self.plan)?;
                self.begin(piece);
                Ok(Order::Rows(unit, Box::new(rows)))
            }
            Answer::Pass { piece, sample } => {
                self.begin(piece);
                Ok(Order::Pass(sample))
            }
            Answer::Add => {
                self.adds.set(true);
                Ok(Order::Add)
            }
            Answer::Leave => Ok(Order::Leave),
            _ => Err(misfit("letter")),
        }
    }

    fn go_on(&self) -> bool {
        // A line that is broken shows at the next call.
        while let Ok(Some(bytes)) = self.line.receive(Duration::ZERO) {
            if let Ok(Answer::Drop { piece }) = Reader::new(&bytes).head()
                && piece == self.piece.get()
            {
                self.wanted.set(false);
            }
        }
        self.wanted.get() && !self.closing.load(Ordering::Relaxed)
    }

    fn rows_done(&self, unit: &Unit, rows: &Rows, elapsed: Duration, launches: u64) -> Result<()> {
        let call = Call::RowsDone { unit: unit.clone(), elapsed, launches };
        self.line.send(put_rows(Packet::of(&call), rows).into_bytes())
    }

    fn pass_done(
        &self,
        number: u32,
        sample: Sample,
        facts: Option<PassFacts>,
        elapsed: Duration,
    ) -> Result<()> {
        let call = Call::PassDone { number, passes: sample.photons.passes, facts, elapsed };
        self.line.send(put_sample(Packet::of(&call), &sample).into_bytes())
    }

    fn begin_adding(&self) -> Result<Option<(Vec<FilmPixel>, u32, Sample)>> {
        if !self.adds.get() {
            return Ok(None);
        }
        self.tell(&Call::BeginAdding)?;
        let Some((answer, bytes)) = self.answer()? else { return Ok(None) };
        let Answer::Adding(number) = answer else { return Err(misfit("letter")) };
        self.adds.set(number.is_some());
        let Some(number) = number else { return Ok(None) };
        let mut reader = arrays(&bytes)?;
        let film = counted(reader.array()?, pixels(self.plan))?;
        Ok(Some((film, number, get_sample(&mut reader, number, self.plan)?)))
    }

    fn end_adding(&self, _sample: Sample, film: Result<Vec<FilmPixel>>, launches: u64) -> Result<()> {
        let failure = film.as_ref().err().map(Error::to_string);
        let packet = Packet::of(&Call::EndAdding { failure, launches });
        let packet = if let Ok(film) = &film { packet.with(film) } else { packet };
        self.line.send(packet.into_bytes()).and(film.map(drop))
    }

    fn lose(&self, error: &Error) {
        let reason = (!matches!(error, Error::Interrupted)).then(|| error.to_string());
        // Where the line is broken, the other end has learnt of it by itself.
        let _ = self.tell(&Call::Lost(reason));
    }
}
