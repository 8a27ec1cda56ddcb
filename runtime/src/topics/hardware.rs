//! Topics between a mission and a robot's hardware in a process of its own.

use iceoryx2::prelude::ZeroCopySend;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Payload;
use crate::time::Time;

/// The hardware's side: it lives, and how well it hears the mission. Topic `hardware/state`, once a control period.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::HardwareState.v1")]
pub struct HardwareState {
    /// When this was true.
    pub stamp: Time,
    /// The machine's monotonic clock when the hardware's time began, ns: what turns its times into others'.
    pub epoch: u64,
    /// Counts these samples, from 1.
    pub seq: u64,
    /// Age of the newest word from the mission, s; negative if there was none.
    pub age: f64,
    /// From a sample of this topic to the first word from the mission that knew of it, s; negative before the first.
    pub round_trip: f64,
    /// Words from the mission that have come.
    pub heard: u64,
    /// Words from the mission that were sent and have not come.
    pub lost: u64,
}

impl Payload for HardwareState {
    const TOPIC: &'static str = "hardware/state";
}

/// The mission's side: a word that it lives. Topic `hardware/pulse`, once a control period, in the hardware's time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::MissionPulse.v1")]
pub struct MissionPulse {
    /// When it was sent.
    pub stamp: Time,
    /// Counts these samples, from 1 each time that the mission has found the hardware anew.
    pub seq: u64,
    /// The newest [`HardwareState::seq`] that the mission knows.
    pub echo: u64,
}

impl Payload for MissionPulse {
    const TOPIC: &'static str = "hardware/pulse";
}
