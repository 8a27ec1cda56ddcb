//! The robots of one thread.

use std::{cell::RefCell, rc::Rc, sync::Arc};

use actix::{Actor, Addr, AsyncContext, Context, Handler, Message, Recipient, ResponseFuture};

use super::{Pulse, Word};
use crate::{
    clock::Stopwatch,
    host::HostError,
    recording::{Entries, Track},
    robot::{FinishRobot, Robot, RobotPlan, RobotReport, RobotStepped, StepRobot},
    time::Time,
};

/// The robots of one thread, stepped one after the other.
pub(super) struct Crew {
    members: Vec<Member>,
    conductor: Recipient<CrewStepped>,
    next: usize,
    now: Time,
    done: usize,
    /// What the robots said in this step, and what all robots said in the last one.
    said: Vec<Word>,
    heard: Option<Arc<[Word]>>,
    index: usize,
    /// Buffers that have been to the recorder and back.
    parcel: Vec<Parcel>,
    _pulse: Pulse,
}

struct Member {
    index: usize,
    robot: Addr<Robot>,
    /// `None` if it is muted.
    track: Option<Rc<RefCell<Track>>>,
}

/// What one robot recorded in one step.
#[derive(Debug, Default)]
pub(super) struct Parcel {
    /// The crew that packed it.
    pub crew: usize,
    /// The robot's place in the plan.
    pub robot: usize,
    pub entries: Entries,
}

/// Step all robots. They hear what was said in the last step; the parcels of an earlier step come back to be filled again.
#[derive(Message)]
#[rtype(result = "()")]
pub(super) struct StepCrew {
    pub now: Time,
    pub heard: Option<Arc<[Word]>>,
    pub empties: Vec<Parcel>,
}

/// All robots of a crew have been stepped.
#[derive(Message)]
#[rtype(result = "()")]
pub(super) struct CrewStepped {
    pub parcels: Vec<Parcel>,
    /// What the robots said, in their order.
    pub said: Vec<Word>,
    /// How many robots have nothing more to do.
    pub done: usize,
}

/// Collect the last words of all robots.
#[derive(Message)]
#[rtype(result = "Vec<(usize, RobotReport)>")]
pub(super) struct FinishCrew {
    pub now: Time,
}

impl Crew {
    /// Brings the robots to life on the current arbiter; numbers are their places in the fleet's plan.
    pub(super) fn start(
        index: usize,
        plans: Vec<(usize, RobotPlan)>,
        stopwatch: Stopwatch,
        conductor: Recipient<CrewStepped>,
        pulse: Pulse,
    ) -> Result<Addr<Crew>, HostError> {
        let mut failed = None;
        let crew = Crew::create(|context| {
            let address = context.address();
            let mut members = Vec::with_capacity(plans.len());
            for (index, plan) in plans {
                let its_pulse = pulse.of(format!("robot `{}`", plan.name));
                match Robot::start(plan, stopwatch, address.clone().recipient(), its_pulse) {
                    Ok((robot, track)) => {
                        let track = Some(track).filter(|track| !track.borrow().is_muted());
                        members.push(Member { index, robot, track });
                    }
                    Err(error) => {
                        failed = Some(error);
                        break;
                    }
                }
            }
            Crew {
                members,
                conductor,
                next: 0,
                now: Time::START,
                done: 0,
                said: Vec::new(),
                heard: None,
                index,
                parcel: Vec::new(),
                _pulse: pulse,
            }
        });
        failed.map_or(Ok(crew), Err)
    }

    fn go_on(&mut self) {
        if let Some(member) = self.members.get(self.next) {
            self.next += 1;
            member.robot.do_send(StepRobot { now: self.now, heard: self.heard.clone() });
            return;
        }
        let mut parcels = std::mem::take(&mut self.parcel);
        let tracks = || self.members.iter().filter_map(|member| Some((member.index, member.track.as_ref()?)));
        parcels.resize_with(tracks().count(), Parcel::default);
        for (parcel, (robot, track)) in parcels.iter_mut().zip(tracks()) {
            (parcel.crew, parcel.robot) = (self.index, robot);
            track.borrow_mut().swap_entries(&mut parcel.entries);
        }
        self.heard = None;
        self.conductor.do_send(CrewStepped { parcels, said: std::mem::take(&mut self.said), done: self.done });
    }
}

impl Actor for Crew {
    type Context = Context<Self>;
}

impl Handler<StepCrew> for Crew {
    type Result = ();

    fn handle(&mut self, step: StepCrew, _: &mut Context<Self>) {
        (self.parcel, self.heard) = (step.empties, step.heard);
        (self.now, self.next, self.done) = (step.now, 0, 0);
        self.go_on();
    }
}

impl Handler<RobotStepped> for Crew {
    type Result = ();

    fn handle(&mut self, stepped: RobotStepped, _: &mut Context<Self>) {
        self.done += usize::from(stepped.done);
        if let Some(member) = self.next.checked_sub(1).and_then(|last| self.members.get(last)) {
            let index = member.index;
            self.said.extend(stepped.said.into_iter().map(|word| word.of(index)));
        }
        self.go_on();
    }
}

impl Handler<FinishCrew> for Crew {
    type Result = ResponseFuture<Vec<(usize, RobotReport)>>;

    fn handle(&mut self, finish: FinishCrew, _: &mut Context<Self>) -> Self::Result {
        let robots: Vec<_> = self.members.iter().map(|member| (member.index, member.robot.clone())).collect();
        Box::pin(async move {
            let mut reports = Vec::with_capacity(robots.len());
            for (index, robot) in robots {
                reports.push((index, robot.send(FinishRobot { now: finish.now }).await.unwrap_or_default()));
            }
            reports
        })
    }
}
