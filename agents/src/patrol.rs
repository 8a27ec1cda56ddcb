//! Patrol: sends the corridor follower from place to place.
//!
//! A small master control (Randazza 1989, §2.6): order the follower to the next place, choose one of its ways out, put the
//! robot into it, and order again. The way is chosen by chance, so that a patrol covers a floor without a map; it turns back
//! only where there is no other way.
//!
//! It is written as a script, and shows how manoeuvres that take minutes read as prose.

use std::{cell::RefCell, f64::consts::FRAC_PI_2, f64::consts::PI, rc::Rc, time::Duration};

use orienteer_runtime::{
    agent::{Aborted, Agent, Behaviour, BuildError, Finish, Inputs, Outputs, Pilot, RobotContext, Script, Strategy, Wiring},
    geometry::Pose,
    time::Time,
    topics::{CorridorOrder, CorridorReport, Opening, PoseEstimate},
};
use rand::RngExt;
use rand_pcg::Pcg64;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of a patrol.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PatrolConfig {
    /// Speed across a place, m/s.
    #[schemars(range(min = 0.02, max = 2.0))]
    pub speed: f64,
    /// Turn rate, rad/s.
    #[schemars(range(min = 0.05, max = 3.0))]
    pub turn_rate: f64,
    /// Probability of going straight on where that is possible and a side is open too.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub straight_on: f64,
    /// Clear distance beyond the far corner, m, that makes going straight on possible.
    #[schemars(range(min = 0.2, max = 10.0))]
    pub clear_ahead: f64,
}

impl Default for PatrolConfig {
    fn default() -> Self {
        Self { speed: 0.3, turn_rate: 0.8, straight_on: 0.6, clear_ahead: 0.8 }
    }
}

/// The agent.
#[derive(Debug)]
pub struct Patrol {
    script: Script,
    places: Rc<RefCell<u32>>,
}

/// A way out of a place.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Way {
    Straight,
    Left,
    Right,
    Back,
}

/// How far past the corner the robot's centre stands when it is in a way out, m: the rear sonar is level with the corner.
const INTO_PORT: f64 = 0.15;
/// A port that can't be reached is tried so often.
const TRIES: u32 = 3;

async fn patrol(pilot: Pilot, config: PatrolConfig, mut random: Pcg64, places: Rc<RefCell<u32>>) -> Result<(), Aborted> {
    // The first pose has to be known before anything else.
    pilot.next::<PoseEstimate>().await?;
    let mut order = 0;
    let mut lost = 0;
    loop {
        order += 1;
        let report = follow(&pilot, order).await?;
        *places.borrow_mut() += 1;
        let way = match report.opening() {
            // A gap in both walls, a wide hall: feel the way forward, and after a while go back.
            Opening::Lost if lost < 2 => {
                lost += 1;
                Way::Straight
            }
            Opening::Lost => {
                lost = 0;
                Way::Back
            }
            _ => {
                lost = 0;
                choose(&report, &config, &mut random)
            }
        };
        enter(&pilot, &config, &report, way).await;
    }
}

/// Has the follower go to the next place.
async fn follow(pilot: &Pilot, order: u32) -> Result<CorridorReport, Aborted> {
    pilot.release();
    let stamp = pilot.now();
    pilot.publish(CorridorOrder { stamp, order });
    loop {
        let report = pilot.next::<CorridorReport>().await?;
        if report.order == order {
            return Ok(report);
        }
    }
}

fn choose(report: &CorridorReport, config: &PatrolConfig, random: &mut Pcg64) -> Way {
    let straight = report.ahead > report.width + config.clear_ahead;
    let sides: &[Way] = match report.opening() {
        Opening::Left => &[Way::Left],
        Opening::Right => &[Way::Right],
        Opening::Both => &[Way::Left, Way::Right],
        Opening::DeadEnd | Opening::Lost => &[],
    };
    // Drawn in any case, so that what the world looks like does not shift later choices.
    let (go_straight, side) = (random.random_bool(config.straight_on), random.random_range(0..2));
    match sides {
        [] if straight => Way::Straight,
        [] => Way::Back,
        _ if straight && go_straight => Way::Straight,
        sides => sides[side % sides.len()],
    }
}

/// Puts the robot into a way out. If that fails even when tried again, the follower will have to make the best of it.
async fn enter(pilot: &Pilot, config: &PatrolConfig, report: &CorridorReport, way: Way) {
    let width = if report.width > 0.0 { report.width } else { 1.5 };
    // From the start pose, whose corner is level with the front sonar; see the follower.
    let middle = 0.1 + 0.5 * width;
    let (local, strategy) = match way {
        Way::Straight => (Pose::new(0.1 + width + INTO_PORT, 0.0, 0.0), Strategy::Straight),
        Way::Left => (Pose::new(middle, 0.5 * width + INTO_PORT, FRAC_PI_2), Strategy::YFirst),
        Way::Right => (Pose::new(middle, -0.5 * width - INTO_PORT, -FRAC_PI_2), Strategy::YFirst),
        Way::Back => (Pose::new(0.0, 0.0, PI), Strategy::Straight),
    };
    let goal = report.pose.then(local);
    for _ in 0..TRIES {
        let Some(here) = pilot.latest::<PoseEstimate>() else { return };
        let Some(handle) = pilot.save_pose(here.pose.between(goal)) else { return };
        match pilot.move_to(handle, strategy, config.speed, config.turn_rate).await {
            Ok(()) => return,
            Err(_) => {
                // Whoever took the base has moved the robot; plan anew from where it is.
                pilot.release();
                if pilot.sleep(Duration::from_millis(500)).await.is_err() {
                    return;
                }
            }
        }
    }
}

impl Behaviour for Patrol {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        self.script.step(now, inputs, out);
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        last_words.fact("places", f64::from(*self.places.borrow()));
    }
}

impl Agent for Patrol {
    const KIND: &'static str = "patrol";
    const HELP: &'static str = "sends the corridor follower on from place to place, choosing ways by chance";
    const PRIORITY: u8 = 4;
    type Config = PatrolConfig;

    fn topics(wiring: &mut Wiring) {
        wiring.reads::<PoseEstimate>().reads::<CorridorReport>().writes::<CorridorOrder>();
    }

    fn build(config: Self::Config, robot: &RobotContext) -> Result<Self, BuildError> {
        if robot.platform.turning_radius > 0.0 {
            return Err(BuildError::new("a patrol needs a base that can turn on the spot"));
        }
        let mut wiring = Wiring::default();
        Self::topics(&mut wiring);
        let places = Rc::new(RefCell::new(0));
        let (random, counter) = (robot.stream("ways"), places.clone());
        let script = Script::new(&wiring, move |pilot| patrol(pilot, config, random, counter));
        Ok(Self { script, places })
    }
}
