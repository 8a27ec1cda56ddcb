//! The motors of an ARCOS base: what they were told, and how they get there.

use std::f64::consts::PI;

use orienteer_runtime::{
    geometry::{Pose, Twist, angle::wrap},
    time::Time,
};

use crate::{
    base::profile::{Braking, ramp},
    wire::arcos::{
        command::{Code, Command},
        settings::Settings,
        units::Units,
    },
};

/// A unit of the wheels' own command, m/s.
const WHEEL_UNIT: f64 = 0.02;
/// A way or a turn is done within this, m or rad.
const DONE: f64 = 2e-3;

/// How the base was told to move along.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Along {
    Speed(f64),
    /// So far to go, m, backward if negative.
    Distance(f64),
}

/// How it was told to turn.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Turn {
    Rate(f64),
    /// To this heading, in the session's frame.
    Heading(f64),
}

/// Speed and its changes along or about one axis, m or rad.
#[derive(Debug, Clone, Copy)]
struct Axis {
    speed: f64,
    /// For ways and turns.
    top: f64,
    /// For everything.
    greatest: f64,
    acceleration: f64,
    deceleration: f64,
}

impl Axis {
    fn approach(&mut self, wanted: f64, seconds: f64) {
        let wanted = wanted.clamp(-self.greatest, self.greatest);
        let faster = wanted.abs() > self.speed.abs() && wanted * self.speed >= 0.0;
        let rate = if faster { self.acceleration } else { self.deceleration };
        self.speed = ramp(self.speed, wanted, rate, seconds).0;
    }

    /// The speed at which to go what is left.
    fn towards(&self, left: f64, seconds: f64) -> f64 {
        if left.abs() < DONE {
            return 0.0;
        }
        let Self { acceleration, deceleration, .. } = *self;
        let braking = Braking { acceleration, deceleration, period: seconds, latency: seconds };
        braking.speed(left.abs(), self.speed * left.signum(), self.top).copysign(left)
    }

    /// Sets acceleration or deceleration, as the sign says.
    fn set_change(&mut self, change: f64) {
        if change > 0.0 {
            self.acceleration = change;
        } else if change < 0.0 {
            self.deceleration = -change;
        }
    }

    fn set_top(&mut self, top: f64) {
        self.top = top.abs().min(self.greatest);
    }
}

/// Two motors and what they were told.
#[derive(Debug, Clone)]
pub(super) struct Motors {
    units: Units,
    on: bool,
    along: Along,
    turn: Turn,
    linear: Axis,
    angular: Axis,
    /// Where the base is, in the session's frame.
    here: Pose,
    since: Option<Time>,
}

impl Motors {
    /// Motors that are off.
    pub fn new(settings: &Settings, units: Units) -> Self {
        let metres = |number: u16| f64::from(number) / 1000.0;
        let radians = |number: u16| f64::from(number).to_radians();
        Self {
            units,
            on: false,
            along: Along::Speed(0.0),
            turn: Turn::Rate(0.0),
            linear: Axis {
                speed: 0.0,
                top: metres(settings.top_speed),
                greatest: metres(settings.greatest_speed),
                acceleration: metres(settings.acceleration),
                deceleration: metres(settings.deceleration),
            },
            angular: Axis {
                speed: 0.0,
                top: radians(settings.top_turn_rate),
                greatest: radians(settings.greatest_turn_rate),
                acceleration: radians(settings.angular_acceleration),
                deceleration: radians(settings.angular_deceleration),
            },
            here: Pose::default(),
            since: None,
        }
    }

    pub fn are_on(&self) -> bool {
        self.on
    }

    /// True if they drive the base along.
    pub fn are_driven(&self) -> bool {
        self.linear.speed != 0.0
    }

    /// Nobody is in charge any more.
    pub fn switch_off(&mut self) {
        self.on = false;
        self.stand();
    }

    fn stand(&mut self) {
        (self.along, self.turn) = (Along::Speed(0.0), Turn::Rate(0.0));
    }

    /// The session's frame begins here.
    pub fn begin_here(&mut self) {
        self.here = Pose::default();
    }

    /// The heading that the base tries to keep, rad.
    pub fn control(&self) -> f64 {
        match self.turn {
            Turn::Heading(heading) => heading,
            Turn::Rate(_) => self.here.heading,
        }
    }

    /// Does what a command says, if it is one for motors.
    pub fn obey(&mut self, command: &Command<'_>, number: i32) {
        let number = f64::from(number);
        let (metres, radians) = (number / 1000.0, number.to_radians());
        match command.code {
            Code::Enable if number == 0.0 => self.switch_off(),
            Code::Enable => self.on = true,
            Code::Velocity => self.along = Along::Speed(metres),
            Code::Move => self.along = Along::Distance(metres),
            Code::TurnRate => self.turn = Turn::Rate(radians),
            Code::Heading => self.turn = Turn::Heading(wrap(radians)),
            Code::HeadingChange => self.turn = Turn::Heading(wrap(self.here.heading + radians.clamp(-PI, PI))),
            Code::Stop => self.stand(),
            Code::EmergencyStop => {
                self.stand();
                (self.linear.speed, self.angular.speed) = (0.0, 0.0);
            }
            Code::Wheels => {
                let (left, right) = command.as_wheels().unwrap_or_default();
                let (left, right) = (f64::from(left) * WHEEL_UNIT, f64::from(right) * WHEEL_UNIT);
                self.along = Along::Speed((left + right) / 2.0);
                self.turn = Turn::Rate((right - left) / self.units.tread);
            }
            Code::Acceleration => self.linear.set_change(metres),
            Code::AngularAcceleration => self.angular.set_change(radians),
            Code::TopSpeed => self.linear.set_top(metres),
            Code::TopTurnRate => self.angular.set_top(radians),
            _ => {}
        }
    }

    /// The speeds from `now` on, of a base that is `here` in the session's frame; `alone` if its watchdog has run out.
    pub fn drive(&mut self, now: Time, here: Pose, alone: bool) -> Twist {
        let seconds = now.secs_since(self.since.replace(now).unwrap_or(now));
        let before = std::mem::replace(&mut self.here, here);
        if let Along::Distance(left) = &mut self.along {
            *left -= before.between(here).x;
        }
        let stands = alone || !self.on;
        let linear = match self.along {
            _ if stands => 0.0,
            Along::Speed(speed) => speed,
            Along::Distance(left) => self.linear.towards(left, seconds),
        };
        let angular = match self.turn {
            _ if stands => 0.0,
            Turn::Rate(rate) => rate,
            Turn::Heading(heading) => self.angular.towards(wrap(heading - here.heading), seconds),
        };
        self.linear.approach(linear, seconds);
        self.angular.approach(angular, seconds);
        Twist::new(self.linear.speed, self.angular.speed)
    }
}
