use std::{
    sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError},
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

use orienteer_runtime::{
    geometry::Twist,
    robot_model::Platform,
    time::Time,
    topics::{Odometry, Truth},
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
/// Failures that are kept until the node looks.
const KEPT_ERRORS: usize = 4;

/// A base driver on a thread of its own, which stops the base when commands stop coming.
///
/// An actor's mailbox drains until it is empty, so one that is flooded, or a behaviour that sleeps in its step, keeps every
/// timer of its thread waiting. The deadline of a base must not depend on them. The guard's thread reads the driver every
/// 10 ms and passes commands on; a command that is not renewed in time ([`Watchdog`]) is replaced by a stop,
/// whatever became of whoever gave it.
pub struct Guarded {
    shared: Arc<Shared>,
    platform: Platform,
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
    errors: Vec<DriverError>,
    quit: bool,
}

impl Guarded {
    /// Puts a driver on a thread of its own; commands hold for little more than one control `period`.
    ///
    /// # Errors
    /// If the thread can't be started.
    pub fn new(mut driver: Box<dyn BaseDriver>, robot: &str, period: Duration) -> Result<Self, DriverError> {
        // The first step may come before the thread does; a device that is not ready yet will be asked again.
        let odometry = driver.poll(Time::START).ok();
        let state = State {
            watchdog: Watchdog::new(period),
            valid_until: Time::START,
            started: None,
            fresh_command: false,
            odometry,
            truth: driver.truth(),
            errors: Vec::new(),
            quit: false,
        };
        let shared = Arc::new(Shared { state: Mutex::new(state), news: Condvar::new() });
        let platform = driver.platform().clone();
        let watched = shared.clone();
        let thread = thread::Builder::new().name(format!("base of {robot}")).spawn(move || watch(driver, &watched));
        let thread = thread.map_err(|source| DriverError::Io { what: "the base's thread can't be started".into(), source })?;
        Ok(Self { shared, platform, thread: Some(thread) })
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

    /// The fleet's time at an instant.
    fn time_at(&self, instant: Instant) -> Time {
        self.started.map_or(Time::START, |started| Time::START + instant.saturating_duration_since(started))
    }

    fn keep(&mut self, error: DriverError) {
        if self.errors.len() < KEPT_ERRORS {
            self.errors.push(error);
        }
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

/// The guard's thread.
fn watch(mut driver: Box<dyn BaseDriver>, shared: &Shared) {
    hurry();
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
        let now = Instant::now();
        next_beat = next_beat.max(now - BEAT) + BEAT;
        state.fresh_command = false;
        let (time, quit) = (state.time_at(now), state.quit);
        // The driver may take its time; commands must not wait for it.
        drop(state);
        if quit {
            driver.stop();
            return;
        }
        let measured = driver.poll(time);
        // Looked up at the last moment: while the driver was read, the command may have expired.
        let mut state = shared.lock();
        let time = state.time_at(Instant::now());
        let command = state.command(time);
        drop(state);
        let commanded = driver.command(time, command);
        let truth = driver.truth();
        let mut state = shared.lock();
        state.truth = truth;
        match measured {
            Ok(odometry) => state.odometry = Some(odometry),
            Err(error) => state.keep(error),
        }
        if let Err(error) = commanded {
            state.keep(error);
        }
    }
}

impl BaseDriver for Guarded {
    fn platform(&self) -> &Platform {
        &self.platform
    }

    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        let mut state = self.shared.lock();
        state.hear(now);
        if !state.errors.is_empty() {
            return Err(state.errors.remove(0));
        }
        state
            .odometry
            .ok_or_else(|| DriverError::LinkLost { device: self.platform.name.clone(), why: "nothing has come yet".into() })
    }

    fn command(&mut self, now: Time, twist: Twist) -> Result<(), DriverError> {
        let mut state = self.shared.lock();
        state.hear(now);
        state.watchdog.feed(now, twist);
        state.fresh_command = true;
        self.shared.news.notify_one();
        Ok(())
    }

    fn truth(&self) -> Option<Truth> {
        self.shared.lock().truth
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
            // A driver that panicked has taken its device with it; nothing is left to be told.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::sync::mpsc;

    use orienteer_runtime::geometry::Limits;

    use super::*;

    struct Witness {
        platform: Platform,
        told: mpsc::Sender<(Instant, Twist)>,
    }

    impl BaseDriver for Witness {
        fn platform(&self) -> &Platform {
            &self.platform
        }

        fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
            Ok(Odometry { stamp: now, ..Odometry::default() })
        }

        fn command(&mut self, _now: Time, twist: Twist) -> Result<(), DriverError> {
            let deaf = |_| DriverError::Refused { what: "nobody listens".into() };
            self.told.send((Instant::now(), twist)).map_err(deaf)
        }

        fn stop(&mut self) {
            let _ = self.told.send((Instant::now(), Twist::STOP));
        }
    }

    /// A base whose commands hold until a time, and what it is told.
    fn guarded(period: Duration, until: Time) -> (Guarded, mpsc::Receiver<(Instant, Twist)>) {
        let (told, hears) = mpsc::channel();
        let platform = Platform {
            name: "witness".into(),
            radius: 0.3,
            limits: Limits::NONE,
            acceleration: 1.0,
            angular_acceleration: 1.0,
            turning_radius: 0.0,
        };
        let base = Guarded::new(Box::new(Witness { platform, told }), "test", period).unwrap();
        base.guard().hold_until(until);
        (base, hears)
    }

    #[test]
    fn a_command_that_is_not_renewed_is_replaced_by_a_stop_even_if_its_giver_sleeps() {
        let period = Duration::from_millis(50);
        let (mut base, hears) = guarded(period, Time::FAR);
        let given = Instant::now();
        base.command(Time::START, Twist::new(0.5, 0.0)).unwrap();
        thread::sleep(Duration::from_millis(300));
        drop(base);
        let told: Vec<_> = hears.try_iter().collect();
        let last_moving = told.iter().filter(|(_, twist)| !twist.is_stop()).map(|(when, _)| *when).max().unwrap();
        let stopped = told.iter().find(|(when, twist)| *when > last_moving && twist.is_stop()).unwrap().0;
        // A machine that stalls can only make the stop later than this; the order of events is what is checked.
        assert!(last_moving.duration_since(given) <= period + Duration::from_millis(10), "moved on after its time");
        assert!(stopped > last_moving && told.last().unwrap().1.is_stop());
    }

    #[test]
    fn a_command_is_as_old_as_the_step_that_brings_it() {
        let (mut base, hears) = guarded(Duration::from_millis(50), Time::FAR);
        base.poll(Time::from_secs_f64(1.0)).unwrap();
        // A behaviour sleeps in this step, after another has claimed the base.
        thread::sleep(Duration::from_millis(100));
        base.command(Time::from_secs_f64(1.0), Twist::new(0.5, 0.0)).unwrap();
        thread::sleep(Duration::from_millis(30));
        drop(base);
        assert!(hears.try_iter().all(|(_, twist)| twist.is_stop()), "an old command was executed");
    }

    #[test]
    fn a_command_never_outlives_the_decision_behind_it() {
        let (mut base, hears) = guarded(Duration::from_millis(500), Time::START);
        base.command(Time::from_secs_f64(1.0), Twist::new(0.5, 0.0)).unwrap();
        drop(base);
        assert!(hears.try_iter().all(|(_, twist)| twist.is_stop()), "the decision was over before it came");
    }
}
