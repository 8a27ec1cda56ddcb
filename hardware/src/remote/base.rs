//! Stands in for a base whose node lives in another process.

use std::time::Duration;

use orienteer_runtime::{
    agent::{Behaviour, Finish, Inputs, Level, Outputs, Phase, Wiring},
    arbitration::lease,
    geometry::Pose,
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
    carried: Carried,
}

/// How far the robot had come when its hardware was started anew, and began to count anew: where it was then, for all anybody knows, it
/// goes on from.
#[derive(Debug, Clone, Copy, Default)]
struct Carried {
    /// When the hardware began to count.
    epoch: u64,
    /// The pose at which it began, in the frame in which the mission counts.
    origin: Pose,
    travelled: f64,
    turned: f64,
}

impl Carried {
    /// What hardware of this epoch says, told in a way that goes on from the last word.
    fn goes_on(&mut self, epoch: u64, last: Option<Odometry>, said: Odometry) -> Odometry {
        if let Some(last) = last.filter(|_| epoch != self.epoch) {
            self.origin = last.pose.then(said.pose.inverse());
            (self.travelled, self.turned) = (last.travelled - said.travelled, last.turned - said.turned);
        }
        self.epoch = epoch;
        Odometry {
            pose: self.origin.then(said.pose),
            travelled: self.travelled + said.travelled,
            turned: self.turned + said.turned,
            ..said
        }
    }
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
            carried: Carried::default(),
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
        let (carried, epoch) = (&mut self.carried, alive.state.epoch);
        alive.ports.odometry.drain(|sample| *odometry = Some(carried.goes_on(epoch, *odometry, sample.shifted(shift))));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_goes_on_when_the_hardware_begins_anew() {
        let mut carried = Carried::default();
        let said = |x, heading, travelled| Odometry {
            pose: Pose::new(x, 0.0, heading),
            travelled,
            turned: heading,
            ..Odometry::default()
        };
        let quarter = std::f64::consts::FRAC_PI_2;
        let first = carried.goes_on(7, None, said(1.0, 0.0, 3.0));
        assert_eq!(first, said(1.0, 0.0, 3.0), "the first word is taken as it is");
        let last = carried.goes_on(7, Some(first), said(2.0, quarter, 4.0));
        let anew = carried.goes_on(8, Some(last), said(0.0, 0.0, 0.0));
        assert!(last.pose.between(anew.pose).point().coords.norm() < 1e-9);
        let on = carried.goes_on(8, Some(anew), said(0.5, 0.0, 0.5));
        // It looks along y by now.
        assert!((on.pose.x - 2.0).abs() < 1e-9 && (on.pose.y - 0.5).abs() < 1e-9, "{:?}", on.pose);
        assert!((on.travelled - 4.5).abs() < 1e-9 && (on.turned - quarter).abs() < 1e-9);
    }
}
