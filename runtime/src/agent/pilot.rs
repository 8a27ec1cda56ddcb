//! What a script steers with: moves, waits, and the newest samples.

use std::{
    cell::RefCell,
    f64::consts::{FRAC_PI_2, PI},
    future::poll_fn,
    rc::Rc,
    task::Poll,
    time::Duration,
};

use nalgebra::Point2;

use super::{Inputs, Level, LogLine, Outputs, Wiring};
use crate::{
    arbitration::client::{BaseHandle, BaseState, MotionId},
    geometry::{Limits, Pose, Twist, angle},
    time::Time,
    topics::{ClientId, MotionState, Payload, PoseEstimate},
};

/// Why a manoeuvre was broken off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Aborted {
    /// A higher priority took the base.
    #[error("a higher priority took the base")]
    Overridden {
        /// Who.
        by: ClientId,
    },
    /// The base was not free in time.
    #[error("the base was not free in time")]
    Busy,
    /// The base could not go on: something is in the way, or it touches something.
    #[error("the base could not go on")]
    Blocked,
    /// The claim on the base lapsed.
    #[error("the claim on the base lapsed")]
    Lapsed,
    /// Something that the script waited for did not happen in time.
    #[error("what was waited for did not happen in time")]
    TimedOut,
}

/// How to reach a saved pose (Randazza 1989, §2.5): in a straight line, or one component after the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Strategy {
    /// Turn toward the goal and drive there, backward if it lies behind.
    Straight,
    /// First the sideways component, then the forward one, as seen from where the robot starts.
    SidewaysFirst,
    /// First the forward component, then the sideways one, as seen from where the robot starts: for goals round a corner.
    ForwardFirst,
}

/// A pose that was saved, to come back to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseHandle(Pose);

impl PoseHandle {
    /// A pose that somebody else has named, map frame.
    #[must_use]
    pub fn at(pose: Pose) -> Self {
        Self(pose)
    }

    /// The saved pose, map frame.
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.0
    }
}

/// What script and pilot exchange in a step.
pub(super) struct Desk {
    now: Time,
    steps: u64,
    /// Apart from the rest, so that a script can look at them and use its pilot at the same time.
    inputs: Rc<RefCell<Inputs>>,
    base: BaseHandle,
    /// A velocity to be kept until something else is ordered.
    cruise: Option<Twist>,
    limits: Limits,
    logs: Vec<LogLine>,
    publications: Vec<Box<dyn FnOnce(&mut Outputs)>>,
}

impl Desk {
    pub(super) fn new(wiring: &Wiring) -> Self {
        Self {
            now: Time::START,
            steps: 0,
            inputs: Rc::new(RefCell::new(Inputs::offline(wiring))),
            base: BaseHandle::new(ClientId::NONE),
            cruise: None,
            limits: Limits::NONE,
            logs: Vec::new(),
            publications: Vec::new(),
        }
    }

    /// A step begins.
    pub(super) fn open(&mut self, now: Time, inputs: &Inputs, base: &BaseHandle) {
        self.now = now;
        self.steps += 1;
        self.inputs.borrow_mut().copy_from(inputs);
        self.base = base.clone();
    }

    /// A step ends.
    pub(super) fn close(&mut self, out: &mut Outputs) {
        if let Some(twist) = self.cruise {
            self.base.drive(twist);
        }
        if self.limits != Limits::NONE {
            self.base.limit(self.limits);
        }
        out.base = self.base.clone();
        for topic in self.inputs.borrow().undeclared().news() {
            out.undeclared().note(topic);
        }
        for line in self.logs.drain(..) {
            out.repeat(line);
        }
        for publish in self.publications.drain(..) {
            publish(out);
        }
    }

    pub(super) fn release(&mut self) {
        self.cruise = None;
        self.base.release();
    }

    /// Why the script can't go on, if it can't.
    fn lost(&self) -> Option<Aborted> {
        match self.base.state() {
            BaseState::Overridden { by } => Some(Aborted::Overridden { by }),
            BaseState::Busy => Some(Aborted::Busy),
            BaseState::Lapsed => Some(Aborted::Lapsed),
            BaseState::Free | BaseState::Waiting | BaseState::Holding => None,
        }
    }
}

/// What a script flies the robot with.
///
/// Everything that takes time is an `async fn` that returns `Err(`[`Aborted`]`)` when the base is lost, so `?` unwinds the
/// manoeuvre. Motions claim the base by themselves; [`Pilot::release`] gives it back.
#[derive(Clone)]
pub struct Pilot {
    desk: Rc<RefCell<Desk>>,
}

