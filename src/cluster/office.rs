//! Who carries letters between processes: MPI.
//!
//! One thread does all that is done with MPI. It sleeps where there is nothing to do, the longer the longer that lasts: MPI
//! itself would spin, and the processor is for devices. A letter goes as a frame of its port and its length, with
//! what is in it where that is short, and in pieces after it where it is long: counts of MPI have 31 bits.

use super::Place;
use crate::post::{Exchange, Letter};
use crate::{Error, Result};
use mpi::datatype::Equivalence;
use mpi::environment::Universe;
use mpi::point_to_point::{Destination, Source};
use mpi::request;
use mpi::topology::{Communicator, SimpleCommunicator};
use mpi::{Rank, Threading};
use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicI32, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::thread::JoinHandle;
use std::time::Duration;

/// Bytes that go with the frame.
const SHORT: usize = 4000;
/// Bytes of a piece.
const PIECE: usize = 64 << 20;
/// Bytes of port and length.
const FRAME: usize = 16;
/// Shortest and longest sleep.
const NAPS: [Duration; 2] = [Duration::from_micros(50), Duration::from_millis(4)];

/// What the thread is to do when it is not to carry letters any more; codes from 0 on: end all processes with them.
const OPEN: i32 = -1;
const CLOSE: i32 = -2;

/// The thread.
pub(super) struct Office {
    thread: JoinHandle<()>,
    wish: Arc<AtomicI32>,
}

impl Office {
    /// Joins the other processes.
    ///
    /// # Errors
    /// [`Error::Failed`] when MPI does not let it.
    pub fn open() -> Result<(Place, Arc<Exchange>, Self)> {
        let wish = Arc::new(AtomicI32::new(OPEN));
        let (ready, place) = channel();
        let thread = std::thread::Builder::new().name("mpi".into()).spawn({
            let wish = Arc::clone(&wish);
            move || {
                let Some((universe, _)) = mpi::initialize_with_threading(Threading::Funneled) else { return };
                let world = universe.world();
                let (out, outgoing) = channel();
                let exchange = Arc::new(Exchange::new(out));
                if ready.send((place_in(&world), Arc::clone(&exchange))).is_err() {
                    return;
                }
                let carrier = Carrier { universe, world, exchange, wish, halves: HashMap::new() };
                carrier.carry(&outgoing);
            }
        });
        let failed = |what: String| Error::Failed(format!("MPI cannot be used: {what}"));
        let thread = thread.map_err(|error| failed(error.to_string()))?;
        let (place, exchange) = place.recv().map_err(|_| failed("it was initialised before".into()))?;
        Ok((place, exchange, Self { thread, wish }))
    }

    /// Carries what is left, and leaves the others, which must do the same.
    pub fn close(self) {
        self.wish.store(CLOSE, Ordering::Relaxed);
        let _ = self.thread.join();
    }

    /// Ends all processes at once.
    pub fn abort(self, code: u8) {
        self.wish.store(code.into(), Ordering::Relaxed);
        let _ = self.thread.join();
    }
}

fn place_in(world: &SimpleCommunicator) -> Place {
    let machine = world.split_shared(world.rank());
    let [rank, size, local_rank, local_size] =
        [world.rank(), world.size(), machine.rank(), machine.size()].map(|n| u32::try_from(n).unwrap_or(0));
    Place { rank, size, local_rank, local_size }
}

/// A letter of which pieces are still to come.
struct Half {
    letter: Letter,
    filled: usize,
}

struct Carrier {
    exchange: Arc<Exchange>,
    wish: Arc<AtomicI32>,
    /// By the process that sends it: one after another.
    halves: HashMap<Rank, Half>,
    world: SimpleCommunicator,
    /// MPI ends with it.
    universe: Universe,
}

impl Carrier {
    fn carry(mut self, outgoing: &Receiver<Letter>) {
        let mut nap = NAPS[0];
        loop {
            let mut is_busy = self.receive();
            // Wakes at once for what goes out.
            if let Ok(letter) = outgoing.recv_timeout(if is_busy { Duration::ZERO } else { nap }) {
                self.send(&letter);
                is_busy = true;
            }
            nap = if is_busy { NAPS[0] } else { (2 * nap).min(NAPS[1]) };
            if !is_busy && self.is_closing() {
                break;
            }
        }
        drop(self.universe);
    }

    /// Whether it is time to leave; ends all processes if that is wished.
    fn is_closing(&self) -> bool {
        let wish = self.wish.load(Ordering::Relaxed);
        if wish >= 0 {
            self.world.abort(wish);
        }
        wish == CLOSE
    }

    /// Receives what has come in; whether there was something.
    fn receive(&mut self) -> bool {
        let Some((message, status)) = self.world.any_process().immediate_matched_probe() else {
            return false;
        };
        let source = status.source_rank();
        let count = usize::try_from(status.count(u8::equivalent_datatype())).unwrap_or(0);
        if let Some(mut half) = self.halves.remove(&source) {
            let end = (half.filled + count).min(half.letter.bytes.len());
            message.matched_receive_into(&mut half.letter.bytes[half.filled..end]);
            half.filled = end;
            self.settle(source, half);
        } else {
            let mut frame = vec![0; count];
            message.matched_receive_into(&mut frame[..]);
            if let Some(half) = opened(source, &frame) {
                self.settle(source, half);
            }
        }
        true
    }

    fn settle(&mut self, source: Rank, half: Half) {
        if half.filled == half.letter.bytes.len() {
            self.exchange.deliver(half.letter);
        } else {
            self.halves.insert(source, half);
        }
    }

    fn send(&mut self, letter: &Letter) {
        let length = letter.bytes.len();
        let mut frame = [letter.port.to_le_bytes(), (length as u64).to_le_bytes()].concat();
        let is_short = length <= SHORT;
        if is_short {
            frame.extend(&letter.bytes);
        }
        self.send_bytes(letter.peer, &frame);
        if !is_short {
            letter.bytes.chunks(PIECE).for_each(|piece| self.send_bytes(letter.peer, piece));
        }
    }

    /// Sends and goes on receiving meanwhile: the other end may do the same.
    fn send_bytes(&mut self, peer: u32, bytes: &[u8]) {
        let world = self.universe.world();
        let process = world.process_at_rank(peer as Rank);
        request::scope(|scope| {
            let mut sending = process.immediate_send(scope, bytes);
            let mut nap = NAPS[0];
            while let Err(unfinished) = sending.test() {
                sending = unfinished;
                if self.receive() {
                    nap = NAPS[0];
                } else {
                    std::thread::sleep(nap);
                    nap = (2 * nap).min(NAPS[1]);
                }
                self.is_closing();
            }
        });
    }
}

/// What a frame begins.
fn opened(source: Rank, frame: &[u8]) -> Option<Half> {
    let (port, rest) = frame.split_first_chunk::<8>()?;
    let (length, short) = rest.split_first_chunk::<8>()?;
    let mut bytes = short.to_vec();
    bytes.resize(usize::try_from(u64::from_le_bytes(*length)).ok()?, 0);
    let letter = Letter { peer: u32::try_from(source).ok()?, port: u64::from_le_bytes(*port), bytes };
    Some(Half { letter, filled: frame.len() - FRAME })
}
