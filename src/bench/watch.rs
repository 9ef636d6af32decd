//! What a bench tells while it runs, and whether it should stop.

use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Interval of lines about one long piece of work.
const INTERVAL: Duration = Duration::from_secs(5);

/// Where a bench reports to, and who may stop it.
pub struct Watch<'a> {
    say: &'a dyn Fn(&str),
    interrupt: &'a AtomicBool,
    last: Cell<Instant>,
}

impl<'a> Watch<'a> {
    /// Lines go to `say`; `interrupt` asks for the end.
    pub fn new(say: &'a dyn Fn(&str), interrupt: &'a AtomicBool) -> Self {
        Self { say, interrupt, last: Cell::new(Instant::now()) }
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
