//! Carries out a motion, period by period.
//!
//! The executor turns what arbitration decided into the twist of the next control period. Velocities and stops go through as
//! they are; relative moves follow a trapezoid of speed whose braking is solved for whole periods (see
//! [`profile`](super::profile)), so that they end on the mark.
//!
//! # Which motion is which
//!
//! A relative motion is named by its holder, the holder's transaction and [`Motion::id`]. As long as the name stays the same
//! it goes on; its distance and its speed may be changed on the way, its progress counts from where it began. A new name
//! begins anew.
//!
//! A motion that another one displaced before it was done is **given up**: when its name comes back it is reported as
//! [`MotionState::Blocked`], and the base stands. Its progress can't count, because meanwhile the robot has been somewhere
//! else, and beginning anew would drive the whole distance a second time. Only its owner knows what is left to do: it gives
//! a new id. A motion that was done stays done. The last [`REMEMBERED`] names are kept; no owner hangs on to older ones.
//!
//! # When it gives up
//!
//! * a turn in place on a base that can't turn in place: at once;
//! * an emergency stop or blocked wheels: at once;
//! * no progress for [`ExecutorConfig::patience`] (somebody holds the speed down, or there is no free distance), or for
//!   [`ExecutorConfig::contact_patience`] in contact.
//!
//! A report of [`MotionState::Done`] repeats exactly the distance that was asked for if it was met within the tolerance, so that no
//! one waits for the last micrometre of a sum of floating-point numbers.

use orienteer_runtime::{
    geometry::Twist,
    robot_model::Platform,
    time::Time,
    topics::{BaseDecision, ClientId, Motion, MotionKind, MotionReport, MotionState, Odometry, flags},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::profile::{Braking, ramp};

/// How many displaced or finished motions are remembered.
pub const REMEMBERED: usize = 16;

/// Time in which a surprising velocity is believed, s.
const ESTIMATE_TIME: f64 = 0.2;

/// How relative moves are carried out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ExecutorConfig {
    /// A translation is done within this distance of its mark, m. At least half an encoder step.
    #[schemars(range(min = 0.0001, max = 0.1))]
    pub distance_tolerance: f64,
    /// A rotation is done within this angle of its mark, degrees.
    #[schemars(range(min = 0.001, max = 10.0))]
    pub angle_tolerance_deg: f64,
    /// The share of the platform's acceleration that braking is planned with.
    #[schemars(range(min = 0.1, max = 1.0))]
    pub braking_share: f64,
    /// For how long the base goes on at its old speed before it heeds a lower one, s. A driver that knows better counts with more.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub latency: f64,
    /// A move that makes no progress for so long is given up, s.
    #[schemars(range(min = 0.1, max = 3600.0))]
    pub patience: f64,
    /// The same while the body touches something, s.
    #[schemars(range(min = 0.0, max = 3600.0))]
    pub contact_patience: f64,
    /// How fast a heading error is steered away on a straight move, 1/s; 0 leaves it.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub heading_gain: f64,
}

impl Default for ExecutorConfig {
    fn default() -> Self {
        Self {
            distance_tolerance: 0.001,
            angle_tolerance_deg: 0.1,
            braking_share: 0.9,
            latency: 0.0,
            patience: 10.0,
            contact_patience: 0.5,
            heading_gain: 2.0,
        }
    }
}

impl ExecutorConfig {
    /// For a base that tells its way in steps of so many metres, its turns in steps of so many radians, and heeds a command after so many
    /// seconds: asks for no more than it can do.
    #[must_use]
    pub fn for_a_base(self, way: f64, turn: f64, latency: f64) -> Self {
        Self {
            distance_tolerance: self.distance_tolerance.max(2.0 * way),
            angle_tolerance_deg: self.angle_tolerance_deg.max(2.0 * turn.to_degrees()),
            latency: self.latency.max(latency),
            ..self
        }
    }
}

/// What tells one relative motion from another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Name {
    holder: ClientId,
    transaction: u32,
    id: u32,
    turns: bool,
}

/// A relative motion in progress.
#[derive(Debug, Clone, Copy)]
struct Move {
    name: Name,
    state: MotionState,
    /// Signed way driven since it began.
    driven: f64,
    turned_before: f64,
    last: Odometry,
    /// Progress and time when it last got on.
    mark: (f64, Time),
    final_progress: f64,
}

