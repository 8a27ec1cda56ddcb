//! The one actor that hosts any behaviour.
//!
//! A `Host` joins a plain [`Behaviour`] to the links of its robot and steps it when told to. What one behaviour does can't
//! hurt another: a panic is caught, the behaviour's claims are closed, and it is built anew after a pause that doubles each
//! time; a step that takes too long is counted and reported.

mod claims;
mod restart;

use std::{
    cell::RefCell,
    panic::{AssertUnwindSafe, catch_unwind},
    rc::Rc,
    time::Duration,
};

use actix::{Actor, Addr, Context, Handler, Message};

use crate::{
    agent::{Behaviour, BuildError, Finish, GRID, Inputs, Level, LogLine, Outputs, Phase, RobotContext, Wiring},
    clock::Stopwatch,
    fleet::Pulse,
    link::{LinkError, RobotBus},
    recording::Track,
    robot::Robot,
    time::Time,
};

use claims::ClaimPorts;
use restart::Restart;

/// Builds a node's behaviour on the robot's own thread, and again after a panic.
pub type Factory = Box<dyn Fn(&RobotContext) -> Result<Box<dyn Behaviour>, BuildError> + Send>;

/// A node of a robot as it is planned, before it lives.
pub struct NodePlan {
    /// What the node knows of its robot.
    pub context: RobotContext,
    /// The phases in which it is stepped.
    pub phases: Vec<Phase>,
    /// The topics it reads and writes.
    pub wiring: Wiring,
    /// True if it may claim the base or the sonar.
    pub claims: bool,
    /// A step that takes longer is an overrun.
    pub deadline: Duration,
    /// Builds the behaviour.
    pub factory: Factory,
}

/// Take one step. Answered by [`Stepped`] to the robot.
#[derive(Message)]
#[rtype(result = "()")]
pub(crate) struct Step {
    pub now: Time,
    pub phase: Phase,
}

/// A node has taken its step.
#[derive(Message)]
#[rtype(result = "()")]
pub(crate) struct Stepped {
    /// True if the node has nothing more to do.
    pub done: bool,
}

/// The mission is over; answer with your last words.
#[derive(Message)]
#[rtype(result = "NodeReport")]
pub(crate) struct LastWords {
    pub now: Time,
}

/// How a node has lived.
#[derive(Debug, Default)]
pub struct NodeReport {
    /// The node's name.
    pub name: String,
    /// Figures and files that it leaves.
    pub finish: Finish,
    /// How often its behaviour panicked and was built anew.
    pub panics: u32,
    /// Steps that took longer than the node's deadline. Counted at wall time only.
    pub overruns: u32,
    /// Samples and log lines dropped because a step produced too many.
    pub dropped: u64,
}

pub(crate) struct Host {
    context: RobotContext,
    behaviour: Option<Box<dyn Behaviour>>,
    factory: Factory,
    inputs: Inputs,
    outputs: Outputs,
    claims: Option<ClaimPorts>,
    restart: Restart,
    deadline: Duration,
    stopwatch: Stopwatch,
    track: Rc<RefCell<Track>>,
    robot: Addr<Robot>,
    report: NodeReport,
    /// Why there is no behaviour, if there is none.
    down: String,
    /// It has warned of something, and said no good news since.
    warned: bool,
    _pulse: Pulse,
}

/// A node can't be brought to life.
#[derive(Debug, thiserror::Error)]
pub enum HostError {
    /// A link can't be made.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The behaviour refused its parameters.
    #[error("`{node}` on robot `{robot}`: {source}")]
    Build {
        /// The robot.
        robot: String,
        /// The node.
        node: String,
        /// What it said.
        source: BuildError,
    },
}

impl Host {
    pub(crate) fn new(
        plan: NodePlan,
        bus: &RobotBus,
        stopwatch: Stopwatch,
        track: Rc<RefCell<Track>>,
        robot: Addr<Robot>,
        pulse: Pulse,
    ) -> Result<Self, HostError> {
        let behaviour = (plan.factory)(&plan.context).map_err(|source| HostError::Build {
            robot: plan.context.robot.to_string(),
            node: plan.context.node.to_string(),
            source,
        })?;
        let claims = if plan.claims { Some(ClaimPorts::connect(bus, &plan.context)?) } else { None };
        Ok(Self {
            inputs: Inputs::connect(&plan.wiring, Some(bus))?,
            outputs: Outputs::connect(&plan.wiring, plan.context.client, Some(bus))?,
            report: NodeReport { name: plan.context.node.to_string(), ..NodeReport::default() },
            context: plan.context,
            behaviour: Some(behaviour),
            factory: plan.factory,
            claims,
            restart: Restart::default(),
            deadline: plan.deadline,
            stopwatch,
            track,
            robot,
            down: String::new(),
            warned: false,
            _pulse: pulse,
        })
    }

    fn step(&mut self, step: &Step) -> bool {
        self.inputs.phase = step.phase;
        self.inputs.refresh();
        if let Some(claims) = &mut self.claims {
            claims.hear(&mut self.outputs);
        }
        self.revive(step.now);
        let started = self.stopwatch.start();
        self.run(step.now);
        if let Some(took) = started.elapsed().filter(|took| *took > self.deadline) {
            self.report.overruns += 1;
            let text = format!("a step took {took:.1?}, more than its deadline of {:?}", self.deadline);
            self.outputs.log(Level::WARN, text);
        }
        if let Some(claims) = &mut self.claims
            && let Err(error) = claims.speak(step.now, &mut self.outputs)
        {
            self.outputs.log(Level::ERROR, format!("can't claim: {error}"));
        }
        self.deliver(step.now);
        self.outputs.is_done()
    }

