//! Courses for the corridor follower, and what came of a run.

use std::{cell::RefCell, ops::ControlFlow, rc::Rc, sync::PoisonError};

use orienteer_hardware::sim::Arena;
use orienteer_runtime::{geometry::Pose, random::Streams, time::Time};
use rand::RngExt;

use super::SuiteError;
use crate::{
    Registry,
    mission::{self, Recording, RunOptions},
};

/// What opens at the end of the stretch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Branches {
    Left,
    Right,
    Both,
}

impl Branches {
    fn left(self) -> bool {
        self != Branches::Right
    }

    fn right(self) -> bool {
        self != Branches::Left
    }

    /// The follower's fact that counts such places.
    fn fact(self) -> &'static str {
        match self {
            Branches::Left => "openings_left",
            Branches::Right => "openings_right",
            Branches::Both => "openings_both",
        }
    }
}

/// Length of the hallway that is measured, m.
pub(super) const HALLWAY: f64 = 20.0;
/// Where the robot starts, m from the corridor's closed end.
const START: f64 = 1.0;
/// What it may need to find the middle, m.
const SETTLING: f64 = 2.0;
/// Width of the side branches, m (Randazza 1989).
const BRANCH: f64 = 1.12;
/// Radius of Huey's sonar ring, m: so far short of the corner the robot's centre shall stop.
const RING: f64 = 0.08;
/// Steps without motion after which a run is over; longer than the follower's patience.
const STILL: u32 = 160;
/// A run is over after this time at the latest, s.
const LONGEST: f64 = 200.0;

/// One run: a world, and a start.
#[derive(Debug, Clone)]
pub(super) struct Course {
    seed: u64,
    world: String,
    start: Pose,
    /// Which sides open, and where along the corridor the near corner is.
    place: Option<(Branches, f64)>,
}

/// What came of a run; lengths in m, angles in rad.
#[derive(Debug, Clone)]
pub(super) struct Run {
    /// Root mean square of the lateral offset after the first 2 m.
    pub rms: f64,
    /// The largest lateral offset after the first 2 m.
    pub deviation: f64,
    /// Distance along the corridor after the first 2 m.
    pub length: f64,
    /// How often it hit something.
    pub collisions: u32,
    /// Distance from the start pose; infinite if it had none to reach.
    pub miss: f64,
    /// Angle between its heading and the corridor.
    pub heading: f64,
    /// True if it told exactly one place, of the right kind.
    pub sides_right: bool,
}

impl Run {
    /// True if it stands within 10 cm of the start pose.
    pub fn is_placed(&self) -> bool {
        self.miss <= 0.1
    }
}

impl Course {
    /// A corridor with an opening after 5 to 9 m.
    pub fn with_branches(width: f64, branches: Branches, seed: u64) -> Self {
        let streams = Streams::new(seed);
        let mut random = streams.stream("course", "world");
        let middle = random.random_range(7.0..11.0);
        let depth: f64 = random.random_range(1.2..4.0);
        let side = |sign: f64| {
            let end = sign * (0.5 * width + depth);
            format!("[[corridor]]\nalong = [[{middle}, 0.0], [{middle}, {end}]]\nwidth = {BRANCH}\n")
        };
        let mut world = format!("[[corridor]]\nalong = [[0.0, 0.0], [{}, 0.0]]\nwidth = {width}\n", middle + 4.0);
        if branches.left() {
            world.push_str(&side(1.0));
        }
        if branches.right() {
            world.push_str(&side(-1.0));
        }
        Self { seed, world, start: start(&streams), place: Some((branches, middle - 0.5 * BRANCH)) }
    }

    /// A hallway without openings, long enough to measure [`HALLWAY`] of it.
    pub fn hallway(seed: u64) -> Self {
        let length = START + SETTLING + HALLWAY + 1.0;
        let world = format!("[[corridor]]\nalong = [[0.0, 0.0], [{length}, 0.0]]\nwidth = 2.46\n");
        Self { seed, world, start: start(&Streams::new(seed)), place: None }
    }

