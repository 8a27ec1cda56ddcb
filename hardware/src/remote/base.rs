//! Stands in for a base whose node lives in another process.

use std::time::Duration;

use orienteer_runtime::{
    agent::{Behaviour, Finish, Inputs, Level, Outputs, Phase, Wiring},
    arbitration::lease,
    link::{Bell, LinkError, Publisher, RobotBus, Subscriber},
    time::Time,
    topics::{BaseDecision, HardwareState, LineState, MissionPulse, MotionReport, Odometry, Truth},
};

use super::{
    RemoteHardware, Stamped,
    attachment::{Alive, Attachment, Ports},
};
use crate::{driver::DriverError, nodes::trouble::Trouble};

/// A base that says nothing for so long is not well.
const SILENT: Duration = Duration::from_millis(500);

/// Brings what the base says into the mission, and what is decided to the base.
pub struct RemoteBase {
    hardware: Attachment<BasePorts>,
    period: Duration,
    odometry: Option<Odometry>,
    motion: MotionReport,
    truth: Option<Truth>,
    /// The number of the last pulse to this hardware.
    pulse: u64,
    /// Time with a speed other than zero, s.
    driving: f64,
    failing: bool,
    /// The hardware is there, and its base says nothing.
    silence: Trouble,
}

struct BasePorts {
    odometry: Subscriber<Odometry>,
    motion: Subscriber<MotionReport>,
    truth: Subscriber<Truth>,
    line: Subscriber<LineState>,
    decisions: Publisher<BaseDecision>,
    pulses: Publisher<MissionPulse>,
    /// Wakes the hardware, which waits for the decision.
    bell: Bell,
}

impl Ports for BasePorts {
    fn open(bus: &RobotBus) -> Result<Self, LinkError> {
        Ok(Self {
            odometry: bus.subscriber()?,
            motion: bus.subscriber()?,
            truth: bus.subscriber()?,
            line: bus.subscriber()?,
            decisions: bus.publisher()?,
            pulses: bus.publisher()?,
            bell: bus.bell()?,
        })
    }
}

impl RemoteBase {
    /// Stands in for the base of this hardware, in a mission with this control period.
    #[must_use]
    pub fn new(hardware: RemoteHardware, period: Duration) -> Self {
        Self {
            hardware: Attachment::new(hardware, true),
            period,
            odometry: None,
            motion: MotionReport::default(),
            truth: None,
            pulse: 0,
            driving: 0.0,
            failing: false,
            silence: Trouble::new("base"),
        }
    }

    /// The topics that it reads and writes, if its driver has a line or has none.
    #[must_use]
    pub fn wiring(has_line: bool) -> Wiring {
        let mut wiring = Wiring::default();
        wiring.reads::<BaseDecision>();
        wiring.writes::<Odometry>().writes::<MotionReport>().writes::<Truth>().writes::<HardwareState>();
        if has_line {
            wiring.writes::<LineState>();
        }
        wiring
    }

    fn sense(&mut self, now: Time, out: &mut Outputs) {
        self.hardware.tend(now, out);
        let Some(alive) = self.hardware.alive() else { return };
        let shift = alive.shift;
        let (odometry, motion, truth) = (&mut self.odometry, &mut self.motion, &mut self.truth);
        alive.ports.odometry.drain(|sample| *odometry = Some(sample.shifted(shift)));
        alive.ports.motion.drain(|sample| *motion = sample.shifted(shift));
        alive.ports.truth.drain(|sample| *truth = Some(sample.shifted(shift)));
        out.publish(alive.state.shifted(shift));
        let mut line = None;
        alive.ports.line.drain(|sample| line = Some(sample.shifted(shift)));
        if let Some(line) = line {
            out.publish(line);
        }
        // The hardware may be there and its base gone: what is old is not told again and again.
        let odometry = self.odometry.filter(|odometry| now.since(odometry.stamp) <= lease(self.period));
        self.listen(now, self.odometry.is_some_and(|odometry| now.since(odometry.stamp) <= SILENT), out);
        if let Some(odometry) = odometry {
            out.publish(odometry);
            if !odometry.twist.is_stop() {
                self.driving += self.period.as_secs_f64();
            }
        }
        if let Some(truth) = self.truth {
            out.publish(truth);
        }
        out.publish(self.motion);
    }

    /// Tells when the base falls silent although the hardware is there, and when it is heard again.
    fn listen(&mut self, now: Time, heard: bool, out: &mut Outputs) {
        let device = "the base beside the hardware".to_owned();
        let why = "it says nothing; the hardware's own output tells why".to_owned();
        if heard {
            if self.silence.is_on() {
                self.silence.end(out);
            }
        } else if self.odometry.is_some() {
            self.silence.happen(now, &DriverError::LinkLost { device, why }, out);
        } else {
            self.silence.happen(now, &DriverError::Waiting { device, why }, out);
        }
    }

    fn act(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        let (Some(alive), Some(decision)) = (self.hardware.alive(), inputs.fresh::<BaseDecision>()) else {
            self.pulse = 0;
            return;
        };
        let theirs = alive.shift.wrapping_neg();
        self.pulse += 1;
        let pulse = MissionPulse { stamp: now, seq: self.pulse, echo: alive.state.seq };
        let Alive { ports, .. } = alive;
        let sent = ports.decisions.publish(decision.shifted(theirs)).and_then(|_| ports.pulses.publish(pulse.shifted(theirs)));
        ports.bell.ring();
        match sent {
            Ok(_) => self.failing = false,
            Err(error) if !self.failing => {
                self.failing = true;
                out.log(Level::ERROR, format!("the base can't be told what is decided: {error}"));
            }
            Err(_) => {}
        }
    }
}

impl Behaviour for RemoteBase {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        match inputs.phase {
            Phase::Sense => self.sense(now, out),
            _ => self.act(now, inputs, out),
        }
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        if self.hardware.alive().is_none() {
            last_words.failure(match (self.hardware.is_another(), &self.odometry) {
                (true, _) => "the hardware was started with another configuration",
                (false, Some(_)) => "the hardware was gone at the end",
                (false, None) => "the hardware never was there",
            });
        } else if let Some(failure) = self.silence.last_words() {
            last_words.failure(failure);
        }
        last_words.fact("driving_s", self.driving);
        if let Some(truth) = self.truth {
            last_words.fact("collisions", f64::from(truth.collisions));
            last_words.fact("bumped", f64::from(truth.bumped));
        }
    }
}
