//! One robot: the actor that leads its nodes through each control period.
//!
//! A period is sense → estimate → behave → arbitrate → act. The `Robot` tells one node after the other to take its step and
//! waits for its answer before it tells the next, so the order is that of the plan whatever else the arbiter's run queue
//! holds. At the end of the period it copies the robot's topics into the recording, if there is one. All nodes of a robot live on one arbiter.

mod dialogue;

use std::{cell::RefCell, rc::Rc, sync::Arc, time::Duration};

use actix::{Actor, ActorFutureExt, Addr, AsyncContext, Context, Handler, Message, Recipient, ResponseFuture, WrapFuture};

use crate::{
    agent::{Phase, Tap, Wiring},
    clock::Stopwatch,
    fleet::{Exchange, Pulse, Word},
    host::{Host, HostError, LastWords, NodePlan, NodeReport, Step, Stepped},
    link::{LinkError, RobotBus, RobotTicket},
    recording::Track,
    time::Time,
};
use dialogue::Dialogue;

/// A robot as it is planned, before it lives.
pub struct RobotPlan {
    /// Its name, unique in the mission.
    pub name: Arc<str>,
    /// Its nodes; within a phase they are stepped in this order.
    pub nodes: Vec<NodePlan>,
    /// Its links.
    pub bus: RobotTicket,
    /// Encodes its part of the recording.
    pub track: Track,
    /// Before it acts it rings for another process that is attached to its run, and waits so long for that to ring back. Without it, it
    /// acts at once.
    pub answered_within: Option<Duration>,
}

/// Take one control period, having heard what was said in the last one. Answered by [`RobotStepped`] to the crew.
#[derive(Message)]
#[rtype(result = "()")]
pub(crate) struct StepRobot {
    pub now: Time,
    pub heard: Option<Arc<[Word]>>,
}

/// A robot has completed a control period.
#[derive(Message)]
#[rtype(result = "()")]
pub(crate) struct RobotStepped {
    pub done: bool,
    /// What it told the others.
    pub said: Vec<Word>,
}

/// The mission is over; collect the nodes' last words.
#[derive(Message)]
#[rtype(result = "RobotReport")]
pub(crate) struct FinishRobot {
    pub now: Time,
}

/// How a robot has fared.
#[derive(Debug, Default)]
pub struct RobotReport {
    /// The robot's name.
    pub name: String,
    /// Its nodes, in the order of the plan.
    pub nodes: Vec<NodeReport>,
}

impl RobotReport {
    /// The figure of this name, from whichever node gave it.
    #[must_use]
    pub fn fact(&self, name: &str) -> Option<f64> {
        self.facts().find(|(other, _)| *other == name).map(|(_, value)| value)
    }

    /// All figures of all nodes.
    pub fn facts(&self) -> impl Iterator<Item = (&str, f64)> {
        self.nodes.iter().flat_map(|node| node.finish.facts.iter().map(|(name, value)| (name.as_str(), *value)))
    }
}

/// One turn of one node within a control period.
struct Turn {
    phase: Phase,
    node: Addr<Host>,
}

pub(crate) struct Robot {
    name: Arc<str>,
    turns: Vec<Turn>,
    nodes: Vec<Addr<Host>>,
    taps: Vec<Box<dyn Tap>>,
    exchange: Exchange,
    track: Rc<RefCell<Track>>,
    crew: Recipient<RobotStepped>,
    next: usize,
    /// The time at which this period began, and the time that its nodes are told.
    began: Time,
    now: Time,
    done: bool,
    dialogue: Option<Dialogue>,
    pulse: Pulse,
}

impl Robot {
    /// Brings a robot to life on the current arbiter. The track is shared: who takes what was recorded is the crew's matter.
    pub(crate) fn start(
        plan: RobotPlan,
        stopwatch: Stopwatch,
        crew: Recipient<RobotStepped>,
        pulse: Pulse,
    ) -> Result<(Addr<Robot>, Rc<RefCell<Track>>), HostError> {
        let track = Rc::new(RefCell::new(plan.track));
        let bus = plan.bus.open();
        let taps = if track.borrow().is_muted() { Vec::new() } else { taps(&plan.nodes, &bus)? };
        let exchange = exchange(&plan.nodes, &bus)?;
        let dialogue = plan.answered_within.map(|patience| Dialogue::new(&bus, patience, stopwatch)).transpose()?;
        let name = plan.name.clone();
        let mut failed = None;
        let robot = Robot::create(|context| {
            let address = context.address();
            let mut robot = Robot {
                name,
                turns: Vec::new(),
                nodes: Vec::new(),
                taps,
                exchange,
                track: track.clone(),
                crew,
                next: 0,
                began: Time::START,
                now: Time::START,
                done: false,
                dialogue,
                pulse,
            };
            if let Err(error) = robot.hire(plan.nodes, &bus, stopwatch, &track, &address) {
                failed = Some(error);
            }
            robot
        });
        match failed {
            Some(error) => Err(error),
            None => Ok((robot, track)),
        }
    }

