//! The arbiters as a node.

use std::time::Duration;

use super::{Clients, base::BaseArbiter, explain, lease, sonar::SonarArbiter};
use crate::{
    agent::{Behaviour, Finish, Inputs, Level, Outputs, Wiring},
    time::Time,
    topics::{BaseClaim, BaseDecision, BaseNotice, ClientId, SonarClaim, SonarDecision},
};

/// The arbiters of a robot as a node: claims in, decisions and notices out, once a step.
#[derive(Debug)]
pub struct Arbitration {
    clients: Clients,
    base: BaseArbiter,
    sonar: SonarArbiter,
    lease: Duration,
    notices: Vec<BaseNotice>,
    holder: ClientId,
    decided: Time,
    /// Seconds for which each client has had the base.
    held: Vec<f64>,
}

impl Arbitration {
    /// Arbitration between these clients, once every control `period`; `sonar` must have been made for the same.
    #[must_use]
    pub fn new(clients: &Clients, sonar: SonarArbiter, period: Duration) -> Self {
        Self {
            clients: clients.clone(),
            base: BaseArbiter::new(clients),
            sonar,
            lease: lease(period),
            notices: Vec::with_capacity(16),
            holder: ClientId::NONE,
            decided: Time::START,
            held: vec![0.0; clients.iter().count()],
        }
    }

    /// The topics that it reads and writes.
    #[must_use]
    pub fn wiring() -> Wiring {
        let mut wiring = Wiring::default();
        wiring.reads::<BaseClaim>().reads::<SonarClaim>();
        wiring.writes::<BaseDecision>().writes::<BaseNotice>().writes::<SonarDecision>();
        wiring
    }

    fn account(&mut self, now: Time, decision: &BaseDecision, out: &mut Outputs) {
        if let Some(held) = self.held.get_mut(usize::from(self.holder.0)) {
            *held += now.secs_since(self.decided);
        }
        self.decided = now;
        if decision.holder != self.holder {
            self.holder = decision.holder;
            out.log(Level::DEBUG, explain::base(decision, &self.clients).to_string());
        }
    }
}

impl Behaviour for Arbitration {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        // A claim from the future would silence its client until then, and one without an end would outlive it.
        let latest = now + self.lease;
        for claim in inputs.each::<BaseClaim>() {
            let (stamp, valid_until) = (claim.stamp.min(now), claim.valid_until.min(latest));
            self.base.claim(&BaseClaim { stamp, valid_until, ..*claim });
        }
        for claim in inputs.each::<SonarClaim>() {
            let (stamp, valid_until) = (claim.stamp.min(now), claim.valid_until.min(latest));
            self.sonar.claim(&SonarClaim { stamp, valid_until, ..*claim });
        }
        self.notices.clear();
        let decision = self.base.decide(now, &mut self.notices);
        self.account(now, &decision, out);
        out.publish(decision);
        for notice in &self.notices {
            out.publish(*notice);
        }
        out.publish(self.sonar.decide(now));
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        for ((_, client), held) in self.clients.iter().zip(&self.held) {
            if *held > 0.0 {
                last_words.fact(format!("held_s.{}", client.name), *held);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use proptest::prelude::*;

    use super::*;
    use crate::{
        arbitration::sonar::SafetyFloor,
        geometry::Twist,
        robot_model::{Ring, Transducer},
        topics::{FiringProgram, Motion},
    };

    const PERIOD: Duration = Duration::from_millis(50);
    const LIAR: ClientId = ClientId(0);
    const HONEST: ClientId = ClientId(1);

    struct Bench {
        node: Arbitration,
        inputs: Inputs,
        out: Outputs,
        now: Time,
    }

    impl Bench {
        fn new() -> Self {
            let clients: Clients = [("liar", 9), ("honest", 5)].into_iter().collect();
            let mut program = FiringProgram::default();
            program.slots.push(1);
            let transducers = vec![Transducer { mount: Default::default(), half_beam: 0.2 }];
            let ring = Ring { name: "one".into(), transducers, min_range: 0.1, max_range: 5.0, slot_time: 0.05, program };
            let wiring = Arbitration::wiring();
            Self {
                node: Arbitration::new(&clients, SonarArbiter::new(&clients, &ring, SafetyFloor::none()), PERIOD),
                inputs: Inputs::offline(&wiring),
                out: Outputs::offline(&wiring),
                now: Time::from_secs_f64(1.0),
            }
        }

        fn claim(&mut self, client: ClientId, transaction: u32, stamp: Time, valid_until: Time) {
            let motion = Motion::velocity(Twist::new(0.1 * f64::from(transaction), 0.0));
            let claim =
                BaseClaim { client, transaction, stamp, valid_until, wait_until: Time::FAR, motion, ..BaseClaim::default() };
            self.inputs.put(claim);
            let mut program = FiringProgram::default();
            program.slots.push(1);
            self.inputs.put(SonarClaim { client, stamp, valid_until, program });
        }

        /// Who has base and sonar.
        fn step(&mut self) -> (BaseDecision, ClientId) {
            self.now = self.now + PERIOD;
            self.node.step(self.now, &self.inputs, &mut self.out);
            let decided = (
                *self.out.published::<BaseDecision>().last().unwrap(),
                self.out.published::<SonarDecision>().last().unwrap().holder,
            );
            self.inputs.settle();
            self.out.settle();
            decided
        }
    }

    /// Any time, the absurd ones often.
    fn time() -> impl Strategy<Value = Time> {
        prop_oneof![
            Just(Time::START),
            Just(Time::FAR),
            (0u64..4_000_000_000).prop_map(Time::from_nanos),
            any::<u64>().prop_map(Time::from_nanos)
        ]
    }

    proptest! {
        #[test]
        fn nobody_holds_on_from_the_grave(claims in prop::collection::vec((time(), time()), 1..20)) {
            let mut bench = Bench::new();
            for (stamp, valid_until) in claims {
                bench.claim(LIAR, 1, stamp, valid_until);
                let (decision, _) = bench.step();
                prop_assert!(decision.valid_until <= bench.now + lease(PERIOD));
            }
            // It has died. Two steps may still be its own.
            bench.step();
            bench.step();
            let (now, until) = (bench.now + PERIOD, bench.now + 3 * PERIOD);
            bench.claim(HONEST, 1, now, until);
            let (decision, sonar) = bench.step();
            prop_assert_eq!((decision.holder, sonar), (HONEST, HONEST));
        }

        #[test]
        fn nobody_is_locked_out_by_what_it_said_of_the_future(stamp in time(), valid_until in time()) {
            let mut bench = Bench::new();
            bench.claim(LIAR, 1, stamp, valid_until);
            bench.step();
            let (now, until) = (bench.now + PERIOD, bench.now + 3 * PERIOD);
            bench.claim(LIAR, 2, now, until);
            let (decision, sonar) = bench.step();
            prop_assert_eq!((decision.holder, decision.transaction, sonar), (LIAR, 2, LIAR));
        }
    }

    #[test]
    fn an_honest_claim_is_taken_as_it_is() {
        let mut bench = Bench::new();
        let (now, until) = (bench.now + PERIOD, bench.now + PERIOD + lease(PERIOD));
        bench.claim(HONEST, 1, now, until);
        let (decision, sonar) = bench.step();
        assert_eq!((decision.holder, decision.valid_until, sonar), (HONEST, until, HONEST));
    }
}
