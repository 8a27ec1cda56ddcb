//! The mission's thread: shares the robots out, steps the crews, keeps time and the recording.

use std::{ops::ControlFlow, sync::Arc, time::Duration};

use actix::{Actor, ActorFutureExt, Addr, Arbiter, AsyncContext, Context, Handler, Message, WrapFuture};
use tokio::sync::oneshot;

use super::{
    Died, Ended, Environment, FleetControl, FleetError, FleetPlan, FleetReport, Observer, Pulse, Word,
    crew::{Crew, CrewStepped, FinishCrew, Parcel, StepCrew},
    leader::Beat,
    signals::Ear,
};
use crate::{
    clock::{Clock, Stopwatch},
    recording::Recorder,
    robot::{RobotPlan, RobotReport},
    time::Time,
};

/// How often a paused fleet looks whether it may go on.
const PAUSE_POLL: Duration = Duration::from_millis(20);
/// How often a fleet whose steps are far apart looks whether it is to stop.
const STOP_POLL: Duration = Duration::from_millis(100);

/// Runs a fleet on the current actor system.
pub(super) async fn conduct(plan: FleetPlan) -> Result<FleetReport, FleetError> {
    let threads = plan.threads.clamp(1, plan.robots.len().max(1));
    let fleet_size = plan.robots.len();
    let mut robots = plan.robots;
    if plan.recorder.is_none() {
        // A hash has a recorder too: without one nobody ever looks at what a track encodes.
        robots.iter_mut().for_each(|robot| robot.track.mute());
    }
    let shares = share_out(robots, threads);
    let stopwatch = Clock::stopwatch(plan.pace);
    let (ended, end) = oneshot::channel();
    plan.epoch.begin();
    let conductor = Conductor {
        crews: Vec::new(),
        waiting: 0,
        parcels: Vec::new(),
        said: Vec::new(),
        empties: (0..threads).map(|_| Vec::new()).collect(),
        done: 0,
        fleet_size,
        clock: Clock::new(plan.pace, plan.period),
        beat: plan.leader.map(Beat::of),
        now: Time::START,
        last: plan.duration.map(|duration| Time::START + duration),
        environment: plan.environment,
        observer: plan.observer,
        control: plan.control.clone(),
        recorder: plan.recorder,
        ended: Some(ended),
    }
    .start();

    let mut arbiters = Vec::new();
    let mut crews = Vec::new();
    let mustered = muster(shares, stopwatch, &conductor, &mut arbiters, &mut crews).await;
    let report = match mustered {
        Ok(()) => {
            let _ear = Ear::open(plan.control);
            conductor.do_send(Begin { crews: crews.clone() });
            match end.await {
                Ok(end) => finish(end, &crews).await,
                Err(_) => Err(FleetError::System("the conductor died".to_string())),
            }
        }
        Err(error) => Err(error),
    };
    for arbiter in arbiters {
        arbiter.stop();
        // Joined so that the robots' ports are dropped before the process goes on.
        if arbiter.join().is_err() {
            tracing::error!("a thread of the fleet panicked at its end");
        }
    }
    report
}

/// Brings the robots to life. What has been started when it fails is in `arbiters` and `crews` all the same.
async fn muster(
    shares: Vec<Vec<(usize, RobotPlan)>>,
    stopwatch: Stopwatch,
    conductor: &Addr<Conductor>,
    arbiters: &mut Vec<Arbiter>,
    crews: &mut Vec<Addr<Crew>>,
) -> Result<(), FleetError> {
    // The first share stays on this thread, the others get an arbiter each.
    for (index, share) in shares.into_iter().enumerate() {
        let to = conductor.clone().recipient();
        let pulse = Pulse::new(format!("thread {}", index + 1), conductor.clone().recipient());
        if index == 0 {
            crews.push(Crew::start(index, share, stopwatch, to, pulse)?);
            continue;
        }
        let arbiter = Arbiter::new();
        let (sent, started) = oneshot::channel();
        arbiter.spawn_fn(move || {
            // If nobody waits for the answer any more, the fleet has failed to start elsewhere.
            let _ = sent.send(Crew::start(index, share, stopwatch, to, pulse));
        });
        arbiters.push(arbiter);
        crews.push(started.await.map_err(|_| FleetError::System("a thread died while robots came to life".to_string()))??);
    }
    Ok(())
}

