//! The office floor, with and without people.

use std::{cell::RefCell, ops::ControlFlow, rc::Rc, time::Duration};

use nalgebra::Point2;
use orienteer_hardware::sim::Arena;
use orienteer_runtime::{geometry::Pose, time::Time, topics::Truth};

use super::{
    SuiteError,
    witness::{Rover, Witness},
};
use crate::{
    Registry,
    mission::{self, Recording, RunOptions},
};

/// Ten minutes of two robots that roam the office floor.
#[derive(Debug, Clone, Default)]
pub(super) struct Floor {
    /// With its three people.
    pub people: bool,
    /// Times that a robot stepped aside, per robot.
    pub overrides: f64,
    /// Times that it did with nobody near, per robot.
    pub false_alarms: f64,
    /// Share of time that avoidance had the base, %.
    pub held: f64,
    /// How often a robot drove into something.
    pub collisions: f64,
    /// How far a robot drove, m.
    pub driven: f64,
}

/// Whoever is nearer than this, centre to centre less two radii, may be given way to, m.
const NEAR: f64 = 2.5;
/// Length of a run, s.
const DURATION: f64 = 600.0;

/// Runs the office floor.
pub(super) fn run(seed: u64, people: bool) -> Result<Floor, SuiteError> {
    let registry = Registry::standard().with_agent::<Witness>().with_agent::<Rover>();
    let files = mission::embedded_files().map(|(name, bytes)| {
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let text = match name.as_str() {
            "office-floor.toml" => {
                let quick = text.replace("[mission]", "[mission]\nlinks = \"direct\"\nthreads = 1");
                format!(
                    "{}\n[template.huey.agent.witness]\n[template.huey.agent.rover]\n",
                    without(&quick, "[template.huey.agent.corridor-follower]", "[[robot]]")
                )
            }
            "worlds/office-floor.toml" if !people => without(&text, "[[person]]", "[[place]]"),
            _ => text,
        };
        (name, text.into_bytes())
    });
    let loaded = mission::load_files(files, "office-floor.toml", &registry).map_err(SuiteError::from_display)?;

    let watch = Rc::new(RefCell::new(Watch::default()));
    let seen = watch.clone();
    let observer = move |now: Time, arena: Option<&Arena>| {
        if let Some(arena) = arena {
            seen.borrow_mut().after_step(now, arena);
        }
        ControlFlow::Continue(())
    };
    let options = RunOptions {
        record: Recording::Off,
        seed: Some(seed),
        duration: Some(Duration::from_secs_f64(DURATION)),
        observer: Some(Box::new(observer)),
        ..RunOptions::default()
    };
    let outcome = mission::run(loaded, &registry, options).map_err(SuiteError::from_display)?;

    let watch = watch.borrow();
    let mut floor = Floor { people, collisions: f64::from(watch.collisions), ..Floor::default() };
    for (at, robot, place, gap) in &watch.hits {
        let (x, y) = (place.x, place.y);
        tracing::info!(
            "office floor {seed}: robot {robot} drove into something at {at:.2} s, ({x:.2}, {y:.2}), {gap:.2} m from anybody"
        );
    }
    let share = 1.0 / outcome.robots.len().max(1) as f64;
    for (i, robot) in outcome.robots.iter().enumerate() {
        floor.driven += share * robot.fact("roamed_m").unwrap_or(0.0);
        floor.held += share * 100.0 * robot.fact("held_s").unwrap_or(0.0) / DURATION;
        for (_, at) in robot.facts().filter(|(name, _)| *name == "override_at") {
            floor.overrides += share;
            if watch.gap(i, at) > NEAR {
                floor.false_alarms += share;
            }
        }
    }
    Ok(floor)
}

/// The text without what begins with `first` and ends before the next `until`.
fn without(text: &str, first: &str, until: &str) -> String {
    let Some(begin) = text.find(first) else { return text.to_owned() };
    let end = text[begin..].find(until).map_or(text.len(), |end| begin + end);
    format!("{}{}", &text[..begin], &text[end..])
}

/// Distances from each robot to whoever is nearest to it.
#[derive(Debug, Default)]
struct Watch {
    gaps: Vec<(f64, Vec<f64>)>,
    collisions: u32,
    /// When, which robot, where, and how far from whoever was nearest.
    hits: Vec<(f64, usize, Pose, f64)>,
    counted: Vec<u32>,
}

impl Watch {
    fn after_step(&mut self, now: Time, arena: &Arena) {
        let bodies: Vec<(Point2<f64>, f64, Truth)> = arena
            .robots()
            .iter()
            .filter_map(|body| body.lock().ok().map(|body| (body.pose().point(), body.radius(), body.truth())))
            .collect();
        let people: Vec<(Point2<f64>, f64)> =
            arena.with_people(|people| people.bodies().iter().map(|body| (body.disc.center, body.disc.radius)).collect());
        let gaps = bodies.iter().enumerate().map(|(i, (here, radius, _))| {
            let others = bodies.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, (at, radius, _))| (*at, *radius));
            others
                .chain(people.iter().copied())
                .map(|(at, other)| (at - here).norm() - radius - other)
                .fold(f64::INFINITY, f64::min)
        });
        let gaps: Vec<f64> = gaps.collect();
        self.counted.resize(bodies.len(), 0);
        for (robot, ((_, _, truth), counted)) in bodies.iter().zip(&mut self.counted).enumerate() {
            if truth.collisions > *counted {
                self.hits.push((now.as_secs_f64(), robot, truth.pose, gaps[robot]));
            }
            *counted = truth.collisions;
        }
        self.gaps.push((now.as_secs_f64(), gaps));
        self.collisions = self.counted.iter().sum();
    }

    /// Distance from a robot to whoever was nearest to it at a time.
    fn gap(&self, robot: usize, at: f64) -> f64 {
        let step = self.gaps.partition_point(|(t, _)| *t < at);
        self.gaps.get(step).and_then(|(_, gaps)| gaps.get(robot)).copied().unwrap_or(f64::INFINITY)
    }
}
