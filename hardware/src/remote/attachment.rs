//! The mission's hold on hardware elsewhere: found, lost, and found again.

use std::time::Duration;

use orienteer_runtime::{
    agent::{Level, Outputs},
    clock::Epoch,
    link::{Bus, BusOptions, LinkError, RobotBus, Subscriber},
    time::Time,
    topics::HardwareState,
};

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
    run: String,
    robot: String,
    epoch: Epoch,
    held: Option<Held<P>>,
    /// When it was looked for last.
    tried: Option<Time>,
    told: String,
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
    pub fn new(run: String, robot: String, epoch: Epoch, speaks: bool) -> Self {
        Self { run, robot, epoch, held: None, tried: None, told: String::new(), speaks }
    }

    /// Hears whether the hardware lives, and looks for it if it does not.
    pub fn tend(&mut self, now: Time, out: &mut Outputs) {
        if let Some(held) = &mut self.held {
            let (state, heard) = (&mut held.state, &mut held.heard);
            held.states.drain(|sample| (*state, *heard) = (Some(*sample), now));
            if now.since(held.heard) < SILENCE {
                if held.state.is_some() {
                    self.tell(out, "the hardware is there".to_owned());
                }
                return;
            }
            self.held = None;
            self.tell(out, "the hardware is gone; looking for it".to_owned());
        }
        if self.tried.is_none_or(|tried| now.since(tried) >= AGAIN) {
            self.tried = Some(now);
            match self.attach(now) {
                Ok(held) => self.held = Some(held),
                Err(LinkError::NoSuchRun { run }) => {
                    let hint = format!("start it with `orienteer hardware` and this configuration (run `{run}`)");
                    self.tell(out, format!("waiting for the hardware of `{}`: {hint}", self.robot));
                }
                Err(error) => self.tell(out, format!("the hardware can't be reached: {error}; {}", error.hint())),
            }
        }
    }

    /// What to work with; `None` before the hardware has said anything, and when it is gone.
    pub fn alive(&mut self) -> Option<Alive<'_, P>> {
        let own = self.epoch.nanos()?;
        let held = self.held.as_mut()?;
        let state = held.state?;
        Some(Alive { ports: &mut held.ports, state, shift: state.epoch.cast_signed().wrapping_sub(own.cast_signed()) })
    }

    fn attach(&self, now: Time) -> Result<Held<P>, LinkError> {
        let bus = Bus::attach(&self.run, &BusOptions::default())?.robot(&self.robot)?.open();
        Ok(Held { ports: P::open(&bus)?, states: bus.subscriber()?, state: None, heard: now })
    }

    /// Says what is new.
    fn tell(&mut self, out: &mut Outputs, text: String) {
        if self.speaks && self.told != text {
            out.log(Level::WARN, &*text);
        }
        self.told = text;
    }
}
