//! Topics of lines: to a robot's base, and between a mission and hardware in a process of its own.

use iceoryx2::prelude::ZeroCopySend;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Payload;
use crate::time::Time;

/// The hardware's side: it lives, and how well it hears the mission. Topic `hardware/state`, once a control period.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::HardwareState.v3")]
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
    /// Steps in which the mission answered what had been sensed before the base acted.
    pub answered: u64,
    /// Of the configuration that the hardware was started with.
    pub fingerprint: Fingerprint,
}

impl Payload for HardwareState {
    const TOPIC: &'static str = "hardware/state";
}

/// What tells one robot's configuration from another's, so that a mission does not reckon with a body that is not there.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::Fingerprint.v2")]
pub struct Fingerprint {
    /// The control period, ns.
    pub period: u64,
    /// Checksum of the body: its size, its limits, its accelerations.
    pub platform: u32,
    /// Checksum of the sonar ring.
    pub ring: u32,
    /// Checksum of the base's driver, by its name.
    pub driver: u32,
    /// Checksum of how the base carries out relative motions.
    pub motion: u32,
    /// Checksum of how the base protects itself.
    pub protection: u32,
    /// Always 0, so that no byte is without a meaning.
    pub reserved: u32,
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

/// How well the line to a base carries. Topic `base/line`, once a control period, of drivers that have a line.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::LineState.v2")]
pub struct LineState {
    /// When this was true.
    pub stamp: Time,
    /// Since the last whole packet, s; negative before the first.
    pub age: f64,
    /// How often the line was opened.
    pub opened: u64,
    /// Whole packets that came.
    pub packets: u64,
    /// Those of them that told the driver nothing.
    pub unknown: u64,
    /// What began like a packet and had a wrong checksum or a length that can't be.
    pub broken: u64,
    /// Bytes that belonged to no packet.
    pub noise: u64,
}

impl Payload for LineState {
    const TOPIC: &'static str = "base/line";
}
