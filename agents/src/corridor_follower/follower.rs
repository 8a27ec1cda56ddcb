//! The manoeuvre: settle, follow, look past the corner, come back to the start pose, report.

use std::sync::Arc;

use orienteer_runtime::{
    geometry::{Pose, Twist, angle},
    robot_model::{LookOut, Platform, Ring},
    time::Time,
    topics::{Odometry, Opening, SonarScan},
};

use super::{
    Comparison, CorridorFilter, CorridorFollowerConfig, Side, SideWatch, acquire::acquire, median::Median, wall_shift::WallShift,
};

/// The manoeuvre of following one stretch of corridor.
#[derive(Debug)]
pub struct Follower {
    config: CorridorFollowerConfig,
    ring: Arc<Ring>,
    platform: Arc<Platform>,
    look_out: LookOut,
    stage: Stage,
    filter: Option<CorridorFilter>,
    odometry: Option<Pose>,
    /// Speed, and the time up to which the path is known.
    speed: f64,
    moved_until: Time,
    /// Path length along the corridor since the order, m.
    path: f64,
    /// Path length at which a wall was seen last.
    wall_seen: f64,
    sides: [SideWatch; 2],
    shifts: [WallShift; 2],
    /// Share of late readings that fitted a wall, of those that should.
    fit: f64,
    /// The last readings of each transducer, and a buffer for their medians.
    medians: Vec<Median>,
    ranges: Vec<f64>,
    blocked_since: Option<Time>,
    /// Since when the robot is where it is, when it wants to move.
    stalled: Option<(Time, f64)>,
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
    Probe {
        until: f64,
    },
    /// To the start pose.
    Place {
        at: f64,
        opening: Opening,
    },
}

/// A corridor leaves so much to either side of a robot in its middle, m: Huey's radius and this make its corridor of 1.12 m.
const ROOM: f64 = 0.25;
/// Slower than this it stands, m/s and rad/s.
const STILL: f64 = 0.02;
/// Off the corridor's direction by no more than this, what a flank hears belongs to the path, rad.
const ALONG: f64 = 0.35;
/// A reading this near to what is expected fits, m.
const FITS: f64 = 0.2;
/// Weight of a new reading in the share of those that fit; its time constant is 2 s on Huey's ring.
const FORGETTING: f64 = 0.002;
/// If fewer fit than this share, the estimate is wrong.
const LOST_TRACK: f64 = 0.15;
/// Off its course by more than this, the robot turns before it goes, rad.
const FAR_OFF_COURSE: f64 = 0.6;
/// At the start pose within this distance, m.
const PLACED: f64 = 0.01;
/// Corners on both sides that are no farther apart along the corridor belong to one opening, m.
const OPPOSITE: f64 = 0.2;
/// How far the robot's centre may go past a corner for the sake of looking at the other side, m.
const FARTHEST_PROBE: f64 = 0.6;
/// Who is kept from going on though the way ahead looks free waits so many times as long: the base remembers for a while what
/// has gone.
const HINDERED: f64 = 3.0;
/// Facing along the corridor within this angle, rad.
const ALIGNED: f64 = 0.03;

impl Follower {
    /// A follower for a robot with this ring and body.
    ///
    /// # Errors
    /// If no transducer looks ahead, to the left or to the right.
    pub fn new(config: CorridorFollowerConfig, ring: Arc<Ring>, platform: Arc<Platform>) -> Result<Self, String> {
        Ok(Self {
            look_out: ring.look_out()?,
            stage: Stage::Idle,
            filter: None,
            odometry: None,
            speed: 0.0,
            moved_until: Time::START,
            path: 0.0,
            wall_seen: 0.0,
            sides: [SideWatch::new(config.wall_before_opening, config.opening_depth); 2],
            shifts: Default::default(),
            fit: 1.0,
            medians: vec![Median::default(); ring.transducers.len()],
            ranges: Vec::with_capacity(ring.transducers.len()),
            blocked_since: None,
            stalled: None,
            config,
            ring,
            platform,
        })
    }

    /// Starts a stretch here.
    pub fn begin(&mut self) {
        self.stage = Stage::Settle;
        self.filter = None;
        (self.path, self.wall_seen) = (0.0, 0.0);
        self.sides = [SideWatch::new(self.config.wall_before_opening, self.config.opening_depth); 2];
        self.shifts = Default::default();
        self.medians.fill(Median::default());
        (self.blocked_since, self.stalled) = (None, None);
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
        (self.speed, self.moved_until) = (odometry.twist.linear, odometry.stamp);
        if self.stage == Stage::Settle && (odometry.twist.linear.abs() > STILL || odometry.twist.angular.abs() > STILL) {
            // What was heard while it moved does not belong together.
            self.medians.fill(Median::default());
        }
    }

