//! What came of a meeting.

use std::{cell::RefCell, ops::ControlFlow, rc::Rc};

use nalgebra::{Point2, Vector2};
use orienteer_hardware::sim::Arena;
use orienteer_runtime::time::Time;

use super::{Encounter, SuiteError, encounter::Task, witness};
use crate::{
    Registry,
    mission::{self, Recording, RunOptions},
};

/// How an encounter went.
#[derive(Debug, Clone, Default)]
pub(super) struct Verdict {
    /// How often the two came to touch.
    pub contacts: u32,
    /// Contacts during which the robot moved toward the person.
    pub toward: u32,
    /// How often the robot drove into anything else.
    pub collisions: u32,
    /// How often avoidance took the base.
    pub overrides: usize,
    /// The robot's corridor follower was overridden and did not resume its way to the end.
    pub lost: bool,
    /// The narrowest gap between the two, m.
    pub nearest: f64,
}

/// Discs this close touch, m.
const TOUCH: f64 = 1e-3;
/// Slower than this toward somebody is not moving toward them, m/s.
const TOWARD: f64 = 0.01;
/// An overridden follower must travel on this far, m, ...
const ON: f64 = 2.0;
/// (or to the end of the corridor, which is here, m)
const END: f64 = 19.0;
/// ... within this time after it got the base back, s.
const SOON: f64 = 60.0;

/// What the observer sees, step by step.
#[derive(Debug, Default)]
struct Watch {
    touching: bool,
    blamed: bool,
    collisions: u32,
    verdict: Verdict,
    /// Where the robot was, along the corridor.
    trail: Vec<(f64, f64)>,
}

impl Watch {
    fn after_step(&mut self, now: Time, arena: &Arena) -> Option<()> {
        let robot = arena.robots().first()?.clone();
        let (truth, radius) = {
            let body = robot.lock().ok()?;
            (body.truth(), body.radius())
        };
        let person = arena.with_people(|people| people.bodies().first().copied())?;
        let here: Point2<f64> = truth.pose.point();
        let to = person.disc.center - here;
        let gap = to.norm() - radius - person.disc.radius;
        self.verdict.nearest = self.verdict.nearest.min(gap);
        self.trail.push((now.as_secs_f64(), here.x));

        let direction = truth.pose.direction();
        let velocity = Vector2::new(direction.x, direction.y) * truth.twist.linear;
        let hit = truth.collisions - self.collisions;
        self.collisions = truth.collisions;
        if gap <= TOUCH {
            if !self.touching {
                self.verdict.contacts += 1;
                self.blamed = false;
            }
            // A body that drives into another is stopped by it before anyone could see it move.
            let toward = velocity.dot(&to) / to.norm().max(1e-9) > TOWARD || hit > 0;
            if toward && !self.blamed {
                self.blamed = true;
                self.verdict.toward += 1;
            }
        } else {
            self.verdict.collisions += hit;
        }
        self.touching = gap <= TOUCH;
        Some(())
    }

    /// True if a robot that got its base back at `back` travelled on, and stood at the corridor's end when its follower reported.
    fn arrived(&self, back: f64, reported: f64) -> bool {
        let place = |at: f64| self.trail.get(self.trail.partition_point(|(t, _)| *t < at)).map_or(f64::NAN, |(_, x)| *x);
        let travelled = self.trail.iter().filter(|(t, _)| (back..=back + SOON).contains(t)).map(|(_, x)| x - place(back));
        let on = travelled.fold(0.0, f64::max);
        (on >= ON || place(back) > END - ON) && place(reported) > END - 1.0
    }
}

/// Runs an encounter.
pub(super) fn judge(encounter: &Encounter) -> Result<Verdict, SuiteError> {
    let registry = Registry::standard().with_agent::<witness::Witness>().with_agent::<witness::StraightOn>();
    let loaded = mission::load_files(encounter.files(), "mission.toml", &registry)
        .map_err(|problems| SuiteError(format!("encounter {}: {problems}", encounter.seed)))?;
    let watch = Rc::new(RefCell::new(Watch::default()));
    watch.borrow_mut().verdict.nearest = f64::INFINITY;
    let seen = watch.clone();
    let observer = move |now: Time, arena: Option<&Arena>| {
        if let Some(arena) = arena {
            seen.borrow_mut().after_step(now, arena);
        }
        ControlFlow::Continue(())
    };
    let options = RunOptions { record: Recording::Off, observer: Some(Box::new(observer)), ..RunOptions::default() };
    let outcome = mission::run(loaded, &registry, options).map_err(SuiteError::from_display)?;
    let robot = outcome.robots.first().ok_or_else(|| SuiteError("the robot has gone".to_owned()))?;

    let watch = watch.borrow();
    let mut verdict = watch.verdict.clone();
    let times = |fact: &'static str| robot.facts().filter(move |(name, _)| *name == fact).map(|(_, at)| at);
    let reported = robot.fact("report_at");
    // Once the follower has reported there is nothing left to be overridden.
    let before = reported.unwrap_or(f64::INFINITY);
    verdict.overrides = times("override_at").filter(|at| *at < before).count();
    if encounter.task == Task::Follow {
        let back = times("override_end").filter(|at| *at < before).last();
        let resumed = reported.zip(back).is_some_and(|(at, back)| watch.arrived(back, at));
        verdict.lost = verdict.overrides > 0 && !resumed;
    }
    Ok(verdict)
}
