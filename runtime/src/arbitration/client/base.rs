//! How a client asks for the base, and what it hears of it.

use std::time::Duration;

use crate::{
    geometry::{Limits, Twist},
    time::Time,
    topics::{BaseClaim, BaseDecision, BaseNotice, ClientId, Motion, MotionKind, MotionReport, MotionState, NoticeKind},
};

/// How a client stands with the base.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BaseState {
    /// It does not want the base.
    Free,
    /// It wants the base and does not have it yet.
    Waiting,
    /// It has the base.
    Holding,
    /// It had the base, and a higher priority took it.
    Overridden {
        /// Who has the base now.
        by: ClientId,
    },
    /// It waited for the base as long as it would. The next command begins anew.
    Busy,
    /// Its claim was not renewed in time. The next command begins anew.
    Lapsed,
}

/// What to do when a higher priority takes the base.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum OnOverride {
    /// Go on claiming: hear what the overrider does, and get the base back when it yields.
    #[default]
    HangOn,
    /// Let go of the base at once. The next command begins a new transaction.
    Surrender,
}

/// Names a relative motion: no two clients of a robot use the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct MotionId(u32);

impl MotionId {
    /// The id that the motion and its reports carry.
    #[must_use]
    pub fn get(self) -> u32 {
        self.0
    }
}

/// What a client has ordered.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Order {
    /// Stand until told otherwise.
    Stand,
    /// A velocity, and whether it was ordered in this step.
    Drive { twist: Twist, fresh: bool },
    /// A relative motion that goes on by itself.
    Relative(Motion),
}

/// A behaviour's hold on the base.
///
/// Commands, [`drive`](Self::drive), [`translate`](Self::translate), [`rotate`](Self::rotate) and [`stop`](Self::stop), begin
/// a transaction if none is open; they are executed once the base is held. They differ in how long they last:
///
/// * a velocity lasts for **one step**. A holder that does not call `drive` in a step stands, so that a stale command never
///   moves the robot;
/// * a relative motion goes on by itself until it is done or blocked, until another command, or until the base is lost. It
///   is not taken up again after an override, for the robot is somewhere else by then: look at
///   [`motion_state`](Self::motion_state) and command anew;
/// * [`stop`](Self::stop) lasts until another command.
///
/// A [`limit`](Self::limit) lasts for one step and needs no transaction.
#[derive(Debug, Clone)]
pub struct BaseHandle {
    client: ClientId,
    state: BaseState,
    /// The number used last; the open transaction's if one is open.
    number: u32,
    /// A transaction is open, as far as is known here.
    open: bool,
    /// When the open transaction was first claimed.
    begun: Option<Time>,
    order: Order,
    limits: Limits,
    patience: Option<Duration>,
    on_override: OnOverride,
    overrider_motion: Motion,
    /// The relative motion ordered last, and how it stands.
    latest_motion: (u32, MotionState),
    /// Stamp of the newest answer that the state rests on.
    heard: Time,
    /// Something was asked for since the last claim that is no number.
    nonsense: bool,
}

impl BaseHandle {
    /// A handle for a client that has not asked for anything.
    #[must_use]
    pub fn new(client: ClientId) -> Self {
        Self {
            client,
            state: BaseState::Free,
            number: 0,
            open: false,
            begun: None,
            order: Order::Stand,
            limits: Limits::NONE,
            patience: None,
            on_override: OnOverride::HangOn,
            overrider_motion: Motion::STOP,
            latest_motion: (0, MotionState::Idle),
            heard: Time::START,
            nonsense: false,
        }
    }

    /// Keeps a velocity for this step. Call it in every step. One that is not finite makes the base stand, and a person is told.
    pub fn drive(&mut self, twist: Twist) {
        self.nonsense |= !twist.is_finite();
        self.order(Order::Drive { twist, fresh: true });
    }

    /// Moves straight on by `distance` m (negative: backward) at up to `speed` m/s, then rests. Numbers that are not finite
    /// make a motion that is blocked from the start.
    pub fn translate(&mut self, distance: f64, speed: f64) -> MotionId {
        self.relative(|id| Motion::translate(id, distance, speed))
    }

