//! What a member of another process and the crew write to each other: [`Desk`](super::desk::Desk), by letter.

use super::board::Unit;
use super::queue::Sample;
use crate::caustics::{PassFacts, PassLedger};
use crate::irradiance::{Directions, LightData, LightFacts};
use crate::post::{Packet, Reader};
use crate::render::{PathLedger, Plan, Rows};
use crate::{Error, Result};
use bytemuck::{NoUninit, Zeroable};
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// From a member to the crew.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Call {
    /// Answered by [`Answer::Light`].
    Light,
    LightProgress(f32),
    /// With the light.
    LightDone {
        shape: LightShape,
        facts: Option<LightFacts>,
        launches: u64,
        elapsed: Duration,
    },
    Built {
        time: Duration,
        cached: bool,
    },
    /// Answered by [`Answer::Rows`], [`Answer::Pass`], [`Answer::Add`] or [`Answer::Leave`].
    Order {
        pace: u64,
    },
    /// With the rows.
    RowsDone {
        unit: Unit,
        elapsed: Duration,
        launches: u64,
    },
    /// With the sample.
    PassDone {
        number: u32,
        passes: u32,
        facts: Option<PassFacts>,
        elapsed: Duration,
    },
    /// Answered by [`Answer::Adding`].
    BeginAdding,
    /// With the film, unless there is a reason why not.
    EndAdding {
        failure: Option<String>,
        launches: u64,
    },
    /// The member works no more, for this reason; none: nothing is wrong with its device.
    Lost(Option<String>),
}

/// From the crew to a member.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Answer {
    /// With the light, where there is some.
    Light {
        compute: bool,
        shape: Option<LightShape>,
    },
    /// The piece of work of this number, with the rows.
    Rows {
        piece: u64,
        unit: Unit,
    },
    Pass {
        piece: u64,
        sample: u32,
    },
    Add,
    Leave,
    /// With the film and the sample of this number, where there is one.
    Adding(Option<u32>),
    /// That piece of work is not wanted any more.
    Drop {
        piece: u64,
    },
}

/// How the numbers of light are laid out.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct LightShape {
    dims: [usize; 3],
    directed: bool,
}

impl LightShape {
    pub fn of(light: &LightData) -> Self {
        Self { dims: light.dims, directed: light.directions.is_some() }
    }

    pub fn put(light: &LightData, packet: Packet) -> Packet {
        let packet = packet.with(&light.fluence).with(&light.direct);
        match &light.directions {
            Some(Directions { drift, flow }) => packet.with(drift).with(flow),
            None => packet,
        }
    }

    pub fn get(self, reader: &mut Reader<'_>, plan: &Plan<'_>) -> Result<LightData> {
        let expected = plan.method.light.as_ref().map(|setup| (setup.direct_grid.dims, setup.is_directed()));
        let cells = self.dims.iter().product();
        let mut of_cells = || reader.array().and_then(|values| counted(values, cells));
        if expected != Some((self.dims, self.directed)) {
            return Err(misfit("light volume"));
        }
        let (fluence, direct) = (of_cells()?, of_cells()?);
        let directions =
            if self.directed { Some(Directions { drift: of_cells()?, flow: of_cells()? }) } else { None };
        Ok(LightData { dims: self.dims, fluence, direct, directions })
    }
}

/// Rows that are empty are not sent: so begins every picture.
pub(super) fn put_rows(packet: Packet, rows: &Rows) -> Packet {
    fn put<T: NoUninit>(packet: Packet, values: &[T]) -> Packet {
        let is_empty = bytemuck::cast_slice::<T, u8>(values).iter().all(|&byte| byte == 0);
        packet.with(if is_empty { &[] } else { values })
    }
    put(put(packet, &rows.film), &rows.auxiliary).with(&[rows.paths])
}

pub(super) fn get_rows(reader: &mut Reader<'_>, unit: &Unit, plan: &Plan<'_>) -> Result<Rows> {
    let all = plan.scene.image.height.div_ceil(crate::render::TILE);
    if unit.rows.is_empty() || unit.rows.end > all || unit.first_sample.checked_add(unit.samples).is_none() {
        return Err(misfit("piece of work"));
    }
    let mut rows = Rows::of(unit.rows.clone(), plan);
    let pixels = rows.pixels.len();
    rows.film = filled(reader.array()?, pixels)?;
    let auxiliary = reader.array()?;
    if plan.has_auxiliary() {
        rows.auxiliary = filled(auxiliary, pixels)?;
    }
    rows.paths = counted::<PathLedger>(reader.array()?, 1)?[0];
    Ok(rows)
}

pub(super) fn put_sample(packet: Packet, sample: &Sample) -> Packet {
    packet.with(&sample.pixels).with(&[sample.photons.flux]).with(&[sample.photons.bounced])
}

pub(super) fn get_sample(reader: &mut Reader<'_>, passes: u32, plan: &Plan<'_>) -> Result<Sample> {
    let pixels = counted(reader.array()?, pixels(plan))?;
    let flux = counted(reader.array()?, 1)?;
    let bounced = counted(reader.array()?, 1)?;
    Ok(Sample { pixels, photons: PassLedger { passes, flux: flux[0], bounced: bounced[0] } })
}

/// Pixels of the plan's image.
pub(super) fn pixels(plan: &Plan<'_>) -> usize {
    plan.scene.image.width as usize * plan.scene.image.height as usize
}

/// So many values, or none, which stands for as many zeros.
fn filled<T: Zeroable + Clone>(values: Vec<T>, count: usize) -> Result<Vec<T>> {
    if values.is_empty() { Ok(vec![T::zeroed(); count]) } else { counted(values, count) }
}

pub(super) fn counted<T>(values: Vec<T>, count: usize) -> Result<Vec<T>> {
    if values.len() == count { Ok(values) } else { Err(misfit("array")) }
}

pub(super) fn misfit(what: &str) -> Error {
    Error::Failed(format!("another process has sent a {what} that does not fit this render"))
}
