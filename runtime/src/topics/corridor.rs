//! Topics of corridor following.

use iceoryx2::prelude::ZeroCopySend;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Payload;
use crate::{geometry::Pose, time::Time};

/// Tells the corridor follower to go. Topic `corridor/order`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::CorridorOrder.v1")]
pub struct CorridorOrder {
    /// When the order was given.
    pub stamp: Time,
    /// Names the order; the report repeats it. A new number replaces a running order, 0 calls it off. The same number again changes
    /// nothing, so an order may be repeated until its report has come.
    pub order: u32,
}

impl Payload for CorridorOrder {
    const TOPIC: &'static str = "corridor/order";
    const QUEUE: usize = 4;
}

/// How a stretch of corridor ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Opening {
    /// Only the left side opens.
    Left,
    /// Only the right side opens.
    Right,
    /// Both sides open.
    Both,
    /// A wall ahead and walls on both sides.
    DeadEnd,
    /// The follower gave up: it lost its way or could not get the base.
    Lost,
}

impl Opening {
    /// As payloads hold it.
    pub(super) fn number(self) -> u32 {
        match self {
            Opening::Lost => 0,
            Opening::Left => 1,
            Opening::Right => 2,
            Opening::Both => 3,
            Opening::DeadEnd => 4,
        }
    }

    /// What a payload holds. A number that is not known says nothing.
    pub(super) fn numbered(number: u32) -> Self {
        match number {
            1 => Opening::Left,
            2 => Opening::Right,
            3 => Opening::Both,
            4 => Opening::DeadEnd,
            _ => Opening::Lost,
        }
    }
}

/// The corridor follower has arrived at a place, or gives up. Topic `corridor/report`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::CorridorReport.v2")]
pub struct CorridorReport {
    /// When the robot came to rest.
    pub stamp: Time,
    /// The order that this answers.
    pub order: u32,
    /// See [`CorridorReport::opening`].
    opening: u32,
    /// How often a higher priority took the base on the way: what ended the stretch may have come and may go.
    pub overrides: u32,
    /// Where the robot stands, map frame.
    pub pose: Pose,
    /// Distance between the corridor's walls as seen on the way, m; 0 if never seen.
    pub width: f64,
    /// Clear distance ahead of the robot's centre, m.
    pub ahead: f64,
    /// Length of the stretch, m.
    pub length: f64,
}

impl CorridorReport {
    /// A report with this ending.
    #[must_use]
    pub fn new(stamp: Time, order: u32, opening: Opening) -> Self {
        Self { stamp, order, opening: opening.number(), ..Self::default() }
    }

    /// How the stretch ended.
    #[must_use]
    pub fn opening(&self) -> Opening {
        Opening::numbered(self.opening)
    }
}

impl Payload for CorridorReport {
    const TOPIC: &'static str = "corridor/report";
    const QUEUE: usize = 4;
}
