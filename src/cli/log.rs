//! What the program does, line by line, for people: how much of it, and how it looks.

use std::{
    backtrace::{Backtrace, BacktraceStatus},
    io::{self, Write},
    panic::PanicHookInfo,
    thread,
};

use tracing_subscriber::{
    filter::{LevelFilter, Targets},
    layer::SubscriberExt,
};

use super::{stderr, style::Paint};
use crate::runtime::host::{NEWS, RELIEF};

/// Sends log lines, and what panics say, to standard error. Robots' lines carry the mission's time; the wall clock's would only differ
/// from run to run. What robots find out is told if `news` is wanted.
pub fn start(verbose: u8, quiet: bool, news: bool) {
    let level = match (quiet, verbose) {
        (true, _) => LevelFilter::ERROR,
        (false, 0) => LevelFilter::WARN,
        (false, 1) => LevelFilter::INFO,
        (false, _) => LevelFilter::DEBUG,
    };
    // Who sees that something has failed sees that it works again; and what a robot finds out is why it was sent.
    let relief = if quiet { level } else { level.max(LevelFilter::INFO) };
    let news = if news { relief } else { level };
    let subscriber = tracing_subscriber::fmt()
        .with_max_level(LevelFilter::TRACE)
        .with_target(false)
        .without_time()
        .with_ansi(Paint::stderr().is_coloured())
        .with_writer(|| Lines)
        .finish()
        .with(Targets::new().with_default(level).with_target(RELIEF, relief).with_target(NEWS, news));
    // Fails only if there is one already.
    let _ = tracing::subscriber::set_global_default(subscriber);
    std::panic::set_hook(Box::new(|panic| stderr::write(last_words(panic).as_bytes())));
}

/// Lines on their way to standard error.
struct Lines;

impl Write for Lines {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        stderr::write(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// As the standard library would tell of a panic, if not in the thread that panics.
fn last_words(panic: &PanicHookInfo<'_>) -> String {
    let thread = thread::current();
    let trace = Backtrace::capture();
    let trace = if trace.status() == BacktraceStatus::Captured { format!("{trace}\n") } else { String::new() };
    format!("thread '{}' {panic}\n{trace}", thread.name().unwrap_or("without a name"))
}
