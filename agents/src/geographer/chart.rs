//! What a robot knows while it explores: the map that it shares, those it shares it with, and where it stands itself.

use nalgebra::Point2;
use orienteer_runtime::{
    agent::Inputs,
    geometry::Pose,
    time::Time,
    topics::{PlacesChange, PoseEstimate, TeamPlacesChange, TeamWhereabouts, Whereabouts},
};
use petgraph::graph::NodeIndex;

use super::{
    map::{Change, TopologicalMap},
    team::{Sign, Team},
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
    pub own: Sign,
    /// Where it last stood at a place that it knows.
    pub fix: Option<Fix>,
    /// Its place in the mission.
    me: u32,
    /// There are other robots.
    has_mates: bool,
    /// How many changes it has told, and how many of them it has heard, with the place that the last one was about.
    told: u32,
    heard: (u32, Option<NodeIndex>),
    /// How many places of the map it has found.
    pub added: u32,
    /// It has no part in the team's map.
    stands_by: bool,
    /// When the map last changed.
    pub changed: Time,
    /// What it last said of itself, and when.
    said: Option<(Time, Sign)>,
}

impl Chart {
    /// For the robot with this place in a mission of so many.
    pub fn new(me: u32, robots: usize) -> Self {
        Self { me, has_mates: robots > 1, team: Team::of(me), ..Self::default() }
    }

    /// Hears what the team has to say.
    pub fn hear(&mut self, now: Time, inputs: &Inputs) {
        for TeamWhereabouts { whereabouts, robot, .. } in inputs.each() {
            self.team.hear(*robot, whereabouts);
        }
        self.team.settle(now);
        for TeamPlacesChange { change, robot, .. } in inputs.each() {
            let number = change.number;
            self.changed = now;
            let change = Change::heard(change).filter(|_| !self.stands_by);
            let place = change.and_then(|change| self.map.apply(change));
            if *robot == self.me {
                self.heard = (number, place);
            }
        }
        if let Some(estimate) = inputs.latest::<PoseEstimate>() {
            self.own.pose = self.in_map(estimate.pose);
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

    /// True if all that the robot has told is in the map; the place that the last change was about.
    pub fn is_up_to_date(&self) -> Option<Option<NodeIndex>> {
        (self.heard.0 == self.told).then_some(self.heard.1)
    }

    /// Where the robot is, if it is time to say so.
    pub fn whereabouts(&mut self, now: Time) -> Option<Whereabouts> {
        let still = Sign { pose: Pose::default(), ..self.own };
        let is_news = self.said.is_none_or(|(when, sign)| sign != still || now.since(when).as_secs_f64() >= REPEATED);
        if !self.has_mates || !is_news {
            return None;
        }
        self.said = Some((now, still));
        Some(self.own.told(now))
    }

    /// The robot is at a place.
    pub fn arrive_at(&mut self, place: NodeIndex) {
        let spot = self.map.place(place).map(|place| place.at);
        self.own = Sign { at: Some(place), spot, pose: self.own.pose, ..Sign::default() };
    }

    /// The robot has come to a place that has no name yet. It still keeps others from the corridor that it came by.
    pub fn arrive_at_new(&mut self, spot: Point2<f64>) {
        self.own = Sign { at: None, spot: Some(spot), goal: None, ..self.own };
    }

    /// The robot does not know where it is.
    pub fn go_astray(&mut self) {
        self.own = Sign { pose: self.own.pose, ..Sign::default() };
    }

    /// The robot has no part in the team's map, and is in nobody's way for long.
    pub fn stand_by(&mut self) {
        (self.stands_by, self.own.is_idle) = (true, true);
    }

    /// True if it has no part in the team's map.
    pub fn stands_by(&self) -> bool {
        self.stands_by
    }

    /// True if there may be others.
    pub fn has_mates(&self) -> bool {
        self.has_mates
    }
}
