//! The delays before a node that panicked lives again.

use std::time::Duration;

use crate::time::Time;

/// When a behaviour that panicked may live again: after half a second, then twice as long each time, up to half a minute. A
/// behaviour that has lived for a minute since its last restart is forgiven.
#[derive(Debug, Default)]
pub(super) struct Restart {
    last_pause: Duration,
    due: Time,
}

const FIRST_PAUSE: Duration = Duration::from_millis(500);
const LONGEST_PAUSE: Duration = Duration::from_secs(30);
const FORGIVEN_AFTER: Duration = Duration::from_secs(60);

impl Restart {
    /// Notes a panic, or an attempt that failed, and returns the pause before the next attempt.
    pub(super) fn after_panic(&mut self, now: Time) -> Duration {
        let forgiven = now.since(self.due) > FORGIVEN_AFTER;
        self.last_pause = if forgiven { FIRST_PAUSE } else { (self.last_pause * 2).clamp(FIRST_PAUSE, LONGEST_PAUSE) };
        self.due = now + self.last_pause;
        self.last_pause
    }

    /// It is no use to try again.
    pub(super) fn never(&mut self) {
        self.due = Time::FAR;
    }

    pub(super) fn is_due(&self, now: Time) -> bool {
        now >= self.due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_double_up_to_half_a_minute_and_are_forgiven() {
        let mut restart = Restart::default();
        let mut now = Time::from_secs_f64(1.0);
        let mut pauses = Vec::new();
        for _ in 0..8 {
            let pause = restart.after_panic(now);
            pauses.push(pause.as_millis());
            assert!(!restart.is_due(now) && restart.is_due(now + pause));
            now = now + pause;
        }
        assert_eq!(pauses, [500, 1000, 2000, 4000, 8000, 16_000, 30_000, 30_000]);
        assert_eq!(restart.after_panic(now + Duration::from_secs(61)), FIRST_PAUSE);
    }
}
