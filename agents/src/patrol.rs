//! Patrol: sends the corridor follower from place to place.
//!
//! A small master control (Randazza 1989, §2.6): order the follower to the next place, choose one of its ways out, put the
//! robot into it, and order again. The way is chosen by chance, so that a patrol covers a floor without a map; it turns back
//! only where there is no other way.
//!
//! It is written as a script, and shows how manoeuvres that take minutes read as prose.

use std::{
    cell::RefCell,
    f64::consts::{FRAC_PI_2, PI},
    rc::Rc,
    sync::Arc,
    time::Duration,
};

use nalgebra::{Rotation2, Vector2};
use orienteer_runtime::{
    agent::{Aborted, Agent, Behaviour, BuildError, Finish, Inputs, Outputs, Pilot, RobotContext, Script, Wiring},
    geometry::Twist,
    robot_model::{LookOut, Ring},
    time::Time,
    topics::{CorridorOrder, CorridorReport, Opening, PoseEstimate, SonarScan},
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
    /// Openings narrower than this are doors, and passed by, m.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub least_width: f64,
}

impl Default for PatrolConfig {
    fn default() -> Self {
        Self { speed: 0.3, turn_rate: 0.8, straight_on: 0.5, clear_ahead: 0.8, least_width: 1.0 }
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
    /// Turning on the spot by so much, rad.
    Turn(f64),
}

/// Where it came from.
const BACK: Way = Way::Turn(PI);

/// How far past the corner the robot's centre stands when it is in a way out, m: the rear sonar is level with the corner.
const INTO_PORT: f64 = 0.15;
/// A flank that reads this much more than half the corridor's width is open, m.
const OPEN: f64 = 0.35;
/// So many readings in a row are believed.
const BELIEVED: u32 = 6;
/// No place is wider than this, m.
const WIDEST: f64 = 4.0;
/// Who has been kept from going on for this long gives the way up: before the base forgets what it met and does not see any more.
const HINDERED: Duration = Duration::from_secs(8);
/// A stretch shorter than this was no way at all, m: the robot is hemmed in.
const NO_WAY: f64 = 0.05;
/// With so much room to a side a robot does not stand at the end of a corridor, m.
const ACROSS: f64 = 2.0;
/// How long a ring takes to have looked everywhere.
const LOOK_ROUND: Duration = Duration::from_secs(1);
/// What is nearer than this repels, m; what is nearer than that repels no more strongly.
const NEAR: f64 = 1.0;
const TOUCHING: f64 = 0.1;
/// How far to go away from there, m.
const A_LITTLE: f64 = 0.3;
/// How far to back off from where it does not go on, m.
const BACK_OFF: f64 = 0.15;
/// Distance to something ahead, from the robot's centre, at which crossing ends, m.
const AHEAD: f64 = 0.65;

/// The transducers that look ahead, to the left and to the right.
#[derive(Debug, Clone)]
struct Eyes {
    ring: Arc<Ring>,
    look_out: LookOut,
}

impl Eyes {
    fn of(ring: &Arc<Ring>) -> Result<Self, String> {
        Ok(Self { look_out: ring.look_out()?, ring: ring.clone() })
    }

    /// Free distance from the robot's centre to what is ahead, m.
    fn ahead(&self, scan: &SonarScan) -> Option<f64> {
        self.look_out.ahead.iter().filter_map(|i| self.free(scan, *i)).min_by(f64::total_cmp)
    }

    /// Away from all that is near, rad off the robot's heading: the sum of what each beam's echo repels with (Khatib 1986). `None` if
    /// nothing is.
    fn away(&self, scan: &SonarScan) -> Option<f64> {
        let repels = |i: usize| {
            let free = self.free(scan, i)?;
            let force = (1.0 / free.max(TOUCHING) - 1.0 / NEAR).max(0.0);
            Some(-force * Rotation2::new(self.ring.transducers.get(i)?.mount.heading).matrix().column(0))
        };
        let sum: Vector2<f64> = (0..self.ring.transducers.len()).filter_map(repels).sum();
        (sum.norm() > f64::EPSILON).then(|| sum.y.atan2(sum.x))
    }

    /// By how much to turn to the side where there is more room, rad, if there is more than a corridor's end has: then the robot does not stand at one, but across its
    /// corridor.
    fn freer_side(&self, scan: &SonarScan) -> Option<f64> {
        let room = self.look_out.flanks.map(|flank| self.free(scan, flank).unwrap_or_default());
        let (turn, room) = if room[0] >= room[1] { (FRAC_PI_2, room[0]) } else { (-FRAC_PI_2, room[1]) };
        (room > ACROSS).then_some(turn)
    }

