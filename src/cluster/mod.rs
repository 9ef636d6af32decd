//! Several processes on one picture, on one machine or many: `mpirun -n N svetlo render …`.
//!
//! Rank 0 is the one that the user speaks to: it reads arguments, writes pictures and messages, and has the film. The
//! others read the same scene and data, and put their devices at its disposal: each is a member of rank 0's
//! [`Crew`](crate::crew::Crew) by a line of letters ([`post`](crate::post)). What falls to whom shows in no bit of the
//! picture, as among the devices of one process.
//!
//! - `launch`: whether this process is one of several
//! - `word`: what rank 0 and the others say to each other about the render as a whole
//! - `fleet`: the others, as rank 0 sees them
//! - `rank`: one of the others
//! - `office` (feature `mpi`): who carries letters

mod fleet;
mod launch;
#[cfg(feature = "mpi")]
mod office;
mod rank;
mod word;

pub use fleet::Fleet;
pub use launch::{Launch, SWITCH};
pub use rank::{Rank, serve};
pub use word::Identity;

use crate::post::Exchange;
use crate::{Error, Result};
#[cfg(feature = "mpi")]
use std::sync::Arc;

/// Where a process stands among those that were started together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Its number, from 0.
    pub rank: u32,
    /// How many there are.
    pub size: u32,
    /// Its number among those of its machine.
    pub local_rank: u32,
    /// How many there are on its machine.
    pub local_size: u32,
}

impl Place {
    /// Of a process that was started alone.
    pub const ALONE: Self = Self { rank: 0, size: 1, local_rank: 0, local_size: 1 };

    /// Those of a machine's devices that are for this process: each for one, as far as there are as many.
    pub fn deal<T>(&self, devices: Vec<T>) -> Vec<T> {
        let (me, all, count) = (self.local_rank as usize, self.local_size.max(1) as usize, devices.len());
        let is_mine = |index: usize| index % all == me || (count <= me && index == me % count.max(1));
        devices
            .into_iter()
            .enumerate()
            .filter(|(index, _)| is_mine(*index))
            .map(|(_, device)| device)
            .collect()
    }
}

/// This process among those that were started together.
pub struct Process {
    place: Place,
    #[cfg(feature = "mpi")]
    office: Option<office::Office>,
    #[cfg(feature = "mpi")]
    exchange: Option<Arc<Exchange>>,
}

impl Process {
    /// Finds out, and joins the others.
    ///
    /// # Errors
    /// [`Error::Input`] when there are others that cannot be joined.
    #[cfg(feature = "mpi")]
    pub fn join() -> Result<Self> {
        let Some(launch) = Launch::of_environment()? else {
            return Ok(Self { place: Place::ALONE, office: None, exchange: None });
        };
        let (place, exchange, office) = office::Office::open()?;
        if place.size != launch.size {
            office.close();
            return Err(Error::Input(format!(
                "{} says {} processes, but MPI knows of {}: this svetlo was built for another MPI than that which has \
                 started it",
                launch.variable, launch.size, place.size
            )));
        }
        Ok(Self { place, office: Some(office), exchange: Some(exchange) })
    }

    /// Finds out.
    ///
    /// # Errors
    /// [`Error::Input`] when the environment says what is not understood.
    #[cfg(not(feature = "mpi"))]
    pub fn join() -> Result<Self> {
        let size = Launch::of_environment()?.map_or(1, |launch| launch.size);
        Ok(Self { place: Place { size, ..Place::ALONE } })
    }

    /// Where it stands.
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// Refuses to do `what` in several processes at once, which would write the same files.
    ///
    /// # Errors
    /// [`Error::Input`] that says what to do instead.
    pub fn check_alone(&self, what: &str) -> Result<()> {
        let size = self.place.size;
        if size == 1 {
            return Ok(());
        }
        let cause = if cfg!(feature = "mpi") {
            format!("only svetlo render shares work among processes; start svetlo {what} without mpirun")
        } else {
            "this svetlo was built without MPI, so that all of them would do the same work and write the same files; \
             build it with `cargo build --release --features mpi`, or start it without mpirun"
                .into()
        };
        Err(Error::Input(format!(
            "svetlo {what} was started as {size} processes: {cause} ({SWITCH}=off: they have different work on purpose)"
        )))
    }

    /// The way to the others, if there are some.
    pub fn exchange(&self) -> Option<&Exchange> {
        #[cfg(feature = "mpi")]
        return self.exchange.as_deref().filter(|_| self.place.size > 1);
        #[cfg(not(feature = "mpi"))]
        None
    }

    /// Leaves the others, which do so, too.
    pub fn leave(self) {
        #[cfg(feature = "mpi")]
        if let Some(office) = self.office {
            office.close();
        }
    }

    /// Ends all processes at once: one does not answer.
    pub fn abort(self, code: u8) {
        #[cfg(feature = "mpi")]
        if let Some(office) = self.office {
            office.abort(code);
        }
        #[cfg(not(feature = "mpi"))]
        let _ = code;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dealt(devices: usize, local_size: u32) -> Vec<Vec<usize>> {
        let place = |local_rank| Place { local_rank, local_size, ..Place::ALONE };
        (0..local_size).map(|rank| place(rank).deal((0..devices).collect())).collect()
    }

    #[test]
    fn devices_are_dealt_to_the_processes_of_a_machine() {
        assert_eq!(dealt(3, 1), [[0, 1, 2]]);
        assert_eq!(dealt(4, 4), [[0], [1], [2], [3]]);
        assert_eq!(dealt(5, 2), [vec![0, 2, 4], vec![1, 3]]);
        assert_eq!(dealt(1, 3), [[0], [0], [0]]);
        assert_eq!(dealt(2, 5), [[0], [1], [0], [1], [0]]);
        assert_eq!(dealt(0, 2), [[0_usize; 0], []]);
    }
}
