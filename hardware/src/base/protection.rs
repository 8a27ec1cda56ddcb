//! The base protects itself.
//!
//! This is the last stage before the driver. Behaviours and arbitration can't switch it off; it can only slow down or stop what they
//! demand. Its rules are applied in this order, and the first that forbids gives the [`Reason`]:
//!
//! 1. a demand that is not finite: stop;
//! 2. the link to the base is lost: stop;
//! 3. odometry that is not finite or too old: stop, because nothing is known of the own motion;
//! 4. an emergency stop is pressed, or the motors are off: stop;
//! 5. the demand has outlived its time: stop;
//! 6. contact: see below;
//! 7. the limits of the platform and of the clients: the same curve, slower;
//! 8. no transducer looks where the base is going: creep, or stop if there is none at all. One that should look is silent: stop,
//!    or creep;
//! 9. **free distance**: never faster than the base can stop in the free distance that it sees.
//!
//! # Free distance
//!
//! Let `f` be the length of path that the body can go on an arc before it touches something (see [`swept_path`]). A
//! command is permitted if the base can still brake after it has been held for one period:
//!
//! ```text
//! v·latency + v² / 2b  ≤  f − margin,    v and f as they will be then, b a share of the deceleration
//! ```
//!
//! [`safe_stop`] says this exactly, curves included. What the base has driven since a reading was taken is no reaction time to
//! be guessed: readings are fixed in the odometry frame (see [`sight`]), so it is taken off exactly. What it has driven since it
//! last said where it is, is taken at the most that its commands allow.
//!
//! An echo says how far, but not where within the beam. Two readings of it are both taken at their worst:
//!
//! * *something small*: it may be anywhere on the arc of the echo's range across the beam, so all of the arc blocks. For an obstacle
//!   that the beam saw this is always on the safe side.
//! * *a wall*: the beam may look straight at a wall, with any direction within the beam as its normal unless the neighbouring
//!   beams contradict (they would have to meet the wall too, at a range that follows from it). The wall goes on unseen to where the
//!   body will meet it. A weakly braking base that drifts towards a wall beside it would otherwise first see it ahead when it is
//!   too late.
//!
//! What has slipped into a gap between two beams is remembered for a while (see `memory`).
//!
//! Side walls seen obliquely by the front-diagonal beams are therefore met *farther in* than they are, by up to the half beam. That
//! costs speed only where a wall is a hand's breadth from the body; the tests measure how much.
//!
//! # Contact
//!
//! Odometry says that something is touched, and with bumpers whether that is ahead or behind. Where it does not: if the base was driving
//! when it began, the contact is taken to be on the side it drove towards; if it stood, at the nearest thing that the sonars see within a
//! hand's breadth of the body. Away from there
//! (120° or more off) it may back off, straight and slowly, as far as rule 9 lets it. In any other direction, when nothing
//! tells where the contact is, and for turns, it stands still until the contact ends.

mod config;
mod memory;
pub mod safe_stop;
pub mod sight;
pub mod swept_path;
mod told;
pub mod watchdog;

use std::time::Duration;

use orienteer_runtime::{
    geometry::{Limits, Twist, angle},
    robot_model::{Platform, Ring},
    time::Time,
    topics::{Odometry, SonarScan, flags},
};

pub use self::config::ProtectionConfig;
use self::{
    safe_stop::{Motion, SafeStop},
    sight::{Obstacle, Sight},
    told::Told,
};
use crate::base::profile::ramp;

/// What is asked of the base for the next control period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand {
    /// The velocity.
    pub twist: Twist,
    /// After this time the demand is worth nothing.
    pub valid_until: Time,
    /// The caps of all clients together.
    pub limits: Limits,
}

/// Whether the driver reaches its base.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinkState {
    /// Commands and readings get through.
    Up,
    /// They do not.
    Lost,
}

/// Why less was permitted than demanded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Reason {
    /// The demand held NaN or an infinity.
    BadDemand,
    /// The link to the base is lost.
    LinkLost,
    /// Odometry held NaN or an infinity, or was too old.
    BadOdometry,
    /// An emergency stop is pressed, or what counts as one.
    EmergencyStop,
    /// Its motors are off, and not for a program to switch on.
    MotorsOff,
    /// The demand had outlived its time.
    StaleCommand,
    /// The body touches something, or its wheels are blocked.
    Contact,
    /// More was demanded than the platform can do.
    Platform,
    /// No transducer looks in the direction of travel.
    Blind,
    /// A transducer that looks in the direction of travel has been silent for too long.
    StaleSonar,
    /// The base could not stop in the free distance that it sees.
    FreeDistance,
}

impl Reason {
    /// One line for a person.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Reason::BadDemand => "the demand is not a number",
            Reason::LinkLost => "the link to the base is lost",
            Reason::BadOdometry => "odometry is missing or not a number",
            Reason::EmergencyStop => "an emergency stop is pressed, or a wheel hangs in the air",
            Reason::MotorsOff => "its motors are off",
            Reason::StaleCommand => "the command is too old",
            Reason::Contact => "the body touches something",
            Reason::Platform => "the platform can't do more",
            Reason::Blind => "no sonar looks that way",
            Reason::StaleSonar => "the sonar is silent",
            Reason::FreeDistance => "too little free distance ahead",
        }
    }

    /// True if [`flags::PROTECTED`] is to be set: everything but being cut to the platform's limits.
    #[must_use]
    pub fn is_protective(self) -> bool {
        self != Reason::Platform
    }
}