/// Deals the robots out in contiguous shares, so that each thread's parcels are in order.
fn share_out(robots: Vec<RobotPlan>, threads: usize) -> Vec<Vec<(usize, RobotPlan)>> {
    let count = robots.len();
    let mut shares: Vec<Vec<_>> = (0..threads).map(|_| Vec::new()).collect();
    for (index, robot) in robots.into_iter().enumerate() {
        shares[index * threads / count.max(1)].push((index, robot));
    }
    shares
}

/// Collects the last words, with which the bases stop; only then the recording may keep anybody waiting.
async fn finish(end: End, crews: &[Addr<Crew>]) -> Result<FleetReport, FleetError> {
    let mut robots: Vec<(usize, RobotReport)> = Vec::new();
    let mut died = end.died;
    for (index, crew) in crews.iter().enumerate() {
        match crew.send(FinishCrew { now: end.time }).await {
            Ok(reports) => robots.extend(reports),
            // The bases of the other crews have to stop first.
            Err(_) => drop(died.get_or_insert_with(|| format!("thread {}", index + 1))),
        }
    }
    robots.sort_by_key(|(index, _)| *index);
    let recording = end.recorder.map(|mut recorder| {
        end.parcels.into_iter().for_each(|mut parcel| recorder.append(&mut parcel.entries));
        recorder.finish()
    });
    if let Some(who) = died {
        return Err(FleetError::Died { who });
    }
    Ok(FleetReport {
        robots: robots.into_iter().map(|(_, report)| report).collect(),
        time: end.time,
        steps: end.steps,
        missed: end.missed,
        elapsed: end.elapsed,
        ended: end.why,
        recording,
    })
}

/// How the last step left things.
struct End {
    time: Time,
    steps: u64,
    missed: u64,
    elapsed: Duration,
    why: Ended,
    /// What the robots recorded in the last step, in their order.
    parcels: Vec<Parcel>,
    recorder: Option<Recorder>,
    /// Who died, so that it could not go on.
    died: Option<String>,
}

struct Conductor {
    crews: Vec<Addr<Crew>>,
    waiting: usize,
    /// What the robots recorded in this step; nothing if there is no recorder.
    parcels: Vec<Parcel>,
    /// What the robots said in this step.
    said: Vec<Word>,
    /// Emptied buffers, by crew.
    empties: Vec<Vec<Parcel>>,
    done: usize,
    fleet_size: usize,
    clock: Clock,
    /// Away while somebody waits for it.
    beat: Option<Beat>,
    now: Time,
    last: Option<Time>,
    environment: Box<dyn Environment>,
    observer: Box<dyn Observer>,
    control: FleetControl,
    recorder: Option<Recorder>,
    ended: Option<oneshot::Sender<End>>,
}

/// All crews are alive: start the first step.
#[derive(Message)]
#[rtype(result = "()")]
struct Begin {
    crews: Vec<Addr<Crew>>,
}

/// It is time for the next step.
#[derive(Message)]
#[rtype(result = "()")]
struct Next;

impl Conductor {
    fn step(&mut self) {
        self.now = self.clock.now();
        (self.waiting, self.done) = (self.crews.len(), 0);
        self.said.sort_by_key(|word| word.robot);
        let heard = (!self.said.is_empty()).then(|| Arc::from(std::mem::take(&mut self.said)));
        for (crew, empties) in self.crews.iter().zip(&mut self.empties) {
            crew.do_send(StepCrew { now: self.now, heard: heard.clone(), empties: std::mem::take(empties) });
        }
    }

