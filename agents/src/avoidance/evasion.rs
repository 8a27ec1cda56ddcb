//! Stepping aside: choosing a way out, driving it, waiting, and turning back.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_8, PI};

use orienteer_runtime::{
    geometry::{Pose, Twist, angle},
    time::Time,
    topics::Odometry,
};

use super::{AvoidanceConfig, Surroundings, Threat};

/// Steps aside for what keeps coming.
#[derive(Debug)]
pub struct Evasion {
    stage: Stage,
    /// True if the base turns on the spot; otherwise it can only go forward or back.
    turns: bool,
    steps: u32,
    count: u32,
    /// Heading to come back to, odometry frame.
    home: f64,
    calm_since: Option<Time>,
    /// What it stepped aside for last.
    threat: Option<Threat>,
    /// Since when the base has not moved although it was told to.
    stuck_since: Option<Time>,
}

/// What avoidance wants of the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Move {
    /// Nothing; the base may go to others.
    Nothing,
    /// The base, with this twist.
    Drive(Twist),
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Stage {
    Idle,
    /// Turning to a heading (odometry frame), then to drive with this sign.
    Turn {
        to: f64,
        sign: f64,
    },
    /// Driving straight from a pose.
    Drive {
        from: Pose,
        sign: f64,
    },
    /// Standing until nothing comes any more.
    Watch,
    /// Turning back to the heading that it had.
    Return,
}

/// A step shorter than this is not worth it, m.
const SHORTEST: f64 = 0.2;
/// Distance kept from everything while stepping aside, m.
const MARGIN: f64 = 0.06;
/// A threat this close ends a step that leads toward it, m ...
const TOUCHING: f64 = 0.1;
/// ... with what it covers until the robot has noticed it and stands, s.
const REACTION: f64 = 0.4;
/// Who is abreast of the robot by this much, rad, may be a little ahead of it or a little behind.
const ABREAST: f64 = 0.2;
/// Nobody else gets the base while something is this close, m (Randazza 1989: a reading of 30 cm), ...
const BESET: f64 = 0.08;
/// ... unless it stays for so long, s: then it is no person.
const RESIGNED: f64 = 8.0;
/// Good enough when turning, rad.
const TURNED: f64 = 0.05;
/// The base's protection may see an obstacle where avoidance sees none. A move that does not get on for so long is given up, s.
const STUCK: f64 = 0.5;

impl Evasion {
    /// At rest; `turns` if the base can turn on the spot.
    #[must_use]
    pub fn new(turns: bool) -> Self {
        Self { stage: Stage::Idle, turns, steps: 0, count: 0, home: 0.0, calm_since: None, threat: None, stuck_since: None }
    }

    /// True while it needs the base.
    #[must_use]
    pub fn is_active(&self) -> bool {
        self.stage != Stage::Idle
    }

    /// How often it has stepped aside.
    #[must_use]
    pub fn count(&self) -> u32 {
        self.count
    }

    /// What it stepped aside for last.
    #[must_use]
    pub fn threat(&self) -> Option<Threat> {
        self.threat
    }

    /// The direction of the step aside that it is about to take or takes, odometry frame, rad.
    #[must_use]
    pub fn way(&self) -> Option<f64> {
        match self.stage {
            Stage::Turn { to, sign } => Some(if sign > 0.0 { to } else { angle::wrap(to + PI) }),
            Stage::Drive { from, sign } => Some(if sign > 0.0 { from.heading } else { angle::wrap(from.heading + PI) }),
            Stage::Idle | Stage::Watch | Stage::Return => None,
        }
    }

    /// What to do now.
    pub fn step(&mut self, now: Time, config: &AvoidanceConfig, around: &Surroundings, odometry: &Odometry) -> Move {
        let threat = most_urgent(config, around);
        if self.is_stuck(now, odometry) {
            self.stuck_since = None;
            self.stage = if self.stage == Stage::Return { Stage::Idle } else { Stage::Watch };
        }
        match self.stage {
            Stage::Idle => match threat {
                Some(threat) if odometry.twist.linear.abs() < 0.1 => {
                    (self.steps, self.home, self.calm_since) = (0, odometry.pose.heading, None);
                    self.count += 1;
                    self.choose(config, around, odometry, &threat)
                }
                // Caution has stopped the robot by the time it matters.
                _ => Move::Nothing,
            },
            Stage::Turn { to, sign } => match turn_toward(to, odometry, config.turn_rate) {
                Some(twist) => Move::Drive(twist),
                None => {
                    self.stage = Stage::Drive { from: odometry.pose, sign };
                    self.drive(config, around, odometry)
                }
            },
            Stage::Drive { .. } => self.drive(config, around, odometry),
            Stage::Watch => self.watch(now, config, around, odometry, threat),
            Stage::Return => match turn_toward(self.home, odometry, 0.7 * config.turn_rate) {
                Some(twist) => Move::Drive(twist),
                None => {
                    self.stage = Stage::Idle;
                    Move::Nothing
                }
            },
        }
    }

