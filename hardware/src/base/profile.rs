//! The arithmetic of speeding up and braking in whole control periods.
//!
//! A command is held for one control period `T`, and the base changes its speed towards it by at most `a`. So the question
//! of every period is: which speed `u` may be commanded now, such that the distance covered while it is held, and the
//! distance needed to come to rest afterwards, fit into what is left?
//!
//! ```text
//! travel(v → u, T) + u·latency + u² / 2b  ≤  remaining
//! ```
//!
//! Solving this in each period lands exactly on the mark, whatever the period. The usual `v = √(2·a·remaining)` knows
//! nothing of the period and overshoots by up to `v·T`.

/// Moves `value` towards `target` by at most `rate` per second for `seconds`. Returns the value at the end and its integral,
/// both exact.
#[must_use]
pub fn ramp(value: f64, target: f64, rate: f64, seconds: f64) -> (f64, f64) {
    let gap = target - value;
    let ramp_time = gap.abs() / rate;
    if ramp_time <= seconds {
        (target, 0.5 * (value + target) * ramp_time + target * (seconds - ramp_time))
    } else {
        let end = value + rate.copysign(gap) * seconds;
        (end, 0.5 * (value + end) * seconds)
    }
}

/// What a base may use for [`Braking::speed`]. Works for metres and for radians alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Braking {
    /// Largest change of speed of the base, m/s² (or rad/s²).
    pub acceleration: f64,
    /// The part of it that is planned with when braking, at most `acceleration`.
    pub deceleration: f64,
    /// For how long the command is held, s.
    pub period: f64,
    /// For how long the base goes on at the commanded speed before it heeds a lower command, s.
    pub latency: f64,
}

impl Braking {
    /// The highest speed in `0..=cap` that may be commanded now to a base that moves at `speed` (negative: away from the
    /// mark), so that it can still come to rest within `remaining`.
    ///
    /// If even the hardest braking is not enough, it is 0.
    #[must_use]
    pub fn speed(&self, remaining: f64, speed: f64, cap: f64) -> f64 {
        let fastest = (speed + self.acceleration * self.period).max(0.0).min(cap);
        if self.needed(speed, fastest) <= remaining {
            // Nothing is gained by asking for less than the cap: the base speeds up as fast as it can in either case.
            return cap;
        }
        // needed() grows with the command, so halving finds the root; 48 halvings exhaust the digits of any sensible speed.
        let (mut low, mut high) = (0.0, fastest);
        for _ in 0..48 {
            let middle = 0.5 * (low + high);
            if self.needed(speed, middle) <= remaining {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }

    /// Distance from now to rest if `command` is held for one period and the base then brakes.
    #[must_use]
    pub fn needed(&self, speed: f64, command: f64) -> f64 {
        let (end, covered) = ramp(speed, command, self.acceleration, self.period);
        covered + end.max(0.0) * self.latency + end * end / (2.0 * self.deceleration)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_ramp_agrees_with_small_steps(from in -2.0..2.0f64, to in -2.0..2.0f64, rate in 0.1..5.0f64, seconds in 0.001..2.0f64) {
            let (end, covered) = ramp(from, to, rate, seconds);
            let (steps, mut v, mut x) = (20_000, from, 0.0);
            let dt = seconds / f64::from(steps);
            for _ in 0..steps {
                let next = v + (to - v).clamp(-rate * dt, rate * dt);
                x += 0.5 * (v + next) * dt;
                v = next;
            }
            prop_assert!((end - v).abs() < 1e-9 && (covered - x).abs() < 1e-3 * seconds);
        }

        #[test]
        fn obeying_the_allowed_speed_never_overruns(
            distance in 0.001..5.0f64, cap in 0.01..2.0f64, a in 0.1..4.0f64, share in 0.5..1.0f64, period in 0.005..0.2f64
        ) {
            let braking = Braking { acceleration: a, deceleration: share * a, period, latency: 0.0 };
            let (mut v, mut x) = (0.0, 0.0);
            for _ in 0..((20.0 + 40.0 * distance / cap) / period) as usize {
                let u = braking.speed(distance - x, v, cap);
                let (end, covered) = ramp(v, u, a, period);
                v = end;
                x += covered;
                prop_assert!(x <= distance + 1e-9);
            }
            // and it gets there
            prop_assert!(distance - x < 1e-3, "short by {}", distance - x);
        }
    }
}
