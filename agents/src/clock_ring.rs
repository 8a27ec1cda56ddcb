//! Rings of ranges, read like a clock: what detectors look at (Randazza 1989, §4.2).
//!
//! A *ring* holds one range for each of 16 directions, 22.5° apart, the first ahead and the rest clockwise. A single pass of a
//! sonar ring is never trusted: a ring is made of twelve of them, direction by direction. Two rings, of which the second was taken
//! half a step turned to the right, make a *double ring* of 32 directions.

use std::f64::consts::TAU;

use orienteer_runtime::{geometry::angle, robot_model, topics::SonarScan};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Directions of a ring.
pub const DIRECTIONS: usize = 16;
/// From one direction to the next, rad.
pub const STEP: f64 = TAU / DIRECTIONS as f64;
/// A transducer may point so far off its direction, rad.
const OFF: f64 = 0.01;

/// One range for each direction, m from the transducer's face; the greatest range where nothing answered.
pub type ClockRing = [f64; DIRECTIONS];

/// How several ranges of one direction become one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RingFilter {
    /// Their mean. A single spurious reading spoils it.
    Mean,
    /// Their median; of an even number the mean of the middle two, if they agree, else the nearer.
    Median,
    /// The most frequent value; of several the smallest.
    Mode,
}

/// Which transducer looks in which direction of the clock.
#[derive(Debug, Clone, PartialEq)]
pub struct Clockwork {
    transducers: [usize; DIRECTIONS],
    /// Distance of the faces from the robot's centre, m.
    pub face: f64,
    max_range: f64,
}

impl Clockwork {
    /// Reads a sonar ring like a clock.
    ///
    /// # Errors
    /// If it does not look in all 16 directions from one circle about the robot's centre, with a sentence for people.
    pub fn new(ring: &robot_model::Ring) -> Result<Self, String> {
        let mut transducers = [0; DIRECTIONS];
        for (direction, transducer) in transducers.iter_mut().enumerate() {
            let bearing = -STEP * direction as f64;
            let looks = |i: &usize| angle::turn(ring.transducers[*i].mount.heading, bearing).abs() < OFF;
            let found = ring.nearest_to(bearing).filter(looks);
            *transducer = found.ok_or_else(|| {
                format!(
                    "`{}` has no transducer that looks {:.1} deg to the left of ahead; the detectors need 16, 22.5 deg apart, as `denning-16` has",
                    ring.name,
                    angle::wrap(bearing).to_degrees()
                )
            })?;
        }
        let reach = |i: usize| ring.transducers[i].mount.x.hypot(ring.transducers[i].mount.y);
        let face = reach(transducers[0]);
        if transducers.iter().any(|i| (reach(*i) - face).abs() > OFF) {
            return Err(format!("the transducers of `{}` are not on one circle about the robot's centre", ring.name));
        }
        Ok(Self { transducers, face, max_range: ring.max_range })
    }
}

/// Gathers passes of the sonar until they make a ring.
///
/// ```
/// use orienteer_agents::clock_ring::{Gathering, RingFilter};
/// let mut gathering = Gathering::new(3);
/// for range in [1.0, 9.0, 1.1] {
///     gathering.add(&[range; 16]);
/// }
/// assert!(gathering.is_full());
/// assert_eq!(gathering.ring(RingFilter::Median)[0], 1.1);
/// ```
#[derive(Debug, Clone)]
pub struct Gathering {
    /// By direction, all that was heard.
    ranges: [Vec<f64>; DIRECTIONS],
    wanted: usize,
    seq: u64,
}

impl Gathering {
    /// Of so many passes.
    #[must_use]
    pub fn new(wanted: usize) -> Self {
        Self { ranges: std::array::from_fn(|_| Vec::with_capacity(wanted)), wanted, seq: 0 }
    }

    /// Takes a pass, if it is another than the last one.
    pub fn hear(&mut self, clockwork: &Clockwork, scan: &SonarScan) {
        if scan.seq == self.seq || self.is_full() {
            return;
        }
        self.seq = scan.seq;
        for (ranges, transducer) in self.ranges.iter_mut().zip(clockwork.transducers) {
            ranges.extend(scan.echo(transducer).free_distance(clockwork.max_range as f32).map(f64::from));
        }
    }

