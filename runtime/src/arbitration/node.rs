use super::{Clients, base::BaseArbiter, explain, sonar::SonarArbiter};
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
    notices: Vec<BaseNotice>,
    holder: ClientId,
    decided: Time,
    /// Seconds for which each client has had the base.
    held: Vec<f64>,
}

impl Arbitration {
    /// Arbitration between these clients; `sonar` must have been made for the same.
    #[must_use]
    pub fn new(clients: &Clients, sonar: SonarArbiter) -> Self {
        Self {
            clients: clients.clone(),
            base: BaseArbiter::new(clients),
            sonar,
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
        for claim in inputs.each::<BaseClaim>() {
            self.base.claim(claim);
        }
        for claim in inputs.each::<SonarClaim>() {
            self.sonar.claim(claim);
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
