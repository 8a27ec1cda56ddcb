//! The node over a driver that does what a test says.
#![allow(clippy::unwrap_used)]

use std::sync::{Arc, Mutex};

use orienteer_runtime::{
    geometry::{Limits, Pose, Twist},
    robot_model::Platform,
    topics::Motion,
};

use super::*;
use crate::base::presets;

/// What the driver is asked to do, and what came of it.
#[derive(Default)]
struct Notes {
    commands: Vec<Twist>,
    stops: u32,
    spoil: Option<fn(&mut Odometry)>,
    refuses: bool,
}

struct Scripted {
    platform: Platform,
    notes: Arc<Mutex<Notes>>,
}

impl BaseDriver for Scripted {
    fn platform(&self) -> &Platform {
        &self.platform
    }

    fn command(&mut self, _now: Time, twist: Twist) -> Result<(), DriverError> {
        let mut notes = self.notes.lock().unwrap();
        notes.commands.push(twist);
        match notes.refuses {
            true => Err(DriverError::Refused { what: "a broken axle".into() }),
            false => Ok(()),
        }
    }

    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        let mut odometry = Odometry { stamp: now, flags: flags::ENABLED, ..Odometry::default() };
        if let Some(spoil) = self.notes.lock().unwrap().spoil {
            spoil(&mut odometry);
        }
        Ok(odometry)
    }

    fn stop(&mut self) {
        self.notes.lock().unwrap().stops += 1;
    }
}

/// A base that is told to drive in each step.
struct Bench {
    node: BaseNode,
    inputs: Inputs,
    out: Outputs,
    notes: Arc<Mutex<Notes>>,
    now: Time,
}

const PERIOD: Duration = Duration::from_millis(50);

impl Bench {
    fn new() -> Self {
        Self::with_sonar(false)
    }

    fn with_sonar(sonar_required: bool) -> Self {
        let notes = Arc::new(Mutex::new(Notes::default()));
        let driver = Scripted { platform: presets::b12_huey().platform(), notes: notes.clone() };
        let ring = crate::rings::find("denning-16").unwrap().ring;
        let protection = ProtectionConfig { sonar_required, ..ProtectionConfig::default() };
        let node = BaseNode::new(Box::new(driver), &ring, ExecutorConfig::default(), protection, PERIOD);
        let wiring = BaseNode::wiring(false);
        Self { node, inputs: Inputs::offline(&wiring), out: Outputs::offline(&wiring), notes, now: Time::START }
    }

    /// A control period. Returns what was commanded, if anything, and whether odometry was published.
    fn step(&mut self) -> (Option<Twist>, bool) {
        self.now = self.now + PERIOD;
        self.notes.lock().unwrap().commands.clear();
        self.out.settle();
        self.inputs.phase = Phase::Sense;
        self.node.step(self.now, &self.inputs, &mut self.out);
        let published = !self.out.published::<Odometry>().is_empty();
        self.inputs.phase = Phase::Act;
        let mut decision = BaseDecision::default();
        (decision.stamp, decision.valid_until) = (self.now, self.now + 2 * PERIOD);
        (decision.motion, decision.limits) = (Motion::velocity(Twist::new(0.2, 0.0)), Limits::NONE);
        self.inputs.put(decision);
        self.node.step(self.now, &self.inputs, &mut self.out);
        (self.notes.lock().unwrap().commands.last().copied(), published)
    }

    /// A control period in which nobody decides anything.
    fn step_alone(&mut self) -> Option<Twist> {
        self.now = self.now + PERIOD;
        self.notes.lock().unwrap().commands.clear();
        self.inputs.settle();
        for phase in [Phase::Sense, Phase::Act] {
            self.inputs.phase = phase;
            self.node.step(self.now, &self.inputs, &mut self.out);
        }
        self.notes.lock().unwrap().commands.last().copied()
    }

    fn with(&self, change: impl FnOnce(&mut Notes)) {
        change(&mut self.notes.lock().unwrap());
    }
}

#[test]
fn odometry_that_makes_no_sense_goes_to_nobody_and_stops_the_base() {
    let nonsense: [fn(&mut Odometry); 4] = [
        |odometry| odometry.pose = Pose { x: f64::NAN, y: 0.0, heading: 0.0 },
        |odometry| odometry.twist.linear = f64::INFINITY,
        |odometry| odometry.travelled = f64::NAN,
        |odometry| odometry.stamp = odometry.stamp + Duration::from_secs(3600),
    ];
    for spoil in nonsense {
        let mut bench = Bench::new();
        assert_eq!(bench.step(), (Some(Twist::new(0.2, 0.0)), true));
        bench.with(|notes| notes.spoil = Some(spoil));
        assert_eq!(bench.step(), (Some(Twist::STOP), false));
        bench.with(|notes| notes.spoil = None);
        assert_eq!(bench.step(), (Some(Twist::new(0.2, 0.0)), true), "it is back");
    }
}

/// It may have come from another process, which may die after it, or never have meant well.
#[test]
fn a_decision_that_says_to_hold_for_ever_holds_for_two_periods_and_a_half() {
    let mut bench = Bench::new();
    bench.step();
    let mut decision = *bench.inputs.latest::<BaseDecision>().unwrap();
    decision.valid_until = Time::FAR;
    bench.inputs.settle();
    bench.inputs.put(decision);
    bench.node.step(bench.now, &bench.inputs, &mut bench.out);
    let told: Vec<_> = (0..4).map(|_| bench.step_alone()).collect();
    let drives = Some(Twist::new(0.2, 0.0));
    assert_eq!(told, [drives, drives, Some(Twist::STOP), Some(Twist::STOP)]);
}

#[test]
fn a_base_that_does_not_take_a_command_is_stopped_and_told_nothing_else_for_a_second() {
    let mut bench = Bench::new();
    bench.step();
    bench.with(|notes| notes.refuses = true);
    bench.step();
    assert_eq!(bench.notes.lock().unwrap().stops, 1);
    bench.with(|notes| notes.refuses = false);
    for _ in 0..20 {
        assert_eq!(bench.step().0, Some(Twist::STOP));
    }
    assert_eq!(bench.step().0, Some(Twist::new(0.2, 0.0)));
}

/// A ring needs a moment for its first pass, which is nothing to warn of in every mission; but one that stays silent is.
#[test]
fn a_sonar_that_says_nothing_is_warned_of_once_and_not_at_the_very_start() {
    let mut bench = Bench::with_sonar(true);
    let mut warned = Vec::new();
    for _ in 0..200 {
        let (twist, _) = bench.step();
        assert_eq!(twist, Some(Twist::STOP));
        warned.extend(bench.out.said().iter().filter(|line| line.level == Level::WARN).map(|_| bench.now));
    }
    assert_eq!(warned, [Time::START + FIRST_PASS]);
}
