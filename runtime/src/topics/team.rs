//! Topics by which robots that explore a floor together tell each other what they find and where they go.

use iceoryx2::prelude::ZeroCopySend;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Label, Payload, TeamPayload};
use crate::{geometry::Pose, time::Time};

/// Stands for "none" where a payload of this file names a place.
pub const NOWHERE: u32 = u32::MAX;

/// A change of the map of places. Topic `places/change`.
///
/// Places are numbered in the order in which they were added, from 0; arms are quarter turns to the left of the floor's first direction, 0 to 3. Which of the fields
/// mean something depends on [`what`](Self::what).
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::PlacesChange.v1")]
pub struct PlacesChange {
    /// When it was found out.
    pub stamp: Time,
    /// Counts the changes of one robot, from 1.
    pub number: u32,
    /// 1: the floor's first direction; 2: a new place; 3: a place was come to again; 4: a corridor was gone; 5: an arm could not be gone; 6: a place is something else than it was thought to be. Anything else changes nothing.
    pub what: u32,
    /// The place that it is about.
    pub place: u32,
    /// The arm of that place.
    pub arm: u32,
    /// The place at the other end of a corridor.
    pub to: u32,
    /// The arm of that other place.
    pub to_arm: u32,
    /// In which direction the robot went that saw what a place is.
    pub seen: u32,
    /// Which arms of the place are ways: bit 0 for arm 0, and so on.
    pub ways: u32,
    /// Length of a corridor, m.
    pub length: f64,
    /// The floor's first direction, map frame, rad.
    pub heading: f64,
    /// A place's middle, map frame, m.
    pub at: [f64; 2],
    /// Covariance of `at`: xx, xy, yy, m².
    pub covariance: [f64; 3],
    /// How probable it is that the place is what it is named.
    pub belief: f64,
    /// What the place is, by its name in the catalogue.
    pub kind: Label,
    /// The same for people.
    pub title: Label,
}

impl Payload for PlacesChange {
    const TOPIC: &'static str = "places/change";
    const QUEUE: usize = 4;
}

impl TeamPayload for PlacesChange {
    type Heard = TeamPlacesChange;

    fn heard(&self, robot: u32) -> Self::Heard {
        TeamPlacesChange { change: *self, robot, reserved: 0 }
    }
}

/// A change of the map of places that a robot of the team has told. Topic `team/places-change`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::TeamPlacesChange.v1")]
pub struct TeamPlacesChange {
    /// The change.
    pub change: PlacesChange,
    /// Who told it, by its place in the mission, from 0.
    pub robot: u32,
    reserved: u32,
}

impl Payload for TeamPlacesChange {
    const TOPIC: &'static str = "team/places-change";
    const QUEUE: usize = 64;
}

/// Where a robot is and goes, for those who explore the same floor. Topic `places/whereabouts`; repeated, so that nobody need remember who has gone.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::Whereabouts.v1")]
pub struct Whereabouts {
    /// When that was.
    pub stamp: Time,
    /// Since when it goes, or wants to go, the way that it names.
    pub since: Time,
    /// Where it is, map frame.
    pub pose: Pose,
    /// Middle of the place that it keeps others from, map frame, m.
    pub spot: [f64; 2],
    /// 1 if there is such a spot.
    pub has_spot: u32,
    /// The place that it keeps others from, by its number; [`NOWHERE`] if it keeps none, or one that has no number yet.
    pub at: u32,
    /// The place from which it goes into a corridor, and by which arm; [`NOWHERE`] if it goes into none.
    pub way: [u32; 2],
    /// The place and arm that it goes to explore; [`NOWHERE`] if there is none.
    pub goal: [u32; 2],
    /// The robot that is in its way, by its place in the mission; [`NOWHERE`] if none is.
    pub held_up_by: u32,
    /// Bit 0: it has found nothing more to explore. Bit 1: every way that it knows out of its place is somebody else's.
    pub state: u32,
}

impl Default for Whereabouts {
    fn default() -> Self {
        Self {
            stamp: Time::START,
            since: Time::START,
            pose: Pose::default(),
            spot: [0.0; 2],
            has_spot: 0,
            at: NOWHERE,
            way: [NOWHERE; 2],
            goal: [NOWHERE; 2],
            held_up_by: NOWHERE,
            state: 0,
        }
    }
}

impl Payload for Whereabouts {
    const TOPIC: &'static str = "places/whereabouts";
    const QUEUE: usize = 4;
}

impl TeamPayload for Whereabouts {
    type Heard = TeamWhereabouts;

    fn heard(&self, robot: u32) -> Self::Heard {
        TeamWhereabouts { whereabouts: *self, robot, reserved: 0 }
    }
}

/// Where a robot of the team is and goes. Topic `team/whereabouts`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::TeamWhereabouts.v1")]
pub struct TeamWhereabouts {
    /// What it told.
    pub whereabouts: Whereabouts,
    /// Who told it, by its place in the mission, from 0.
    pub robot: u32,
    reserved: u32,
}

impl Payload for TeamWhereabouts {
    const TOPIC: &'static str = "team/whereabouts";
    const QUEUE: usize = 64;
}