impl Pilot {
    pub(super) fn new(desk: Rc<RefCell<Desk>>) -> Self {
        Self { desk }
    }

    /// The time of this step.
    #[must_use]
    pub fn now(&self) -> Time {
        self.desk.borrow().now
    }

    /// The newest sample of a topic.
    #[must_use]
    pub fn latest<P: Payload>(&self) -> Option<P> {
        self.inputs().borrow().latest().copied()
    }

    /// Waits for the next step.
    ///
    /// # Errors
    /// If the base is lost.
    pub async fn next_step(&self) -> Result<(), Aborted> {
        let started = self.desk.borrow().steps;
        poll_fn(|_| {
            let desk = self.desk.borrow();
            match desk.lost() {
                _ if desk.steps == started => Poll::Pending,
                Some(why) => Poll::Ready(Err(why)),
                None => Poll::Ready(Ok(())),
            }
        })
        .await
    }

    /// Waits until a condition on the inputs holds; it is looked at in every step, this one first. The condition may use the pilot.
    ///
    /// # Errors
    /// If the base is lost.
    pub async fn until(&self, mut condition: impl FnMut(&Inputs) -> bool) -> Result<(), Aborted> {
        let inputs = self.inputs();
        while !condition(&inputs.borrow()) {
            self.next_step().await?;
        }
        Ok(())
    }

    /// Waits for the next sample of a topic. A topic that was not declared never has one; the host reports that.
    ///
    /// # Errors
    /// If the base is lost.
    pub async fn next<P: Payload>(&self) -> Result<P, Aborted> {
        loop {
            self.next_step().await?;
            if let Some(sample) = self.inputs().borrow().fresh::<P>() {
                return Ok(*sample);
            }
        }
    }

    /// Waits.
    ///
    /// # Errors
    /// If the base is lost.
    pub async fn sleep(&self, span: Duration) -> Result<(), Aborted> {
        let end = self.now() + span;
        while self.now() < end {
            self.next_step().await?;
        }
        Ok(())
    }

    /// Drives straight on by `distance` m (negative: backward) at up to `speed` m/s and comes to rest.
    ///
    /// # Errors
    /// If the base is lost or can't go on.
    pub async fn translate(&self, distance: f64, speed: f64) -> Result<(), Aborted> {
        let motion = self.order(|base| base.translate(distance, speed));
        self.arrive(motion).await
    }

    /// Turns on the spot by `angle` rad (positive: left) at up to `rate` rad/s and comes to rest. Nothing keeps a base from that but what it
    /// touches: then it gets away from there first, a little back or ahead, and turns by what is left.
    ///
    /// # Errors
    /// If the base is lost or can't go on.
    pub async fn rotate(&self, angle: f64, rate: f64) -> Result<(), Aborted> {
        let heading = || self.latest::<PoseEstimate>().map(|estimate| estimate.pose.heading);
        let before = heading();
        let motion = self.order(|base| base.rotate(angle, rate));
        match self.arrive(motion).await {
            Err(Aborted::Blocked) => {
                self.back_off().await?;
                let turned = before.zip(heading()).map_or(0.0, |(before, now)| angle::turn(before, now));
                let motion = self.order(|base| base.rotate(angle - turned, rate));
                self.arrive(motion).await
            }
            ended => ended,
        }
    }

    /// Gets away from what the body touches: the base lets it go nowhere else.
    async fn back_off(&self) -> Result<(), Aborted> {
        /// So far, m.
        const AWAY: f64 = 0.06;
        /// At up to this speed, m/s.
        const SLOWLY: f64 = 0.05;
        match self.translate(-AWAY, SLOWLY).await {
            Err(Aborted::Blocked) => self.translate(AWAY, SLOWLY).await,
            ended => ended,
        }
    }

    /// Keeps a velocity until something else is ordered.
    pub fn drive(&self, twist: Twist) {
        self.desk.borrow_mut().cruise = Some(twist);
    }

    /// Takes or keeps the base, and stands.
    pub fn stop(&self) {
        self.order(BaseHandle::stop);
    }

    /// Gives the base back.
    pub fn release(&self) {
        self.desk.borrow_mut().release();
    }

    /// Caps whoever has the base, until changed; [`Limits::NONE`] lifts the cap.
    pub fn limit(&self, limits: Limits) {
        self.desk.borrow_mut().limits = limits;
    }

