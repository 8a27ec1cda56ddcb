use std::{f64::consts::FRAC_PI_2, sync::Arc};

use orienteer_runtime::{
    geometry::{Pose, Twist},
    robot_model::{Platform, Ring},
    time::Time,
    topics::{Echo, Odometry, Opening, SonarScan},
};

use super::{CorridorFilter, CorridorFollowerConfig, Side, SideWatch};

/// The manoeuvre of following one stretch of corridor.
#[derive(Debug)]
pub struct Follower {
    config: CorridorFollowerConfig,
    ring: Arc<Ring>,
    platform: Arc<Platform>,
    front: usize,
    flanks: [usize; 2],
    stage: Stage,
    filter: Option<CorridorFilter>,
    odometry: Option<Pose>,
    /// Path length along the corridor since the order, m.
    path: f64,
    /// Path length at which a wall was seen last.
    wall_seen: f64,
    sides: [SideWatch; 2],
    medians: [Median; 3],
    blocked_since: Option<Time>,
}

/// What the follower wants in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wish {
    /// It has no order, or waits for its first readings.
    Nothing,
    /// To drive.
    Drive(Twist),
    /// To report the end of the stretch; widths and distances in m, 0 if unknown.
    Report {
        /// How it ended.
        opening: Opening,
        /// Width of the corridor.
        width: f64,
        /// Clear distance ahead of the robot's centre.
        ahead: f64,
        /// Length of the stretch.
        length: f64,
    },
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Stage {
    Idle,
    /// Standing, until each flank has been heard often enough for a median.
    Settle,
    Follow,
    /// Past the first corner, to see whether the other side opens too.
    Probe { corner: f64, until: f64 },
    /// To the start pose.
    Place { at: f64, opening: Opening },
}

/// At the start pose within this distance, m.
const PLACED: f64 = 0.01;
/// Facing along the corridor within this angle, rad.
const ALIGNED: f64 = 0.03;

impl Follower {
    /// A follower for a robot with this ring and body; `None` if no transducer looks ahead, to the left or to the right.
    #[must_use]
    pub fn new(config: CorridorFollowerConfig, ring: Arc<Ring>, platform: Arc<Platform>) -> Option<Self> {
        let facing = |bearing| ring.nearest_to(bearing).filter(|i| ring.within(bearing, 0.2).any(|j| j == *i));
        let (front, left, right) = (facing(0.0)?, facing(FRAC_PI_2)?, facing(-FRAC_PI_2)?);
        Some(Self {
            config,
            ring,
            platform,
            front,
            flanks: [left, right],
            stage: Stage::Idle,
            filter: None,
            odometry: None,
            path: 0.0,
            wall_seen: 0.0,
            sides: [SideWatch::default(); 2],
            medians: Default::default(),
            blocked_since: None,
        })
    }

    /// Starts a stretch here.
    pub fn begin(&mut self) {
        self.stage = Stage::Settle;
        self.filter = None;
        (self.path, self.wall_seen) = (0.0, 0.0);
        self.sides = Default::default();
        self.medians = Default::default();
        self.blocked_since = None;
    }

    /// Gives the stretch up.
    pub fn call_off(&mut self) {
        self.stage = Stage::Idle;
    }

    /// The filter's estimate, once there is one.
    #[must_use]
    pub fn estimate(&self) -> Option<&CorridorFilter> {
        self.filter.as_ref()
    }

    /// Takes a reading of the odometry, whoever moves the robot.
    pub fn moved(&mut self, odometry: &Odometry) {
        if !odometry.pose.is_sound() {
            return;
        }
        if let (Some(last), Some(filter)) = (self.odometry, &mut self.filter) {
            let moved = last.between(odometry.pose);
            let (sin, cos) = filter.heading().sin_cos();
            self.path += cos * moved.x - sin * moved.y;
            filter.predict(moved);
        }
        self.odometry = Some(odometry.pose);
    }

    /// Takes a scan.
    pub fn heard(&mut self, scan: &SonarScan) {
        for (median, transducer) in self.medians.iter_mut().zip([self.flanks[0], self.flanks[1], self.front]) {
            if scan.is_fresh(transducer) {
                median.push(scan.echo(transducer), self.ring.max_range);
            }
        }
        let (ring, path) = (self.ring.clone(), self.path);
        let Some(filter) = &mut self.filter else { return };
        let (sides, wall_seen) = (&mut self.sides, &mut self.wall_seen);
        filter.correct(&ring, scan, |i, comparison| {
            if comparison.perpendicular {
                let expected = match scan.echo(i) {
                    Echo::Range(range) => f64::from(range) - comparison.surplus,
                    _ => 0.0,
                };
                sides[comparison.side as usize].hear(path, comparison.surplus, expected);
            }
            if comparison.surplus.abs() < 0.2 {
                *wall_seen = path;
            }
        });
    }

    /// What to do now.
    pub fn wish(&mut self, now: Time) -> Wish {
        match self.stage {
            Stage::Idle => Wish::Nothing,
            Stage::Settle => self.settle(),
            Stage::Follow => self.follow(now),
            Stage::Probe { corner, until } => self.probe(corner, until),
            Stage::Place { at, opening } => self.place(at, opening),
        }
    }