    /// The barrier: all crews are through with the step.
    fn complete(&mut self, context: &mut Context<Self>) {
        let now = self.now;
        self.parcels.sort_by_key(|parcel| parcel.robot);
        let watched = self.observer.after_step(now);
        let why = if self.done == self.fleet_size {
            Some(Ended::AllDone)
        } else if self.last.is_some_and(|last| now >= last) {
            Some(Ended::Complete)
        } else if self.control.is_stopped() || watched == ControlFlow::Break(()) {
            Some(Ended::Stopped)
        } else {
            None
        };
        match why {
            Some(why) => self.end(now, why, None),
            None => {
                self.record();
                self.clock.advance();
                self.wait_for_next(context);
            }
        }
    }

    /// Hands what the robots recorded to the recorder, in their order, and the buffers back to their crews.
    fn record(&mut self) {
        for mut parcel in self.parcels.drain(..) {
            if let Some(recorder) = &mut self.recorder {
                recorder.append(&mut parcel.entries);
            }
            self.empties[parcel.crew].push(parcel);
        }
    }

    /// Begins the next step when it is due, or at once if it is to be the last.
    fn wait_for_next(&mut self, context: &mut Context<Self>) {
        let led = self.beat.as_ref().is_some_and(Beat::is_led);
        let pause = if led { self.clock.grace() } else { self.clock.remaining() };
        if pause.is_zero() || self.control.is_stopped() {
            self.begin_step(context);
            return;
        }
        let pause = pause.min(STOP_POLL);
        let Some(mut beat) = self.beat.take() else {
            context.run_later(pause, Self::wait_for_next);
            return;
        };
        let wait = async move { (beat.wait(pause).await, beat) };
        context.spawn(wait.into_actor(self).map(|(rung, beat), conductor, context| {
            conductor.beat = Some(beat);
            if rung && conductor.clock.follow() {
                conductor.begin_step(context);
            } else {
                conductor.wait_for_next(context);
            }
        }));
    }

    fn begin_step(&mut self, context: &mut Context<Self>) {
        if self.control.holds() {
            context.run_later(PAUSE_POLL, |conductor, context| {
                conductor.clock.resume();
                conductor.begin_step(context);
            });
            return;
        }
        self.environment.advance(self.clock.now());
        context.notify(Next);
    }

    fn end(&mut self, time: Time, why: Ended, died: Option<String>) {
        let end = End {
            time,
            steps: self.clock.tick() + 1,
            missed: self.clock.missed(),
            elapsed: self.clock.elapsed(),
            why,
            parcels: std::mem::take(&mut self.parcels),
            recorder: self.recorder.take(),
            died,
        };
        if let Some(ended) = self.ended.take() {
            // Nobody waits only if the whole system is going down.
            let _ = ended.send(end);
        }
    }
}

impl Actor for Conductor {
    type Context = Context<Self>;
}

impl Handler<Begin> for Conductor {
    type Result = ();

    fn handle(&mut self, begin: Begin, _: &mut Context<Self>) {
        self.crews = begin.crews;
        self.step();
    }
}

impl Handler<Next> for Conductor {
    type Result = ();

    fn handle(&mut self, _: Next, _: &mut Context<Self>) {
        self.step();
    }
}

impl Handler<CrewStepped> for Conductor {
    type Result = ();

    fn handle(&mut self, mut stepped: CrewStepped, context: &mut Context<Self>) {
        self.done += stepped.done;
        self.parcels.append(&mut stepped.parcels);
        self.said.append(&mut stepped.said);
        self.waiting -= 1;
        if self.waiting == 0 {
            self.complete(context);
        }
    }
}

impl Handler<Died> for Conductor {
    type Result = ();

    /// The step under way will never be complete.
    fn handle(&mut self, died: Died, _: &mut Context<Self>) {
        self.parcels.clear();
        self.end(self.now, Ended::Stopped, Some(died.who));
    }
}
