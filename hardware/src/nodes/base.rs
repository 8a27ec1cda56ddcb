use std::time::Duration;

use orienteer_runtime::{
    agent::{Behaviour, Finish, Inputs, Level, Outputs, Phase, Wiring},
    robot_model::Ring,
    time::Time,
    topics::{BaseDecision, MotionReport, Odometry, SonarScan, Truth, flags},
};

use crate::{
    base::{
        executor::{Executor, ExecutorConfig},
        protection::{Demand, LinkState, Protection, ProtectionConfig, Reason},
    },
    driver::{BaseDriver, DriverError},
    nodes::Guard,
};

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
    link: LinkState,
    reason: Option<Reason>,
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
            link: LinkState::Lost,
            reason: None,
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

    /// The topics that it reads and writes.
    #[must_use]
    pub fn wiring() -> Wiring {
        let mut wiring = Wiring::default();
        wiring.reads::<BaseDecision>().reads::<SonarScan>();
        wiring.writes::<Odometry>().writes::<MotionReport>().writes::<Truth>();
        wiring
    }

    fn sense(&mut self, now: Time, out: &mut Outputs) {
        match self.driver.poll(now) {
            Ok(mut odometry) => {
                if self.link == LinkState::Lost && self.odometry.is_some() {
                    out.log(Level::WARN, "the base is back");
                }
                self.link = LinkState::Up;
                if self.reason.is_some_and(Reason::is_protective) {
                    odometry.flags |= flags::PROTECTED;
                }
                self.odometry = Some(odometry);
                out.publish(odometry);
            }
            Err(DriverError::EndOfLog { .. }) => out.end_mission(),
            Err(error) => self.fail(&error, out),
        }
        if let Some(truth) = self.driver.truth() {
            out.publish(truth);
        }
        out.publish(self.report);
    }

    fn act(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        let (Some(decision), Some(odometry)) = (inputs.latest::<BaseDecision>(), self.odometry) else { return };
        let period = self.period.as_secs_f64();
        let (twist, report) = self.executor.step(now, decision, &odometry, period);
        self.report = report;
        let demand = Demand { twist, valid_until: decision.valid_until, limits: decision.limits };
        let scans = inputs.each::<SonarScan>();
        // Every scan counts: a pass may renew only some transducers. The last one goes with the demand.
        if let Some((_, earlier)) = scans.split_last() {
            for scan in earlier {
                self.protection.take(scan);
            }
        }
        let permitted = self.protection.filter(now, &demand, &odometry, scans.last(), self.link);
        self.executor.permitted(permitted.twist);
        self.remark(permitted.reason, out);
        if !permitted.twist.is_stop() {
            self.driving += period;
        }
        if let Some(guard) = &self.guard {
            guard.hold_until(demand.valid_until);
        }
        if let Err(error) = self.driver.command(now, permitted.twist) {
            self.fail(&error, out);
        }
    }

    /// Tells when protection begins to hold the base for a reason that a person should know.
    fn remark(&mut self, reason: Option<Reason>, out: &mut Outputs) {
        if reason.is_some_and(Reason::is_protective) {
            self.protected_steps += 1;
        }
        if reason != self.reason {
            if let Some(reason) = reason.filter(|reason| reason.is_protective()) {
                let usual = matches!(reason, Reason::FreeDistance | Reason::Blind) || !self.has_sonar;
                out.log(if usual { Level::DEBUG } else { Level::WARN }, format!("the base protects itself: {}", reason.text()));
            }
            self.reason = reason;
        }
    }

    /// Tells of a failure once; the base is lost until it is heard again.
    fn fail(&mut self, error: &DriverError, out: &mut Outputs) {
        if self.link == LinkState::Up || self.odometry.is_none() {
            out.log(Level::ERROR, format!("the base fails: {error}"));
        }
        self.link = LinkState::Lost;
    }
}

impl Behaviour for BaseNode {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        match inputs.phase {
            Phase::Sense => self.sense(now, out),
            _ => self.act(now, inputs, out),
        }
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        self.driver.stop();
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