/// What the base may do in the next control period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Permitted {
    /// The velocity.
    pub twist: Twist,
    /// Why it is less than demanded, if it is.
    pub reason: Option<Reason>,
}

/// Where the body touches something.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Contact {
    None,
    /// In this direction of the robot frame, rad.
    At(f64),
    Somewhere,
}

/// The protection of one base.
#[derive(Debug, Clone)]
pub struct Protection {
    platform: Platform,
    config: ProtectionConfig,
    sight: Sight,
    max_age: f64,
    obstacles: Vec<Obstacle>,
    contact: Contact,
    told: Told,
    /// The speed that its commands have given the base, whatever is measured, m/s.
    pace: f64,
}

impl Protection {
    /// Protects a base that can do what `platform` says and carries `ring`.
    #[must_use]
    pub fn new(platform: Platform, ring: &Ring, config: ProtectionConfig) -> Self {
        let max_age = config.max_sonar_age + 2.0 * ring.pass_time();
        Self {
            sight: Sight::new(ring, max_age, config.period),
            obstacles: Vec::with_capacity(64),
            told: Told::nothing(config.max_odometry_age + config.latency, config.period),
            platform,
            config,
            max_age,
            contact: Contact::None,
            pace: 0.0,
        }
    }

    /// Takes in a scan ahead of the next [`filter`](Self::filter): when several have come in a period, each may have renewed other
    /// transducers.
    pub fn take(&mut self, scan: &SonarScan) {
        self.sight.take(scan);
    }

    /// Says what may be done of `demand` in the next control period. Call it once a period, with the newest odometry and the newest
    /// scan if there is one; scans that were seen before do no harm.
    pub fn filter(
        &mut self,
        now: Time,
        demand: &Demand,
        odometry: &Odometry,
        scan: Option<&SonarScan>,
        link: LinkState,
    ) -> Permitted {
        let sound = odometry.pose.is_sound() && odometry.twist.is_finite();
        if sound {
            self.sight.pass(odometry);
        }
        if let Some(scan) = scan {
            self.sight.take(scan);
        }
        self.feel(now, odometry);
        let fresh = sound && now.secs_since(odometry.stamp) <= self.config.max_odometry_age;
        let permitted = match self.must_stop(now, demand, odometry, fresh, link) {
            Some(reason) => Permitted { twist: Twist::STOP, reason: Some(reason) },
            None => self.slow_down(now, demand, odometry),
        };
        self.told.tell(now, permitted.twist);
        self.pace = self.pace_after(permitted.twist.linear);
        permitted
    }

    /// What a command makes of the pace; a base may brake as weakly as stops are planned with.
    fn pace_after(&self, commanded: f64) -> f64 {
        let slows = commanded.abs() < self.pace.abs() || commanded * self.pace < 0.0;
        let rate = self.platform.acceleration * if slows { self.config.braking_share } else { 1.0 };
        ramp(self.pace, commanded, rate, self.config.period).0
    }

    /// Rules 1 to 5.
    fn must_stop(&self, now: Time, demand: &Demand, odometry: &Odometry, fresh: bool, link: LinkState) -> Option<Reason> {
        if !demand.twist.is_finite() {
            Some(Reason::BadDemand)
        } else if link == LinkState::Lost {
            Some(Reason::LinkLost)
        } else if !fresh {
            Some(Reason::BadOdometry)
        } else if odometry.flags & flags::EMERGENCY_STOP != 0 {
            Some(if odometry.flags & flags::ENABLED != 0 { Reason::EmergencyStop } else { Reason::MotorsOff })
        } else if now > demand.valid_until && !demand.twist.is_stop() {
            Some(Reason::StaleCommand)
        } else {
            None
        }
    }

    /// Rules 6 to 9.
    fn slow_down(&mut self, now: Time, demand: &Demand, odometry: &Odometry) -> Permitted {
        let wanted = demand.twist;
        let Some(mut twist) = self.back_off(wanted) else {
            return Permitted { twist: Twist::STOP, reason: (!wanted.is_stop()).then_some(Reason::Contact) };
        };
        let mut reason = (twist != wanted).then_some(Reason::Contact);
        let capped = self.within_platform(twist);
        if capped != twist {
            reason = reason.or(Some(Reason::Platform));
        }
        // and() turns a limit that is no number into zero
        let limits = demand.limits.and(Limits::NONE);
        twist = capped.within(limits);
        if self.config.sonar_required {
            let (cap, why) = self.look(now, twist);
            let mut safe = twist.within(Limits { linear: cap, angular: f64::MAX });
            if cap == 0.0 && twist.linear != 0.0 {
                safe = Twist::new(0.0, self.turn_alone(twist));
            }
            reason = if safe == twist { reason } else { reason.filter(|known| *known != Reason::Platform).or(Some(why)) };
            twist = self.stoppable(now, safe, odometry);
            reason = if safe == twist {
                reason
            } else {
                reason.filter(|known| *known != Reason::Platform).or(Some(Reason::FreeDistance))
            };
        }
        Permitted { twist, reason }
    }

