//! Hardware in a process of its own, joined to its mission over shared memory.
//!
//! ```text
//!  mission's process                                     hardware's process
//!  ┌────────────┐ ◀── odometry, motion, truth, state ─── ┌──────────┐
//!  │ RemoteBase │ ─── base/decision, pulse ────────────▶ │ BaseNode │ ◀─▶ driver
//!  │ RemoteSonar│ ◀── sonar/scan ─────────────────────── │ SonarNode│ ◀─▶ driver
//!  └────────────┘ ─── sonar/decision ──────────────────▶ │ Presence │
//!                                                        └──────────┘
//! ```
//!
//! The hardware owns a public run under the name that [`run_of`] gives it, and the very nodes run in it that would run in the mission:
//! executor, protection and guard sit beside the driver. In the mission two nodes stand in for them, attach to that run as soon as it
//! is there, and again when it has come back; they work with none that was started with [another configuration](fingerprint()). Either side may start first, stop, or die; the base stands when it hears of no decision.
//!
//! Each side has a time of its own. What crosses the border is turned into the receiver's, by when either time began on the clock that
//! all processes of a machine share.

mod attachment;
mod base;
mod fingerprint;
mod presence;
mod sonar;

use orienteer_runtime::{
    clock::Epoch,
    topics::{
        BaseDecision, Fingerprint, HardwareState, LineState, MissionPulse, MotionReport, Odometry, SonarDecision, SonarScan,
        Truth,
    },
};

pub use base::RemoteBase;
pub use fingerprint::fingerprint;
pub use presence::Presence;
pub use sonar::RemoteSonar;

/// The name of the public run that a robot's hardware owns. Two missions of one name, and robots of one name in them, would meet.
#[must_use]
pub fn run_of(mission: &str, robot: &str) -> String {
    format!("{mission}.{robot}")
}

/// Hardware in another process, as a mission knows it.
#[derive(Debug, Clone)]
pub struct RemoteHardware {
    /// The run that it owns; see [`run_of`].
    pub run: String,
    /// The robot's name.
    pub robot: String,
    /// When the mission's own time began.
    pub epoch: Epoch,
    /// What its configuration must be like; see [`fingerprint`](fingerprint()).
    pub fingerprint: Fingerprint,
    /// Its base is at the end of a line; see [`BaseKind::HAS_LINE`](crate::drivers::BaseKind::HAS_LINE).
    pub has_line: bool,
}

/// A sample with times in it.
trait Stamped: Copy {
    /// The same for somebody whose time began so many nanoseconds earlier.
    fn shifted(self, earlier: i64) -> Self;
}

macro_rules! stamped {
    ($($sample:ty: $($time:ident),+;)+) => {
        $(impl Stamped for $sample {
            fn shifted(mut self, earlier: i64) -> Self {
                $(self.$time = self.$time.shifted(earlier);)+
                self
            }
        })+
    };
}

stamped! {
    Odometry: stamp;
    MotionReport: stamp;
    Truth: stamp;
    LineState: stamp;
    HardwareState: stamp;
    SonarScan: stamp;
    BaseDecision: stamp, valid_until, since;
    SonarDecision: stamp, since;
    MissionPulse: stamp;
}
