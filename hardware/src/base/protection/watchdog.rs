//! Lets no command outlive its time.
//!
//! The base never executes a command other than a stop that is older than one control period plus a grace of 10 ms. A guard beside the
//! driver, on a thread of its own, asks [`Watchdog::command`] what may be executed now and sleeps until [`Watchdog::deadline`].

use std::time::Duration;

use orienteer_runtime::{geometry::Twist, time::Time};

/// What a command may be late, on top of a control period. Half of the 10 ms that are promised; the other half is for a thread to
/// wake up in.
pub const GRACE: Duration = Duration::from_millis(5);

/// Watches the age of the newest command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Watchdog {
    lifetime: Duration,
    command: Twist,
    given: Time,
    expired: u64,
}

impl Watchdog {
    /// A watchdog for commands that come once a `period`. There is no command yet.
    #[must_use]
    pub fn new(period: Duration) -> Self {
        Self { lifetime: period + GRACE, command: Twist::STOP, given: Time::START, expired: 0 }
    }

    /// A new command, computed at `given`. One that is not finite is a stop; one that is older than the newest is ignored.
    pub fn feed(&mut self, given: Time, command: Twist) {
        if given >= self.given {
            self.given = given;
            self.command = if command.is_finite() { command } else { Twist::STOP };
        }
    }

    /// Forgets the command: the base stands until the next one.
    pub fn cancel(&mut self) {
        self.command = Twist::STOP;
    }

    /// What the base may do now.
    pub fn command(&mut self, now: Time) -> Twist {
        if self.deadline().is_some_and(|deadline| now > deadline) {
            self.command = Twist::STOP;
            self.expired += 1;
        }
        self.command
    }

    /// When the base must be told to stop unless a new command has come; `None` if it has been told already.
    #[must_use]
    pub fn deadline(&self) -> Option<Time> {
        (!self.command.is_stop()).then(|| self.given + self.lifetime)
    }

    /// How often a command has outlived its time.
    #[must_use]
    pub fn expired(&self) -> u64 {
        self.expired
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn nothing_but_a_stop_is_ever_older_than_a_period_and_the_grace(
            events in prop::collection::vec((0u64..40, prop::bool::ANY, -1.0..1.0f64), 1..200)
        ) {
            let mut watchdog = Watchdog::new(Duration::from_millis(50));
            let (mut now, mut fed) = (0u64, None);
            for (wait, feeds, speed) in events {
                now += wait;
                let time = Time::from_nanos(now * 1_000_000);
                if feeds {
                    watchdog.feed(time, Twist::new(speed, 0.0));
                    fed = Some((now, speed));
                }
                let command = watchdog.command(time);
                match fed {
                    Some((when, speed)) if now - when <= 55 => prop_assert_eq!(command.linear, speed),
                    _ => prop_assert!(command.is_stop()),
                }
            }
        }
    }

    #[test]
    fn an_expired_command_is_counted_once_and_an_old_one_is_not_taken() {
        let mut watchdog = Watchdog::new(Duration::from_millis(50));
        let at = |millis: u64| Time::from_nanos(millis * 1_000_000);
        watchdog.feed(at(100), Twist::new(0.5, 0.0));
        assert_eq!(watchdog.deadline(), Some(at(155)));
        assert!(watchdog.command(at(156)).is_stop() && watchdog.command(at(200)).is_stop());
        assert_eq!((watchdog.expired(), watchdog.deadline()), (1, None));
        watchdog.feed(at(90), Twist::new(0.5, 0.0));
        assert!(watchdog.command(at(95)).is_stop());
        watchdog.feed(at(210), Twist::new(f64::NAN, 0.0));
        assert!(watchdog.command(at(210)).is_stop());
    }
}
