//! The base as a node: driver, executor and protection in one control period.

use std::time::Duration;

use orienteer_runtime::{
    agent::{Behaviour, Finish, Inputs, Level, Outputs, Phase, Wiring},
    arbitration::lease,
    robot_model::Ring,
    time::Time,
    topics::{BaseDecision, LineState, MotionReport, Odometry, SonarScan, Truth, flags},
};

use crate::{
    base::{
        executor::{Executor, ExecutorConfig},
        protection::{Demand, LinkState, Protection, ProtectionConfig, Reason},
    },
    driver::{BaseDriver, DriverError},
    nodes::{
        Guard, IN_THE_FUTURE,
        trouble::{Ended, Trouble},
    },
};

/// A ring that has said nothing for so long after the start is silent.
const FIRST_PASS: Duration = Duration::from_secs(2);
/// The motors of a base that was just found may be off for so long.
const GREETING: Duration = Duration::from_secs(2);
/// A base that has not taken a command is told nothing but to stop for this long, s.
const FORGIVEN: f64 = 1.0;

/// The base: publishes odometry, carries out what arbitration has decided, and protects itself.
///
/// In the sense phase it reads the driver; in the act phase the executor turns the decision into a twist, protection cuts it
/// down to what is safe, and the driver gets it.
pub struct BaseNode {
    driver: Box<dyn BaseDriver>,
    executor: Executor,
    protection: Protection,
    guard: Option<Guard>,
    period: Duration,
    odometry: Option<Odometry>,
    report: MotionReport,
    /// When the newest decision came.
    decided: Time,
    /// The newest reading made sense.
    heard: bool,
    /// A scan has come.
    sees: bool,
    /// When the base last failed to take a command.
    disobeyed: Option<Time>,
    trouble: Trouble,
    /// When it came, or came back.
    back: Time,
    reason: Option<Reason>,
    /// A person knows of it.
    warned: bool,
    protected_steps: u64,
    /// Time with a speed other than zero, s.
    driving: f64,
    has_sonar: bool,
}

impl BaseNode {
    /// A node over this driver, on a robot with this ring, stepped once a `period`.
    #[must_use]
    pub fn new(
        driver: Box<dyn BaseDriver>,
        ring: &Ring,
        executor: ExecutorConfig,
        protection: ProtectionConfig,
        period: Duration,
    ) -> Self {
        let platform = driver.platform().clone();
        let protection = ProtectionConfig { period: period.as_secs_f64(), ..protection };
        Self {
            executor: Executor::new(platform.clone(), executor),
            has_sonar: protection.sonar_required,
            protection: Protection::new(platform, ring, protection),
            driver,
            guard: None,
            period,
            odometry: None,
            report: MotionReport::default(),
            decided: Time::START,
            heard: false,
            sees: false,
            disobeyed: None,
            trouble: Trouble::new("base"),
            back: Time::START,
            reason: None,
            warned: false,
            protected_steps: 0,
            driving: 0.0,
        }
    }

    /// Tells the guard of the driver's thread how long each command holds.
    #[must_use]
    pub fn guarded_by(mut self, guard: Guard) -> Self {
        self.guard = Some(guard);
        self
    }

    /// The topics that it reads and writes, if its driver has a line or has none.
    #[must_use]
    pub fn wiring(has_line: bool) -> Wiring {
        let mut wiring = Wiring::default();
        wiring.reads::<BaseDecision>().reads::<SonarScan>();
        wiring.writes::<Odometry>().writes::<MotionReport>().writes::<Truth>();
        if has_line {
            wiring.writes::<LineState>();
        }
        wiring
    }

    fn sense(&mut self, now: Time, out: &mut Outputs) {
        match self.driver.poll(now).and_then(|odometry| self.plausible(now, odometry)) {
            Ok(mut odometry) => {
                self.heard = true;
                if self.reason.is_some_and(Reason::is_protective) {
                    odometry.flags |= flags::PROTECTED;
                }
                self.odometry = Some(odometry);
                out.publish(odometry);
            }
            Err(DriverError::EndOfLog { .. }) => out.end_mission(),
            Err(error) => {
                self.heard = false;
                self.trouble.happen(now, &error, out);
            }
        }
        if self.trouble.is_on() && self.link(now) == LinkState::Up {
            self.back = now;
            if self.trouble.end(out) == Ended::Back && self.driver.line().is_some() {
                out.log(Level::WARN, "what the base did meanwhile may be missing from its pose");
            }
        }
        if let Some(truth) = self.driver.truth() {
            out.publish(truth);
        }
        if let Some(line) = self.driver.line() {
            out.publish(line);
        }
        out.publish(self.report);
    }

