//! What the base has been told of late. A base that heeds late, and says late where it is, may be doing any of it.

use std::collections::VecDeque;

use orienteer_runtime::{geometry::Twist, time::Time};

/// No more commands than this are remembered, however many there are in the time that matters.
const MOST: usize = 8192;

/// The newest commands.
#[derive(Debug, Clone)]
pub(super) struct Told {
    /// When, and the speed, m/s; oldest first.
    speeds: VecDeque<(Time, f64)>,
    /// So many are kept.
    count: usize,
    last: Twist,
}

impl Told {
    /// Told nothing yet, and one command a `period` from then on, of which those of so many `seconds` matter.
    pub fn nothing(seconds: f64, period: f64) -> Self {
        let count = (seconds / period).ceil().clamp(1.0, MOST as f64) as usize + 1;
        Self { speeds: VecDeque::with_capacity(count), count, last: Twist::STOP }
    }

    /// The last command.
    pub fn last(&self) -> Twist {
        self.last
    }

    /// Remembers a command.
    pub fn tell(&mut self, now: Time, twist: Twist) {
        if self.speeds.len() == self.count {
            self.speeds.pop_front();
        }
        self.speeds.push_back((now, twist.linear));
        self.last = twist;
    }

    /// The least and the greatest speed (m/s, signed) that the base had as its command at any time from `since` on.
    pub fn speeds(&self, since: Time) -> (f64, f64) {
        let (mut least, mut greatest) = (self.last.linear, self.last.linear);
        for (when, speed) in self.speeds.iter().rev() {
            (least, greatest) = (least.min(*speed), greatest.max(*speed));
            // This one was in force at that time; those before it were not.
            if *when <= since {
                break;
            }
        }
        (least, greatest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_are_those_in_force_since_then() {
        let mut told = Told::nothing(3.0, 0.5);
        assert_eq!(told.speeds(Time::START), (0.0, 0.0));
        for (second, speed) in [(1.0, 0.5), (2.0, -0.3), (3.0, 0.1)] {
            told.tell(Time::from_secs_f64(second), Twist::new(speed, 0.0));
        }
        let since = |second| told.speeds(Time::from_secs_f64(second));
        assert_eq!([3.5, 3.0, 2.5, 2.0, 1.5].map(since), [(0.1, 0.1), (0.1, 0.1), (-0.3, 0.1), (-0.3, 0.1), (-0.3, 0.5)]);
        for _ in 0..20 {
            told.tell(Time::from_secs_f64(4.0), Twist::STOP);
        }
        assert_eq!(told.speeds.len(), 7);
        assert_eq!(told.last(), Twist::STOP);
    }
}
