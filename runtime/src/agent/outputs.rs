//! What a node says, publishes and leaves behind.

use std::any::{Any, TypeId};

use tracing::Level;

use super::{Wiring, inputs::USUAL, undeclared::Undeclared};
use crate::{
    arbitration::client::{BaseHandle, SonarHandle},
    link::{LinkError, Publisher, RobotBus},
    recording::GridImage,
    topics::{ClientId, Payload},
};

/// A sentence that a node wants to be read and recorded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LogLine {
    /// How much it matters.
    pub level: Level,
    /// The sentence.
    pub text: String,
    /// True if people want to read it who have not asked for log lines.
    pub news: bool,
}

/// Everything that a node may do in one step.
pub struct Outputs {
    /// The node's hold on the base.
    pub base: BaseHandle,
    /// The node's hold on the sonar.
    pub sonar: SonarHandle,
    slots: Vec<Box<dyn WritePort>>,
    logs: Vec<LogLine>,
    grids: Vec<GridImage>,
    overflow: u32,
    undeclared: Undeclared,
    draws: bool,
    done: bool,
}

/// The name under which pictures of grids are recorded.
pub(crate) const GRID: &str = "map";

/// How many log lines one step may say; more are dropped and counted as overflow.
const MAX_LOGS: usize = 16;

impl Outputs {
    pub(crate) fn connect(wiring: &Wiring, client: ClientId, bus: Option<&RobotBus>) -> Result<Self, LinkError> {
        let slots = wiring.write_ports().iter().map(|port| (port.writer)(bus)).collect::<Result<_, _>>()?;
        Ok(Self { draws: wiring.draws_a_map(), ..Self::with_ports(client, slots) })
    }

    fn with_ports(client: ClientId, slots: Vec<Box<dyn WritePort>>) -> Self {
        Self {
            base: BaseHandle::new(client),
            sonar: SonarHandle::new(client),
            slots,
            logs: Vec::new(),
            grids: Vec::new(),
            overflow: 0,
            undeclared: Undeclared::default(),
            draws: false,
            done: false,
        }
    }

    /// Outputs that go nowhere: for tests.
    #[must_use]
    pub fn offline(wiring: &Wiring) -> Self {
        // Without a bus no port can fail.
        Self::connect(wiring, ClientId(0), None).unwrap_or_else(|_| Self::with_ports(ClientId(0), Vec::new()))
    }

    /// Says that this robot has nothing more to do. The mission ends when all its robots say so.
    pub fn end_mission(&mut self) {
        self.done = true;
    }

    /// Forgets what was published and said, as the host does after each step: for tests that take several steps.
    pub fn settle(&mut self) {
        for slot in &mut self.slots {
            slot.discard();
        }
        self.logs.clear();
        self.grids.clear();
    }

    /// Publishes a sample at the end of the step. A node can publish as many samples of a topic in one step as the topic's
    /// queue holds; more are dropped and counted.
    pub fn publish<P: Payload>(&mut self, sample: P) {
        let Some(slot) = self.slots.iter_mut().find(|slot| slot.payload() == TypeId::of::<P>()) else {
            self.undeclared.note(P::TOPIC);
            return;
        };
        if let Some(slot) = slot.as_any_mut().downcast_mut::<WriteSlot<P>>() {
            if slot.pending.len() < P::QUEUE {
                slot.pending.push(sample);
            } else {
                self.overflow += 1;
            }
        }
    }

    /// What was published in this step: for tests.
    #[must_use]
    pub fn published<P: Payload>(&self) -> &[P] {
        self.slots.iter().find_map(|slot| slot.as_any().downcast_ref::<WriteSlot<P>>()).map_or(&[], |slot| &slot.pending)
    }

    /// What was said in this step: for tests.
    #[must_use]
    pub fn said(&self) -> &[LogLine] {
        &self.logs
    }

    /// Says something at level [`Level::INFO`].
    pub fn say(&mut self, text: impl Into<String>) {
        self.log(Level::INFO, text);
    }

    /// Says something; it is shown and recorded with the time and the node's name.
    pub fn log(&mut self, level: Level, text: impl Into<String>) {
        self.repeat(LogLine { level, text: text.into(), news: false });
    }

    /// Says something at level [`Level::INFO`] that people want to read who have not asked for log lines: what the robot found out, now and then.
    pub fn announce(&mut self, text: impl Into<String>) {
        self.repeat(LogLine { level: Level::INFO, text: text.into(), news: true });
    }