    /// What makes no sense goes to nobody: one NaN would stay in every sum that it enters, one stamp from the future would make
    /// everything after it look old.
    fn plausible(&self, now: Time, odometry: Odometry) -> Result<Odometry, DriverError> {
        let garbled = |what: &str| DriverError::Garbled { device: self.driver.platform().name.clone(), what: what.into() };
        let numbers = [odometry.twist.linear, odometry.twist.angular, odometry.travelled, odometry.turned];
        if !odometry.pose.is_sound() || !numbers.iter().all(|number| number.is_finite()) {
            return Err(garbled("odometry is not a number"));
        }
        if odometry.stamp.secs_since(now) > IN_THE_FUTURE {
            return Err(garbled("odometry is from the future"));
        }
        Ok(odometry)
    }

    /// The link is as good as the worse of its directions. Who has not taken a command gets none but stops for a while.
    fn link(&self, now: Time) -> LinkState {
        let obeys = self.disobeyed.is_none_or(|when| now.secs_since(when) > FORGIVEN);
        if self.heard && obeys { LinkState::Up } else { LinkState::Lost }
    }

    fn act(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        let (Some(decision), Some(odometry)) = (inputs.latest::<BaseDecision>(), self.odometry) else { return };
        let period = self.period.as_secs_f64();
        let (twist, report) = self.executor.step(now, decision, &odometry, period);
        self.report = report;
        // It may have come from another process, which is taken at less than its word, and may have died since.
        let valid_until = decision.valid_until.min(self.decided + lease(self.period));
        let demand = Demand { twist, valid_until, limits: decision.limits };
        let scans = inputs.each::<SonarScan>();
        self.sees |= !scans.is_empty();
        // Every scan counts: a pass may renew only some transducers. The last one goes with the demand.
        if let Some((_, earlier)) = scans.split_last() {
            for scan in earlier {
                self.protection.take(scan);
            }
        }
        let link = self.link(now);
        let permitted = self.protection.filter(now, &demand, &odometry, scans.last(), link);
        self.executor.permitted(permitted.twist);
        self.remark(now, permitted.reason, out);
        if !permitted.twist.is_stop() {
            self.driving += period;
        }
        if let Some(guard) = &self.guard {
            // Where nobody wants to move, what is left is protection's own braking on a curve, good for this period.
            guard.hold_until(if demand.twist.is_stop() { now + self.period } else { demand.valid_until });
        }
        if let Err(error) = self.driver.command(now, permitted.twist) {
            // It may still carry out the command before.
            self.driver.stop();
            self.disobeyed = Some(now);
            self.trouble.happen(now, &error, out);
        }
    }

    /// Tells when protection begins to hold the base for a reason that a person should know.
    fn remark(&mut self, now: Time, reason: Option<Reason>, out: &mut Outputs) {
        if reason.is_some_and(Reason::is_protective) {
            self.protected_steps += 1;
        }
        if reason != self.reason {
            self.reason = reason;
            self.warned = false;
            if let Some(reason) = reason.filter(|reason| reason.is_protective() && self.is_usual(now, *reason)) {
                out.log(Level::DEBUG, format!("the base protects itself: {}", reason.text()));
            }
        }
        if let Some(reason) = reason.filter(|reason| !self.warned && reason.is_protective() && !self.is_usual(now, *reason)) {
            self.warned = true;
            out.log(Level::WARN, format!("the base protects itself: {}", reason.text()));
        }
    }

    /// True if a person need not know.
    fn is_usual(&self, now: Time, reason: Reason) -> bool {
        match reason {
            Reason::FreeDistance | Reason::Blind => true,
            // Nobody hears anything before the first pass of the ring is over.
            Reason::StaleSonar if !self.sees && now < Time::START + FIRST_PASS => true,
            // Real ones switch their motors on when they have been greeted.
            Reason::MotorsOff if now < self.back + GREETING => true,
            // Without sonar it is a log that is played, or a base on blocks.
            Reason::StaleCommand | Reason::StaleSonar => !self.has_sonar,
            _ => false,
        }
    }
}

impl Behaviour for BaseNode {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        // From another process it may come in either phase.
        if inputs.fresh::<BaseDecision>().is_some() {
            self.decided = now;
        }
        match inputs.phase {
            Phase::Sense => self.sense(now, out),
            _ => self.act(now, inputs, out),
        }
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        self.driver.stop();
        if let Some(failure) = self.trouble.last_words() {
            last_words.failure(failure);
        }
        last_words.fact("driving_s", self.driving);
        last_words.fact("protected_s", self.protected_steps as f64 * self.period.as_secs_f64());
        if let Some(truth) = self.driver.truth() {
            last_words.fact("collisions", f64::from(truth.collisions));
            last_words.fact("bumped", f64::from(truth.bumped));
        }
    }
}

impl Drop for BaseNode {
    /// A node that goes, for whatever reason, leaves a base that stands.
    fn drop(&mut self) {
        self.driver.stop();
    }
}

#[cfg(test)]
mod tests;