    fn within_platform(&self, twist: Twist) -> Twist {
        let mut twist = twist;
        if self.platform.turning_radius > 0.0 {
            let sharpest = twist.linear.abs() / self.platform.turning_radius;
            twist.angular = twist.angular.clamp(-sharpest, sharpest);
        }
        twist.within(self.platform.limits)
    }

    /// The turn rate that is left to a base that must not translate.
    fn turn_alone(&self, twist: Twist) -> f64 {
        if self.platform.turning_radius > 0.0 || self.contact != Contact::None { 0.0 } else { twist.angular }
    }

    /// Finds out where the body touches something: from its bumpers, or else when that begins.
    fn feel(&mut self, now: Time, odometry: &Odometry) {
        let bumpers = (odometry.flags & flags::CONTACT_AHEAD != 0, odometry.flags & flags::CONTACT_BEHIND != 0);
        if odometry.flags & (flags::CONTACT | flags::STALLED) == 0 {
            self.contact = Contact::None;
        } else if bumpers.0 || bumpers.1 {
            self.contact = match bumpers {
                (true, true) => Contact::Somewhere,
                (ahead, _) => Contact::At(if ahead { 0.0 } else { std::f64::consts::PI }),
            };
        } else if self.contact == Contact::None {
            let drove = if self.told.last().linear != 0.0 { self.told.last().linear } else { odometry.twist.linear };
            self.contact = if drove.abs() > 1e-3 {
                Contact::At(if drove > 0.0 { 0.0 } else { std::f64::consts::PI })
            } else {
                self.nearest(now, odometry).map_or(Contact::Somewhere, Contact::At)
            };
        }
    }

    /// Bearing of the nearest thing within a hand's breadth of the body.
    fn nearest(&mut self, now: Time, odometry: &Odometry) -> Option<f64> {
        let reach = self.platform.radius + 0.15;
        let points = self.sight.points(now, odometry.pose, self.max_age);
        let near = points.filter(|point| point.coords.norm() <= reach);
        near.min_by(|a, b| a.coords.norm().total_cmp(&b.coords.norm())).map(|point| point.y.atan2(point.x))
    }

    /// What rule 6 leaves of a demand; `None` for nothing.
    fn back_off(&self, wanted: Twist) -> Option<Twist> {
        let bearing = match self.contact {
            Contact::None => return Some(wanted),
            Contact::Somewhere => return None,
            Contact::At(bearing) => bearing,
        };
        let direction = if wanted.linear < 0.0 { std::f64::consts::PI } else { 0.0 };
        let leads_away = wanted.linear != 0.0 && angle::turn(bearing, direction).cos() <= -0.5;
        let speed = wanted.linear.abs().min(self.config.back_off_speed);
        leads_away.then(|| Twist::new(speed.copysign(wanted.linear), 0.0))
    }

    /// Rule 8: the cap on speed, and why.
    fn look(&self, now: Time, twist: Twist) -> (f64, Reason) {
        let bearing = if twist.linear < 0.0 { std::f64::consts::PI } else { 0.0 };
        match self.sight.age_towards(now, bearing, self.config.look_half_angle_deg.to_radians()) {
            // Who sees nothing at all has nothing to creep by.
            None if self.sight.is_empty() => (0.0, Reason::Blind),
            None => (self.config.blind_speed, Reason::Blind),
            Some(age) if age > self.max_age => (self.config.stale_speed, Reason::StaleSonar),
            Some(_) => (f64::MAX, Reason::FreeDistance),
        }
    }

    /// Rule 9.
    fn stoppable(&mut self, now: Time, twist: Twist, odometry: &Odometry) -> Twist {
        let untold = now.secs_since(odometry.stamp).max(0.0);
        let ProtectionConfig { period, latency, .. } = self.config;
        let since = odometry.stamp - Duration::from_secs_f64(latency);
        let motion = Motion::estimate(odometry.twist, &self.told, since, &self.platform, (period, untold + latency));
        // Where it has come to since the base said where it is.
        let pose = odometry.pose.along_arc(motion.twist.linear * untold, motion.twist.angular * untold);
        if twist.linear == 0.0 && motion.twist.linear == 0.0 {
            return twist;
        }
        let mut judge = SafeStop { platform: &self.platform, config: &self.config, motion, pace: self.pace, obstacles: &[] };
        let body = self.platform.radius + self.config.clearance;
        self.sight.look(now, pose, self.max_age, body, judge.reach(twist), &mut self.obstacles);
        judge.obstacles = &self.obstacles;
        let allowed = judge.fastest(twist);
        // Turning on the spot sweeps nothing, once it is on the spot.
        if allowed.is_stop() && odometry.twist.linear.abs() < 0.01 { Twist::new(0.0, self.turn_alone(twist)) } else { allowed }
    }
}

#[cfg(test)]
mod scene;
#[cfg(test)]
mod tests;