    /// Publishes a sample at the end of the step.
    pub fn publish<P: Payload>(&self, sample: P) {
        self.desk.borrow_mut().publications.push(Box::new(move |out| out.publish(sample)));
    }

    /// Says something.
    pub fn say(&self, text: impl Into<String>) {
        self.desk.borrow_mut().logs.push(LogLine { level: Level::INFO, text: text.into(), news: false });
    }

    /// Says something that people want to read who have not asked for log lines.
    pub fn announce(&self, text: impl Into<String>) {
        self.desk.borrow_mut().logs.push(LogLine { level: Level::INFO, text: text.into(), news: true });
    }

    /// Saves the pose that lies at `offset` (robot frame) from where the robot thinks it is; `None` before the first estimate.
    /// The script must read [`PoseEstimate`].
    #[must_use]
    pub fn save_pose(&self, offset: Pose) -> Option<PoseHandle> {
        self.latest::<PoseEstimate>().map(|estimate| PoseHandle(estimate.pose.then(offset)))
    }

    /// Drives to a saved pose at up to `speed` m/s, turning at up to `rate` rad/s, and ends at its heading.
    ///
    /// # Errors
    /// If the base is lost or can't go on.
    pub async fn move_to(&self, goal: PoseHandle, strategy: Strategy, speed: f64, rate: f64) -> Result<(), Aborted> {
        let start = self.latest::<PoseEstimate>().ok_or(Aborted::TimedOut)?.pose;
        let local = start.between(goal.0);
        let corner = match strategy {
            Strategy::Straight => None,
            Strategy::SidewaysFirst => Some(Pose::new(0.0, local.y, 0.0)),
            Strategy::ForwardFirst => Some(Pose::new(local.x, 0.0, 0.0)),
        };
        if let Some(corner) = corner {
            self.go(start.then(corner).point(), speed, rate).await?;
        }
        self.go(goal.0.point(), speed, rate).await?;
        self.face(goal.0.heading, rate).await
    }

    /// Turns toward a point (map frame) and drives there at up to `speed` m/s, turning at up to `rate` rad/s; backward if it lies more than
    /// 135° off.
    ///
    /// # Errors
    /// If the base is lost or can't go on.
    pub async fn go(&self, goal: Point2<f64>, speed: f64, rate: f64) -> Result<(), Aborted> {
        /// Nearer than this it is there, m.
        const THERE: f64 = 0.01;
        let here = self.latest::<PoseEstimate>().ok_or(Aborted::TimedOut)?.pose;
        let distance = (goal - here.point()).norm();
        if distance < THERE {
            return Ok(());
        }
        let bearing = here.bearing_of(goal);
        let backward = bearing.abs() > FRAC_PI_2 + 0.5 * FRAC_PI_2;
        let (turn, distance) = if backward { (angle::wrap(bearing + PI), -distance) } else { (bearing, distance) };
        self.turn(turn, rate).await?;
        self.translate(distance, speed).await
    }

    /// Turns on the spot to a heading (map frame, rad) at up to `rate` rad/s.
    ///
    /// # Errors
    /// If the base is lost or can't go on.
    pub async fn face(&self, heading: f64, rate: f64) -> Result<(), Aborted> {
        let here = self.latest::<PoseEstimate>().ok_or(Aborted::TimedOut)?.pose;
        self.turn(angle::turn(here.heading, heading), rate).await
    }

    async fn turn(&self, angle: f64, rate: f64) -> Result<(), Aborted> {
        /// Less than this is not worth a motion, rad.
        const STRAIGHT: f64 = 0.005;
        if angle.abs() < STRAIGHT { Ok(()) } else { self.rotate(angle, rate).await }
    }

    fn inputs(&self) -> Rc<RefCell<Inputs>> {
        self.desk.borrow().inputs.clone()
    }

    fn order<T>(&self, order: impl FnOnce(&mut BaseHandle) -> T) -> T {
        let mut desk = self.desk.borrow_mut();
        desk.cruise = None;
        order(&mut desk.base)
    }

    async fn arrive(&self, motion: MotionId) -> Result<(), Aborted> {
        loop {
            self.next_step().await?;
            match self.desk.borrow().base.motion_state(motion) {
                MotionState::Done => return Ok(()),
                MotionState::Blocked => return Err(Aborted::Blocked),
                MotionState::Idle | MotionState::Running => {}
            }
        }
    }
}