    fn hire(
        &mut self,
        nodes: Vec<NodePlan>,
        bus: &RobotBus,
        stopwatch: Stopwatch,
        track: &Rc<RefCell<Track>>,
        address: &Addr<Robot>,
    ) -> Result<(), HostError> {
        let mut phases = Vec::new();
        for plan in nodes {
            phases.push(plan.phases.clone());
            let pulse = self.pulse.of(format!("`{}` on robot `{}`", plan.context.node, self.name));
            self.nodes.push(Host::new(plan, bus, stopwatch, track.clone(), address.clone(), pulse)?.start());
        }
        for phase in [Phase::Sense, Phase::Estimate, Phase::Behave, Phase::Arbitrate, Phase::Act] {
            for (node, _) in self.nodes.iter().zip(&phases).filter(|(_, phases)| phases.contains(&phase)) {
                self.turns.push(Turn { phase, node: node.clone() });
            }
        }
        Ok(())
    }

    /// Tells the next node to take its step, or reports the end of the period.
    fn go_on(&mut self, context: &mut Context<Self>) {
        let acts = self.turns.get(self.next).is_some_and(|turn| turn.phase == Phase::Act);
        if acts && self.asks(context) {
            return;
        }
        if let Some(turn) = self.turns.get(self.next) {
            self.next += 1;
            turn.node.do_send(Step { now: self.now, phase: turn.phase });
            return;
        }
        if !self.taps.is_empty() {
            let mut track = self.track.borrow_mut();
            for tap in &mut self.taps {
                tap.drain(&mut track);
            }
        }
        self.crew.do_send(RobotStepped { done: self.done, said: self.exchange.said() });
    }

    /// Asks the other process, if there is one to be asked and that has not been done; true if the answer is to be waited for.
    fn asks(&mut self, context: &mut Context<Self>) -> bool {
        let dialogue = self.dialogue.as_mut().filter(|dialogue| !dialogue.over);
        let Some(listening) = dialogue.and_then(Dialogue::ring) else { return false };
        context.spawn(listening.listen().into_actor(self).map(|answer, robot, context| {
            if let Some(dialogue) = &mut robot.dialogue {
                robot.now = robot.began + dialogue.end(answer);
            }
            robot.go_on(context);
        }));
        true
    }
}

/// One tap for each topic that any node writes, in the order of the plan.
fn taps(nodes: &[NodePlan], bus: &RobotBus) -> Result<Vec<Box<dyn Tap>>, LinkError> {
    let mut all = Wiring::default();
    for node in nodes {
        all.absorb_writes(&node.wiring);
    }
    all.write_ports().iter().map(|port| (port.tap)(bus)).collect()
}

/// What any node tells other robots, or wants to hear of them.
fn exchange(nodes: &[NodePlan], bus: &RobotBus) -> Result<Exchange, LinkError> {
    let mut all = Wiring::default();
    nodes.iter().for_each(|node| all.absorb_exchange(&node.wiring));
    let tellers = all.told_ports().iter().map(|port| (port.teller)(bus)).collect::<Result<_, _>>()?;
    let hearers = all.heard_ports().iter().map(|port| (port.hearer)(bus)).collect::<Result<_, _>>()?;
    Ok(Exchange::new(tellers, hearers))
}

impl Actor for Robot {
    type Context = Context<Self>;
}

impl Handler<StepRobot> for Robot {
    type Result = ();

    fn handle(&mut self, step: StepRobot, context: &mut Context<Self>) {
        (self.began, self.now, self.next, self.done) = (step.now, step.now, 0, false);
        self.track.borrow_mut().begin(step.now);
        if let Some(words) = step.heard {
            self.exchange.hear(&words);
        }
        if let Some(dialogue) = &mut self.dialogue {
            dialogue.begin();
        }
        self.go_on(context);
    }
}

impl Handler<Stepped> for Robot {
    type Result = ();

    fn handle(&mut self, stepped: Stepped, context: &mut Context<Self>) {
        self.done |= stepped.done;
        self.go_on(context);
    }
}

impl Handler<FinishRobot> for Robot {
    type Result = ResponseFuture<RobotReport>;

    fn handle(&mut self, finish: FinishRobot, _: &mut Context<Self>) -> Self::Result {
        let (name, nodes) = (self.name.to_string(), self.nodes.clone());
        Box::pin(async move {
            let mut report = RobotReport { name, nodes: Vec::new() };
            for node in nodes {
                // A node that can't answer has died with its arbiter; its last words are lost.
                report.nodes.push(node.send(LastWords { now: finish.now }).await.unwrap_or_default());
            }
            report
        })
    }
}