/// Turns motions into twists. One per base.
#[derive(Debug, Clone)]
pub struct Executor {
    platform: Platform,
    config: ExecutorConfig,
    current: Option<Move>,
    past: [(Name, MotionState, f64); REMEMBERED],
    next: usize,
    /// What was demanded last, and how fast the base should move by now.
    demanded: Twist,
    expected: Twist,
}

/// A relative move along one axis, metres or radians.
struct Axis {
    target: f64,
    progress: f64,
    speed: f64,
    cap: f64,
    acceleration: f64,
    tolerance: f64,
}

impl Executor {
    /// An executor for a base that can do what `platform` says.
    #[must_use]
    pub fn new(platform: Platform, config: ExecutorConfig) -> Self {
        Self {
            platform,
            config,
            current: None,
            past: [(Name::default(), MotionState::Idle, 0.0); REMEMBERED],
            next: 0,
            demanded: Twist::STOP,
            expected: Twist::STOP,
        }
    }

    /// The twist for the next `period` seconds and how the motion stands, from the newest odometry.
    pub fn step(&mut self, now: Time, decision: &BaseDecision, odometry: &Odometry, period: f64) -> (Twist, MotionReport) {
        self.estimate(odometry, period);
        let (demand, report) = match decision.motion.kind() {
            MotionKind::Stop => (Twist::STOP, self.leave(now)),
            MotionKind::Velocity(twist) => (twist.within(self.platform.limits), self.leave(now)),
            MotionKind::Translate { distance, speed } => self.relative(now, decision, odometry, (distance, speed), period),
            MotionKind::Rotate { angle, rate } => self.relative(now, decision, odometry, (angle, rate), period),
        };
        self.demanded = demand;
        (demand, report)
    }

    /// Tells what protection made of the last demand, so that the executor knows what the base is really doing. Call it whenever
    /// the two may differ.
    pub fn permitted(&mut self, twist: Twist) {
        self.demanded = twist;
    }

    /// Follows the drive's own ramp and pulls it towards the measured velocity. Encoders with coarse steps measure velocity
    /// poorly at short periods (1 mm in 10 ms is 0.1 m/s), so the pull is gentle. Drivers measure the mean over a period or its
    /// end; whatever lies between is no surprise.
    fn estimate(&mut self, odometry: &Odometry, period: f64) {
        let pull = (period / ESTIMATE_TIME).min(1.0);
        let follow = |before: f64, demanded: f64, rate: f64, measured: f64| {
            let (after, _) = ramp(before, demanded, rate, period);
            let surprise = measured - measured.clamp(before.min(after), before.max(after));
            if surprise.is_finite() { after + pull * surprise } else { after }
        };
        let platform = &self.platform;
        self.expected = Twist::new(
            follow(self.expected.linear, self.demanded.linear, platform.acceleration, odometry.twist.linear),
            follow(self.expected.angular, self.demanded.angular, platform.angular_acceleration, odometry.twist.angular),
        );
    }

    /// The current relative motion, if any, is over.
    fn leave(&mut self, now: Time) -> MotionReport {
        if let Some(old) = self.current.take() {
            let state = if old.state == MotionState::Done { MotionState::Done } else { MotionState::Blocked };
            let progress = old.final_progress;
            if let Some(slot) = self.past.get_mut(self.next) {
                *slot = (old.name, state, progress);
            }
            self.next = (self.next + 1) % REMEMBERED;
        }
        MotionReport::new(now, 0, MotionState::Idle, 0.0)
    }

    fn relative(
        &mut self,
        now: Time,
        decision: &BaseDecision,
        odometry: &Odometry,
        (target, cap): (f64, f64),
        period: f64,
    ) -> (Twist, MotionReport) {
        let name = Name::of(decision);
        if self.current.is_none_or(|current| current.name != name) {
            self.leave(now);
            self.current = Some(self.begin(now, name, odometry));
        }
        let Some(mut current) = self.current else { return (Twist::STOP, self.leave(now)) };
        current.advance(odometry);
        let twist = if current.state == MotionState::Running {
            self.run(now, &mut current, odometry, (target, cap), period)
        } else {
            Twist::STOP
        };
        self.current = Some(current);
        (twist, MotionReport::new(now, name.id, current.state, current.final_progress))
    }

