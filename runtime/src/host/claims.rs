//! The ports by which a node claims and hears what was decided.

use std::time::Duration;

use crate::{
    agent::{Level, Outputs, RobotContext},
    arbitration,
    link::{LinkError, Publisher, RobotBus, Subscriber},
    time::Time,
    topics::{BaseClaim, BaseDecision, BaseNotice, MotionReport, SonarClaim, SonarDecision},
};

/// A node's side of the arbitration: brings what was decided to its handles, and their claims to the arbiter.
pub(super) struct ClaimPorts {
    decisions: Subscriber<BaseDecision>,
    notices: Subscriber<BaseNotice>,
    reports: Subscriber<MotionReport>,
    claims: Publisher<BaseClaim>,
    sonar_decisions: Subscriber<SonarDecision>,
    sonar_claims: Publisher<SonarClaim>,
    lease: Duration,
    heard: Vec<BaseNotice>,
    /// True if the last claims said anything; silence need not be repeated.
    spoke: bool,
    spoke_of_sonar: bool,
    /// The last step asked for something that is no number.
    nonsense: bool,
}

impl ClaimPorts {
    pub(super) fn connect(bus: &RobotBus, context: &RobotContext) -> Result<Self, LinkError> {
        Ok(Self {
            decisions: bus.subscriber()?,
            notices: bus.subscriber()?,
            reports: bus.subscriber()?,
            claims: bus.publisher()?,
            sonar_decisions: bus.subscriber()?,
            sonar_claims: bus.publisher()?,
            lease: arbitration::lease(context.period),
            heard: Vec::with_capacity(16),
            spoke: false,
            spoke_of_sonar: false,
            nonsense: false,
        })
    }

    /// Tells the handles what has been decided since the last step.
    pub(super) fn hear(&mut self, outputs: &mut Outputs) {
        self.heard.clear();
        let heard = &mut self.heard;
        self.notices.collect(|notice| heard.push(*notice));
        let (mut decision, mut report, mut sonar) = (None, None, None);
        self.decisions.collect(|sample| decision = Some(*sample));
        self.reports.collect(|sample| report = Some(*sample));
        self.sonar_decisions.collect(|sample| sonar = Some(*sample));
        outputs.base.hear(heard, decision.as_ref(), report.as_ref());
        if let Some(decision) = &sonar {
            outputs.sonar.hear(decision);
        }
    }

    /// Publishes what the node claims now.
    pub(super) fn speak(&mut self, now: Time, outputs: &mut Outputs) -> Result<(), LinkError> {
        let nonsense = outputs.base.take_nonsense();
        if nonsense && !self.nonsense {
            outputs.log(Level::WARN, "asks for a motion or a limit that is no number (NaN or infinite): the base stands instead");
        }
        self.nonsense = nonsense;
        let claim = outputs.base.claim(now, self.lease);
        let wants = claim.transaction != 0 || claim.limits != crate::geometry::Limits::NONE;
        if wants || self.spoke {
            self.claims.publish(claim)?;
        }
        let sonar = outputs.sonar.claim(now, self.lease);
        let wants_sonar = !sonar.program.slots.is_empty();
        if wants_sonar || self.spoke_of_sonar {
            self.sonar_claims.publish(sonar)?;
        }
        (self.spoke, self.spoke_of_sonar) = (wants, wants_sonar);
        Ok(())
    }
}
