//! What a base says of itself, in metres and radians.

use std::{collections::VecDeque, time::Duration};

use orienteer_runtime::{
    geometry::Twist,
    time::Time,
    topics::{Odometry, flags},
};

use crate::wire::oi::{
    sensors::{Sensors, stasis},
    stream::PERIOD,
    units::{Model, Way, change},
};

/// Velocity is measured over so many frames: a count of an encoder is 0.44 mm, 3 cm/s in a single one.
const FRAMES: usize = 6;
/// After a longer pause between two frames nobody knows in which time the way between them was gone.
const PAUSE: Duration = Duration::from_millis(60);
/// Slower than this, m/s, the caster may not turn.
const CREEPS: f64 = 0.05;
/// On a sharper curve than this, rad/s, it may not turn either.
const STRAIGHT: f64 = 0.1;
/// It has stopped when it has not turned for so long.
const STUCK: Duration = Duration::from_millis(700);

/// Odometry of one base, frame by frame.
///
/// The pose is relative to where the base stood at its first frame. What it did while nothing was heard of it nobody knows: its counters
/// may have begun anew meanwhile, so they are read on from where they stand then.
#[derive(Debug, Clone)]
pub struct Readings {
    model: Model,
    /// Counts of the left and the right wheel in the last frame.
    counts: Option<(u16, u16)>,
    /// Way and turn of the last frames.
    steps: VecDeque<(f64, f64)>,
    odometry: Option<Odometry>,
    caster: Caster,
}

/// The caster at the front, which turns while the base goes ahead.
///
/// Some have none that can be seen: one that was never seen to turn tells nothing.
#[derive(Debug, Clone, Default)]
struct Caster {
    was_seen_to_turn: bool,
    /// Since when it should turn, and does not.
    still: Option<Time>,
}

impl Readings {
    /// Of a base of this model, of which nothing was heard yet.
    #[must_use]
    pub fn new(model: Model) -> Self {
        Self { model, counts: None, steps: VecDeque::with_capacity(FRAMES), odometry: None, caster: Caster::default() }
    }

    /// Takes in a frame that came at `now`, from a base whose wheels were told to move like this.
    pub fn follow(&mut self, now: Time, sensors: &Sensors, told: Twist) {
        let (way, turn) = self.step(sensors);
        let before = self.odometry.unwrap_or_default();
        if now.since(before.stamp) > PAUSE {
            self.steps.clear();
        }
        if self.steps.len() == FRAMES {
            self.steps.pop_front();
        }
        self.steps.push_back((way, turn));
        let stuck = self.caster.is_stuck(now, sensors, told);
        self.odometry = Some(Odometry {
            stamp: now,
            pose: before.pose.along_arc(way, turn),
            twist: self.twist(),
            travelled: before.travelled + way.abs(),
            turned: before.turned + turn,
            battery: f32::from(sensors.voltage) / 1000.0,
            flags: state_of(sensors, stuck),
        });
    }

    /// The base has been away: its counters may stand anywhere.
    pub fn begin_anew(&mut self) {
        self.counts = None;
        self.steps.clear();
        self.caster.still = None;
    }

    /// The newest odometry; `None` before the first frame.
    #[must_use]
    pub fn odometry(&self) -> Option<Odometry> {
        self.odometry
    }

    /// Way and turn since the last frame, m and rad.
    fn step(&mut self, sensors: &Sensors) -> (f64, f64) {
        let now = (sensors.left_encoder, sensors.right_encoder);
        let Some(last) = self.counts.replace(now) else { return (0.0, 0.0) };
        match self.model.way {
            Way::Encoders(count) => {
                let metres = |before, now| f64::from(change(before, now)) * count;
                let (left, right) = (metres(last.0, now.0), metres(last.1, now.1));
                ((left + right) / 2.0, (right - left) / self.model.tread)
            }
            Way::Sums => (f64::from(sensors.distance) / 1000.0, f64::from(sensors.angle).to_radians()),
        }
    }

    fn twist(&self) -> Twist {
        let seconds = self.steps.len() as f64 * PERIOD.as_secs_f64();
        let (way, turn) = self.steps.iter().fold((0.0, 0.0), |sum, step| (sum.0 + step.0, sum.1 + step.1));
        Twist::new(way / seconds, turn / seconds)
    }
}

impl Caster {
    fn is_stuck(&mut self, now: Time, sensors: &Sensors, told: Twist) -> bool {
        let turns = sensors.stasis & stasis::GOES_AHEAD != 0;
        let blind = sensors.stasis & stasis::DIRTY != 0;
        self.was_seen_to_turn |= turns && !blind;
        let should_turn = told.linear > CREEPS && told.angular.abs() < STRAIGHT;
        if turns || blind || !should_turn || !self.was_seen_to_turn {
            self.still = None;
        } else {
            self.still.get_or_insert(now);
        }
        self.still.is_some_and(|since| now.since(since) >= STUCK)
    }
}

/// The module's head says why. Motors that do not obey are an emergency stop, whoever has switched them off.
fn state_of(sensors: &Sensors, stuck: bool) -> u32 {
    let obeys = sensors.mode.obeys();
    [
        (obeys, flags::ENABLED),
        (sensors.overloaded() || stuck, flags::STALLED),
        (sensors.bumps() || sensors.cliff(), flags::CONTACT | flags::CONTACT_AHEAD),
        (!obeys || sensors.drops(), flags::EMERGENCY_STOP),
    ]
    .into_iter()
    .filter_map(|(is, flag)| is.then_some(flag))
    .sum()
}

#[cfg(test)]
mod tests;
