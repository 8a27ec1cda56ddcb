//! The body of one simulated robot.

use std::{
    collections::VecDeque,
    sync::{Arc, Weak},
    time::Duration,
};

use nalgebra::Point2;
use orienteer_runtime::{
    geometry::{Pose, Twist, angle::wrap},
    time::Time,
    topics::{Odometry, Truth, flags},
};
use rand_pcg::Pcg64;

use super::{Arena, bodies::Others};
use crate::{
    base::{
        kinematics::{BaseConfig, Kinematics},
        odometry::{Odometer, OdometryConfig},
    },
    world::{geometry::Disc, obstacles::sweep_disc},
};

/// What a simulated robot is made of.
#[derive(Debug, Clone)]
pub struct SimBodyConfig {
    /// Its drive and body.
    pub base: BaseConfig,
    /// How its odometry errs.
    pub odometry: OdometryConfig,
}

/// Length of one step of the physics.
const SUBSTEP: Duration = Duration::from_millis(10);
/// How far back [`SimBody::pose_at`] reaches. At wall time the base is read more often than the sonar.
const REMEMBERED: Duration = Duration::from_secs(1);
/// What was touched stays touched until it is farther away than this, m: as far as a bumper springs back.
const BUMPER: f64 = 5e-3;
/// A robot that moves toward what it touches faster than this has driven into it, m/s.
const PUSHING: f64 = 0.01;

/// Bodies nearer than this may touch, m.
const TOUCH: f64 = 1e-6;
/// How far a body may go between two looks at who stands near; 50 ms at 3 m/s are 15 cm.
const ROAMING: f64 = 0.5;

/// The body of a simulated robot: where it truly is, how it moves, and what it runs into.
#[derive(Debug)]
pub struct SimBody {
    arena: Weak<Arena>,
    /// Its place among the arena's bodies.
    number: usize,
    radius: f64,
    kinematics: Kinematics,
    odometer: Odometer,
    random: Pcg64,
    pose: Pose,
    now: Time,
    demand: Twist,
    /// Poses at the ends of the last substeps, for whoever wants to know where it was in between.
    trail: VecDeque<(Time, Pose)>,
    odometry: Odometry,
    touching: Touching,
    collisions: u32,
    bumped: u32,
    /// Whoever the body can touch as long as it stays near `looked_from`.
    others: Others<Disc>,
    looked_from: Point2<f64>,
}

/// What the body touches, and who is to blame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Touching {
    Nothing,
    /// The robot drove into it.
    Hit,
    /// It came to the robot.
    Bumped,
}

impl SimBody {
    pub(super) fn new(arena: &Arc<Arena>, number: usize, name: &str, start: Pose, config: SimBodyConfig) -> Self {
        let odometer = Odometer::new(config.odometry);
        Self {
            arena: Arc::downgrade(arena),
            number,
            radius: config.base.radius,
            kinematics: Kinematics::new(config.base),
            odometry: *odometer.state(),
            odometer,
            random: arena.streams().stream(name, "odometry"),
            pose: start,
            now: Time::START,
            demand: Twist::STOP,
            trail: VecDeque::from([(Time::START, start)]),
            touching: Touching::Nothing,
            collisions: 0,
            bumped: 0,
            others: Others::default(),
            looked_from: start.point(),
        }
    }

    /// True pose, world frame.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// Radius of the body, m.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Its place among the arena's bodies.
    #[must_use]
    pub fn number(&self) -> usize {
        self.number
    }

    /// Everything about it that only a simulation can know.
    #[must_use]
    pub fn truth(&self) -> Truth {
        Truth {
            stamp: self.now,
            pose: self.pose,
            twist: self.kinematics.twist(),
            collisions: self.collisions,
            bumped: self.bumped,
        }
    }

    /// What its encoders say.
    #[must_use]
    pub fn odometry(&self) -> Odometry {
        let contact = if self.touching == Touching::Nothing { 0 } else { flags::CONTACT };
        Odometry { stamp: self.now, flags: self.odometry.flags | contact, ..self.odometry }
    }

    /// Where it touches something, robot frame, rad: the direction of the nearest surface. `None` while it touches nothing.
    #[must_use]
    pub fn touched_at(&self) -> Option<f64> {
        if self.touching == Touching::Nothing {
            return None;
        }
        let (here, reach) = (self.pose.point(), self.radius + BUMPER);
        let wall = self.arena.upgrade()?.world().obstacles.nearest(here, reach).map(|wall| (wall.distance, wall.at));
        let others = self.others.found().iter().map(|other| ((other.center - here).norm() - other.radius, other.center));
        let (_, at) = others.filter(|(gap, _)| *gap <= reach).chain(wall).min_by(|a, b| a.0.total_cmp(&b.0))?;
        let towards = at - here;
        Some(wrap(towards.y.atan2(towards.x) - self.pose.heading))
    }