    /// Turns on the spot by `angle` rad (positive: left) at up to `rate` rad/s, then rests. Numbers that are not finite make a
    /// motion that is blocked from the start.
    pub fn rotate(&mut self, angle: f64, rate: f64) -> MotionId {
        self.relative(|id| Motion::rotate(id, angle, rate))
    }

    /// Takes or keeps the base, and stands.
    pub fn stop(&mut self) {
        self.order(Order::Stand);
    }

    /// Gives the base up, or no longer asks for it.
    pub fn release(&mut self) {
        self.close(BaseState::Free);
    }

    /// Caps whoever has the base, this client included, in this step. Of several calls in a step the tighter bounds count.
    pub fn limit(&mut self, limits: Limits) {
        self.nonsense |= limits.linear.is_nan() || limits.angular.is_nan();
        self.limits = self.limits.and(limits);
    }

    /// Sets how long the open transaction and later ones wait for the base, each from its first claim. Zero is one try.
    /// Without this call a client waits for as long as it takes.
    pub fn wait_at_most(&mut self, patience: Duration) {
        self.patience = Some(patience);
    }

    /// Waits for as long as it takes; takes back [`wait_at_most`](Self::wait_at_most).
    pub fn wait_forever(&mut self) {
        self.patience = None;
    }

    /// Chooses to hang on in this and later overrides; a new handle does.
    pub fn hang_on(&mut self) {
        self.on_override = OnOverride::HangOn;
    }

    /// Chooses to surrender in this and later overrides.
    pub fn surrender(&mut self) {
        self.on_override = OnOverride::Surrender;
        if let BaseState::Overridden { .. } = self.state {
            self.close(self.state);
        }
    }

    /// How the client stands, as far as it has heard.
    #[must_use]
    pub fn state(&self) -> BaseState {
        self.state
    }

    /// True if the base is this client's.
    #[must_use]
    pub fn is_holding(&self) -> bool {
        self.state == BaseState::Holding
    }

    /// What the overrider commands, while the client is overridden and hangs on.
    #[must_use]
    pub fn overrider_motion(&self) -> Motion {
        self.overrider_motion
    }

    /// How a relative motion stands. [`MotionState::Blocked`] if the base could not go on, and also if the base was lost or
    /// given other orders before the motion was done. Only the motion ordered last is remembered: others are
    /// [`MotionState::Idle`].
    #[must_use]
    pub fn motion_state(&self, id: MotionId) -> MotionState {
        if id.0 == self.latest_motion.0 { self.latest_motion.1 } else { MotionState::Idle }
    }

    /// Takes in what was published since the last call: all notices (those to others are skipped), and the newest decision
    /// and report. Samples may be missing; the newest decision sets right what a lost notice would have told.
    pub fn hear(&mut self, notices: &[BaseNotice], decision: Option<&BaseDecision>, report: Option<&MotionReport>) {
        let client = self.client;
        for notice in notices.iter().filter(|notice| notice.client == client) {
            self.hear_notice(notice);
        }
        if let Some(decision) = decision {
            self.hear_decision(decision);
        }
        if let Some(report) = report {
            self.hear_report(report);
        }
    }

    /// The claim to publish at the end of the step at `now`; it lapses after `lease`. Ends what lasts for one step.
    pub fn claim(&mut self, now: Time, lease: Duration) -> BaseClaim {
        let begun = *self.begun.get_or_insert(now);
        let claim = BaseClaim {
            client: self.client,
            transaction: if self.open { self.number } else { 0 },
            stamp: now,
            valid_until: now + lease,
            wait_until: self.patience.map_or(Time::FAR, |patience| begun + patience),
            motion: match self.order {
                Order::Relative(motion) => motion,
                Order::Drive { twist, fresh: true } => Motion::velocity(twist),
                Order::Drive { .. } | Order::Stand => Motion::STOP,
            },
            limits: self.limits,
        };
        if let Order::Drive { fresh, .. } = &mut self.order {
            *fresh = false;
        }
        self.limits = Limits::NONE;
        claim
    }

