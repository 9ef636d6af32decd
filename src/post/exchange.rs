//! Where letters of a process come in and go out: a box for every line to another process.

use crate::{Error, Result};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// A letter on its way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Letter {
    /// The process at the other end: where it goes, or whence it comes.
    pub peer: u32,
    /// For which line; both ends know it by the same number.
    pub port: u64,
    /// What is in it.
    pub bytes: Vec<u8>,
}

/// What has been carried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Traffic {
    /// Letters sent.
    pub sent: u64,
    /// Their bytes.
    pub sent_bytes: u64,
    /// Letters received.
    pub received: u64,
    /// Their bytes.
    pub received_bytes: u64,
}

type Sorted = HashMap<(u32, u64), (Sender<Vec<u8>>, Option<Receiver<Vec<u8>>>)>;

/// Sorts letters that come in, and collects those that go out.
pub struct Exchange {
    boxes: Mutex<Sorted>,
    out: Sender<Letter>,
    counts: [AtomicU64; 4],
}

impl Exchange {
    /// One whose letters are taken from the other end of `out` by who carries them.
    pub fn new(out: Sender<Letter>) -> Self {
        Self { boxes: Mutex::default(), out, counts: Default::default() }
    }

    /// The line to a process by that port, with all letters that have come in by it; each may be asked for once.
    pub fn line(&self, peer: u32, port: u64) -> Line<'_> {
        let mut boxes = self.boxes.lock().unwrap_or_else(PoisonError::into_inner);
        let (_, inbox) = boxes.entry((peer, port)).or_insert_with(empty);
        // Asked for again, it would be the first one's: nothing comes in here.
        let inbox = inbox.take().unwrap_or_else(|| channel().1);
        Line { exchange: self, peer, port, inbox }
    }

    /// A letter has come in.
    pub fn deliver(&self, letter: Letter) {
        self.count(2, letter.bytes.len());
        let mut boxes = self.boxes.lock().unwrap_or_else(PoisonError::into_inner);
        let entry = boxes.entry((letter.peer, letter.port));
        let (inbox, _) = match entry {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => new.insert(empty()),
        };
        // Where nobody reads any more, it is too late.
        let _ = inbox.send(letter.bytes);
    }

    /// What has been carried so far.
    pub fn traffic(&self) -> Traffic {
        let [sent, sent_bytes, received, received_bytes] =
            [0, 1, 2, 3].map(|i: usize| self.counts[i].load(Ordering::Relaxed));
        Traffic { sent, sent_bytes, received, received_bytes }
    }

    /// Has a letter carried.
    ///
    /// # Errors
    /// [`Error::Failed`] when nobody carries letters any more.
    pub fn send(&self, letter: Letter) -> Result<()> {
        self.count(0, letter.bytes.len());
        self.out.send(letter).map_err(|_| Error::Failed("letters are carried no more".into()))
    }

    fn count(&self, first: usize, bytes: usize) {
        self.counts[first].fetch_add(1, Ordering::Relaxed);
        self.counts[first + 1].fetch_add(bytes as u64, Ordering::Relaxed);
    }
}

fn empty() -> (Sender<Vec<u8>>, Option<Receiver<Vec<u8>>>) {
    let (send, receive) = channel();
    (send, Some(receive))
}

/// One end of a line to another process. Letters arrive in the order in which they were sent.
pub struct Line<'e> {
    exchange: &'e Exchange,
    peer: u32,
    port: u64,
    inbox: Receiver<Vec<u8>>,
}

impl Line<'_> {
    /// The process at the other end.
    pub fn peer(&self) -> u32 {
        self.peer
    }

    /// Sends a letter.
    ///
    /// # Errors
    /// [`Error::Failed`] when nobody carries letters any more.
    pub fn send(&self, bytes: Vec<u8>) -> Result<()> {
        self.exchange.send(Letter { peer: self.peer, port: self.port, bytes })
    }

    /// The next letter; waits for it, at most so long.
    ///
    /// # Errors
    /// [`Error::Failed`] when there will be none.
    pub fn receive(&self, patience: Duration) -> Result<Option<Vec<u8>>> {
        match self.inbox.recv_timeout(patience) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => {
                Err(Error::Failed(format!("the line to process {} is taken already", self.peer)))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_wait_for_who_reads_them() {
        let (out, outgoing) = channel();
        let exchange = Exchange::new(out);
        let letter = |port, text: &str| Letter { peer: 3, port, bytes: text.into() };
        for (port, text) in [(1, "first"), (2, "other"), (1, "second")] {
            exchange.deliver(letter(port, text));
        }
        let line = exchange.line(3, 1);
        exchange.deliver(letter(1, "third"));
        let read = || line.receive(Duration::ZERO).unwrap().map(|bytes| String::from_utf8(bytes).unwrap());
        assert_eq!(
            [read(), read(), read(), read()].map(Option::unwrap_or_default),
            ["first", "second", "third", ""]
        );
        line.send("answer".into()).unwrap();
        assert_eq!(outgoing.recv().unwrap(), letter(1, "answer"));
        assert!(exchange.line(3, 1).receive(Duration::ZERO).is_err());
        let traffic = Traffic { sent: 1, sent_bytes: 6, received: 4, received_bytes: 21 };
        assert_eq!(exchange.traffic(), traffic);
        drop(outgoing);
        assert!(line.send(Vec::new()).is_err());
    }
}
