//! The history of one transducer and the line that is fitted to it.

use nalgebra::{Point2, Vector2};
use orienteer_runtime::geometry::angle;

/// The recent readings of one transducer, freed of the robot's own motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Track {
    /// The last three readings: their median goes before everything else, so that one spurious echo shows nowhere.
    recent: [f64; 3],
    count: usize,
    /// The most by which a thing at rest can have come nearer since the beginning, m.
    along: f64,
    last: Option<(Point2<f64>, f64)>,
    /// When the newest reading was taken, s.
    taken: f64,
    samples: [Sample; HISTORY],
    len: usize,
    next: usize,
    range: Option<f64>,
    trend: Trend,
}

/// One reading.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reading {
    /// When it was taken, s.
    pub time: f64,
    /// From the transducer's face, m; the ring's greatest if nothing was heard.
    pub range: f64,
    /// Whether anything was heard.
    pub heard: bool,
    /// The robot's centre, odometry frame.
    pub at: Point2<f64>,
    /// Where the beam pointed, odometry frame, rad.
    pub axis: f64,
}

/// How what the transducer hears moves by itself.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Trend {
    /// Speed at which it comes nearer, m/s.
    pub approach: f64,
    /// How much nearer it has come, m.
    pub came: f64,
    /// It came evenly and for long enough.
    pub steady: bool,
}

#[derive(Debug, Clone, Copy, Default)]
struct Sample {
    time: f64,
    /// What the reading would be if things at rest had come nearer as much as they can.
    still: f64,
    axis: f64,
}

/// At 25 ms per ring, 0.8 s.
const HISTORY: usize = 32;
/// Slopes of fewer readings than this, or over less time, s, are not worth anything: at 25 ms per ring, six readings.
const ENOUGH: (usize, f64) = (3, 0.12);
/// By how much two readings of somebody who stands may differ, m: one quantum, and noise.
const SCATTER: f64 = 0.08;
/// Nobody walks faster than this, m/s. What changes by more between two readings is something else.
const WALKS: f64 = 1.6;
/// Between readings that are farther apart in time than this, s, anything may have happened: as slow as the slowest rings.
const LONGEST_PASS: f64 = 0.5;
/// A beam that has turned by more than this, rad, looks elsewhere.
const ELSEWHERE: f64 = 0.09;
/// Tangent of the widest angle of incidence at which walls usually answer (30°).
const RIM: f64 = 0.577;
/// Readings of somebody who walks evenly scatter about the line by less than this, m (noise 1 cm, quantum 3 cm: 1.3 cm).
const EVEN: f64 = 0.022;
/// For how long something must have been coming to be believed, s.
const LASTING: f64 = 0.35;

impl Default for Track {
    fn default() -> Self {
        Self {
            recent: [0.0; 3],
            count: 0,
            along: 0.0,
            last: None,
            taken: f64::NEG_INFINITY,
            samples: [Sample::default(); HISTORY],
            len: 0,
            next: 0,
            range: None,
            trend: Trend::default(),
        }
    }
}

impl Track {
    /// What is heard, m from the face; `None` if nothing.
    pub fn range(&self) -> Option<f64> {
        self.range
    }

    /// When the newest reading was taken, s; before all times if there is none.
    pub fn taken(&self) -> f64 {
        self.taken
    }

    /// How it moves by itself, as of the last [`Track::refit`].
    pub fn trend(&self) -> Trend {
        self.trend
    }

    /// Works out anew how what is heard moves: once after the readings of a step, for it looks through the whole history.
    pub fn refit(&mut self) {
        self.trend = self.fit();
    }

    /// Takes a reading of a beam in which things may be up to `half` off the axis, rad. `course` gives the direction of a vector.
    pub fn push(&mut self, reading: Reading, half: f64, course: impl FnOnce(Vector2<f64>) -> f64) {
        let jump = SCATTER + WALKS * (reading.time - self.taken).clamp(0.0, LONGEST_PASS);
        self.taken = reading.time;
        if let Some((last, axis)) = self.last.replace((reading.at, reading.axis)) {
            let by = reading.at - last;
            let off = angle::turn(course(by), reading.axis).abs();
            self.along += by.norm() * (off - half).max(0.0).cos();
            // A wall that answers at the rim of a beam gets nearer by r·tan i per radian when the beam turns toward its normal.
            self.along += RIM * self.range.unwrap_or(0.0) * angle::turn(axis, reading.axis).abs();
        }
        self.recent[self.count % 3] = if reading.heard { reading.range } else { f64::INFINITY };
        self.count += 1;
        if self.count < 3 {
            return;
        }
        let [a, b, c] = self.recent;
        let range = a.max(b).min(a.min(b).max(c));
        self.range = range.is_finite().then_some(range);
        let still = range + self.along;
        if !range.is_finite() || (self.len > 0 && (still - self.newest(0).still).abs() > jump) {
            self.len = 0;
        }
        if range.is_finite() {
            self.samples[self.next] = Sample { time: reading.time, still, axis: reading.axis };
            self.next = (self.next + 1) % HISTORY;
            self.len = (self.len + 1).min(HISTORY);
        }
    }

