//! What a robot says of itself to those who explore with it.

use nalgebra::Point2;
use orienteer_runtime::{
    geometry::Pose,
    time::Time,
    topics::{NOWHERE, Whereabouts},
};
use petgraph::graph::NodeIndex;

use crate::geographer::{compass::Quarter, map::Exit};

/// Bits of [`Whereabouts::state`].
const IDLE: u32 = 1;
const SHUT_IN: u32 = 2;
const STANDS_BY: u32 = 4;

/// Where a robot is among the places, and where it goes. It comes as [`Whereabouts`].
///
/// | the robot | `at` | `spot` | `way` | `goal` |
/// |---|---|---|---|---|
/// | is [astray](Self::astray), or has been nowhere yet | | | | |
/// | is [at](Self::stays_at) a place | that place | its middle | | |
/// | [wants](Self::wants) to leave it, or is on its way | still that place | its middle | where it leaves it | the arm that it goes to explore; none if it makes way |
/// | has [come](Self::comes_to) to a place without a name | | its middle | as before | |
/// | [goes on](Self::passes), as there was none | | | as before | |
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Presence {
    /// Since when it goes, or wants to go, `way`.
    pub since: Time,
    /// Where it is, map frame.
    pub pose: Pose,
    /// Middle of the place that it keeps others from, map frame, m.
    pub spot: Option<Point2<f64>>,
    /// That place, if it has a name.
    pub at: Option<NodeIndex>,
    /// The corridor that it is in, or wants to go into.
    pub way: Option<Exit>,
    /// What it goes to explore.
    pub goal: Option<Exit>,
    /// The robot that is in its way.
    pub held_up_by: Option<u32>,
    /// It has found nothing more to explore.
    pub is_idle: bool,
    /// It can't make way: every way that it knows is somebody else's, or it is in a corridor and its place is taken.
    pub is_shut_in: bool,
    /// It explores no more, and stays where it is.
    pub stands_by: bool,
}

impl Presence {
    /// Of a robot that does not know where it is.
    #[must_use]
    pub fn astray(self) -> Self {
        Self { pose: self.pose, stands_by: self.stands_by, ..Self::default() }
    }

    /// Of a robot that explores no more, for good.
    #[must_use]
    pub fn standing_by(self) -> Self {
        Self { stands_by: true, ..self.astray() }
    }

    /// Of a robot at a place, with the place's middle.
    #[must_use]
    pub fn stays_at(self, place: NodeIndex, spot: Option<Point2<f64>>) -> Self {
        Self { at: Some(place), spot, ..self.astray() }
    }

    /// Of a robot that wants to go this way from now on.
    #[must_use]
    pub fn wants(self, way: Exit, goal: Option<Exit>, since: Time) -> Self {
        Self { way: Some(way), goal, since, held_up_by: None, is_idle: false, is_shut_in: false, ..self }
    }

    /// Of a robot that wants to go nowhere any more.
    #[must_use]
    pub fn lets_go(self) -> Self {
        Self { way: None, goal: None, ..self }
    }

    /// Of a robot that has come to a place without a name. It still keeps others from the corridor that it came by.
    #[must_use]
    pub fn comes_to(self, spot: Point2<f64>) -> Self {
        Self { at: None, spot: Some(spot), goal: None, ..self }
    }

    /// Of a robot that came to a place which turned out to be none.
    #[must_use]
    pub fn passes(self) -> Self {
        Self { at: None, spot: None, ..self }
    }

    /// As others hear it.
    #[must_use]
    pub fn told(&self, stamp: Time) -> Whereabouts {
        let place = |place: NodeIndex| place.index() as u32;
        let exit = |exit: Option<Exit>| exit.map_or([NOWHERE; 2], |(at, arm)| [place(at), arm.index() as u32]);
        let states = [(self.is_idle, IDLE), (self.is_shut_in, SHUT_IN), (self.stands_by, STANDS_BY)];
        Whereabouts {
            stamp,
            since: self.since,
            pose: self.pose,
            spot: self.spot.unwrap_or_default().into(),
            has_spot: u32::from(self.spot.is_some()),
            at: self.at.map_or(NOWHERE, place),
            way: exit(self.way),
            goal: exit(self.goal),
            held_up_by: self.held_up_by.unwrap_or(NOWHERE),
            state: states.into_iter().filter(|(is_set, _)| *is_set).map(|(_, bit)| bit).sum(),
        }
    }

    /// What was heard.
    #[must_use]
    pub fn heard(told: &Whereabouts) -> Self {
        let known = |number: u32| (number != NOWHERE).then_some(number);
        let place = |number: u32| known(number).map(|number| NodeIndex::new(number as usize));
        let exit = |[at, arm]: [u32; 2]| Some((place(at)?, *Quarter::ALL.get(arm as usize)?));
        let is = |bit: u32| told.state & bit != 0;
        Self {
            since: told.since,
            pose: told.pose,
            spot: (told.has_spot == 1).then(|| Point2::from(told.spot)),
            at: place(told.at),
            way: exit(told.way),
            goal: exit(told.goal),
            held_up_by: known(told.held_up_by),
            is_idle: is(IDLE),
            is_shut_in: is(SHUT_IN),
            stands_by: is(STANDS_BY),
        }
    }
}
