//! How a render is shown while it runs: a bar on a terminal, plain lines otherwise, all on stderr.

use super::stderr::say;
use crate::render::Status;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Interval of plain progress lines.
const LINE_INTERVAL: Duration = Duration::from_secs(5);

/// Shows progress in the way that fits where stderr goes.
pub enum ProgressView {
    /// A bar on a terminal.
    Bar(ProgressBar),
    /// A line now and then.
    Lines {
        /// When the next line is due.
        next: Instant,
    },
    /// Nothing.
    Quiet,
}

impl ProgressView {
    /// A bar, lines, or nothing when `quiet`.
    pub fn new(quiet: bool) -> Self {
        if quiet {
            return Self::Quiet;
        }
        if !std::io::stderr().is_terminal() {
            return Self::Lines { next: Instant::now() + LINE_INTERVAL };
        }
        let bar = ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::stderr());
        if let Ok(style) = ProgressStyle::with_template("[{bar:30}] {msg}") {
            bar.set_style(style.progress_chars("=> "));
        }
        Self::Bar(bar)
    }

    /// Shows where the render stands; `fraction` is how much of it is done, if that is known.
    pub fn show(&mut self, status: &Status, fraction: Option<f64>) {
        match self {
            Self::Bar(bar) => {
                bar.set_position((fraction.unwrap_or(0.0).clamp(0.0, 1.0) * 1000.0) as u64);
                bar.set_message(text(status, fraction));
            }
            Self::Lines { next } => {
                if Instant::now() >= *next {
                    say(&text(status, fraction));
                    *next = Instant::now() + LINE_INTERVAL;
                }
            }
            Self::Quiet => {}
        }
    }

    /// Runs `say`, which writes lines, with no bar in the way.
    pub fn suspend(&self, say: impl FnOnce()) {
        match self {
            Self::Bar(bar) => bar.suspend(say),
            _ => say(),
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

fn text(status: &Status, fraction: Option<f64>) -> String {
    if status.progress.light < 1.0 {
        // How long the diffusion equation takes is not known beforehand.
        let (done, elapsed) = (status.progress.light * 100.0, status.elapsed.as_secs_f64());
        return format!("light in the volume: {done:.0} %, {elapsed:.1} s");
    }
    let mut text = match status.target {
        Some(target) => format!("{}/{target} samples", status.progress.samples),
        None => format!("{} samples", status.progress.samples),
    };
    text.push_str(&format!(", {:.1} s", status.elapsed.as_secs_f64()));
    if let Some(error) = status.error {
        text.push_str(&format!(", error {:.3} %", error * 100.0));
    }
    if let Some(done) = fraction.filter(|&done| done > 0.01) {
        text.push_str(&format!(", {:.0} s left", status.elapsed.as_secs_f64() * (1.0 - done) / done));
    }
    text
}
