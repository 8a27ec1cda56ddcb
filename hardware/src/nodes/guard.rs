//! The guard of a base at wall time: a thread beside the driver that stops the base when commands stop coming.

use std::{
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

use orienteer_runtime::{
    geometry::Twist,
    robot_model::Platform,
    time::Time,
    topics::{LineState, Odometry, Truth},
};
use thread_priority::{
    RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy, set_thread_priority_and_policy, thread_native_id,
};

use crate::{
    base::protection::watchdog::Watchdog,
    driver::{BaseDriver, DriverError},
};

/// How often a guarded base is read and told what to do.
const BEAT: Duration = Duration::from_millis(10);
/// The thread's nice value, if the user may have it.
const URGENT: i32 = -15;

/// A base driver on a thread of its own, which stops the base when commands stop coming.
///
/// An actor's mailbox drains until it is empty, so one that is flooded, or a behaviour that sleeps in its step, keeps every
/// timer of its thread waiting. The deadline of a base must not depend on them. The guard's thread reads the driver every
/// 10 ms and passes commands on; a command that is not renewed in time ([`Watchdog`]) is replaced by a stop,
/// whatever became of whoever gave it.
///
/// A driver that panics is told to stop. Rust writes what a panic says first, in the thread that panics, and waits for whoever reads
/// standard error: a program with a base sets a panic hook that does not wait, as the command line of Orienteer does.
pub struct Guarded {
    shared: Arc<Shared>,
    platform: Platform,
    /// Why there is nothing yet.
    why: String,
    thread: Option<JoinHandle<()>>,
}

/// Tells the guard how long the next command may hold at most.
#[derive(Clone)]
pub struct Guard {
    shared: Arc<Shared>,
}

struct Shared {
    state: Mutex<State>,
    news: Condvar,
}

struct State {
    watchdog: Watchdog,
    /// The decision behind the newest command is worth nothing after this.
    valid_until: Time,
    /// When the fleet's clock stood at zero, as far as is known; `None` before the first step. See [`State::hear`].
    started: Option<Instant>,
    fresh_command: bool,
    odometry: Option<Odometry>,
    truth: Option<Truth>,
    line: Option<LineState>,
    /// Why the newest reading, and the newest command, failed; `None` once it has been told.
    unread: Option<DriverError>,
    disobeyed: Option<DriverError>,
    /// The newest reading failed, whether that has been told or not.
    deaf: bool,
    /// The driver has panicked. It was told to stop, and will not be asked again.
    dead: bool,
    quit: bool,
}

impl Guarded {
    /// Puts a driver on a thread of its own; commands hold for little more than one control `period`.
    ///
    /// # Errors
    /// If the thread can't be started.
    pub fn new(mut driver: Box<dyn BaseDriver>, robot: &str, period: Duration) -> Result<Self, DriverError> {
        // The first step may come before the thread does; a device that is not ready yet will be asked again.
        // One that panics will do so again, on its own thread, where nobody is hurt.
        let first = catch_unwind(AssertUnwindSafe(|| {
            let odometry = driver.poll(Time::START).ok();
            (odometry, driver.truth(), driver.line())
        }));
        let (odometry, truth, line) = first.unwrap_or_default();
        let state = State {
            watchdog: Watchdog::new(period),
            valid_until: Time::START,
            started: None,
            fresh_command: false,
            odometry,
            truth,
            line,
            unread: None,
            disobeyed: None,
            deaf: false,
            dead: false,
            quit: false,
        };
        let shared = Arc::new(Shared { state: Mutex::new(state), news: Condvar::new() });
        let platform = driver.platform().clone();
        let watched = shared.clone();
        let thread = thread::Builder::new().name(format!("base of {robot}")).spawn(move || watch(driver, &watched));
        let thread = thread.map_err(|source| DriverError::Io { what: "the base's thread can't be started".into(), source })?;
        Ok(Self { shared, platform, why: "nothing has come yet".to_owned(), thread: Some(thread) })
    }

    /// What tells this guard how long commands hold.
    #[must_use]
    pub fn guard(&self) -> Guard {
        Guard { shared: self.shared.clone() }
    }
}

impl Guard {
    /// The next command must not outlive this time.
    pub fn hold_until(&self, valid_until: Time) {
        self.shared.lock().valid_until = valid_until;
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// What the base may do at a time of the fleet's.
    fn command(&mut self, now: Time) -> Twist {
        if now > self.valid_until {
            // Not a new command: one that is on its way must not be older than this.
            self.watchdog.cancel();
        }
        self.watchdog.command(now)
    }

    /// Learns what the fleet's clock says.
    ///
    /// A step is told the time at which it began, and it may take long to get here: a behaviour may have slept in between. So
    /// of all that was heard, what came with the least delay counts.
    fn hear(&mut self, now: Time) {
        let Some(heard) = Instant::now().checked_sub(now.since(Time::START)) else { return };
        self.started = Some(self.started.map_or(heard, |started| started.min(heard)));
    }

    /// When the base must be told to stop, if it moves.
    fn deadline(&self) -> Option<Instant> {
        let deadline = self.watchdog.deadline()?.min(self.valid_until);
        Some(self.started? + deadline.since(Time::START))
    }

    /// What came of reading the driver and of commanding it.
    fn note(&mut self, measured: Result<Odometry, DriverError>, commanded: Result<(), DriverError>, driver: &dyn BaseDriver) {
        (self.truth, self.line) = (driver.truth(), driver.line());
        self.deaf = measured.is_err();
        match measured {
            Ok(odometry) => (self.odometry, self.unread) = (Some(odometry), None),
            Err(error) => self.unread = Some(error),
        }
        if let Err(error) = commanded {
            self.disobeyed = Some(error);
        }
    }

    /// The fleet's time at an instant.
    fn time_at(&self, instant: Instant) -> Time {
        self.started.map_or(Time::START, |started| Time::START + instant.saturating_duration_since(started))
    }
}

/// Asks to be woken before all ordinary threads: on a busy machine these may wait for a tenth of a second, a moving base must
/// not. Few users may have that; without it the guard is as punctual as the machine is idle.
fn hurry() {
    let urgent = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    if set_thread_priority_and_policy(thread_native_id(), ThreadPriority::Min, urgent).is_err() {
        // The next best, which fewer still are refused.
        let refused = rustix::process::setpriority_process(None, URGENT).is_err();
        tracing::debug!("the guard of a base runs {}", if refused { "at ordinary priority" } else { "at a higher priority" });
    }
}

/// The guard's thread. However it ends, the base has been told to stop.
fn watch(mut driver: Box<dyn BaseDriver>, shared: &Shared) {
    hurry();
    let served = catch_unwind(AssertUnwindSafe(|| serve(driver.as_mut(), shared)));
    // One that has panicked may do so again.
    let stopped = catch_unwind(AssertUnwindSafe(|| driver.stop()));
    if served.is_err() || stopped.is_err() {
        shared.lock().dead = true;
    }
}

/// Reads the driver and passes commands on until it is told to quit.
fn serve(driver: &mut dyn BaseDriver, shared: &Shared) {
    let mut next_beat = Instant::now();
    loop {
        let mut state = shared.lock();
        // Wake for a new command, the beat, or the moment at which the command expires, whichever is first.
        loop {
            let now = Instant::now();
            let wake = state.deadline().map_or(next_beat, |deadline| next_beat.min(deadline));
            if state.quit || state.fresh_command || now >= wake {
                break;
            }
            state = shared.news.wait_timeout(state, wake - now).unwrap_or_else(PoisonError::into_inner).0;
        }
        if state.quit {
            return;
        }
        let now = Instant::now();
        next_beat = next_beat.max(now - BEAT) + BEAT;
        state.fresh_command = false;
        let time = state.time_at(now);
        // The driver may take its time; commands must not wait for it.
        drop(state);
        let measured = driver.poll(time);
        // Looked up at the last moment: while the driver was read, the command may have expired.
        let mut state = shared.lock();
        let time = state.time_at(Instant::now());
        let command = state.command(time);
        drop(state);
        let commanded = driver.command(time, command);
        if commanded.is_err() {
            // It may still carry out the command before.
            driver.stop();
        }
        shared.lock().note(measured, commanded, driver);
    }
}

impl BaseDriver for Guarded {
    fn platform(&self) -> &Platform {
        &self.platform
    }

    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        let mut state = self.shared.lock();
        state.hear(now);
        let told = state.unread.take();
        let lost = |why: &str| DriverError::LinkLost { device: self.platform.name.clone(), why: why.into() };
        match (state.dead, told, state.odometry) {
            (true, ..) => Err(lost("its driver has panicked")),
            (false, Some(error), _) => {
                if let DriverError::Waiting { why, .. } = &error {
                    // Between two readings of the driver the reason is the same.
                    self.why.clone_from(why);
                }
                Err(error)
            }
            (false, None, Some(odometry)) if !state.deaf => Ok(odometry),
            (false, None, Some(_)) => Err(lost("it can't be read")),
            (false, None, None) => Err(DriverError::Waiting { device: self.platform.name.clone(), why: self.why.clone() }),
        }
    }

    fn command(&mut self, now: Time, twist: Twist) -> Result<(), DriverError> {
        let mut state = self.shared.lock();
        state.hear(now);
        state.watchdog.feed(now, twist);
        state.fresh_command = true;
        self.shared.news.notify_one();
        // Of the command before: this one is only on its way.
        state.disobeyed.take().map_or(Ok(()), Err)
    }

    fn truth(&self) -> Option<Truth> {
        self.shared.lock().truth
    }

    fn line(&self) -> Option<LineState> {
        self.shared.lock().line
    }

    fn stop(&mut self) {
        let mut state = self.shared.lock();
        state.valid_until = Time::START;
        state.fresh_command = true;
        self.shared.news.notify_one();
    }
}

impl Drop for Guarded {
    fn drop(&mut self) {
        self.shared.lock().quit = true;
        self.shared.news.notify_one();
        if let Some(thread) = self.thread.take() {
            // A panic of the driver was caught there, and told.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests;
