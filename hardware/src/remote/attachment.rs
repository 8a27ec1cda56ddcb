//! The mission's hold on hardware elsewhere: found, lost, and found again.

use std::{borrow::Cow, time::Duration};

use orienteer_runtime::{
    agent::{Level, Outputs},
    link::{Bus, BusOptions, LinkError, RobotBus, Subscriber},
    time::Time,
    topics::HardwareState,
};

use super::{RemoteHardware, fingerprint::difference};

/// Hardware that says nothing for so long is gone.
const SILENCE: Duration = Duration::from_millis(500);
/// It is looked for so often.
const AGAIN: Duration = Duration::from_millis(500);

/// Ports to the hardware's topics.
pub(super) trait Ports: Sized {
    fn open(bus: &RobotBus) -> Result<Self, LinkError>;
}

/// A node's ports to the hardware's process, when there is one.
pub(super) struct Attachment<P> {
    hardware: RemoteHardware,
    held: Option<Held<P>>,
    /// When it was looked for last.
    tried: Option<Time>,
    told: Cow<'static, str>,
    /// Says what it waits for, and what it has found.
    speaks: bool,
}

struct Held<P> {
    ports: P,
    states: Subscriber<HardwareState>,
    /// The newest state, as it came.
    state: Option<HardwareState>,
    /// When that came, or when it was attached to.
    heard: Time,
}

/// What a node works with while the hardware lives.
pub(super) struct Alive<'a, P> {
    pub ports: &'a mut P,
    /// The newest state, in the hardware's own time.
    pub state: HardwareState,
    /// What turns a time of the hardware's into one of the mission's; its negative turns it back.
    pub shift: i64,
}

impl<P: Ports> Attachment<P> {
    pub fn new(hardware: RemoteHardware, speaks: bool) -> Self {
        Self { hardware, held: None, tried: None, told: Cow::Borrowed(""), speaks }
    }

    /// Hears whether the hardware lives, and looks for it if it does not.
    pub fn tend(&mut self, now: Time, out: &mut Outputs) {
        if let Some(held) = &mut self.held {
            let (state, heard) = (&mut held.state, &mut held.heard);
            held.states.drain(|sample| (*state, *heard) = (Some(*sample), now));
            if now.since(held.heard) < SILENCE {
                if let Some(state) = held.state {
                    self.remark(&state, out);
                }
                return;
            }
            self.held = None;
            self.tell(out, Level::WARN, "the hardware is gone; looking for it");
        }
        if self.tried.is_none_or(|tried| now.since(tried) >= AGAIN) {
            self.tried = Some(now);
            match self.attach(now) {
                Ok(held) => self.held = Some(held),
                Err(LinkError::NoSuchRun { run }) => {
                    let hint = format!("start it with `orienteer hardware` and this configuration (run `{run}`)");
                    self.tell(out, Level::WARN, format!("waiting for the hardware of `{}`: {hint}", self.hardware.robot));
                }
                Err(error) => self.tell(out, Level::WARN, format!("the hardware can't be reached: {error}; {}", error.hint())),
            }
        }
    }

    /// What to work with; `None` before the hardware has said anything, when it is gone, and when it was started with another
    /// configuration.
    pub fn alive(&mut self) -> Option<Alive<'_, P>> {
        let own = self.hardware.epoch.nanos()?;
        let held = self.held.as_mut()?;
        let state = held.state.filter(|state| state.fingerprint == self.hardware.fingerprint)?;
        Some(Alive { ports: &mut held.ports, state, shift: state.epoch.cast_signed().wrapping_sub(own.cast_signed()) })
    }

    /// True if hardware is there, but with another configuration.
    pub fn is_another(&self) -> bool {
        let state = self.held.as_ref().and_then(|held| held.state);
        state.is_some_and(|state| state.fingerprint != self.hardware.fingerprint)
    }

    fn attach(&self, now: Time) -> Result<Held<P>, LinkError> {
        let bus = Bus::attach(&self.hardware.run, &BusOptions::default())?.robot(&self.hardware.robot)?.open();
        Ok(Held { ports: P::open(&bus)?, states: bus.subscriber()?, state: None, heard: now })
    }

    /// Says that the hardware is there, or why it is of no use.
    fn remark(&mut self, state: &HardwareState, out: &mut Outputs) {
        match difference(&state.fingerprint, &self.hardware.fingerprint) {
            None => self.tell(out, Level::INFO, "the hardware is there"),
            Some(difference) => {
                let hint = "start both from the same configuration; until then nothing moves";
                self.tell(
                    out,
                    Level::ERROR,
                    format!("the hardware was started with another configuration: {difference}; {hint}"),
                );
            }
        }
    }

    /// Says what is new.
    fn tell(&mut self, out: &mut Outputs, level: Level, text: impl Into<Cow<'static, str>>) {
        let text = text.into();
        if self.speaks && self.told != text {
            out.log(level, &*text);
        }
        self.told = text;
    }
}