    /// Takes a scan.
    pub fn heard(&mut self, scan: &SonarScan) {
        for (i, median) in self.medians.iter_mut().enumerate().filter(|(i, _)| scan.is_fresh(*i)) {
            median.push(scan.echo(i), self.ring.max_range);
        }
        let Self { filter: Some(filter), ring, sides, shifts, wall_seen, fit, .. } = self else { return };
        // The robot has moved since the echo came.
        let (speed, late) = (self.speed * filter.heading().cos(), self.moved_until.secs_since(scan.stamp));
        let (path, depth, along) = (self.path, self.config.opening_depth, filter.heading().abs() < ALONG);
        let mut shifted = [None; 2];
        filter.correct(ring, scan, |i, compared| {
            let Comparison { side, surplus, perpendicular, .. } = compared;
            let fits = surplus.abs() < FITS;
            *fit += FORGETTING * (f64::from(u8::from(fits)) - *fit);
            if !perpendicular {
                return;
            }
            if fits {
                *wall_seen = path;
            }
            // While it turns or stands across, what passes before the beams does not follow the path.
            if along {
                let at = path - speed * (late + f64::from(scan.age(i)));
                sides[side as usize].hear(at, &compared);
                let step = if surplus < depth { surplus } else { f64::INFINITY };
                shifted[side as usize] = shifts[side as usize].hear(at, step).or(shifted[side as usize]);
            }
        });
        for (side, by) in [Side::Left, Side::Right].into_iter().zip(shifted) {
            if let Some(by) = by {
                filter.shift_wall(side, by);
            }
        }
    }

    /// Somebody else moves the robot: what its front sonar meets meanwhile says nothing of the way ahead.
    pub fn overridden(&mut self) {
        (self.blocked_since, self.stalled) = (None, None);
    }

    /// What to do now.
    pub fn wish(&mut self, now: Time) -> Wish {
        match self.stage {
            Stage::Idle => Wish::Nothing,
            Stage::Settle => self.settle(),
            Stage::Follow => self.follow(now),
            Stage::Probe { until } => self.probe(now, until),
            Stage::Place { at, opening } => self.place(now, at, opening),
        }
    }

    fn settle(&mut self) -> Wish {
        let mut needed = self.look_out.flanks.iter().chain(&self.look_out.ahead);
        if !needed.all(|i| self.medians[*i].is_full()) {
            return Wish::Drive(Twist::STOP);
        }
        let unheard = self.ring.max_range;
        self.ranges.clear();
        self.ranges.extend(self.medians.iter().map(|median| if median.is_full() { median.value() } else { unheard }));
        // Without a new one the old estimate, if there is one, is better than none.
        if let Some(filter) = acquire(&self.ring, &self.ranges, self.platform.radius + ROOM) {
            self.filter = Some(filter);
        }
        if self.filter.is_none() {
            return self.report(Opening::Lost);
        }
        (self.fit, self.wall_seen, self.stalled) = (1.0, self.path, None);
        self.stage = Stage::Follow;
        Wish::Drive(Twist::STOP)
    }

    /// Clear distance ahead of the front transducers.
    fn ahead(&self) -> f64 {
        self.look_out.ahead.iter().map(|i| self.medians[*i].value()).fold(f64::INFINITY, f64::min)
    }

    /// How far before the robot's centre they are, m.
    fn reach(&self) -> f64 {
        self.look_out.ahead.first().map_or(0.0, |i| self.ring.transducers[*i].mount.x)
    }

    /// The near corner of the opening that is being passed: the mean of two that lie opposite each other.
    fn corner(&self) -> Option<f64> {
        match self.sides.each_ref().map(SideWatch::corner) {
            [Some(a), Some(b)] if (a - b).abs() < OPPOSITE => Some(0.5 * (a + b)),
            [Some(a), Some(b)] => Some(a.min(b)),
            [a, b] => a.or(b),
        }
    }