    /// True if something was asked for since the last call that is no number; it was taken for a stop.
    pub(crate) fn take_nonsense(&mut self) -> bool {
        std::mem::take(&mut self.nonsense)
    }

    fn relative(&mut self, motion: impl Fn(u32) -> Motion) -> MotionId {
        // Ids of different clients differ in the upper half, so that neither the base nor a client takes one for another's.
        let count = (self.latest_motion.0 as u16).wrapping_add(1).max(1);
        let id = u32::from(self.client.0.wrapping_add(1)) << 16 | u32::from(count);
        let motion = motion(id);
        if motion.kind() == MotionKind::Stop {
            // Not finite. The base would never report on it.
            self.nonsense = true;
            self.stop();
            self.latest_motion = (id, MotionState::Blocked);
        } else {
            self.order(Order::Relative(motion));
            self.latest_motion = (id, MotionState::Running);
        }
        MotionId(id)
    }

    fn order(&mut self, order: Order) {
        self.drop_relative();
        self.order = order;
        if !self.open {
            self.number = self.number.wrapping_add(1).max(1);
            (self.open, self.begun, self.state) = (true, None, BaseState::Waiting);
        }
    }

    /// Forgets the relative motion, if one is under way.
    fn drop_relative(&mut self) {
        if let Order::Relative(_) = self.order {
            self.order = Order::Stand;
        }
        if self.latest_motion.1 == MotionState::Running {
            self.latest_motion.1 = MotionState::Blocked;
        }
    }

    /// The transaction is over on this side.
    fn close(&mut self, state: BaseState) {
        self.drop_relative();
        (self.open, self.order, self.state) = (false, Order::Stand, state);
    }

    fn hear_notice(&mut self, notice: &BaseNotice) {
        if !self.open || notice.transaction != self.number || notice.stamp < self.heard {
            return;
        }
        self.heard = notice.stamp;
        match notice.kind() {
            NoticeKind::Granted => self.state = BaseState::Holding,
            NoticeKind::Overridden => self.be_overridden(notice.by),
            NoticeKind::OverriderMoves => {
                match self.state {
                    BaseState::Overridden { .. } => self.state = BaseState::Overridden { by: notice.by },
                    // The first word of it has been lost.
                    _ => self.be_overridden(notice.by),
                }
                self.overrider_motion = notice.motion;
            }
            NoticeKind::Busy => self.close(BaseState::Busy),
            NoticeKind::Lapsed => self.close(BaseState::Lapsed),
        }
    }

    fn hear_decision(&mut self, decision: &BaseDecision) {
        if decision.stamp < self.heard {
            return;
        }
        self.heard = decision.stamp;
        let mine = self.open && (decision.holder, decision.transaction) == (self.client, self.number);
        match (self.state, decision.holder.known()) {
            (BaseState::Waiting | BaseState::Overridden { .. }, _) if mine => self.state = BaseState::Holding,
            (BaseState::Holding, Some(by)) if !mine => self.be_overridden(by),
            (BaseState::Overridden { .. }, Some(by)) if self.open => self.state = BaseState::Overridden { by },
            _ => {}
        }
    }

    fn be_overridden(&mut self, by: ClientId) {
        let state = BaseState::Overridden { by };
        self.overrider_motion = Motion::STOP;
        match self.on_override {
            OnOverride::HangOn => {
                self.drop_relative();
                self.state = state;
            }
            OnOverride::Surrender => self.close(state),
        }
    }

    fn hear_report(&mut self, report: &MotionReport) {
        let (latest, state) = &mut self.latest_motion;
        if *latest == 0 && report.id >> 16 == u32::from(self.client.0.wrapping_add(1)) {
            // After a restart, too: an id that the base knows as done would never be executed.
            *latest = report.id;
        } else if *latest == report.id && *state == MotionState::Running {
            *state = match report.state() {
                MotionState::Idle => MotionState::Running,
                known => known,
            };
            if *state != MotionState::Running {
                // Else a base that restarts would take it for a new one.
                self.order = Order::Stand;
            }
        }
    }
}
