//! Geographer: explores a floor place by place and draws its map (Randazza 1989, §1.2; Kuipers & Byun 1988).
//!
//! The robot follows a corridor to the next place, has it named, chooses the nearest way that nobody has gone yet, and leaves. It recognises places that it has
//! been to, so loops close; it is done when no way is left. What it knows it leaves as a graph: `places.json`, and `places.dot` for GraphViz.
//!
//! * [`Compass`], [`Quarter`]: corridors meet at right angles;
//! * [`TopologicalMap`]: places and corridors;
//! * [`Team`], [`Presence`]: the others, if several robots of a mission explore, and who of them has the right of way;
//! * `tour`: what the robot does;
//! * [`export`]: the map as files.
//!
//! Reckoning is by the map and not by the odometry alone: a corridor is straight, so a place lies as far along it as the robot has driven, whatever the wheels
//! say of its heading.

mod chart;
mod compass;
pub mod export;
mod map;
mod team;
#[cfg(test)]
mod tests;
mod tour;

use std::{cell::RefCell, rc::Rc, time::Duration};

use orienteer_runtime::{
    agent::{Agent, Behaviour, BuildError, Finish, Inputs, Level, Outputs, RobotContext, Script, Wiring},
    time::Time,
    topics::{CorridorOrder, CorridorReport, PlaceOrder, PlaceReport, PlacesChange, PoseEstimate, Whereabouts},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::crumbs::Crumbs;
use chart::Chart;
pub use compass::{Compass, Quarter};
pub use map::{Arm, Change, Corridor, Effect, Exit, Place, Route, TopologicalMap};
pub use team::{Presence, Team};
use tour::Tour;

/// Parameters of the geographer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GeographerConfig {
    /// Speed across a place, m/s.
    #[schemars(range(min = 0.02, max = 2.0))]
    pub speed: f64,
    /// Turn rate, rad/s.
    #[schemars(range(min = 0.05, max = 3.0))]
    pub turn_rate: f64,
    /// Width of corridors where the follower could not see it, m.
    #[schemars(range(min = 0.5, max = 5.0))]
    pub width: f64,
    /// End the mission when all is explored.
    pub finish: bool,
}

impl Default for GeographerConfig {
    fn default() -> Self {
        Self { speed: 0.2, turn_rate: 0.6, width: 1.12, finish: true }
    }
}

/// Within this time everybody who explores has said where they are.
const HEARD_OF_ALL: Duration = Duration::from_secs(5);

/// The agent.
#[derive(Debug)]
pub struct Geographer {
    config: GeographerConfig,
    script: Script,
    chart: Rc<RefCell<Chart>>,
    /// When nothing was left to explore.
    done: Option<Time>,
    /// When its first step was.
    began: Option<Time>,
    period: Duration,
}

impl Behaviour for Geographer {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        if self.began.is_none() {
            self.begin(now, out);
        }
        self.chart.borrow_mut().hear(now, inputs);
        if self.script.step(now, inputs, out).is_some() {
            self.end(now, out);
        }
        if self.is_through(now) && self.config.finish {
            out.end_mission();
        }
        if let Some(whereabouts) = self.chart.borrow_mut().whereabouts(now) {
            out.publish(whereabouts);
        }
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        let chart = self.chart.borrow();
        // Its map is not that of the others.
        if chart.own.stands_by && chart.has_mates() {
            return;
        }
        let map = &chart.map;
        last_words.fact("places_found", map.places().len() as f64);
        last_words.fact("corridors_found", map.corridors().count() as f64);
        last_words.fact("places_added", f64::from(chart.added));
        last_words.fact("ways_left", map.unexplored() as f64);
        if let Some(done) = self.done {
            last_words.fact("explored_s", done.as_secs_f64());
        }
        if chart.team.speaks_for_all() {
            export::lines(map).into_iter().for_each(|line| last_words.note(line));
        }
        match export::json(map) {
            Ok(json) => last_words.file("places.json", json.into_bytes()),
            Err(error) => last_words.failure(format!("the map of places can't be written: {error}")),
        }
        last_words.file("places.dot", export::dot(map).into_bytes());
    }
}

impl Geographer {
    /// Whoever was built anew has not heard what the others have found, so places have other numbers for it. It stands by and lets them go on.
    fn begin(&mut self, now: Time, out: &mut Outputs) {
        self.began = Some(now);
        let mut chart = self.chart.borrow_mut();
        if chart.has_mates() && now.since(Time::START) > 3 * self.period {
            chart.own = chart.own.standing_by();
            out.log(Level::WARN, "does not know what the others have found before; stands by while they explore");
        }
    }

    /// The tour is over.
    fn end(&mut self, now: Time, out: &mut Outputs) {
        self.done = Some(now);
        let chart = self.chart.borrow();
        let map = &chart.map;
        if !chart.own.stands_by {
            let what = if map.unexplored() == 0 { "all is explored" } else { "what can be reached is explored" };
            out.announce(format!("{what}: {} places, {} corridors", map.places().len(), map.corridors().count()));
        } else if !chart.has_heard_itself() {
            out.log(Level::WARN, "does not hear itself, so its map may not be that of the others; stands by while they explore");
        }
    }

    /// True if neither this robot nor any other has anything left to explore. Who stands by has to hear of the others first.
    fn is_through(&self, now: Time) -> bool {
        let chart = self.chart.borrow();
        let has_heard = self.began.is_some_and(|began| now.since(began) > HEARD_OF_ALL);
        self.done.is_some() && (!chart.own.stands_by || (has_heard && chart.team.is_through()))
    }
}

impl Agent for Geographer {
    const KIND: &'static str = "geographer";
    const HELP: &'static str = "explores a floor place by place until nothing is left, and draws its map";
    const PRIORITY: u8 = 4;
    type Config = GeographerConfig;

    fn topics(wiring: &mut Wiring) {
        wiring.reads::<PoseEstimate>().reads::<CorridorReport>().reads::<PlaceReport>();
        wiring.writes::<CorridorOrder>().writes::<PlaceOrder>();
        wiring.tells::<PlacesChange>().hears::<PlacesChange>();
        wiring.tells::<Whereabouts>().hears::<Whereabouts>();
    }

    fn build(config: Self::Config, robot: &RobotContext) -> Result<Self, BuildError> {
        if robot.platform.turning_radius > 0.0 {
            return Err(BuildError::new("a geographer needs a base that can turn on the spot"));
        }
        let mut wiring = Wiring::default();
        Self::topics(&mut wiring);
        let chart = Rc::new(RefCell::new(Chart::new(robot.number(), robot.mates_with(Self::KIND))));
        let (ring, shared) = (robot.ring.clone(), chart.clone());
        let script = Script::new(&wiring, move |pilot| {
            // Who was built anew must not give an order that was carried out before.
            let orders = (pilot.now().as_nanos() / 1_000_000) as u32;
            let crumbs = Crumbs::default();
            Tour { pilot, config, ring, chart: shared, crumbs, orders, strange: 0, lost: 0, has_made_way: false }.run()
        });
        Ok(Self { config, script, chart, done: None, began: None, period: robot.period })
    }
}
