//! The agents that take part in the experiments.

use orienteer_runtime::{
    agent::{Agent, Behaviour, BuildError, Finish, Inputs, Outputs, RobotContext, Wiring},
    agents::NoConfig,
    geometry::{Twist, angle},
    time::Time,
    topics::{BaseDecision, ClientId, CorridorReport, Odometry, Opening},
};
use rand::RngExt;
use rand_pcg::Pcg64;

/// Notes when avoidance has the base, and what the corridor follower reports.
///
/// Facts: `held_s`; `override_at` and `override_end` for each time that avoidance took the base and gave it
/// back; `report_at` for a place or a dead end that the follower reported.
pub(super) struct Witness {
    avoidance: Option<ClientId>,
    holding: bool,
    seen: Option<Time>,
    held: f64,
    overrides: Vec<f64>,
    ends: Vec<f64>,
    reported: Option<f64>,
}

impl Behaviour for Witness {
    fn step(&mut self, now: Time, inputs: &Inputs, _out: &mut Outputs) {
        if let Some(decision) = inputs.latest::<BaseDecision>() {
            let holding = self.avoidance.is_some() && decision.holder.known() == self.avoidance;
            if self.holding {
                self.held += self.seen.map_or(0.0, |seen| now.secs_since(seen));
            }
            match (self.holding, holding) {
                (false, true) => self.overrides.push(now.as_secs_f64()),
                (true, false) => self.ends.push(now.as_secs_f64()),
                _ => {}
            }
            (self.holding, self.seen) = (holding, Some(now));
        }
        if let Some(report) = inputs.fresh::<CorridorReport>().filter(|report| report.opening() != Opening::Lost) {
            self.reported.get_or_insert(report.stamp.as_secs_f64());
        }
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        last_words.fact("held_s", self.held);
        for at in &self.overrides {
            last_words.fact("override_at", *at);
        }
        for end in &self.ends {
            last_words.fact("override_end", *end);
        }
        if let Some(at) = self.reported {
            last_words.fact("report_at", at);
        }
    }
}

impl Agent for Witness {
    const KIND: &'static str = "witness";
    const HELP: &'static str = "notes when avoidance has the base";
    const CLAIMS: bool = false;
    type Config = NoConfig;

    fn topics(wiring: &mut Wiring) {
        wiring.reads::<BaseDecision>().reads_if_any::<CorridorReport>();
    }

    fn build(_config: NoConfig, robot: &RobotContext) -> Result<Self, BuildError> {
        let avoidance = robot.clients.find("avoidance");
        let (holding, seen, held) = (false, None, 0.0);
        Ok(Self { avoidance, holding, seen, held, overrides: Vec::new(), ends: Vec::new(), reported: None })
    }
}

/// Drives straight on at 0.3 m/s for as long as it may.
pub(super) struct StraightOn;

impl StraightOn {
    pub(super) const SPEED: f64 = 0.3;
}

impl Behaviour for StraightOn {
    fn step(&mut self, _now: Time, _inputs: &Inputs, out: &mut Outputs) {
        out.base.drive(Twist::new(Self::SPEED, 0.0));
    }
}

impl Agent for StraightOn {
    const KIND: &'static str = "straight-on";
    const HELP: &'static str = "drives straight on";
    const PRIORITY: u8 = 4;
    type Config = NoConfig;

    fn topics(wiring: &mut Wiring) {
        wiring.reads::<Odometry>();
    }

    fn build(_config: NoConfig, _robot: &RobotContext) -> Result<Self, BuildError> {
        Ok(Self)
    }
}

/// Roams about: drives to wherever chance points it, and elsewhere when it does not get on. Meets walls, door posts and
/// furniture at all angles, standing, driving and turning.
pub(super) struct Rover {
    random: Pcg64,
    heading: f64,
    until: Time,
    moved: Time,
    /// Distance driven when last asked, m.
    travelled: f64,
}

impl Behaviour for Rover {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        let Some(odometry) = inputs.latest::<Odometry>() else { return };
        let off = angle::turn(odometry.pose.heading, self.heading);
        if off.abs() > 0.1 || odometry.twist.linear.abs() > 0.02 {
            self.moved = now;
        }
        self.travelled = odometry.travelled;
        if now >= self.until || now.secs_since(self.moved) > 1.0 {
            self.heading = angle::wrap(odometry.pose.heading + self.random.random_range(-3.0..3.0));
            self.until = now + std::time::Duration::from_secs_f64(self.random.random_range(5.0..20.0));
            self.moved = now;
        }
        let speed = if off.abs() > 0.5 { 0.0 } else { 0.4 };
        out.base.drive(Twist::new(speed, (2.0 * off).clamp(-0.8, 0.8)));
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        last_words.fact("roamed_m", self.travelled);
    }
}

impl Agent for Rover {
    const KIND: &'static str = "rover";
    const HELP: &'static str = "roams about";
    const PRIORITY: u8 = 4;
    type Config = NoConfig;

    fn topics(wiring: &mut Wiring) {
        wiring.reads::<Odometry>();
    }

    fn build(_config: NoConfig, robot: &RobotContext) -> Result<Self, BuildError> {
        let random = robot.stream("ways");
        Ok(Self { random, heading: robot.start.heading, until: Time::START, moved: Time::START, travelled: 0.0 })
    }
}