    fn follow(&mut self, now: Time) -> Wish {
        if let Some(corner) = self.corner() {
            let until = corner + self.config.probe;
            self.stage = Stage::Probe { until };
            self.stalled = None;
            return self.probe(now, until);
        }
        if self.path - self.wall_seen > self.config.blind {
            return self.report(Opening::Lost);
        }
        if self.fit < LOST_TRACK {
            self.stage = Stage::Settle;
            self.medians.fill(Median::default());
            return Wish::Drive(Twist::STOP);
        }
        let room = self.ahead() - self.config.front_stop;
        if self.must_turn() {
            // What the front sonar hears now is not what lies ahead.
            (self.blocked_since, self.stalled) = (None, None);
            return Wish::Drive(self.steer(0.0));
        }
        if room > 0.02 {
            self.blocked_since = None;
            // Something beside the front sonar's beam may keep the base from going on, or what the base remembers of it.
            if self.is_stalled(now, HINDERED * self.config.patience) {
                return self.report(Opening::DeadEnd);
            }
            // Half of what the base could do, so that protection has nothing to add.
            let gentle = (self.platform.acceleration * room).sqrt();
            return Wish::Drive(self.steer(self.config.cruise_speed.min(gentle)));
        }
        self.stalled = None;
        let since = *self.blocked_since.get_or_insert(now);
        if now.secs_since(since) >= self.config.patience {
            return self.report(Opening::DeadEnd);
        }
        Wish::Drive(Twist::STOP)
    }

    /// On, slowly, until the beams of both sides are past the corner.
    fn probe(&mut self, now: Time, until: f64) -> Wish {
        let Some(corner) = self.corner() else {
            // The wall is back: it was only a gap.
            self.stage = Stage::Follow;
            return Wish::Drive(self.steer(self.config.creep_speed));
        };
        let blocked = self.ahead() < 0.5 * self.config.front_stop;
        let past = self.sides.iter().all(|side| side.edge() >= until);
        if !past && !blocked && self.path < until + FARTHEST_PROBE && !self.is_stalled(now, self.config.patience) {
            return Wish::Drive(self.steer(self.config.creep_speed));
        }
        let opening = match (self.sides[0].is_open(), self.sides[1].is_open()) {
            (true, true) => Opening::Both,
            (true, false) => Opening::Left,
            _ => Opening::Right,
        };
        let at = corner - self.reach();
        self.stage = Stage::Place { at, opening };
        self.stalled = None;
        self.place(now, at, opening)
    }

    /// True if the robot has not come on for so many seconds, although it wanted to.
    fn is_stalled(&mut self, now: Time, patience: f64) -> bool {
        let (since, path) = *self.stalled.get_or_insert((now, self.path));
        if (self.path - path).abs() > PLACED {
            self.stalled = Some((now, self.path));
            return false;
        }
        now.secs_since(since) > patience
    }

    fn place(&mut self, now: Time, at: f64, opening: Opening) -> Wish {
        let remaining = at - self.path;
        if self.must_turn() {
            return Wish::Drive(self.steer(0.0));
        }
        if remaining.abs() > PLACED && !self.is_stalled(now, self.config.patience) {
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

    /// Where to head, relative to the corridor: at the point `look_ahead` ahead on its axis.
    fn course(&self) -> f64 {
        self.filter.as_ref().map_or(0.0, |filter| -(filter.offset() / self.config.look_ahead).atan().clamp(-0.5, 0.5))
    }

    /// From the heading to the course.
    fn off_course(&self) -> f64 {
        self.filter.as_ref().map_or(0.0, |filter| angle::turn(filter.heading(), self.course()))
    }

    /// True if it faces so far off that it must turn before it goes: after an evasion it may face anywhere.
    fn must_turn(&self) -> bool {
        self.platform.turning_radius == 0.0 && self.off_course().abs() > FAR_OFF_COURSE
    }

    /// Towards the middle of the corridor and along it.
    fn steer(&self, speed: f64) -> Twist {
        let off = self.off_course();
        let angular = (2.0 * off).clamp(-self.config.turn_rate, self.config.turn_rate);
        let share = if self.must_turn() { 0.0 } else { off.cos().max(0.3) };
        Twist::new(speed * share, angular)
    }

    fn report(&mut self, opening: Opening) -> Wish {
        self.stage = Stage::Idle;
        Wish::Report {
            opening,
            width: self.filter.as_ref().map_or(0.0, CorridorFilter::width),
            ahead: self.ahead() + self.reach(),
            length: self.path,
        }
    }
}

#[cfg(test)]
mod tests;