    /// Runs it.
    pub fn run(&self) -> Result<Run, SuiteError> {
        let registry = Registry::standard();
        let files = [("corridor.toml".to_owned(), self.mission()), ("world.toml".to_owned(), self.world.clone())];
        let files = files.map(|(name, text)| (name, text.into_bytes()));
        let loaded = mission::load_files(files, "corridor.toml", &registry).map_err(SuiteError::from_display)?;
        let measured = Rc::new(RefCell::new(Measurement::new(self.start)));
        let observed = measured.clone();
        let observer =
            move |_: Time, arena: Option<&Arena>| arena.map_or(ControlFlow::Break(()), |arena| observed.borrow_mut().look(arena));
        let options =
            RunOptions { threads: Some(1), record: Recording::Off, observer: Some(Box::new(observer)), ..RunOptions::default() };
        let outcome = mission::run(loaded, &registry, options).map_err(SuiteError::from_display)?;
        let fact = |name: &str| outcome.robots.first().and_then(|robot| robot.fact(name)).unwrap_or(0.0);
        let told_right = |branches: Branches| fact("corridors") == 1.0 && fact(branches.fact()) == 1.0;
        let measured = measured.borrow();
        let run = Run {
            rms: measured.rms(),
            deviation: measured.deviation,
            length: measured.last.x - self.start.x - SETTLING,
            collisions: measured.collisions,
            miss: self.place.map_or(f64::INFINITY, |(_, corner)| (measured.last.x - (corner - RING)).hypot(measured.last.y)),
            heading: measured.last.heading.abs(),
            sides_right: self.place.is_some_and(|(branches, _)| told_right(branches)),
        };
        tracing::debug!(seed = self.seed, place = ?self.place, start = ?self.start, end = ?measured.last, ?run, "corridor run");
        Ok(run)
    }

    fn mission(&self) -> String {
        let Pose { x, y, heading } = self.start;
        format!(
            r#"
[mission]
duration = {LONGEST}
seed = {seed}
links = "direct"

[world]
file = "world.toml"

[[robot]]
name = "huey"
base = {{ driver = "sim", platform = "b12-huey" }}
sonar = {{ driver = "sim", ring = "denning-16" }}
start = {{ x = {x:?}, y = {y:?}, heading_deg = {heading_deg:?} }}

[robot.agent.where-am-i]

[robot.agent.avoidance]
priority = 10

[robot.agent.corridor-follower]
priority = 5
autostart = true
"#,
            seed = self.seed,
            heading_deg = heading.to_degrees(),
        )
    }
}

/// Up to 20 cm off the middle and 10° off its direction.
fn start(streams: &Streams) -> Pose {
    let mut random = streams.stream("course", "start");
    Pose::new(START, random.random_range(-0.2..0.2), random.random_range(-10f64..10.0).to_radians())
}

/// The true course of a robot, seen from outside.
#[derive(Debug)]
struct Measurement {
    start: Pose,
    last: Pose,
    /// The sum of squares of lateral offsets, one for each step in which it moved, and their number.
    squares: (f64, u32),
    deviation: f64,
    collisions: u32,
    still: u32,
}

impl Measurement {
    fn new(start: Pose) -> Self {
        Self { start, last: start, squares: (0.0, 0), deviation: 0.0, collisions: 0, still: 0 }
    }

    fn look(&mut self, arena: &Arena) -> ControlFlow<()> {
        let robots = arena.robots();
        let Some(body) = robots.first() else { return ControlFlow::Break(()) };
        let truth = body.lock().unwrap_or_else(PoisonError::into_inner).truth();
        self.collisions = truth.collisions;
        let moving = truth.twist.linear.abs() > 1e-3 || truth.twist.angular.abs() > 1e-3;
        self.still = if moving { 0 } else { self.still + 1 };
        let travelled = truth.pose.x - self.start.x;
        if travelled >= SETTLING && truth.twist.linear.abs() > 1e-3 {
            self.squares = (self.squares.0 + truth.pose.y.powi(2), self.squares.1 + 1);
            self.deviation = self.deviation.max(truth.pose.y.abs());
        }
        self.last = truth.pose;
        if self.still >= STILL { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn rms(&self) -> f64 {
        // A robot that never came so far has not held the middle.
        if self.squares.1 == 0 { f64::INFINITY } else { (self.squares.0 / f64::from(self.squares.1)).sqrt() }
    }
}
