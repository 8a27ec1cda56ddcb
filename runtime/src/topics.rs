//! The catalogue: every topic of a robot, its payload, its units and its limits.
//!
//! A topic carries samples of one [`Payload`] type, so the type *is* the topic: whoever reads [`SonarScan`] reads
//! `sonar/scan`. Payloads are `#[repr(C)]`, fixed in size and free of pointers, so that they can lie in shared memory as they
//! are. They hold numbers only; a reader in another process never has to trust a discriminant. The version in a payload's
//! type name changes with its layout, and links refuse to join two layouts.
//!
//! | topic | payload | writer → readers |
//! |---|---|---|
//! | `sonar/scan` | [`SonarScan`] | sonar → everyone |
//! | `sonar/claims` | [`SonarClaim`] | agents → arbitration |
//! | `sonar/decision` | [`SonarDecision`] | arbitration → sonar, agents |
//! | `base/odometry` | [`Odometry`] | base → everyone |
//! | `base/motion` | [`MotionReport`] | base → agents |
//! | `base/claims` | [`BaseClaim`] | agents → arbitration |
//! | `base/decision` | [`BaseDecision`] | arbitration → base, agents |
//! | `base/notices` | [`BaseNotice`] | arbitration → agents |
//! | `pose` | [`PoseEstimate`] | where-am-i → everyone |
//! | `corridor/order` | [`CorridorOrder`] | whoever plans → corridor follower |
//! | `corridor/report` | [`CorridorReport`] | corridor follower → whoever plans |
//! | `feature/request` | [`FeatureRequest`] | whoever names places → feature detector |
//! | `feature/report` | [`FeatureReport`] | feature detector → whoever names places |
//! | `place/order` | [`PlaceOrder`] | whoever plans → place classifier |
//! | `place/belief` | [`PlaceBelief`] | place classifier → recording, whoever watches |
//! | `place/report` | [`PlaceReport`] | place classifier → whoever plans |
//! | `places/change`, `team/places-change` | [`PlacesChange`], [`TeamPlacesChange`] | geographer → geographers of all robots |
//! | `places/whereabouts`, `team/whereabouts` | [`Whereabouts`], [`TeamWhereabouts`] | geographer → geographers of all robots |
//! | `base/line` | [`LineState`] | base at the end of a line → recording, whoever watches |
//! | `hardware/state` | [`HardwareState`] | hardware in a process of its own → mission |
//! | `hardware/pulse` | [`MissionPulse`] | mission → hardware in a process of its own |
//! | `truth` | [`Truth`] | simulated base → recording only |
//!
//! The topics of a robot are its own. What robots tell each other is a [`TeamPayload`], which everybody hears on a second topic.
//!
//! A behaviour of your own may bring payloads of its own: implement [`Payload`] and use it like these.

mod arbitration;
mod base;
mod corridor;
mod feature;
mod fixed_vec;
mod hardware;
mod label;
mod place;
mod pose;
mod sonar;
mod team;

use std::fmt::Debug;

use iceoryx2::prelude::ZeroCopySend;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

pub use arbitration::{ArbitrationRule, HeldBack};
pub use base::{BaseClaim, BaseDecision, BaseNotice, Motion, MotionKind, MotionReport, MotionState, NoticeKind, Odometry, flags};
pub use corridor::{CorridorOrder, CorridorReport, Opening};
pub use feature::{FeatureKind, FeatureOutcome, FeatureReason, FeatureReport, FeatureRequest, FeatureSearch, Side};
pub use fixed_vec::{FixedVec, MAX_TRANSDUCERS};
pub use hardware::{Fingerprint, HardwareState, LineState, MissionPulse};
pub use label::Label;
pub use place::{PlaceBelief, PlaceOrder, PlaceReport, Way};
pub use pose::{PoseEstimate, Truth};
pub use sonar::{Echo, FiringProgram, SonarClaim, SonarDecision, SonarScan};
pub use team::{NOWHERE, PlacesChange, TeamPlacesChange, TeamWhereabouts, Whereabouts};

/// A sample that a topic carries.
///
/// ```
/// use orienteer_runtime::topics::Payload;
/// use iceoryx2::prelude::ZeroCopySend;
/// use schemars::JsonSchema;
/// use serde::{Deserialize, Serialize};
///
/// /// Air temperature, °C.
/// #[derive(Debug, Clone, Copy, Default, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
/// #[repr(C)]
/// #[type_name("example::Temperature.v1")]
/// struct Temperature { celsius: f32 }
///
/// impl Payload for Temperature {
///     const TOPIC: &'static str = "example/temperature";
/// }
/// assert_eq!(Temperature::QUEUE, 8);
/// ```
pub trait Payload: ZeroCopySend + Copy + Default + Debug + Send + Serialize + DeserializeOwned + JsonSchema + 'static {
    /// The topic's name below the robot's: lower case, words joined by `-`, levels by `/`.
    const TOPIC: &'static str;
    /// How many samples wait for a reader before the oldest is overwritten. Enough for 10 ms of the fastest stream.
    const QUEUE: usize = 8;
    /// True if many nodes of a robot write this topic (claims); otherwise exactly one does.
    const MANY_WRITERS: bool = false;
}

/// What a robot tells all robots of its mission, itself included.
///
/// A node that declares [`Wiring::tells`](crate::agent::Wiring::tells) publishes it as any other sample. At the beginning of the next step every robot that
/// [hears](crate::agent::Wiring::hears) it finds it on the topic of [`Heard`](TeamPayload::Heard): in the order of the mission's robots, and of each robot
/// in the order in which it was said. A robot's words on different topics are in no order.
pub trait TeamPayload: Payload + Sync {
    /// The same, with who said it.
    type Heard: Payload;

    /// The same, as said by a robot, by its place in the mission, from 0.
    fn heard(&self, robot: u32) -> Self::Heard;
}

/// How many topics, writers and readers a robot may have. Links reserve shared memory by these numbers.
pub mod limits {
    /// Nodes (devices, agents, arbitration, recorder) of one robot; also the most writers of a shared topic.
    pub const NODES: usize = 24;
    /// Readers of one topic, those in other processes included.
    pub const READERS: usize = 24;
    /// Processes that may attach to one robot's topics at the same time.
    pub const PROCESSES: usize = 16;
}

/// A node of a robot: its place in the robot's configuration, from 0. Names are in the configuration and in the recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[serde(transparent)]
#[type_name("orienteer::ClientId.v1")]
pub struct ClientId(pub u16);

impl ClientId {
    /// Stands for "nobody".
    pub const NONE: Self = Self(u16::MAX);

    /// `None` for [`ClientId::NONE`].
    #[must_use]
    pub fn known(self) -> Option<ClientId> {
        (self != Self::NONE).then_some(self)
    }
}

impl Default for ClientId {
    fn default() -> Self {
        Self::NONE
    }
}
