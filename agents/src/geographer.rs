//! Geographer: explores a floor place by place and draws its map (Randazza 1989, §1.2; Kuipers & Byun 1988).
//!
//! The robot follows a corridor to the next place, has it named, chooses the nearest way that nobody has gone yet, and leaves. It recognises places that it has
//! been to, so loops close; it is done when no way is left. What it knows it leaves as a graph: `places.json`, and `places.dot` for GraphViz.
//!
//! * [`Compass`], [`Quarter`]: corridors meet at right angles;
//! * [`TopologicalMap`]: places and corridors;
//! * `tour`: what the robot does;
//! * [`export`]: the map as files.
//!
//! Reckoning is by the map and not by the odometry alone: a corridor is straight, so a place lies as far along it as the robot has driven, whatever the wheels
//! say of its heading.

mod compass;
pub mod export;
mod map;
mod tour;

use std::{cell::RefCell, rc::Rc};

use orienteer_runtime::{
    agent::{Agent, Behaviour, BuildError, Finish, Inputs, Outputs, RobotContext, Script, Wiring},
    time::Time,
    topics::{CorridorOrder, CorridorReport, PlaceOrder, PlaceReport, PoseEstimate},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::crumbs::Crumbs;
pub use compass::{Compass, Quarter};
pub use map::{Arm, Corridor, Place, Route, TopologicalMap};
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

/// The agent.
#[derive(Debug)]
pub struct Geographer {
    config: GeographerConfig,
    script: Script,
    map: Rc<RefCell<TopologicalMap>>,
    /// When nothing was left to explore.
    done: Option<Time>,
}

impl Behaviour for Geographer {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        if self.script.step(now, inputs, out).is_some() {
            let map = self.map.borrow();
            out.announce(format!("all is explored: {} places, {} corridors", map.places().len(), map.corridors().count()));
            self.done = Some(now);
        }
        if self.done.is_some() && self.config.finish {
            out.end_mission();
        }
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        let map = self.map.borrow();
        last_words.fact("places_found", map.places().len() as f64);
        last_words.fact("corridors_found", map.corridors().count() as f64);
        last_words.fact("ways_left", map.unexplored() as f64);
        if let Some(done) = self.done {
            last_words.fact("explored_s", done.as_secs_f64());
        }
        export::lines(&map).into_iter().for_each(|line| last_words.note(line));
        match export::json(&map) {
            Ok(json) => last_words.file("places.json", json.into_bytes()),
            Err(error) => last_words.failure(format!("the map of places can't be written: {error}")),
        }
        last_words.file("places.dot", export::dot(&map).into_bytes());
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
    }

    fn build(config: Self::Config, robot: &RobotContext) -> Result<Self, BuildError> {
        if robot.platform.turning_radius > 0.0 {
            return Err(BuildError::new("a geographer needs a base that can turn on the spot"));
        }
        let mut wiring = Wiring::default();
        Self::topics(&mut wiring);
        let map = Rc::new(RefCell::new(TopologicalMap::default()));
        let (ring, shared) = (robot.ring.clone(), map.clone());
        let script = Script::new(&wiring, move |pilot| {
            // Who was built anew must not give an order that was carried out before.
            let orders = (pilot.now().as_nanos() / 1_000_000) as u32;
            Tour { pilot, config, ring, map: shared, crumbs: Crumbs::default(), orders, fix: None, strange: 0 }.run()
        });
        Ok(Self { config, script, map, done: None })
    }
}
