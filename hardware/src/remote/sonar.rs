//! Stands in for a sonar whose node lives in another process.

use orienteer_runtime::{
    agent::{Behaviour, Finish, Inputs, Outputs, Wiring},
    link::{LinkError, Publisher, RobotBus, Subscriber},
    time::Time,
    topics::{SonarDecision, SonarScan},
};

use super::{
    RemoteHardware, Stamped,
    attachment::{Attachment, Ports},
};

/// Brings scans into the mission, and what is decided of their firing to the sonar.
pub struct RemoteSonar {
    hardware: Attachment<SonarPorts>,
    scans: u64,
}

struct SonarPorts {
    scans: Subscriber<SonarScan>,
    decisions: Publisher<SonarDecision>,
}

impl Ports for SonarPorts {
    fn open(bus: &RobotBus) -> Result<Self, LinkError> {
        Ok(Self { scans: bus.subscriber()?, decisions: bus.publisher()? })
    }
}

impl RemoteSonar {
    /// Stands in for the sonar of this hardware.
    #[must_use]
    pub fn new(hardware: RemoteHardware) -> Self {
        // What there is to say, the base says.
        Self { hardware: Attachment::new(hardware, false), scans: 0 }
    }

    /// The topics that it reads and writes.
    #[must_use]
    pub fn wiring() -> Wiring {
        let mut wiring = Wiring::default();
        wiring.reads::<SonarDecision>().writes::<SonarScan>();
        wiring
    }
}

impl Behaviour for RemoteSonar {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        self.hardware.tend(now, out);
        let Some(alive) = self.hardware.alive() else { return };
        let (shift, count) = (alive.shift, &mut self.scans);
        alive.ports.scans.drain(|scan| {
            *count += 1;
            out.publish(scan.shifted(shift));
        });
        if let Some(decision) = inputs.fresh::<SonarDecision>() {
            // One that gets lost is followed by another in the next step.
            let _ = alive.ports.decisions.publish(decision.shifted(shift.wrapping_neg()));
        }
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        last_words.fact("scans", self.scans as f64);
    }
}
