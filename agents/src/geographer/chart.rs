//! What a robot knows while it explores: the map that it shares, those it shares it with, and where it stands itself.

use orienteer_runtime::{
    agent::Inputs,
    geometry::Pose,
    time::Time,
    topics::{PlacesChange, PoseEstimate, TeamPlacesChange, TeamWhereabouts, Whereabouts},
};
use petgraph::graph::NodeIndex;

use super::{
    map::{Change, TopologicalMap},
    team::{Presence, Team},
};

/// Where the robot stood at a place: one pose, in the frame of the map and in that of the odometry.
///
/// From place to place the odometry is good enough to tell in which of the four directions the robot faces and about where it is, whatever it
/// had to do on the way to let somebody pass.
#[derive(Debug, Clone, Copy)]
pub struct Fix {
    /// In the frame of the map.
    pub map: Pose,
    /// In the frame of the odometry.
    pub odometry: Pose,
}

impl Fix {
    /// A pose of the odometry's frame, in that of the map.
    pub fn in_map(&self, odometry: Pose) -> Pose {
        self.map.then(self.odometry.between(odometry))
    }
}

/// How often a robot repeats where it is, s.
const REPEATED: f64 = 0.5;

/// What a robot knows.
#[derive(Debug, Default)]
pub struct Chart {
    pub map: TopologicalMap,
    pub team: Team,
    /// What the robot says of itself.
    pub own: Presence,
    /// Where it last stood at a place that it knows.
    pub fix: Option<Fix>,
    /// Its place in the mission.
    me: u32,
    /// Others explore as well.
    has_mates: bool,
    /// How many changes it has told, and how many of them it has heard, with the place that the last one was about.
    told: u32,
    heard: (u32, Option<NodeIndex>),
    /// How many places of the map it has found.
    pub added: u32,
    /// When something was last found.
    pub changed: Time,
    /// What it last said of itself, and when.
    said: Option<(Time, Presence)>,
}

impl Chart {
    /// For the robot with this place in a mission in which so many others explore.
    pub fn new(me: u32, mates: usize) -> Self {
        Self { me, has_mates: mates > 0, team: Team::of(me), ..Self::default() }
    }

    /// Hears what the team has to say.
    pub fn hear(&mut self, now: Time, inputs: &Inputs) {
        for TeamWhereabouts { whereabouts, robot, .. } in inputs.each() {
            self.team.hear(*robot, whereabouts);
        }
        self.team.settle(now);
        for TeamPlacesChange { change, robot, .. } in inputs.each() {
            self.hear_change(now, change, *robot == self.me);
        }
        if let Some(estimate) = inputs.latest::<PoseEstimate>() {
            self.own.pose = self.in_map(estimate.pose);
        }
    }

    fn hear_change(&mut self, now: Time, told: &PlacesChange, is_own: bool) {
        let change = Change::heard(told).filter(|_| !self.own.stands_by);
        let is_place = matches!(change, Some(Change::Found(_)));
        let effect = change.and_then(|change| self.map.apply(change));
        let is_news = effect.is_some_and(|effect| effect.is_news);
        if is_news {
            self.changed = now;
        }
        if is_own {
            self.heard = (told.number, effect.and_then(|effect| effect.place));
            self.added += u32::from(is_place && is_news);
        }
    }

    /// A pose of the odometry's frame, in that of the map. Before the first place they are the same.
    pub fn in_map(&self, odometry: Pose) -> Pose {
        self.fix.map_or(odometry, |fix| fix.in_map(odometry))
    }

    /// A change as the team hears it.
    pub fn tell(&mut self, change: &Change, now: Time) -> PlacesChange {
        self.told += 1;
        change.told(now, self.told)
    }

    /// True if all that the robot has told is in the map.
    pub fn has_heard_itself(&self) -> bool {
        self.heard.0 == self.told
    }

    /// The place that the last change it has heard of itself was about.
    pub fn last_place(&self) -> Option<NodeIndex> {
        self.heard.1
    }

    /// Where the robot is, if it is time to say so.
    pub fn whereabouts(&mut self, now: Time) -> Option<Whereabouts> {
        let still = Presence { pose: Pose::default(), ..self.own };
        let is_news = self.said.is_none_or(|(when, said)| said != still || now.since(when).as_secs_f64() >= REPEATED);
        if !self.has_mates || !is_news {
            return None;
        }
        self.said = Some((now, still));
        Some(self.own.told(now))
    }

    /// The robot is at a place.
    pub fn arrive_at(&mut self, place: NodeIndex) {
        self.own = self.own.stays_at(place, self.map.place(place).map(|place| place.at));
    }

    /// True if there may be others.
    pub fn has_mates(&self) -> bool {
        self.has_mates
    }
}