    fn begin(&self, now: Time, name: Name, odometry: &Odometry) -> Move {
        let known = self.past.iter().find(|past| past.0 == name && past.1 != MotionState::Idle);
        let (state, progress) = known.map_or((MotionState::Running, 0.0), |past| (past.1, past.2));
        Move {
            name,
            state,
            driven: 0.0,
            turned_before: odometry.turned,
            last: *odometry,
            mark: (0.0, now),
            final_progress: progress,
        }
    }

    fn run(&self, now: Time, current: &mut Move, odometry: &Odometry, (target, cap): (f64, f64), period: f64) -> Twist {
        let turned = odometry.turned - current.turned_before;
        let axis = self.axis(current.name.turns, target, cap, if current.name.turns { turned } else { current.driven });
        current.final_progress = axis.progress;
        if self.must_give_up(now, current, odometry, &axis) {
            current.state = MotionState::Blocked;
            return Twist::STOP;
        }
        let command = axis.command(period, &self.config);
        if command == 0.0 && axis.is_done(period) {
            current.state = MotionState::Done;
            current.final_progress = target;
            return Twist::STOP;
        }
        if current.name.turns {
            return Twist::new(0.0, command);
        }
        let steer = (-self.config.heading_gain * turned).clamp(-0.5, 0.5);
        let sharpest = if self.platform.turning_radius > 0.0 { command.abs() / self.platform.turning_radius } else { f64::MAX };
        Twist::new(command, steer.clamp(-sharpest, sharpest))
    }

    fn axis(&self, turns: bool, target: f64, cap: f64, progress: f64) -> Axis {
        let limits = self.platform.limits;
        let (speed, top, acceleration, tolerance) = if turns {
            let tolerance = self.config.angle_tolerance_deg.to_radians();
            (self.expected.angular, limits.angular, self.platform.angular_acceleration, tolerance)
        } else {
            (self.expected.linear, limits.linear, self.platform.acceleration, self.config.distance_tolerance)
        };
        Axis { target, progress, speed, cap: cap.min(top), acceleration, tolerance }
    }

    fn must_give_up(&self, now: Time, current: &mut Move, odometry: &Odometry, axis: &Axis) -> bool {
        if current.name.turns && self.platform.turning_radius > 0.0 {
            return true;
        }
        if odometry.flags & (flags::EMERGENCY_STOP | flags::STALLED) != 0 {
            return true;
        }
        if (axis.progress - current.mark.0).abs() > axis.tolerance {
            current.mark = (axis.progress, now);
        }
        let in_contact = odometry.flags & flags::CONTACT != 0;
        let patience = if in_contact { self.config.contact_patience } else { self.config.patience };
        now.secs_since(current.mark.1) > patience
    }
}

impl Name {
    fn of(decision: &BaseDecision) -> Self {
        let motion: &Motion = &decision.motion;
        let turns = matches!(motion.kind(), MotionKind::Rotate { .. });
        Self { holder: decision.holder, transaction: decision.transaction, id: motion.id, turns }
    }
}

impl Move {
    /// Adds the newest odometry. [`Odometry::travelled`] sums magnitudes; the sign is that of the step ahead or back.
    fn advance(&mut self, odometry: &Odometry) {
        let way = odometry.travelled - self.last.travelled;
        let ahead = self.last.pose.between(odometry.pose).x;
        if way.is_finite() && ahead != 0.0 {
            self.driven += way.copysign(ahead);
        }
        self.last = *odometry;
    }
}

impl Axis {
    fn left(&self) -> f64 {
        self.target - self.progress
    }

    /// Commanded speed for the next period, signed.
    fn command(&self, period: f64, config: &ExecutorConfig) -> f64 {
        let left = self.left();
        if left.abs() <= 0.5 * self.tolerance {
            return 0.0;
        }
        let deceleration = config.braking_share * self.acceleration;
        let braking = Braking { acceleration: self.acceleration, deceleration, period, latency: config.latency };
        let speed = braking.speed(left.abs(), self.speed * left.signum(), self.cap);
        speed.copysign(left)
    }

    /// On the mark and as good as at rest: what is left of the speed goes within one period and a tenth of the tolerance.
    fn is_done(&self, period: f64) -> bool {
        let creep = self.speed.abs() * period.min(self.speed.abs() / self.acceleration);
        self.left().abs() <= self.tolerance && creep <= 0.1 * self.tolerance
    }
}

#[cfg(test)]
mod tests;