    /// Steps the behaviour, if it is alive.
    fn run(&mut self, now: Time) {
        let Some(behaviour) = &mut self.behaviour else { return };
        let (inputs, outputs) = (&self.inputs, &mut self.outputs);
        // Unwind safety: whatever the step left half-done is dropped below, inputs are read only.
        if let Err(panic) = catch_unwind(AssertUnwindSafe(|| behaviour.step(now, inputs, outputs))) {
            self.bury(now, &panic_text(panic.as_ref()));
        }
    }

    fn bury(&mut self, now: Time, why: &str) {
        self.drop_behaviour();
        self.report.panics += 1;
        self.down = format!("panicked: {why}");
        self.outputs.discard();
        let pause = self.restart.after_panic(now);
        self.outputs.log(
            Level::ERROR,
            format!("panicked: {why}; its claims are closed, it starts again in {:.1} s", pause.as_secs_f64()),
        );
    }

    /// A behaviour can panic once more when it is dropped, such as one that panicked half-way through a change.
    fn drop_behaviour(&mut self) {
        let behaviour = self.behaviour.take();
        if catch_unwind(AssertUnwindSafe(|| drop(behaviour))).is_err() {
            tracing::error!(target: "orienteer", "{}/{} panicked when it was dropped", self.context.robot, self.context.node);
        }
    }

    fn revive(&mut self, now: Time) {
        if self.behaviour.is_some() || !self.restart.is_due(now) {
            return;
        }
        let built = catch_unwind(AssertUnwindSafe(|| (self.factory)(&self.context)));
        match built {
            Ok(Ok(behaviour)) => {
                self.behaviour = Some(behaviour);
                self.outputs.log(Level::WARN, "starts again");
            }
            Ok(Err(error)) if error.for_good => {
                self.restart.never();
                self.down = format!("{}, and {error}", self.down);
                self.outputs.log(Level::ERROR, format!("{error}; it stays down"));
            }
            Ok(Err(error)) => {
                let pause = self.restart.after_panic(now).as_secs_f64();
                self.outputs.log(Level::ERROR, format!("can't be built anew: {error}; the next attempt is in {pause:.1} s"));
            }
            Err(panic) => self.bury(now, &panic_text(panic.as_ref())),
        }
    }

    /// Sends what the step published and hands its log lines to the recording and to the terminal.
    fn deliver(&mut self, now: Time) {
        match self.outputs.flush() {
            Ok(dropped) => self.report.dropped += u64::from(dropped),
            Err(error) => self.outputs.log(Level::ERROR, format!("can't publish: {error}")),
        }
        for topic in self.inputs.undeclared().news() {
            self.outputs.undeclared().note(topic);
        }
        for topic in self.outputs.undeclared().news().to_vec() {
            self.outputs.log(Level::ERROR, format!("uses the topic `{topic}` without having declared it"));
        }
        let mut track = self.track.borrow_mut();
        for line in self.outputs.logs_mut().drain(..) {
            track.log(line.level, &self.context.node, &line.text);
            let answers = line.level == Level::INFO && std::mem::take(&mut self.warned);
            self.warned |= line.level <= Level::WARN;
            show(&self.context, now, &line, answers);
        }
        for grid in self.outputs.grids_mut().drain(..) {
            track.record_grid(GRID, &grid);
        }
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        self.drop_behaviour();
    }
}

impl Actor for Host {
    type Context = Context<Self>;
}

impl Handler<Step> for Host {
    type Result = ();

    fn handle(&mut self, step: Step, _: &mut Context<Self>) {
        let done = self.step(&step);
        self.robot.do_send(Stepped { done });
    }
}

impl Handler<LastWords> for Host {
    type Result = actix::MessageResult<LastWords>;

    fn handle(&mut self, words: LastWords, _: &mut Context<Self>) -> Self::Result {
        let mut report = std::mem::take(&mut self.report);
        let finish = &mut report.finish;
        if let Some(behaviour) = &mut self.behaviour {
            if catch_unwind(AssertUnwindSafe(|| behaviour.finish(words.now, finish))).is_err() {
                report.panics += 1;
                finish.failure("its last words panicked; what it should have left is lost");
            }
        } else {
            finish.failure(format!("it was down at the end: {}", self.down));
        }
        actix::MessageResult(report)
    }
}

/// What a panic said.
#[must_use]
pub fn panic_text(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(ToString::to_string).or_else(|| panic.downcast_ref::<String>().cloned());
    text.unwrap_or_else(|| "no message".to_string())
}

/// Target of the first good news (INFO) of a node that has warned: whoever was told of trouble is told that it is over.
pub const RELIEF: &str = "orienteer::relief";

/// Target of what a node [announces](crate::agent::Outputs::announce).
pub const NEWS: &str = "orienteer::news";

fn show(context: &RobotContext, now: Time, line: &LogLine, answers: bool) {
    let (robot, node) = (&*context.robot, &*context.node);
    match line.level {
        Level::TRACE | Level::DEBUG => tracing::debug!(target: "orienteer", "{now} {robot}/{node}: {}", line.text),
        Level::INFO if line.news => tracing::info!(target: NEWS, "{now} {robot}/{node}: {}", line.text),
        Level::INFO if answers => tracing::info!(target: RELIEF, "{now} {robot}/{node}: {}", line.text),
        Level::INFO => tracing::info!(target: "orienteer", "{now} {robot}/{node}: {}", line.text),
        Level::WARN => tracing::warn!(target: "orienteer", "{now} {robot}/{node}: {}", line.text),
        Level::ERROR => tracing::error!(target: "orienteer", "{now} {robot}/{node}: {}", line.text),
    }
}
