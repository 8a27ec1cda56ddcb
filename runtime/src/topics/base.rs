//! Topics of the base: odometry, claims, decisions, notices, reports.

use iceoryx2::prelude::ZeroCopySend;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{ArbitrationRule, ClientId, FixedVec, HeldBack, Payload};
use crate::{
    geometry::{Limits, Pose, Twist},
    time::Time,
};

/// Bits of [`Odometry::flags`].
pub mod flags {
    /// The motors are powered and obey.
    pub const ENABLED: u32 = 1;
    /// The wheels are blocked.
    pub const STALLED: u32 = 1 << 1;
    /// The body touches something.
    pub const CONTACT: u32 = 1 << 2;
    /// An emergency stop is pressed.
    pub const EMERGENCY_STOP: u32 = 1 << 3;
    /// The base's own protection holds or slows it: stale command, stale sonar, lost link, too little free distance.
    pub const PROTECTED: u32 = 1 << 4;
    /// Beside [`CONTACT`]: what it touches is ahead, less than a right angle from its heading, as a bumper there says.
    pub const CONTACT_AHEAD: u32 = 1 << 5;
    /// Beside [`CONTACT`]: what it touches is behind.
    pub const CONTACT_BEHIND: u32 = 1 << 6;
}

/// What the base knows of its own motion. Topic `base/odometry`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::Odometry.v1")]
pub struct Odometry {
    /// When the encoders were read.
    pub stamp: Time,
    /// Dead-reckoned pose since the driver started, odometry frame.
    pub pose: Pose,
    /// Measured velocity.
    pub twist: Twist,
    /// Sum of all distances driven, forward and backward, m.
    pub travelled: f64,
    /// Sum of all turns, signed, not wrapped, rad.
    pub turned: f64,
    /// Battery, volts; 0 if unknown.
    pub battery: f32,
    /// See [`flags`].
    pub flags: u32,
}

impl Payload for Odometry {
    const TOPIC: &'static str = "base/odometry";
}

/// What the base is to do, in a form that every reader can trust.
///
/// Made by its constructors, read by [`Motion::kind`]. A motion that holds anything but finite numbers reads as
/// [`MotionKind::Stop`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::Motion.v1")]
pub struct Motion {
    code: u32,
    /// Names a relative motion, so that its report can be told from that of an older one; 0 for others.
    pub id: u32,
    first: f64,
    second: f64,
}

/// The meaning of a [`Motion`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MotionKind {
    /// Come to rest as fast as the platform comfortably can.
    Stop,
    /// Keep this velocity.
    Velocity(Twist),
    /// Drive straight on, `distance` metres (negative: backward) at up to `speed` m/s, then rest.
    Translate {
        /// Metres, signed.
        distance: f64,
        /// m/s, positive.
        speed: f64,
    },
    /// Turn on the spot by `angle` rad (positive: left) at up to `rate` rad/s, then rest.
    Rotate {
        /// Radians, signed, not wrapped.
        angle: f64,
        /// rad/s, positive.
        rate: f64,
    },
}

impl Motion {
    /// Come to rest.
    pub const STOP: Self = Self { code: 0, id: 0, first: 0.0, second: 0.0 };

    /// Keep a velocity.
    #[must_use]
    pub const fn velocity(twist: Twist) -> Self {
        Self { code: 1, id: 0, first: twist.linear, second: twist.angular }
    }

    /// A straight move of `distance` m (signed) at up to `speed` m/s. `id` comes back in the [`MotionReport`].
    #[must_use]
    pub const fn translate(id: u32, distance: f64, speed: f64) -> Self {
        Self { code: 2, id, first: distance, second: speed }
    }

    /// A turn of `angle` rad (signed) at up to `rate` rad/s. `id` comes back in the [`MotionReport`].
    #[must_use]
    pub const fn rotate(id: u32, angle: f64, rate: f64) -> Self {
        Self { code: 3, id, first: angle, second: rate }
    }