    /// Takes a pass as it is, in clock order.
    pub fn add(&mut self, pass: &ClockRing) {
        for (ranges, range) in self.ranges.iter_mut().zip(pass) {
            ranges.push(*range);
        }
    }

    /// True if every direction has been heard as often as wanted.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.ranges.iter().all(|ranges| ranges.len() >= self.wanted)
    }

    /// The ring that they make.
    #[must_use]
    pub fn ring(&mut self, filter: RingFilter) -> ClockRing {
        let mut ring = [0.0; DIRECTIONS];
        for (range, heard) in ring.iter_mut().zip(&mut self.ranges) {
            heard.sort_by(f64::total_cmp);
            *range = filter.of(heard);
        }
        ring
    }
}

/// Two middle values that are farther apart than this do not agree, m.
const AGREES: f64 = 0.1;

impl RingFilter {
    /// One range from several, in ascending order; 0 of none.
    fn of(self, sorted: &[f64]) -> f64 {
        let Some(middle) = sorted.get(sorted.len() / 2).copied() else { return 0.0 };
        match self {
            RingFilter::Mean => sorted.iter().sum::<f64>() / sorted.len() as f64,
            RingFilter::Median if sorted.len().is_multiple_of(2) => {
                let below = sorted[sorted.len() / 2 - 1];
                if middle - below < AGREES { 0.5 * (middle + below) } else { below }
            }
            RingFilter::Median => middle,
            RingFilter::Mode => mode(sorted),
        }
    }
}

fn mode(sorted: &[f64]) -> f64 {
    let runs = sorted.chunk_by(|a, b| a == b);
    // Of several that are as long, max_by_key would take the last.
    let longest = runs.fold(&[][..], |longest, run| if run.len() > longest.len() { run } else { longest });
    longest.first().copied().unwrap_or_default()
}

/// Two rings, the second taken half a step to the right of the first: 32 directions, clockwise.
#[must_use]
pub fn double(first: &ClockRing, second: &ClockRing) -> [f64; 2 * DIRECTIONS] {
    std::array::from_fn(|i| if i % 2 == 0 { first[i / 2] } else { second[i / 2] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_are_what_they_are_called() {
        let of = |filter: RingFilter, heard: &[f64]| filter.of(heard);
        assert_eq!(of(RingFilter::Mean, &[1.0, 2.0, 6.0]), 3.0);
        assert_eq!(of(RingFilter::Median, &[1.0, 2.0, 6.0]), 2.0);
        assert_eq!(of(RingFilter::Median, &[1.0, 2.0, 2.04, 6.0]), 2.02);
        assert_eq!(of(RingFilter::Median, &[1.0, 2.0, 5.0, 6.0]), 2.0, "half of them heard something near");
        assert_eq!(of(RingFilter::Mode, &[1.0, 2.0, 2.0, 3.0, 3.0]), 2.0);
        assert_eq!(of(RingFilter::Mode, &[]), 0.0);
    }

    #[test]
    fn a_double_ring_runs_clockwise() {
        let first: ClockRing = std::array::from_fn(|i| i as f64);
        let second: ClockRing = std::array::from_fn(|i| i as f64 + 0.5);
        let both = double(&first, &second);
        assert!(both.iter().enumerate().all(|(i, range)| *range == 0.5 * i as f64));
    }

    #[test]
    fn the_same_pass_counts_once() {
        use orienteer_runtime::{time::Time, topics::Echo};
        let clockwork = Clockwork { transducers: std::array::from_fn(|i| i), face: 0.08, max_range: 7.77 };
        let mut gathering = Gathering::new(2);
        let scan = |seq| SonarScan::from_echoes(Time::START, seq, &[Echo::Range(1.0); DIRECTIONS]);
        for seq in [1, 1, 1] {
            gathering.hear(&clockwork, &scan(seq));
        }
        assert!(!gathering.is_full());
        gathering.hear(&clockwork, &scan(2));
        assert!(gathering.is_full());
    }
}
