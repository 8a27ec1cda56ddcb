//! Who says what time it is.
//!
//! Only the fleet reads a clock, and only through this module. In lockstep, time is a count of control periods; the pace says
//! how fast they follow each other. At wall time, a step is told how long the mission has run.

use std::{
    sync::{Arc, OnceLock},
    time::{Duration, Instant},
};

use rustix::time::{ClockId, Timespec, clock_gettime};

use crate::time::Time;

/// How simulated or real time passes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pace {
    /// Lockstep, each step as soon as the last is complete.
    AsFastAsPossible,
    /// Lockstep at a multiple of real time.
    Factor(f64),
    /// The machine's clock. Steps that come late are skipped, not made up for.
    Wall,
}

/// When a mission's time began, on the clock that all processes of this machine share: what turns one mission's times into
/// another's. To be cloned before the mission begins, and asked once it has.
#[derive(Debug, Clone, Default)]
pub struct Epoch {
    nanos: Arc<OnceLock<u64>>,
}

impl Epoch {
    /// Nanoseconds on the machine's monotonic clock at [`Time::START`]; `None` before the mission has begun.
    #[must_use]
    pub fn nanos(&self) -> Option<u64> {
        self.nanos.get().copied()
    }

    /// The mission begins now.
    pub(crate) fn begin(&self) {
        let Timespec { tv_sec, tv_nsec } = clock_gettime(ClockId::Monotonic);
        // The machine has been up for less than 500 years.
        let _ = self.nanos.set(tv_sec.cast_unsigned() * 1_000_000_000 + tv_nsec.cast_unsigned());
    }
}

/// The clock of a fleet: hands out the time of the next step and how long to wait for it.
#[derive(Debug)]
pub struct Clock {
    pace: Pace,
    period: Duration,
    tick: u64,
    started: Instant,
    /// When step 0 was due, as the steps to come are counted.
    origin: Instant,
    missed: u64,
}

impl Clock {
    /// A clock at the start of a mission.
    #[must_use]
    pub fn new(pace: Pace, period: Duration) -> Self {
        let started = Instant::now();
        Self { pace, period, tick: 0, started, origin: started, missed: 0 }
    }

    /// The time of the current step.
    #[must_use]
    pub fn now(&self) -> Time {
        match self.pace {
            Pace::Wall => Time::START + self.started.elapsed(),
            Pace::AsFastAsPossible | Pace::Factor(_) => self.simulated(),
        }
    }

    fn simulated(&self) -> Time {
        Time::from_nanos(self.tick.saturating_mul(self.period.as_nanos() as u64))
    }

    /// Goes on to the next step and returns how long to wait for it.
    pub fn advance(&mut self) -> Duration {
        self.tick += 1;
        if self.pace == Pace::Wall {
            let late = self.origin.elapsed().saturating_sub(self.due());
            let skipped = (late.as_nanos() / self.period.as_nanos().max(1)) as u64;
            self.tick += skipped;
            self.missed += skipped;
        }
        self.remaining()
    }

    /// How long to wait for the step that comes next; nothing if it is due.
    #[must_use]
    pub fn remaining(&self) -> Duration {
        if self.pace == Pace::AsFastAsPossible { Duration::ZERO } else { self.due().saturating_sub(self.origin.elapsed()) }
    }

    /// Real time from the origin to the step that comes next.
    fn due(&self) -> Duration {
        let simulated = self.simulated().since(Time::START);
        if let Pace::Factor(factor) = self.pace { simulated.div_f64(factor.max(1e-6)) } else { simulated }
    }

    /// Starts simulated time anew at the current step, so that a pause is not made up for.
    pub fn resume(&mut self) {
        if let Pace::Factor(_) = self.pace {
            self.next_is_due();
        }
    }

    /// At wall time: somebody else has set the beat, and all steps to come are counted from there. Who beats twice as fast as this clock
    /// or faster is not followed: `false`.
    pub fn follow(&mut self) -> bool {
        let follows = self.pace == Pace::Wall && self.remaining() <= self.period / 2;
        if follows {
            self.next_is_due();
        }
        follows
    }

    fn next_is_due(&mut self) {
        self.origin = Instant::now().checked_sub(self.due()).unwrap_or(self.origin);
    }

    /// How long a step may still wait for a beat that is somebody else's.
    #[must_use]
    pub fn grace(&self) -> Duration {
        (self.due() + self.period / 2).saturating_sub(self.origin.elapsed())
    }

    /// Number of steps taken or skipped.
    #[must_use]
    pub fn tick(&self) -> u64 {
        self.tick
    }

    /// Steps that were skipped because the last one came too late. Always 0 in lockstep.
    #[must_use]
    pub fn missed(&self) -> u64 {
        self.missed
    }

    /// Wall time since the mission started.
    #[must_use]
    pub fn elapsed(&self) -> Duration {
        self.started.elapsed()
    }

    /// What measures steps under this clock: nothing in lockstep, where the machine's speed must not show.
    #[must_use]
    pub fn stopwatch(pace: Pace) -> Stopwatch {
        if pace == Pace::Wall { Stopwatch::Wall } else { Stopwatch::Off }
    }
}

/// Measures how long a step takes, or does not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stopwatch {
    /// Measures nothing.
    Off,
    /// Measures with the machine's clock.
    Wall,
}

/// A measurement under way.
#[derive(Debug, Clone, Copy)]
pub struct Started(Option<Instant>);

impl Stopwatch {
    /// Starts measuring.
    #[must_use]
    pub fn start(self) -> Started {
        Started((self == Stopwatch::Wall).then(Instant::now))
    }
}

impl Started {
    /// Time since the start; `None` if nothing is measured.
    #[must_use]
    pub fn elapsed(&self) -> Option<Duration> {
        self.0.map(|started| started.elapsed())
    }
}

#[cfg(test)]
mod tests;