    /// The sample that is so many before the newest.
    fn newest(&self, back: usize) -> Sample {
        self.samples[(self.next + 2 * HISTORY - 1 - back) % HISTORY]
    }

    /// A line through the samples, by least squares: `still = r₀ − approach · t`.
    fn fit(&self) -> Trend {
        let Some(newest) = (self.len > 0).then(|| self.newest(0)) else { return Trend::default() };
        let same = |back: &usize| angle::turn(self.newest(*back).axis, newest.axis).abs() < ELSEWHERE;
        let len = (0..self.len).take_while(same).count();
        if len < ENOUGH.0 || newest.time - self.newest(len - 1).time < ENOUGH.1 {
            return Trend::default();
        }
        let n = len as f64;
        let centred = |back: usize| (self.newest(back).time - newest.time, self.newest(back).still - newest.still);
        let (t_sum, r_sum) = (0..len).map(centred).fold((0.0, 0.0), |sum, (t, r)| (sum.0 + t, sum.1 + r));
        let (t_mean, r_mean) = (t_sum / n, r_sum / n);
        let (mut tt, mut tr, mut rr) = (0.0, 0.0, 0.0);
        for (t, r) in (0..len).map(centred) {
            let (t, r) = (t - t_mean, r - r_mean);
            (tt, tr, rr) = (tt + t * t, tr + t * r, rr + r * r);
        }
        if tt <= 0.0 {
            return Trend::default();
        }
        let slope = tr / tt;
        let scatter = ((rr - slope * tr).max(0.0) / n).sqrt();
        let span = newest.time - self.newest(len - 1).time;
        let came = -slope * span;
        let off_line = (rr - slope * tr).max(0.0);
        let evenly = scatter < EVEN && span >= LASTING && off_line < self.off_step(len, rr);
        Trend { approach: -slope, came, steady: evenly }
    }

    /// The squares that are left of `all` (about the mean of the newest `len` samples) if they are not on a line, but on two levels: a
    /// beam that has come to meet something else, which stands as well, draws a step.
    fn off_step(&self, len: usize, all: f64) -> f64 {
        let newest = self.newest(0).still;
        let total: f64 = (0..len).map(|back| self.newest(back).still - newest).sum();
        let n = len as f64;
        let (mut sum, mut most) = (0.0, 0.0_f64);
        for back in 0..len - 1 {
            sum += self.newest(back).still - newest;
            let (one, other) = (back as f64 + 1.0, n - back as f64 - 1.0);
            let apart = sum / one - (total - sum) / other;
            most = most.max(one * other / n * apart * apart);
        }
        all - most
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is made of ranges that are heard every 25 ms by a robot that stands, with noise of up to a centimetre on them.
    fn trend(range: impl Fn(f64) -> f64) -> Trend {
        let mut track = Track::default();
        for n in 0..60 {
            let time = 0.025 * f64::from(n);
            let noise = 0.01 * f64::from((n * 7) % 5 - 2) / 2.0;
            let reading = Reading { time, range: range(time) + noise, heard: true, at: Point2::origin(), axis: 0.0 };
            track.push(reading, 0.2, |_| 0.0);
        }
        track.refit();
        track.trend()
    }

    #[test]
    fn who_walks_comes_steadily_and_a_step_does_not() {
        for speed in [0.15, 0.4, 1.0] {
            let walks = trend(|time| 2.0 - speed * time);
            assert!(walks.steady && (walks.approach - speed).abs() < 0.03, "{speed} m/s: {walks:?}");
        }
        // The two corners of a door post 14 cm thick, one after the other; at the change now this, now that.
        for height in [0.05, 0.09, 0.12] {
            for when in [0.9, 1.0, 1.1, 1.2, 1.3] {
                let flickers = |time: f64| (time * 40.0).round() as i64 % 2 == 0;
                let steps = trend(|time| if time > when + 0.05 || (time > when && flickers(time)) { 1.0 - height } else { 1.0 });
                assert!(!steps.steady || steps.came < 0.1, "{height} m after {when} s: {steps:?}");
            }
        }
    }
}
