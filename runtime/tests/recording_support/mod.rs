//! Made-up missions for the tests of recordings.
#![allow(dead_code, clippy::unwrap_used)]

use std::{f64::consts::TAU, time::Duration};

use orienteer_runtime::{
    geometry::{Limits, Pose, Twist},
    recording::{GridImage, Mission, Recorder, RobotInfo, Source, Track},
    robot_model::{Ring, Transducer},
    time::Time,
    topics::*,
};

pub const PERIOD: Duration = Duration::from_millis(50);

pub fn mission(robots: usize) -> Mission {
    let name = |i| RobotInfo::new(&format!("r{i}"), ["avoidance", "corridor", "planner"]);
    Mission {
        version: "0.1.0".into(),
        seed: 42,
        duration: Duration::from_secs(600),
        control_period: PERIOD,
        robots: (0..robots).map(name).collect(),
        sources: vec![
            Source { name: "office.toml".into(), bytes: b"seed = 42\n# \xc3\xa4\n".to_vec() },
            Source { name: "worlds/floor.toml".into(), bytes: (0..=255).collect() },
        ],
    }
}

pub fn even_ring(count: usize) -> Ring {
    let mount = |i| {
        let heading = TAU * i as f64 / count as f64;
        Pose::new(0.2 * heading.cos(), 0.2 * heading.sin(), heading)
    };
    Ring {
        name: "even".into(),
        transducers: (0..count).map(|i| Transducer { mount: mount(i), half_beam: 0.2 }).collect(),
        min_range: 0.15,
        max_range: 6.0,
        slot_time: 0.0,
        program: FiringProgram::default(),
    }
}

/// A number in `[0, 1)` that depends on robot, step and purpose.
fn wobble(robot: usize, step: u64, purpose: u64) -> f64 {
    let mut x = (robot as u64 + 1) << 40 ^ step << 8 ^ purpose;
    for _ in 0..3 {
        x = (x ^ x >> 31).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }
    (x >> 11) as f64 / (1u64 << 53) as f64
}

/// What one robot's topics carry in one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    pub scan: SonarScan,
    pub odometry: Odometry,
    pub pose: PoseEstimate,
    pub decision: BaseDecision,
    pub truth: Truth,
}

pub fn step(robot: usize, step: u64) -> Step {
    let stamp = Time::START + PERIOD * step as u32;
    let w = |purpose| wobble(robot, step, purpose);
    let mut scan = SonarScan::unfired(16);
    (scan.stamp, scan.seq) = (stamp, step);
    for i in 0..16 {
        let echo = if w(i + 100) < 0.1 { Echo::Nothing } else { Echo::Range(0.2 + 5.0 * w(i) as f32) };
        scan.set(i as usize, echo, w(i + 200) as f32);
    }
    let pose = Pose::new(10.0 * w(1), 10.0 * w(2), 6.0 * w(3) - 3.0);
    let twist = Twist::new(w(4), w(5) - 0.5);
    let odometry = Odometry { stamp, pose, twist, travelled: step as f64 * 0.02, turned: -w(6), battery: 12.5, flags: 1 };
    let covariance = std::array::from_fn(|i| w(i as u64 + 300) * 1e-3);
    let mut decision = BaseDecision::default().because(ArbitrationRule::HigherPriority);
    (decision.stamp, decision.valid_until) = (stamp, stamp + 2 * PERIOD);
    decision.holder = ClientId((step % 3) as u16);
    decision.motion = Motion::velocity(twist);
    decision.limits = Limits { linear: w(7), ..Limits::NONE };
    decision.hold_back(HeldBack::new(ClientId(2), ArbitrationRule::LowerPriority));
    Step {
        scan,
        odometry,
        pose: PoseEstimate { stamp, pose, covariance, travelled: odometry.travelled },
        decision,
        truth: Truth { stamp, pose, twist, collisions: 0, bumped: (step / 100) as u32 },
    }
}

pub fn tracks(robots: usize) -> Vec<Track> {
    (0..robots).map(|i| Track::new(i, &format!("r{i}"), Some(&even_ring(16)))).collect()
}

pub fn record(track: &mut Track, robot: usize, number: u64) {
    let now = Time::START + PERIOD * number as u32;
    let step = step(robot, number);
    track.begin(now);
    track.record(&step.scan);
    track.record(&step.odometry);
    track.record(&step.pose);
    track.record(&step.decision);
    track.record(&step.truth);
    if number % 40 == 7 {
        track.log(tracing::Level::INFO, "corridor", &format!("step {number}"));
    }
    if number % 100 == 50 {
        track.record_grid("map", &grid(robot, number));
    }
}

pub fn grid(robot: usize, number: u64) -> GridImage {
    let cells = (0..1200).map(|i| (wobble(robot, number, i) * 256.0) as u8).collect();
    GridImage { origin: Pose::new(-3.0, -2.0, 0.0), resolution: 0.1, width: 40, height: 30, cells }
}

/// Runs a whole mission through a recorder.
pub fn run(recorder: &mut Recorder, robots: usize, steps: u64) {
    let mut tracks = tracks(robots);
    for number in 1..=steps {
        for (robot, track) in tracks.iter_mut().enumerate() {
            record(track, robot, number);
            recorder.append(track.entries());
        }
    }
}
