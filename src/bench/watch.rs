//! What a bench tells while it runs, and whether it should stop.

use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Interval of lines about one long piece of work.
const INTERVAL: Duration = Duration::from_secs(5);
/// Limits are looked at between launches: what takes several times as long is in a launch that does not come back.
const GRACE: u32 = 4;
/// Launches may take this long.
const LEAST: Duration = Duration::from_secs(10);
/// How often an alarm looks at its clock.
const TICK: Duration = Duration::from_millis(200);

/// Rings when a launch does not come back: then nothing else can tell. Rings once.
pub struct Alarm(Arc<Mutex<Option<(Instant, String)>>>);

impl Alarm {
    /// `ring` is told what did not end, on another thread.
    pub fn new(ring: impl Fn(&str) + Send + 'static) -> Self {
        let due = Arc::new(Mutex::new(None::<(Instant, String)>));
        let (weak, alarm) = (Arc::downgrade(&due), Self(due));
        std::thread::spawn(move || {
            while let Some(due) = weak.upgrade() {
                let over = due
                    .lock()
                    .unwrap_or_else(PoisonError::into_inner)
                    .take_if(|(at, _)| *at <= Instant::now());
                if let Some((_, what)) = over {
                    ring(&what);
                }
                drop(due);
                std::thread::sleep(TICK);
            }
        });
        alarm
    }

    fn set(&self, due: Option<(Instant, String)>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = due;
    }
}

/// Where a bench reports to, and who may stop it.
pub struct Watch<'a> {
    say: &'a dyn Fn(&str),
    interrupt: &'a AtomicBool,
    last: Cell<Instant>,
    alarm: Option<&'a Alarm>,
}

impl<'a> Watch<'a> {
    /// Lines go to `say`; `interrupt` asks for the end.
    pub fn new(say: &'a dyn Fn(&str), interrupt: &'a AtomicBool) -> Self {
        Self { say, interrupt, last: Cell::new(Instant::now()), alarm: None }
    }

    /// With an alarm for launches that do not come back.
    #[must_use]
    pub fn with_alarm(self, alarm: &'a Alarm) -> Self {
        Self { alarm: Some(alarm), ..self }
    }

    /// Expects `what` to end, or at least to say that it takes longer than `limit`.
    pub fn arm(&self, limit: Duration, what: &str) {
        if let Some(alarm) = self.alarm {
            alarm.set(Some((Instant::now() + GRACE * limit.max(LEAST), what.to_owned())));
        }
    }

    /// It has ended.
    pub fn disarm(&self) {
        if let Some(alarm) = self.alarm {
            alarm.set(None);
        }
    }

    /// Says something.
    pub fn say(&self, text: &str) {
        self.last.set(Instant::now());
        (self.say)(text);
    }

    /// Says something unless something was said a moment ago.
    pub fn now_and_then(&self, text: impl FnOnce() -> String) {
        if self.last.get().elapsed() >= INTERVAL {
            self.say(&text());
        }
    }

    /// Whether to stop.
    pub fn interrupted(&self) -> bool {
        self.interrupt.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;

    #[test]
    fn alarms_ring_when_they_are_due_and_not_when_it_ended() {
        let (send, rung) = channel();
        let alarm = Alarm::new(move |what| send.send(what.to_owned()).unwrap_or_default());
        let soon = || Instant::now() + Duration::from_millis(50);
        alarm.set(Some((soon(), "ended".into())));
        alarm.set(None);
        assert!(rung.recv_timeout(Duration::from_millis(600)).is_err());
        alarm.set(Some((soon(), "hangs".into())));
        assert_eq!(rung.recv_timeout(Duration::from_secs(20)).as_deref(), Ok("hangs"));
    }
}