    /// Free distance from the robot's centre along a transducer's beam, m.
    fn free(&self, scan: &SonarScan, transducer: usize) -> Option<f64> {
        let mount = self.ring.transducers.get(transducer)?.mount;
        let range = scan.echo(transducer).free_distance(self.ring.max_range as f32)?;
        Some(f64::from(range) + mount.x.hypot(mount.y))
    }
}

async fn patrol(
    pilot: Pilot,
    config: PatrolConfig,
    eyes: Eyes,
    mut random: Pcg64,
    places: Rc<RefCell<u32>>,
) -> Result<(), Aborted> {
    // The first pose has to be known before anything else.
    pilot.next::<PoseEstimate>().await?;
    // A patrol that was built anew must not give an order that was carried out before.
    let mut order = (pilot.now().as_nanos() / 1_000_000) as u32;
    let (mut lost, mut hemmed_in) = (0, false);
    loop {
        order += 1;
        let report = follow(&pilot, order).await?;
        // Not twice in a row: what is behind may be the end of a corridor.
        hemmed_in = report.length < NO_WAY && !hemmed_in;
        if hemmed_in {
            // Beside a wall or in a corner the follower may take for a corridor what is none.
            into_the_open(&pilot, &config, &eyes).await.ok();
            pilot.release();
            continue;
        }
        *places.borrow_mut() += 1;
        lost = if report.opening() == Opening::Lost { lost + 1 } else { 0 };
        let way = match report.opening() {
            // A gap in both walls, a wide hall: feel the way forward, and after a while go back.
            Opening::Lost if lost % 3 != 0 => Way::Straight,
            Opening::Lost => BACK,
            _ => choose(&report, &config, &eyes, pilot.latest(), &mut random),
        };
        // Whoever takes the base meanwhile moves the robot; the follower makes the best of wherever it stands then.
        if let Err(aborted) = leave(&pilot, &config, &eyes, &report, way).await {
            if aborted == Aborted::Blocked {
                // Back where it came from, the ground is free; who touches something can do nothing else.
                pilot.translate(-BACK_OFF, config.speed).await.ok();
            }
            pilot.release();
            pilot.sleep(Duration::from_millis(500)).await.ok();
        }
    }
}

/// Has the follower go to the next place. The order is repeated in every step: a follower that was built anew has heard none.
async fn follow(pilot: &Pilot, order: u32) -> Result<CorridorReport, Aborted> {
    pilot.release();
    loop {
        pilot.publish(CorridorOrder { stamp: pilot.now(), order });
        pilot.next_step().await?;
        if let Some(report) = pilot.latest::<CorridorReport>().filter(|report| report.order == order) {
            return Ok(report);
        }
    }
}

fn choose(report: &CorridorReport, config: &PatrolConfig, eyes: &Eyes, scan: Option<SonarScan>, random: &mut Pcg64) -> Way {
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
        [] => scan.and_then(|scan| eyes.freer_side(&scan)).map_or(BACK, Way::Turn),
        _ if straight && go_straight => Way::Straight,
        sides => sides[side % sides.len()],
    }
}

/// Puts the robot into a way out of the place.
///
/// It crosses the place first and measures how far each side is open on the way, so that it knows a door from a corridor and
/// finds the middle of what it turns into.
async fn leave(pilot: &Pilot, config: &PatrolConfig, eyes: &Eyes, report: &CorridorReport, way: Way) -> Result<(), Aborted> {
    if let Way::Turn(angle) = way {
        return pilot.rotate(angle, config.turn_rate).await;
    }
    let gaps = cross(pilot, config, eyes, report).await?;
    if gaps.held {
        return pilot.rotate(PI, config.turn_rate).await;
    }
    let (side, turn) = match way {
        Way::Left => (0, FRAC_PI_2),
        Way::Right => (1, -FRAC_PI_2),
        Way::Straight | Way::Turn(_) if gaps.blocked => return pilot.rotate(PI, config.turn_rate).await,
        Way::Straight | Way::Turn(_) => return Ok(()),
    };
    let Some((from, to)) = gaps.sides[side].filter(|(from, to)| to - from >= config.least_width) else {
        // No more than a door: go on, or back if there is no going on.
        return if gaps.blocked { pilot.rotate(PI, config.turn_rate).await } else { Ok(()) };
    };
    pilot.translate(0.5 * (from + to) - gaps.driven, config.speed).await?;
    pilot.rotate(turn, config.turn_rate).await?;
    pilot.translate(0.5 * report.width + INTO_PORT, config.speed).await
}

