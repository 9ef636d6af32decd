//! Letters between processes, whoever carries them: MPI (feature `mpi`), or channels of one process in tests.

mod exchange;
mod packet;

pub use exchange::{Exchange, Letter, Line, Traffic};
pub use packet::{Packet, Reader};