    /// What it shall do from now on.
    pub fn set_demand(&mut self, demand: Twist) {
        self.demand = demand;
    }

    /// Where it was at a time within the last `REMEMBERED`.
    #[must_use]
    pub fn pose_at(&self, time: Time) -> Pose {
        let after = self.trail.partition_point(|(stamp, _)| *stamp < time);
        match (after.checked_sub(1).and_then(|i| self.trail.get(i)), self.trail.get(after)) {
            (Some((from, start)), Some((to, end))) => {
                let share = time.secs_since(*from) / to.secs_since(*from).max(1e-9);
                start.interpolate(*end, share)
            }
            (None, Some((_, pose))) | (Some((_, pose)), None) => *pose,
            (None, None) => self.pose,
        }
    }

    /// The time up to which it has moved.
    #[must_use]
    pub fn now(&self) -> Time {
        self.now
    }

    /// Moves on to `now`; does nothing if it is there already.
    pub fn advance(&mut self, now: Time) {
        if now <= self.now {
            return;
        }
        let Some(arena) = self.arena.upgrade() else { return };
        self.look(&arena, ROAMING);
        while self.now < now {
            let next = now.min(self.now + SUBSTEP);
            let seconds = next.secs_since(self.now);
            self.now = next;
            self.substep(&arena, seconds);
            while self.trail.get(1).is_some_and(|(stamp, _)| self.now.since(*stamp) >= REMEMBERED) {
                self.trail.pop_front();
            }
            self.trail.push_back((self.now, self.pose));
        }
    }

    /// Looks up whom the body can touch before it is farther than `roaming` from where it stands now.
    fn look(&mut self, arena: &Arena, roaming: f64) {
        self.looked_from = self.pose.point();
        let reach = self.radius + roaming;
        arena.with_bodies(|bodies| self.others.look(bodies, self.number, self.looked_from, reach));
    }

    fn substep(&mut self, arena: &Arena, seconds: f64) {
        let travel = self.kinematics.step(self.pose, self.demand, seconds);
        let by = travel.pose.point() - self.pose.point();
        let own = Disc::new(self.pose.point(), self.radius);
        let farthest = by.norm().max(travel.distance.abs()) + 2.0 * TOUCH;
        if (own.center - self.looked_from).norm() + farthest > ROAMING {
            self.look(arena, farthest.max(ROAMING));
        }
        let others = || self.others.found().iter();
        let wall = arena.world().obstacles.sweep(own, by);
        let body = others().filter(|other| near(own, **other, by.norm())).filter_map(|other| sweep_disc(own, by, *other));
        let impact = wall.into_iter().chain(body).min_by(|a, b| a.share.total_cmp(&b.share));
        let (distance, turn) = match impact {
            None => {
                self.pose = travel.pose;
                (travel.distance, travel.turn)
            }
            Some(impact) => {
                // What was driven up to the touch counts; the body goes no farther.
                let share = impact.share.clamp(0.0, 1.0);
                self.pose = self.pose.along_arc(travel.distance * share, travel.turn * share);
                (travel.distance * share, travel.turn * share)
            }
        };
        let speed = self.kinematics.twist().linear.abs();
        self.odometry = self.odometer.measure(self.now, distance, turn, seconds, &mut self.random);
        let hit = impact.is_some() && speed > PUSHING;
        self.touch(arena, hit);
        if impact.is_some() {
            self.kinematics.halt();
        }
    }

    /// Counts each touch once, until the body is free again.
    fn touch(&mut self, arena: &Arena, hit: bool) {
        let (here, radius) = (self.pose.point(), self.radius);
        let within =
            |gap: f64| self.others.found().iter().any(|other| (other.center - here).norm() < other.radius + radius + gap);
        let overlapped = within(-TOUCH);
        let pressed = || within(BUMPER) || arena.world().obstacles.nearest(here, radius + BUMPER).is_some();
        match self.touching {
            Touching::Nothing | Touching::Bumped if hit => {
                // Pushing on against somebody who came to the robot is the robot's fault after all.
                self.collisions += 1;
                self.touching = Touching::Hit;
            }
            Touching::Nothing if overlapped => {
                self.bumped += 1;
                self.touching = Touching::Bumped;
            }
            Touching::Hit | Touching::Bumped if !hit && !overlapped && !pressed() => self.touching = Touching::Nothing,
            _ => {}
        }
    }
}

/// True if two discs are so close that a move of this length could join them.
fn near(own: Disc, other: Disc, length: f64) -> bool {
    (own.center - other.center).norm() <= own.radius + other.radius + length + TOUCH
}