/// Goes a little away from all that is near.
async fn into_the_open(pilot: &Pilot, config: &PatrolConfig, eyes: &Eyes) -> Result<(), Aborted> {
    pilot.drive(Twist::STOP);
    pilot.sleep(LOOK_ROUND).await?;
    let scan = pilot.latest::<SonarScan>().ok_or(Aborted::TimedOut)?;
    let bearing = eyes.away(&scan).ok_or(Aborted::TimedOut)?;
    pilot.rotate(bearing, config.turn_rate).await?;
    pilot.translate(A_LITTLE, config.speed).await
}

/// What was seen on the way across a place. Distances along the way from where it began, m.
#[derive(Debug, Clone, Copy, Default)]
struct Gaps {
    /// Where each side (left, right) is open, if it is.
    sides: [Option<(f64, f64)>; 2],
    /// How far the robot has come.
    driven: f64,
    /// True if something ahead ended it.
    blocked: bool,
    /// True if the base was kept from going on by something that nobody sees.
    held: bool,
}

/// Drives on until both sides are walls again, or something is ahead.
async fn cross(pilot: &Pilot, config: &PatrolConfig, eyes: &Eyes, report: &CorridorReport) -> Result<Gaps, Aborted> {
    let start = pilot.latest::<PoseEstimate>().ok_or(Aborted::TimedOut)?.travelled;
    let half = if report.width > 0.0 { 0.5 * report.width } else { 0.8 };
    let mut gaps = Gaps::default();
    let mut walls = [0u32; 2];
    let mut near_ahead = 0;
    let mut moved = (0.0, pilot.now());
    pilot.drive(Twist::new(config.speed, 0.0));
    loop {
        let scan = pilot.next::<SonarScan>().await?;
        gaps.driven = pilot.latest::<PoseEstimate>().map_or(gaps.driven, |pose| pose.travelled - start);
        for (side, flank) in eyes.look_out.flanks.iter().enumerate() {
            let Some(free) = eyes.free(&scan, *flank) else { continue };
            if free > half + OPEN {
                let (from, _) = gaps.sides[side].unwrap_or((gaps.driven, 0.0));
                gaps.sides[side] = Some((from, gaps.driven));
                walls[side] = 0;
            } else {
                walls[side] += 1;
            }
        }
        let ahead = eyes.ahead(&scan).unwrap_or(0.0);
        near_ahead = if ahead < AHEAD { near_ahead + 1 } else { 0 };
        if gaps.driven - moved.0 > 0.01 {
            moved = (gaps.driven, pilot.now());
        }
        gaps.blocked = near_ahead >= BELIEVED;
        gaps.held = !gaps.blocked && pilot.now().since(moved.1) > HINDERED;
        let closed = walls.iter().all(|count| *count >= BELIEVED) && gaps.driven > 2.0 * INTO_PORT;
        if closed || gaps.blocked || gaps.held || gaps.driven > WIDEST {
            if gaps.blocked {
                // What is ahead is the far wall of the way to the side.
                for (_, to) in gaps.sides.iter_mut().flatten().filter(|(_, to)| gaps.driven - *to < 0.1) {
                    *to = gaps.driven + ahead;
                }
            }
            pilot.stop();
            pilot.next_step().await?;
            return Ok(gaps);
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
        wiring.reads::<PoseEstimate>().reads::<SonarScan>().reads::<CorridorReport>().writes::<CorridorOrder>();
    }

    fn build(config: Self::Config, robot: &RobotContext) -> Result<Self, BuildError> {
        if robot.platform.turning_radius > 0.0 {
            return Err(BuildError::new("a patrol needs a base that can turn on the spot"));
        }
        let mut wiring = Wiring::default();
        Self::topics(&mut wiring);
        let places = Rc::new(RefCell::new(0));
        let eyes = Eyes::of(&robot.ring).map_err(BuildError::new)?;
        let (random, counter) = (robot.stream("ways"), places.clone());
        let script = Script::new(&wiring, move |pilot| patrol(pilot, config, eyes, random, counter));
        Ok(Self { script, places })
    }
}

#[cfg(test)]
mod tests;