    /// What it means.
    #[must_use]
    pub fn kind(&self) -> MotionKind {
        if !(self.first.is_finite() && self.second.is_finite()) {
            return MotionKind::Stop;
        }
        match self.code {
            1 => MotionKind::Velocity(Twist::new(self.first, self.second)),
            2 => MotionKind::Translate { distance: self.first, speed: self.second.abs() },
            3 => MotionKind::Rotate { angle: self.first, rate: self.second.abs() },
            _ => MotionKind::Stop,
        }
    }

    /// The same motion, no faster than the limits allow. A velocity keeps the shape of its path, see [`Twist::within`]; a
    /// relative motion keeps its extent. Whatever reads as [`MotionKind::Stop`] becomes [`Motion::STOP`].
    #[must_use]
    pub fn within(&self, limits: Limits) -> Motion {
        let Limits { linear, angular } = Limits::NONE.and(limits);
        match self.kind() {
            MotionKind::Stop => Self::STOP,
            MotionKind::Velocity(twist) => {
                let twist = twist.within(Limits { linear, angular });
                // Scaling rounds; the clamp takes away the last bit by which it may end up above the limit.
                Self::velocity(Twist::new(twist.linear.clamp(-linear, linear), twist.angular.clamp(-angular, angular)))
            }
            MotionKind::Translate { distance, speed } => Self::translate(self.id, distance, speed.min(linear)),
            MotionKind::Rotate { angle, rate } => Self::rotate(self.id, angle, rate.min(angular)),
        }
    }
}

/// How a relative motion stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionState {
    /// No relative motion has been asked for.
    Idle,
    /// On its way.
    Running,
    /// Complete and at rest.
    Done,
    /// Given up: the base could not go on (contact, stall, no free distance for long).
    Blocked,
}

/// How the base's current relative motion stands. Topic `base/motion`, once a step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::MotionReport.v1")]
pub struct MotionReport {
    /// When this was true.
    pub stamp: Time,
    /// [`Motion::id`] of the motion meant; 0 if none.
    pub id: u32,
    state: u32,
    /// How far it has come: m for a translation, rad for a rotation, signed.
    pub progress: f64,
}

impl MotionReport {
    /// A report on motion `id`.
    #[must_use]
    pub fn new(stamp: Time, id: u32, state: MotionState, progress: f64) -> Self {
        let state = match state {
            MotionState::Idle => 0,
            MotionState::Running => 1,
            MotionState::Done => 2,
            MotionState::Blocked => 3,
        };
        Self { stamp, id, state, progress }
    }

    /// How the motion stands; anything unknown reads as [`MotionState::Blocked`].
    #[must_use]
    pub fn state(&self) -> MotionState {
        match self.state {
            0 => MotionState::Idle,
            1 => MotionState::Running,
            2 => MotionState::Done,
            _ => MotionState::Blocked,
        }
    }
}

impl Payload for MotionReport {
    const TOPIC: &'static str = "base/motion";
}

/// What one client wants of the base, whole, renewed in every step. Topic `base/claims`.
///
/// Claims are states, not events: a lost sample costs nothing, and silence is release. A transaction takes the base, a limit
/// caps whoever has it. To begin a transaction, count `transaction` up; to end it, send 0. Going on to send the number of a
/// transaction that was overridden means to hang on; sending 0 or a new number means to surrender. A transaction that ended
/// as busy or lapsed stays over, however often its number is sent: a new one needs another number.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::BaseClaim.v1")]
pub struct BaseClaim {
    /// Who claims.
    pub client: ClientId,
    /// Number of the transaction; 0 if the client does not want the base.
    pub transaction: u32,
    /// When the claim was made.
    pub stamp: Time,
    /// The whole claim lapses at this time unless renewed.
    pub valid_until: Time,
    /// The transaction fails as busy at the first decision at or after this time that does not grant it. A transaction that
    /// was granted and overridden has done its waiting: it hangs on for as long as it likes.
    pub wait_until: Time,
    /// What to do once the base is held.
    pub motion: Motion,
    /// Caps on whoever holds the base; [`Limits::NONE`] for none.
    pub limits: Limits,
}

impl Payload for BaseClaim {
    const TOPIC: &'static str = "base/claims";
    const QUEUE: usize = 4;
    const MANY_WRITERS: bool = true;
}

