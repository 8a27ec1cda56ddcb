//! How the system asks a program to end.

use std::{
    fs,
    future::poll_fn,
    io, process,
    sync::{Mutex, MutexGuard, OnceLock, PoisonError},
    task::Poll,
    time::Duration,
};

use tokio::{
    runtime::{Builder, Runtime},
    signal::unix::{Signal, SignalKind, signal},
    task::spawn_blocking,
    time::{sleep, timeout},
};

use super::FleetControl;
use crate::{descriptors, recording};

/// Signals that follow one another faster than this are one wish to end: `timeout` and terminals that close send theirs twice.
const ONE_WISH: Duration = Duration::from_secs(1);

/// Nobody waits longer for a line of the log to be written, or for what is done [before the end](before_exit).
const MOMENT: Duration = Duration::from_millis(200);

/// Exit code of a program that was told twice to end.
const INTERRUPTED: i32 = 130;

static LAST: OnceLock<fn(Duration)> = OnceLock::new();

/// What a program does last that a signal ends at once, such as writing the rest of its log. It gives up after the time that it is given.
/// Only the first call counts.
pub fn before_exit(last: fn(Duration)) {
    let _ = LAST.set(last);
}

/// Listens for whoever wants the program to end.
#[derive(Debug)]
pub struct Signals {
    heard: Vec<(Signal, &'static str)>,
}

impl Signals {
    /// From now on none of these signals ends the program by itself, and each one that comes is heard. Who started it with
    /// `nohup` wants it to outlive the terminal. To be called where a tokio runtime is.
    ///
    /// # Errors
    /// If the system does not let the program listen.
    pub fn listen() -> io::Result<Self> {
        let mut heard = vec![(signal(SignalKind::interrupt())?, "Ctrl-C"), (signal(SignalKind::terminate())?, "SIGTERM")];
        if !is_ignored(SignalKind::hangup()) {
            heard.push((signal(SignalKind::hangup())?, "SIGHUP, the terminal is gone"));
        }
        Ok(Self { heard })
    }

    /// Waits until somebody wants the program to end, and says how.
    pub async fn asked_to_end(&mut self) -> &'static str {
        poll_fn(|context| {
            let heard = self.heard.iter_mut().find_map(|(signal, name)| signal.poll_recv(context).is_ready().then_some(*name));
            heard.map_or(Poll::Pending, Poll::Ready)
        })
        .await
    }
}

/// Stops a fleet, or whoever else looks at its [`FleetControl`], when somebody wants the program to end, for as long as this lives.
///
/// The process listens on a thread of its own, because the fleet's may be in a behaviour that never returns. Who asks again then ends
/// the program, with a recording that goes as far as the mission did. (A base that is guarded has stopped long before.) When no ear is left, a signal
/// ends the program at once, as it would have done before the first.
#[derive(Debug)]
pub struct Ear {
    control: FleetControl,
}

/// All that is to be stopped when somebody wants the program to end.
static CONTROLS: Mutex<Vec<FleetControl>> = Mutex::new(Vec::new());

impl Ear {
    /// What comes after this is heard.
    #[must_use]
    pub fn open(control: FleetControl) -> Self {
        // For as long as the process lives: the system is told once that its signals are taken care of.
        static THREAD: OnceLock<Option<Runtime>> = OnceLock::new();
        controls().push(control.clone());
        THREAD.get_or_init(|| {
            let thread = listen_on_a_thread();
            if let Err(error) = &thread {
                tracing::warn!("can't listen for signals, Ctrl-C will kill the mission instead of ending it: {error}");
            }
            thread.ok()
        });
        Self { control }
    }
}

impl Drop for Ear {
    fn drop(&mut self) {
        let mut controls = controls();
        if let Some(place) = controls.iter().position(|control| control.is(&self.control)) {
            controls.swap_remove(place);
        }
    }
}

fn controls() -> MutexGuard<'static, Vec<FleetControl>> {
    CONTROLS.lock().unwrap_or_else(PoisonError::into_inner)
}

fn listen_on_a_thread() -> io::Result<Runtime> {
    descriptors::check_room_for(1).map_err(io::Error::other)?;
    let thread = Builder::new_multi_thread().worker_threads(1).thread_name("signals").enable_all().build()?;
    let signals = {
        let _inside = thread.enter();
        Signals::listen()?
    };
    drop(thread.spawn(stop_when_asked(signals)));
    Ok(thread)
}

async fn stop_when_asked(mut signals: Signals) {
    loop {
        let signal = signals.asked_to_end().await;
        let stopped = controls().clone();
        if stopped.is_empty() {
            exit().await;
        }
        say(move || tracing::info!("{signal}: ending in good order")).await;
        stopped.iter().for_each(FleetControl::stop);
        sleep(ONE_WISH).await;
        // Heard anew: what came in the meantime belongs to the first wish.
        let Ok(anew) = Signals::listen() else { return };
        signals = anew;
        if controls().iter().any(|control| stopped.iter().any(|other| control.is(other))) {
            say(|| tracing::warn!("still ending, maybe a behaviour does not return; Ctrl-C once more ends the program at once"))
                .await;
            let signal = signals.asked_to_end().await;
            say(move || tracing::error!("{signal} again: the program ends at once")).await;
            // A behaviour that hangs has recorded nothing since, but what led to it is there.
            recording::complete_all(ONE_WISH);
            exit().await;
        }
    }
}

/// Says something on another thread: whoever reads it may have stopped, and the next signal must be heard all the same.
async fn say(words: impl FnOnce() + Send + 'static) {
    let _ = timeout(MOMENT, spawn_blocking(words)).await;
}

async fn exit() -> ! {
    if let Some(last) = LAST.get() {
        let _ = timeout(2 * MOMENT, spawn_blocking(|| last(MOMENT))).await;
    }
    process::exit(INTERRUPTED);
}

/// True if the program was started with this signal ignored, as far as Linux tells.
fn is_ignored(kind: SignalKind) -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (kind.as_raw_value() - 1) & 1 == 1)
}