    /// True if a move has not got on for a while.
    fn is_stuck(&mut self, now: Time, odometry: &Odometry) -> bool {
        let moves = matches!(self.stage, Stage::Turn { .. } | Stage::Drive { .. } | Stage::Return);
        if !moves || odometry.twist.linear.abs() > 0.02 || odometry.twist.angular.abs() > 0.05 {
            self.stuck_since = None;
            return false;
        }
        now.secs_since(*self.stuck_since.get_or_insert(now)) > STUCK
    }

    /// Chooses the way out: open, across the comer's path rather than along it, and without much turning.
    fn choose(&mut self, config: &AvoidanceConfig, around: &Surroundings, odometry: &Odometry, threat: &Threat) -> Move {
        self.steps += 1;
        self.threat = Some(*threat);
        let ways = (0..16).map(|k| f64::from(k) * FRAC_PI_8 - PI);
        let best = ways
            .filter(|way| self.turns || way.abs() < 0.01 || way.abs() > PI - 0.01)
            .filter_map(|way| {
                let free = around.free_toward(way, MARGIN, config.step + 0.4);
                let off = angle::turn(threat.bearing, way);
                // Never toward the comer.
                (free >= SHORTEST && off.cos() < 0.4).then(|| (way, score(free, off, way)))
            })
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((way, _)) = best.filter(|_| self.steps <= config.most_steps) else {
            self.stage = Stage::Watch;
            return Move::Drive(Twist::STOP);
        };
        // Either end may go first: never turn by more than a quarter.
        let (turn, sign) = if way.abs() <= FRAC_PI_2 { (way, 1.0) } else { (angle::wrap(way + PI), -1.0) };
        self.stage = Stage::Turn { to: angle::wrap(odometry.pose.heading + turn), sign };
        turn_toward(angle::wrap(odometry.pose.heading + turn), odometry, config.turn_rate)
            .map_or(Move::Drive(Twist::STOP), Move::Drive)
    }

    fn drive(&mut self, config: &AvoidanceConfig, around: &Surroundings, odometry: &Odometry) -> Move {
        let Stage::Drive { from, sign } = self.stage else { return Move::Nothing };
        let course = if sign > 0.0 { 0.0 } else { PI };
        let remaining = config.step - from.distance(&odometry.pose);
        let free = around.free_toward(course, MARGIN, 3.0);
        let closing_in = around.all().any(|thing| {
            let (off, speed) = (angle::turn(course, thing.bearing).abs(), odometry.twist.linear.abs());
            let soon = match off {
                off if off < FRAC_PI_2 - ABREAST => TOUCHING + REACTION * (thing.approach + speed),
                off if off < FRAC_PI_2 + ABREAST => 0.5 * TOUCHING + REACTION * thing.approach,
                _ => 0.0,
            };
            thing.approach > config.approach_speed && thing.clearance < soon
        });
        if remaining < 0.02 || free < 0.03 || closing_in {
            self.stage = Stage::Watch;
            return Move::Drive(Twist::STOP);
        }
        let speed = config.step_speed.min((2.0 * 0.5 * free.min(remaining)).sqrt());
        Move::Drive(Twist::new(sign * speed, 0.0))
    }

    fn watch(
        &mut self,
        now: Time,
        config: &AvoidanceConfig,
        around: &Surroundings,
        odometry: &Odometry,
        threat: Option<Threat>,
    ) -> Move {
        match threat {
            Some(threat) => {
                self.calm_since = None;
                if self.steps < config.most_steps {
                    return self.choose(config, around, odometry, &threat);
                }
            }
            None => {
                let calm = now.secs_since(*self.calm_since.get_or_insert(now));
                let beset = around.all().any(|thing| thing.clearance < BESET);
                if calm >= config.calm && (!beset || calm >= RESIGNED) {
                    self.stage = Stage::Return;
                }
            }
        }
        Move::Drive(Twist::STOP)
    }
}

fn score(free: f64, off_threat: f64, way: f64) -> f64 {
    let turning = way.abs().min(PI - way.abs()) / FRAC_PI_2;
    1.2 * free.min(0.8) + 0.8 * off_threat.sin().abs() - 0.3 * off_threat.cos() - 0.15 * turning
}

/// The threat that would reach the body first, if it is near enough to step aside for.
fn most_urgent(config: &AvoidanceConfig, around: &Surroundings) -> Option<Threat> {
    around
        .all()
        .filter(|thing| thing.steady && thing.approach > config.approach_speed && thing.came >= config.approach_distance)
        .filter(|thing| thing.clearance < config.evade_clearance && thing.clearance < config.evade_time * thing.closing)
        .min_by(|a, b| (a.clearance / a.closing).total_cmp(&(b.clearance / b.closing)))
}

/// A turn on the spot toward a heading; `None` once it faces there.
fn turn_toward(heading: f64, odometry: &Odometry, rate: f64) -> Option<Twist> {
    let remaining = angle::turn(odometry.pose.heading, heading);
    let still = odometry.twist.angular.abs() < 0.2;
    (remaining.abs() > TURNED || !still).then(|| Twist::new(0.0, (4.0 * remaining).clamp(-rate, rate)))
}