    /// Passes on what was said.
    pub(super) fn repeat(&mut self, line: LogLine) {
        if self.logs.len() < MAX_LOGS {
            self.logs.push(line);
        } else {
            self.overflow += 1;
        }
    }

    /// Records a picture of a grid map; [`Wiring::draws_map`] declares that. Costly; once in many seconds is plenty.
    pub fn record_grid(&mut self, grid: GridImage) {
        if self.draws {
            self.grids.push(grid);
        } else {
            self.undeclared.note(GRID);
        }
    }

    /// Sends what the step published and forgets it. Returns how much was dropped because the node said too much.
    pub(crate) fn flush(&mut self) -> Result<u32, LinkError> {
        // One topic that fails takes no other along, and nothing is kept for later: it would be old by then.
        let mut flushed = Ok(());
        for slot in &mut self.slots {
            flushed = flushed.and(slot.flush());
        }
        flushed.map(|()| std::mem::take(&mut self.overflow))
    }

    /// Forgets everything that the step wanted: what happens when it panicked half-way.
    pub(crate) fn discard(&mut self) {
        self.settle();
        self.base.release();
        self.sonar.release();
    }

    pub(crate) fn logs_mut(&mut self) -> &mut Vec<LogLine> {
        &mut self.logs
    }

    pub(crate) fn grids_mut(&mut self) -> &mut Vec<GridImage> {
        &mut self.grids
    }

    pub(crate) fn is_done(&self) -> bool {
        self.done
    }

    /// Topics that were used without having been declared; those that a script reads too.
    pub(crate) fn undeclared(&mut self) -> &mut Undeclared {
        &mut self.undeclared
    }
}

/// The last words of a node.
#[derive(Debug, Default)]
pub struct Finish {
    /// Figures for the summary, by name; units belong in the name (`distance_m`).
    pub facts: Vec<(String, f64)>,
    /// Files to write into the output directory.
    pub files: Vec<OutputFile>,
    /// What it should have left and could not, a sentence each.
    pub failures: Vec<String>,
    /// What the summary shall tell in words, a line each.
    pub notes: Vec<String>,
}

impl Finish {
    /// Adds a figure.
    pub fn fact(&mut self, name: impl Into<String>, value: f64) {
        self.facts.push((name.into(), value));
    }

    /// Adds a file.
    pub fn file(&mut self, name: impl Into<String>, bytes: Vec<u8>) {
        self.files.push(OutputFile { name: name.into(), bytes });
    }

    /// Adds a line to the summary.
    pub fn note(&mut self, text: impl Into<String>) {
        self.notes.push(text.into());
    }

    /// Says what could not be done. A person is told, and the program's exit code says so, too.
    pub fn failure(&mut self, text: impl Into<String>) {
        self.failures.push(text.into());
    }
}

/// A file that a node leaves behind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutputFile {
    /// Name within the output directory, without folders.
    pub name: String,
    /// Content.
    pub bytes: Vec<u8>,
}

/// The writing end of one topic, whatever its payload.
pub(super) trait WritePort {
    fn payload(&self) -> TypeId;
    fn flush(&mut self) -> Result<(), LinkError>;
    fn discard(&mut self);
    fn as_any(&self) -> &dyn Any;
    fn as_any_mut(&mut self) -> &mut dyn Any;
}

pub(super) struct WriteSlot<P: Payload> {
    publisher: Option<Publisher<P>>,
    pending: Vec<P>,
}

impl<P: Payload> WriteSlot<P> {
    pub(super) fn new(publisher: Option<Publisher<P>>) -> Self {
        Self { publisher, pending: Vec::with_capacity(P::QUEUE.min(USUAL)) }
    }
}

impl<P: Payload> WritePort for WriteSlot<P> {
    fn payload(&self) -> TypeId {
        TypeId::of::<P>()
    }

    fn flush(&mut self) -> Result<(), LinkError> {
        let sent = match &mut self.publisher {
            Some(publisher) => self.pending.iter().try_for_each(|sample| publisher.publish(*sample).map(drop)),
            None => Ok(()),
        };
        self.pending.clear();
        sent
    }

    fn discard(&mut self) {
        self.pending.clear();
    }

    fn as_any(&self) -> &dyn Any {
        self
    }

    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }
}