    fn settle(&mut self) -> Wish {
        if !self.medians.iter().all(Median::is_full) {
            return Wish::Drive(Twist::STOP);
        }
        let beside = |side: usize| {
            let free = self.medians[side].value() + self.ring.transducers[self.flanks[side]].mount.y.abs();
            (free < self.config.blind.max(1.6)).then_some(free)
        };
        match CorridorFilter::new(beside(0), beside(1)) {
            Some(filter) => {
                self.filter = Some(filter);
                self.stage = Stage::Follow;
                Wish::Drive(Twist::STOP)
            }
            None => self.report(Opening::Lost),
        }
    }

    fn follow(&mut self, now: Time) -> Wish {
        let half_beam = self.ring.transducers[self.flanks[0]].half_beam;
        let ended = |side: Side| self.sides[side as usize].ended(self.config.wall_before_opening, half_beam);
        if let Some(corner) = [ended(Side::Left), ended(Side::Right)].into_iter().flatten().reduce(f64::min) {
            self.stage = Stage::Probe { corner, until: self.path + self.config.probe };
            return self.probe(corner, self.path + self.config.probe);
        }
        if self.path - self.wall_seen > self.config.blind {
            return self.report(Opening::Lost);
        }
        let room = self.medians[2].value() - self.config.front_stop;
        if room > 0.02 {
            self.blocked_since = None;
            // Half of what the base could do, so that protection has nothing to add.
            let gentle = (self.platform.acceleration * room).sqrt();
            return Wish::Drive(self.steer(self.config.cruise_speed.min(gentle)));
        }
        let since = *self.blocked_since.get_or_insert(now);
        if now.secs_since(since) >= self.config.patience {
            return self.report(Opening::DeadEnd);
        }
        Wish::Drive(Twist::STOP)
    }

    fn probe(&mut self, corner: f64, until: f64) -> Wish {
        let blocked = self.medians[2].value() < 0.5 * self.config.front_stop;
        if self.path < until && !blocked {
            return Wish::Drive(self.steer(self.config.creep_speed));
        }
        let opening = match (self.sides[0].is_open(), self.sides[1].is_open()) {
            (true, true) => Opening::Both,
            (true, false) => Opening::Left,
            _ => Opening::Right,
        };
        let at = corner - self.ring.transducers[self.front].mount.x;
        self.stage = Stage::Place { at, opening };
        self.place(at, opening)
    }

    fn place(&mut self, at: f64, opening: Opening) -> Wish {
        let remaining = at - self.path;
        if remaining.abs() > PLACED {
            let speed = (1.5 * remaining).clamp(-self.config.creep_speed, self.config.creep_speed);
            let heading = self.filter.as_ref().map_or(0.0, CorridorFilter::heading);
            // Only keep straight: the offset can't be mended on so short a way.
            return Wish::Drive(Twist::new(speed, (-1.5 * heading).clamp(-0.3, 0.3)));
        }
        let heading = self.filter.as_ref().map_or(0.0, CorridorFilter::heading);
        if heading.abs() > ALIGNED && self.platform.turning_radius == 0.0 {
            let rate = self.config.turn_rate.min(0.5);
            return Wish::Drive(Twist::new(0.0, (-2.0 * heading).clamp(-rate, rate)));
        }
        self.report(opening)
    }

    /// Towards the middle of the corridor and along it: the course aims at a point `look_ahead` ahead on the axis.
    fn steer(&self, speed: f64) -> Twist {
        let Some(filter) = &self.filter else { return Twist::STOP };
        let course = -(filter.offset() / self.config.look_ahead).atan().clamp(-0.5, 0.5);
        let off = course - filter.heading();
        let angular = (2.0 * off).clamp(-self.config.turn_rate, self.config.turn_rate);
        // After an evasion the robot may face anywhere: first turn, then go.
        let share = if off.abs() > 0.6 && self.platform.turning_radius == 0.0 { 0.0 } else { off.cos().max(0.3) };
        Twist::new(speed * share, angular)
    }

    fn report(&mut self, opening: Opening) -> Wish {
        self.stage = Stage::Idle;
        Wish::Report {
            opening,
            width: self.filter.as_ref().map_or(0.0, CorridorFilter::width),
            ahead: self.medians[2].value() + self.ring.transducers[self.front].mount.x,
            length: self.path,
        }
    }
}

/// Median of the last few readings of a transducer. A median rather than a mean: one spurious echo must not show.
#[derive(Debug, Default)]
struct Median {
    values: [f64; Median::SIZE],
    count: usize,
}

impl Median {
    const SIZE: usize = 5;

    fn push(&mut self, echo: Echo, max_range: f64) {
        if let Some(free) = echo.free_distance(max_range as f32) {
            self.values[self.count % Self::SIZE] = f64::from(free);
            self.count += 1;
        }
    }

    fn is_full(&self) -> bool {
        self.count >= Self::SIZE
    }

    fn value(&self) -> f64 {
        let mut sorted = self.values;
        sorted.sort_unstable_by(f64::total_cmp);
        sorted[Self::SIZE / 2]
    }
}
