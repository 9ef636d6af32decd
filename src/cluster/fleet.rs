//! The processes that work for this one, as it sees them.

use super::word::{CONTROL, Hello, Identity, Order, Ready, Report};
use crate::crew::Colleague;
use crate::device::DeviceName;
use crate::post::{Exchange, Line, Packet, Reader, Traffic};
use crate::{Error, Result};
use std::time::{Duration, Instant};

/// How long a letter is waited for until interrupts are looked for.
const GLANCE: Duration = Duration::from_millis(20);
/// Ports of a view: more than any machine has devices.
const PORTS: u64 = 1 << 16;

/// Whether to go on waiting for a process, by its name in messages and the time that has passed.
pub type GoOn<'a> = dyn Fn(&str, Duration) -> bool + 'a;

/// The other processes.
pub struct Fleet<'e> {
    exchange: &'e Exchange,
    ranks: Vec<Member<'e>>,
    /// The view that they have been told to make ready for.
    view: Option<usize>,
    /// The first port that no line has had.
    port: u64,
}

struct Member<'e> {
    line: Line<'e>,
    host: String,
}

impl Member<'_> {
    /// What to call it in messages.
    fn name(&self) -> String {
        let host = if self.host.is_empty() { String::new() } else { format!(" ({})", self.host) };
        format!("rank {}{host}", self.line.peer())
    }

    fn tell(&self, order: &Order) -> Result<()> {
        self.line.send(Packet::of(order).into_bytes())
    }

    /// Its next report; waits for it as long as `go_on` says so.
    fn report(&self, go_on: &GoOn<'_>) -> Result<Report> {
        let begun = Instant::now();
        loop {
            // What has come counts, however long others were waited for.
            if let Some(bytes) = self.line.receive(GLANCE)? {
                return Reader::new(&bytes).head().map_err(|_| {
                    Error::Input(format!("{} is another version of svetlo than rank 0", self.name()))
                });
            }
            if !go_on(&self.name(), begun.elapsed()) {
                return Err(Error::Interrupted);
            }
        }
    }
}

impl<'e> Fleet<'e> {
    /// Ranks 1 to `size` - 1, which [`serve`](super::serve) in their processes.
    pub fn new(exchange: &'e Exchange, size: u32) -> Self {
        let member = |rank| Member { line: exchange.line(rank, CONTROL), host: String::new() };
        Self { exchange, ranks: (1..size).map(member).collect(), view: None, port: CONTROL + 1 }
    }

    /// Processes, this one included.
    pub fn size(&self) -> usize {
        self.ranks.len() + 1
    }

    /// What has been carried to and from them.
    pub fn traffic(&self) -> Traffic {
        self.exchange.traffic()
    }

    /// Waits, as long as `go_on` says so, until all have read their scene, which must be this one.
    ///
    /// # Errors
    /// [`Error::Input`] when one has none, or another, or is another program; [`Error::Interrupted`].
    pub fn muster(&mut self, mine: &Identity, go_on: &GoOn<'_>) -> Result<()> {
        for rank in &mut self.ranks {
            let Report::Hello(Hello { host, scene }) = rank.report(go_on)? else {
                return Err(disorder(rank));
            };
            rank.host = host;
            let theirs = scene.map_err(|what| {
                Error::Input(format!("{}: {}", rank.name(), what.strip_prefix("error: ").unwrap_or(&what)))
            })?;
            if let Some((what, here, there)) = mine.difference(&theirs) {
                return Err(Error::Input(format!(
                    "{} does not render the same as rank 0: its {what} is {there}, that of rank 0 {here}; all processes \
                     must run the same svetlo with the same arguments, on the same files",
                    rank.name()
                )));
            }
        }
        Ok(())
    }

    /// Has all make ready for a view, if they do not do so already.
    ///
    /// # Errors
    /// [`Error::Failed`] when nobody carries letters any more.
    pub fn begin(&mut self, index: usize) -> Result<()> {
        if self.view != Some(index) {
            self.port += PORTS;
            self.view = Some(index);
            self.ranks.iter().try_for_each(|rank| rank.tell(&Order::View { index, port: self.port }))?;
        }
        Ok(())
    }

    /// Waits, as long as `go_on` says so, until all are ready for the view: their devices, and remarks for the user.
    ///
    /// # Errors
    /// [`Error::Input`] when one has other data or none; [`Error::Interrupted`].
    pub fn devices(&self, data_hash: &str, go_on: &GoOn<'_>) -> Result<(Vec<Colleague<'e>>, Vec<String>)> {
        let (mut colleagues, mut notes) = (Vec::new(), Vec::new());
        for rank in &self.ranks {
            let Report::Ready(Ready { data, devices, remarks }) = rank.report(go_on)? else {
                return Err(disorder(rank));
            };
            let theirs = data.map_err(|what| Error::Input(format!("{}: {what}", rank.name())))?;
            if theirs != data_hash && !devices.is_empty() {
                return Err(Error::Input(format!(
                    "{} has read other data than rank 0: their hash is {theirs}, that of rank 0 {data_hash}; all \
                     processes must find the same files",
                    rank.name()
                )));
            }
            notes.extend(remarks.into_iter().map(|remark| format!("{}: {remark}", rank.name())));
            let peer = rank.line.peer();
            colleagues.extend((self.port..).zip(devices).map(|(port, name)| Colleague {
                name: DeviceName { selector: format!("rank {peer}, {}", name.selector), ..name },
                line: self.exchange.line(peer, port),
            }));
        }
        Ok((colleagues, notes))
    }

    /// The view is done.
    ///
    /// # Errors
    /// [`Error::Failed`] when nobody carries letters any more.
    pub fn close(&mut self) -> Result<()> {
        self.ranks.iter().try_for_each(|rank| rank.tell(&Order::Close))
    }

    /// Has all end with this exit code, and waits until they know, at most so long: the ranks that do not answer.
    pub fn end(self, code: u8, patience: Duration) -> Vec<String> {
        let deadline = Instant::now() + patience;
        for rank in &self.ranks {
            // That letters are no longer carried shows below.
            let _ = rank.tell(&Order::End { code });
        }
        let in_time = |_: &str, _| Instant::now() < deadline;
        let is_silent = |rank: &&Member<'_>| loop {
            match rank.report(&in_time) {
                Ok(Report::Bye) => return false,
                Err(Error::Interrupted | Error::Failed(_)) => return true,
                _ => {}
            }
        };
        self.ranks.iter().filter(is_silent).map(Member::name).collect()
    }
}

fn disorder(rank: &Member<'_>) -> Error {
    Error::Failed(format!("{} speaks out of turn: a mistake of this program", rank.name()))
}
