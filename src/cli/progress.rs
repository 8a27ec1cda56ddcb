//! Progress bars on standard error. Log lines appear above them.

use std::{
    ops::ControlFlow,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use crate::{hardware::sim::Arena, mission::WorldObserver, runtime::time::Time};
use indicatif::{ProgressBar, ProgressStyle};

use super::{stderr, style};

/// How often a mission's bar is drawn anew.
const EVERY: Duration = Duration::from_millis(50);

/// The bar that is on the terminal, if there is one.
static SHOWN: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// The same for whoever writes above it.
pub fn shown() -> Option<ProgressBar> {
    SHOWN.lock().unwrap_or_else(PoisonError::into_inner).clone()
}

/// Takes the bar off the terminal before the program ends without further ado.
pub fn clear() {
    if let Some(bar) = shown() {
        bar.finish_and_clear();
    }
}

/// A bar on standard error for as long as this lives; nothing if that is no terminal.
pub struct Bar(ProgressBar);

impl Bar {
    /// A bar of this length.
    pub fn new(length: u64, template: &str) -> Self {
        // A template that makes no sense would show in the first test; the plain bar is good enough then.
        let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = ProgressBar::new(length).with_style(style.progress_chars("━╸ "));
        *SHOWN.lock().unwrap_or_else(PoisonError::into_inner) = Some(bar.clone());
        Self(bar)
    }

    /// The bar itself.
    pub fn handle(&self) -> ProgressBar {
        self.0.clone()
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
        *SHOWN.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

/// Shows how far a mission has come, and may end it at a time of its own.
pub struct MissionWatch {
    bar: ProgressBar,
    whole: Time,
    end: Option<Time>,
    started: Option<Instant>,
    drawn: Instant,
    /// The bar waits to be drawn: once is enough.
    drawing: Arc<AtomicBool>,
}

impl MissionWatch {
    /// A bar for a mission that lasts this long, and what moves it.
    pub fn new(title: &str, whole: Time) -> (Bar, Self) {
        let bar = Bar::new(whole.as_nanos() / 1_000_000, "{prefix:.bold} {bar:24.cyan/dim} {msg}");
        bar.handle().set_prefix(title.to_owned());
        bar.handle().set_message(format!("0:00 of {}", style::time(whole)));
        let drawing = Arc::default();
        let watch = Self { bar: bar.handle(), whole, end: None, started: None, drawn: Instant::now(), drawing };
        (bar, watch)
    }

    /// Ends the mission at this time.
    pub fn until(mut self, end: Time) -> Self {
        self.end = Some(end);
        self
    }

    /// Has the bar drawn by whoever writes to the terminal, for whom no step waits.
    fn draw(&mut self, now: Time, started: Instant) {
        self.drawn = Instant::now();
        if self.drawing.swap(true, Ordering::Relaxed) {
            return;
        }
        let factor = now.as_secs_f64() / started.elapsed().as_secs_f64().max(1e-9);
        let seconds = Time::from_nanos(now.as_nanos() / 1_000_000_000 * 1_000_000_000);
        let message = format!("{} of {}, {factor:.0} × real time", style::time(seconds), style::time(self.whole));
        let (bar, drawing) = (self.bar.clone(), self.drawing.clone());
        stderr::instruct(move || {
            bar.set_position(now.as_nanos() / 1_000_000);
            bar.set_message(message);
            drawing.store(false, Ordering::Relaxed);
        });
    }
}

impl WorldObserver for MissionWatch {
    fn after_step(&mut self, now: Time, _arena: Option<&Arena>) -> ControlFlow<()> {
        let started = *self.started.get_or_insert_with(Instant::now);
        if self.drawn.elapsed() >= EVERY {
            self.draw(now, started);
        }
        if self.end.is_some_and(|end| now >= end) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