/// What happened to a client's transaction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NoticeKind {
    /// The base is now yours, or yours again.
    Granted,
    /// A higher priority took the base. Told exactly once for each time it happens.
    Overridden,
    /// You hang on: this is a motion that the overriding client commands. Told when it takes over and at each change.
    OverriderMoves,
    /// The base was not free in time; the transaction is over. Told again in answer to every claim that still names it.
    Busy,
    /// The claim was not renewed in time; the transaction is over. Told again in answer to every claim that still names it.
    Lapsed,
}

/// Tells one client what happened to its transaction. Topic `base/notices`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::BaseNotice.v1")]
pub struct BaseNotice {
    /// When it happened.
    pub stamp: Time,
    /// Who is told.
    pub client: ClientId,
    /// Who caused it; nobody where that makes no sense.
    pub by: ClientId,
    code: u32,
    /// The client's transaction.
    pub transaction: u32,
    /// The overrider's motion, for [`NoticeKind::OverriderMoves`].
    pub motion: Motion,
}

impl BaseNotice {
    /// A notice to `client` about its `transaction`.
    #[must_use]
    pub fn new(stamp: Time, client: ClientId, transaction: u32, kind: NoticeKind, by: ClientId) -> Self {
        let code = match kind {
            NoticeKind::Granted => 1,
            NoticeKind::Overridden => 2,
            NoticeKind::OverriderMoves => 3,
            NoticeKind::Busy => 4,
            NoticeKind::Lapsed => 5,
        };
        Self { stamp, client, by, code, transaction, motion: Motion::STOP }
    }

    /// What happened; an unknown code reads as [`NoticeKind::Lapsed`].
    #[must_use]
    pub fn kind(&self) -> NoticeKind {
        match self.code {
            1 => NoticeKind::Granted,
            2 => NoticeKind::Overridden,
            3 => NoticeKind::OverriderMoves,
            4 => NoticeKind::Busy,
            _ => NoticeKind::Lapsed,
        }
    }
}

impl Payload for BaseNotice {
    const TOPIC: &'static str = "base/notices";
    const QUEUE: usize = 32;
}

/// Who has the base, what it shall do, and why. Topic `base/decision`, once a step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::BaseDecision.v1")]
pub struct BaseDecision {
    /// When it was decided.
    pub stamp: Time,
    /// The base must be at rest from this time on unless a newer decision has come.
    pub valid_until: Time,
    /// Who has the base.
    pub holder: ClientId,
    /// Who sets the lowest speed limit; nobody if none is set.
    pub limited_by: ClientId,
    /// Who sets the lowest limit of the turn rate; nobody if none is set.
    pub turn_limited_by: ClientId,
    rule: u16,
    /// The holder's transaction.
    pub transaction: u32,
    /// Since when the holder has had the base without a break; the stamp if nobody has it.
    pub since: Time,
    /// What the holder wants done.
    pub motion: Motion,
    /// The caps of all clients together.
    pub limits: Limits,
    held_back: FixedVec<HeldBack>,
}

impl BaseDecision {
    /// Sets why the holder has the base.
    #[must_use]
    pub fn because(mut self, rule: ArbitrationRule) -> Self {
        self.rule = rule.code();
        self
    }

    /// Why the holder has the base.
    #[must_use]
    pub fn rule(&self) -> ArbitrationRule {
        ArbitrationRule::from_code(self.rule)
    }

    /// Names one more client that is held back; there is room for every node of a robot.
    pub fn hold_back(&mut self, entry: HeldBack) {
        self.held_back.push(entry);
    }

    /// Who is held back and why, first in line first: by priority, then by order of arrival.
    #[must_use]
    pub fn held_back(&self) -> &[HeldBack] {
        &self.held_back
    }

    /// What the base is to do: the holder's motion within everybody's limits.
    #[must_use]
    pub fn limited_motion(&self) -> Motion {
        self.motion.within(self.limits)
    }
}

impl Payload for BaseDecision {
    const TOPIC: &'static str = "base/decision";
    const QUEUE: usize = 4;
}
