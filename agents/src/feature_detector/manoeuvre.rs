//! What all detectors are made of: looking, turning, aligning, following (Randazza 1989, §4.2–4.5).
//!
//! Lengths and angles here are those of the robot frame: x ahead, y to the left, angles to the left.

use std::{
    cell::{Cell, RefCell},
    f64::consts::FRAC_PI_2,
    rc::Rc,
    time::Duration,
};

use orienteer_runtime::{
    agent::{Aborted, Inputs, Pilot, PoseHandle, Strategy},
    geometry::{Pose, Twist, angle},
    time::Time,
    topics::{FeatureReason, FeatureSearch, Odometry, PoseEstimate, Side, SonarScan},
};

use crate::clock_ring::{ClockRing, Clockwork, DIRECTIONS, Gathering, STEP, double};

use super::{
    FeatureDetectorConfig,
    recovery::{LastOverride, Recovery},
    wall_tests::{Beside, abeam, wall_ahead, wall_beside},
};

/// Why a detector ends before it has found its feature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ended {
    /// The feature is not there.
    NotFound(FeatureReason),
    /// The robot could not look.
    Aborted(Aborted),
}

impl From<Aborted> for Ended {
    fn from(aborted: Aborted) -> Self {
        Ended::Aborted(aborted)
    }
}

/// Coarse and fine steps of an alignment, rad, and how many of each there may be one way.
const COARSE: f64 = 5.0 / 180.0 * std::f64::consts::PI;
const COARSE_STEPS: i32 = 12;
const FINE: f64 = 1.0 / 180.0 * std::f64::consts::PI;
const FINE_STEPS: i32 = 25;
/// So many changes of direction end an alignment: the noise decides by then.
const THRASHES: i32 = 5;
/// Two ranges are the same within this, m: half the step in which a Denning ring counts.
const SAME: f64 = 0.016;
/// Two neighbours of the perpendicular that differ by more than this do not look at one wall, m.
const ONE_WALL: f64 = 0.20;
/// Who turned by more than this to face a wall has met something else, rad.
const SKEWED: f64 = 25.0 / 180.0 * std::f64::consts::PI;
/// A wall that is nearer than this beside the robot is too near, m from the sonar's face; and by how much to turn off then, rad.
const TOO_NEAR: f64 = 0.30;
const OFF: f64 = 4.0 / 180.0 * std::f64::consts::PI;
/// So often a base that is kept from going on beside a wall this near, m from the sonar's face, is steered off it.
const NEAR: f64 = 0.36;
const BLOCKED: u32 = 2;
/// Who has not come on by this, m, for so long is kept from it: the base protects itself.
const MOVES: f64 = 0.01;
const STUCK: Duration = Duration::from_secs(3);
/// Who is kept from coming nearer than this to where it should stand first is near enough, m.
const NEARLY_THERE: f64 = 0.10;
/// Slower than this it stands, m/s.
const STANDS: f64 = 0.005;

/// One run of a detector.
pub struct Manoeuvre {
    pub pilot: Pilot,
    pub config: Rc<FeatureDetectorConfig>,
    clockwork: Rc<Clockwork>,
    recovery: Recovery,
    last_override: Rc<LastOverride>,
    /// All that it has turned, without sign, rad.
    turned: Cell<f64>,
    /// When it came on last while it followed something, and how far it had travelled then.
    moved: Cell<(Time, f64)>,
    /// The points that it has recorded, in the order of the sequence that the detector gives them.
    points: RefCell<Vec<Pose>>,
}

/// How a wall was followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Followed {
    /// The wall ended before the length that was asked for.
    pub wall_ended: bool,
    /// How far it went, m.
    pub length: f64,
}

impl Manoeuvre {
    pub fn new(
        pilot: Pilot,
        config: Rc<FeatureDetectorConfig>,
        clockwork: Rc<Clockwork>,
        last_override: Rc<LastOverride>,
    ) -> Self {
        let recovery = Recovery::new(config.recoveries);
        Self {
            pilot,
            config,
            clockwork,
            recovery,
            last_override,
            turned: Cell::new(0.0),
            moved: Cell::default(),
            points: RefCell::default(),
        }
    }

    /// All that it has turned, without sign, rad.
    pub fn turned(&self) -> f64 {
        self.turned.get()
    }

    /// The points that it has recorded so far.
    pub fn points(&self) -> Vec<Pose> {
        self.points.borrow().clone()
    }

    /// How far the transducers' faces are from the robot's centre, m.
    pub fn face(&self) -> f64 {
        self.clockwork.face
    }

    /// A ring of distinct passes.
    pub async fn ring(&self) -> Result<ClockRing, Aborted> {
        self.undisturbed(async || {
            let mut gathering = Gathering::new(self.config.readings as usize);
            self.pilot.until(|inputs| self.gather(&mut gathering, inputs)).await?;
            Ok(gathering.ring(self.config.filter))
        })
        .await
    }

    /// A part of the manoeuvre that begins here, once more if somebody comes between.
    async fn undisturbed<T>(&self, part: impl AsyncFn() -> Result<T, Aborted>) -> Result<T, Aborted> {
        let [.., fast] = self.config.turn_rates_deg;
        let pace = (self.config.travel_speed, fast.to_radians());
        self.recovery.undisturbed(&self.pilot, &self.last_override, self.pose()?, pace, part).await
    }

    fn gather(&self, gathering: &mut Gathering, inputs: &Inputs) -> bool {
        for scan in inputs.each::<SonarScan>() {
            gathering.hear(&self.clockwork, scan);
        }
        gathering.is_full()
    }

    async fn double_ring(&self) -> Result<[f64; 2 * DIRECTIONS], Aborted> {
        let first = self.ring().await?;
        self.turn(-0.5 * STEP).await?;
        let second = self.ring().await?;
        self.turn(0.5 * STEP).await?;
        Ok(double(&first, &second))
    }

    /// Looks for a wall on a side, more than once before it says that there is none.
    pub async fn is_wall_beside(&self, side: Side) -> Result<bool, Aborted> {
        for _ in 0..self.config.tries {
            if wall_beside(&self.ring().await?, side) == Beside::Wall {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Looks for a wall ahead, more than once before it says that there is none.
    pub async fn is_wall_ahead(&self) -> Result<bool, Aborted> {
        for _ in 0..self.config.tries {
            if wall_ahead(&self.double_ring().await?) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Turns, the more gently the less.
    pub async fn turn(&self, angle: f64) -> Result<(), Aborted> {
        let rates = self.config.turn_rates_deg;
        let size = angle.abs() + 1e-9;
        let rate = if size >= FRAC_PI_2 {
            rates[2]
        } else if size > COARSE + 1e-6 {
            rates[1]
        } else {
            rates[0]
        };
        self.turned.set(self.turned.get() + angle.abs());
        self.undisturbed(async || self.pilot.rotate(angle, rate.to_radians()).await).await
    }

    /// Drives straight on, or back.
    pub async fn go(&self, distance: f64) -> Result<(), Aborted> {
        self.undisturbed(async || self.pilot.translate(distance, self.config.travel_speed).await).await
    }

    /// The same where it is narrow.
    pub async fn creep(&self, distance: f64) -> Result<(), Aborted> {
        self.undisturbed(async || self.pilot.translate(distance, self.config.creep_speed).await).await
    }

    /// Drives until what is ahead is as far from the front sonar as this.
    pub async fn close_up(&self, distance: f64) -> Result<(), Aborted> {
        let ahead = self.ring().await?[0];
        self.go(ahead - distance).await
    }

    /// Drives to a pose.
    pub async fn go_to(&self, goal: PoseHandle, strategy: Strategy) -> Result<(), Aborted> {
        let [.., fast] = self.config.turn_rates_deg;
        let from = self.pose()?;
        let rate = fast.to_radians();
        self.undisturbed(async || self.pilot.move_to(goal, strategy, self.config.travel_speed, rate).await).await?;
        // What it turned on the way is not told; between the two headings it turned at least this.
        self.turned.set(self.turned.get() + angle::turn(from.heading, goal.pose().heading).abs());
        Ok(())
    }

    /// Where the robot thinks it is.
    pub fn pose(&self) -> Result<Pose, Aborted> {
        self.pilot.latest::<PoseEstimate>().map(|estimate| estimate.pose).ok_or(Aborted::TimedOut)
    }

    /// Notes a place that lies there from the robot.
    pub fn mark(&self, offset: Pose) -> Result<PoseHandle, Aborted> {
        self.pilot.save_pose(offset).ok_or(Aborted::TimedOut)
    }

    /// Records a point of the feature that lies there from the robot.
    pub fn record(&self, x: f64, y: f64) -> Result<(), Aborted> {
        let point = self.mark(Pose::new(x, y, 0.0))?.pose();
        self.points.borrow_mut().push(point);
        Ok(())
    }

    /// Records a point that was noted before.
    pub fn record_point(&self, point: Pose) {
        self.points.borrow_mut().push(point);
    }

    /// Records the point of the wall beside the robot.
    pub async fn record_beside(&self, side: Side) -> Result<(), Aborted> {
        let y = self.beside(side).await?;
        self.record(0.0, y)
    }

    /// Where the wall beside the robot is, m to the left of its centre.
    pub async fn beside(&self, side: Side) -> Result<f64, Aborted> {
        Ok(side.sign() * (self.ring().await?[abeam(side)] + self.face()))
    }

    /// Brings the robot parallel to the wall on a side, or a little off it if that is too near.
    pub async fn align_beside(&self, side: Side) -> Result<(), Ended> {
        self.align(abeam(side), false).await?;
        self.turn_off(side, &self.ring().await?).await?;
        Ok(())
    }

    /// Brings the robot perpendicular to the wall ahead.
    pub async fn align_ahead(&self) -> Result<(), Ended> {
        let turned = self.align(0, true).await?;
        if turned.abs() > SKEWED { Err(Ended::NotFound(FeatureReason::Skewed)) } else { Ok(()) }
    }

    /// Turns until the given direction hears the nearest and its neighbours hear the same: coarse steps, then fine ones. Says how
    /// far it has turned, to the left.
    async fn align(&self, middle: usize, ahead: bool) -> Result<f64, Ended> {
        let coarse = self.align_coarsely(middle, ahead).await?;
        let fine = self.align_finely(middle).await?;
        Ok(coarse + fine)
    }

    async fn align_coarsely(&self, middle: usize, ahead: bool) -> Result<f64, Ended> {
        let mut steps = [0; 2];
        loop {
            let ring = self.ring().await?;
            let off = |by: i32| ring[(middle as i32 + by).rem_euclid(DIRECTIONS as i32) as usize];
            // Where several are as near, the middle one counts.
            let nearest = [0, -1, 1, -2, 2].into_iter().fold(0, |nearest, by| if off(by) < off(nearest) { by } else { nearest });
            // Beams that are about perpendicular hear the same; what is ahead need not be nearest by more than the noise.
            if nearest == 0 || (ahead && off(0) <= off(nearest) + SAME) {
                return Ok(COARSE * f64::from(steps[0] - steps[1]));
            }
            // Nearest before the middle, clockwise: the nose goes to the left.
            let way = usize::from(nearest > 0);
            steps[way] += 1;
            if steps[way] > COARSE_STEPS {
                return Err(Ended::NotFound(FeatureReason::NotAligned));
            }
            self.turn(if way == 0 { COARSE } else { -COARSE }).await?;
        }
    }

    async fn align_finely(&self, middle: usize) -> Result<f64, Ended> {
        let (mut steps, mut thrashes, mut turned) = (0, 0, 0.0);
        let mut last = 0.0;
        loop {
            let ring = self.ring().await?;
            let before = ring[(middle + DIRECTIONS - 1) % DIRECTIONS];
            let after = ring[(middle + 1) % DIRECTIONS];
            if (after - before).abs() < SAME || (after - before).abs() > ONE_WALL {
                return Ok(turned);
            }
            // The one before is nearer: the nose goes to the left.
            let step = if after > before { FINE } else { -FINE };
            if last * step < 0.0 {
                thrashes += 1;
                if thrashes >= THRASHES {
                    return Ok(turned);
                }
            } else {
                steps += 1;
                if steps > FINE_STEPS {
                    return Err(Ended::NotFound(FeatureReason::NotAligned));
                }
            }
            self.turn(step).await?;
            (turned, last) = (turned + step, step);
        }
    }

    /// Follows the wall on a side for a length, or until it ends.
    pub async fn follow(&self, side: Side, length: f64) -> Result<Followed, Aborted> {
        self.undisturbed(async || self.follow_once(side, length).await).await
    }

    async fn follow_once(&self, side: Side, length: f64) -> Result<Followed, Aborted> {
        let start = self.travelled()?;
        let (mut missing, mut blocked) = (0, 0);
        let mut wall_ended = !self.is_wall_beside(side).await?;
        if !wall_ended {
            self.cruise(self.config.speed)?;
        }
        while !wall_ended && missing < self.config.tries {
            let ring = match self.ring_within(start + length).await {
                // By the wall that it follows, or by something else?
                Err(Aborted::Blocked) if blocked < BLOCKED && self.ring().await?[abeam(side)] < NEAR => {
                    blocked += 1;
                    self.steer_off(side).await?;
                    self.cruise(self.config.speed)?;
                    continue;
                }
                ring => ring?,
            };
            let Some(ring) = ring else { break };
            missing = if wall_beside(&ring, side) == Beside::Wall { 0 } else { missing + 1 };
            wall_ended = missing >= self.config.tries;
            if missing == 0 && self.turn_off(side, &ring).await? {
                self.cruise(self.config.speed)?;
            }
        }
        self.stand().await?;
        Ok(Followed { wall_ended, length: self.travelled()? - start })
    }

    /// Turns a little off a wall that is too near to be followed: so near, the beams hear the same over several degrees, and an alignment
    /// leaves the robot on its way into the wall. Says whether it did.
    async fn turn_off(&self, side: Side, ring: &ClockRing) -> Result<bool, Aborted> {
        let near = ring[abeam(side)] < TOO_NEAR;
        if near {
            self.steer_off(side).await?;
        }
        Ok(near)
    }

    async fn steer_off(&self, side: Side) -> Result<(), Aborted> {
        self.stand().await?;
        self.turn(-side.sign() * OFF).await
    }

    /// Follows the wall on a side until there is something as near ahead as `front`.
    pub async fn follow_to_corner(&self, side: Side, longest: f64, front: f64) -> Result<(), Ended> {
        let wrong = self.undisturbed(async || self.follow_to_corner_once(side, longest, front).await).await?;
        wrong.map_or(Ok(()), |reason| Err(Ended::NotFound(reason)))
    }

    /// Says what is wrong, if anything is.
    async fn follow_to_corner_once(&self, side: Side, longest: f64, front: f64) -> Result<Option<FeatureReason>, Aborted> {
        let start = self.travelled()?;
        let mut missing = 0;
        let mut ended = (!self.is_wall_beside(side).await?).then_some(FeatureReason::NoWallBeside);
        if ended.is_none() {
            self.cruise(self.config.speed)?;
        }
        while ended.is_none() {
            let Some(ring) = self.ring_within(start + longest).await? else {
                ended = Some(FeatureReason::WallTooLong);
                break;
            };
            if ring[0] <= front {
                break;
            }
            missing = if wall_beside(&ring, side) == Beside::Wall { 0 } else { missing + 1 };
            ended = (missing >= self.config.tries).then_some(FeatureReason::WallTooShort);
        }
        self.stand().await?;
        Ok(ended)
    }

    /// A ring while it drives; `None` when it has come so far, m travelled. A base that is kept from going on is
    /// [blocked](Aborted::Blocked).
    async fn ring_within(&self, end: f64) -> Result<Option<ClockRing>, Aborted> {
        let mut gathering = Gathering::new(self.config.readings as usize);
        loop {
            // The pass that came in the very first step was of the ring before.
            self.pilot.next_step().await?;
            let travelled = self.travelled()?;
            let mut is_full = false;
            self.pilot
                .until(|inputs| {
                    is_full = self.gather(&mut gathering, inputs);
                    true
                })
                .await?;
            if is_full {
                return Ok(Some(gathering.ring(self.config.filter)));
            }
            if travelled >= end {
                return Ok(None);
            }
            let (since, from) = self.moved.get();
            if travelled - from > MOVES {
                self.moved.set((self.pilot.now(), travelled));
            } else if self.pilot.now().since(since) > STUCK {
                return Err(Aborted::Blocked);
            }
        }
    }

    /// Drives on until something else is ordered.
    fn cruise(&self, speed: f64) -> Result<(), Aborted> {
        self.moved.set((self.pilot.now(), self.travelled()?));
        self.pilot.drive(Twist::new(speed, 0.0));
        Ok(())
    }

    /// Stops, and waits until it stands.
    pub async fn stand(&self) -> Result<(), Aborted> {
        self.pilot.stop();
        self.pilot.next_step().await?;
        let stands = |odometry: &Odometry| odometry.twist.linear.abs() < STANDS && odometry.twist.angular.abs() < STANDS;
        self.pilot.until(|inputs| inputs.latest::<Odometry>().is_some_and(stands)).await
    }

    fn travelled(&self) -> Result<f64, Aborted> {
        self.pilot.latest::<PoseEstimate>().map(|estimate| estimate.travelled).ok_or(Aborted::TimedOut)
    }

    /// Brings the robot, which stands before a doorway, to the middle of its thickness, and to the right distance from the post on
    /// that side.
    pub async fn between_doorposts(&self, side: Side) -> Result<(), Ended> {
        let config = &self.config;
        let mut steps = 0;
        while self.ring().await?[abeam(side)] > config.doorpost {
            if steps == config.doorpost_steps {
                return Err(Ended::NotFound(FeatureReason::NoWallBeside));
            }
            steps += 1;
            self.creep(0.05).await?;
        }
        self.cruise(config.creep_speed)?;
        let end = self.travelled()? + 2.0 * config.wall_thickness + config.wall_overshoot;
        let mut passed = false;
        while let Some(ring) = self.ring_within(end).await? {
            passed = ring[abeam(side)] > config.doorpost;
            if passed {
                break;
            }
        }
        self.stand().await?;
        if !passed {
            return Err(Ended::NotFound(FeatureReason::WallTooLong));
        }
        self.creep(-(0.5 * config.wall_thickness + config.wall_overshoot)).await?;
        self.turn(side.sign() * FRAC_PI_2).await?;
        self.close_up(config.doorpost_distance).await?;
        self.turn(-side.sign() * FRAC_PI_2).await?;
        Ok(())
    }

    /// Drives to a pose. Where the base can't go on just before it, that will do.
    async fn reach(&self, at: Pose, strategy: Strategy) -> Result<(), Aborted> {
        match self.go_to(PoseHandle::at(at), strategy).await {
            Err(Aborted::Blocked) if self.pose()?.distance(&at) < NEARLY_THERE => {
                self.turn(angle::turn(self.pose()?.heading, at.heading)).await
            }
            ended => ended,
        }
    }

    /// What all detectors begin with: goes to where the feature is expected, faces its wall, and comes near.
    pub async fn approach(&self, search: &FeatureSearch) -> Result<(), Ended> {
        // Whichever side has one wall all along tells how the robot really stands; the way to the place turns with it.
        let before = self.pose()?;
        let ring = self.ring().await?;
        let whole = |side: Side| {
            let (before, after) = (ring[abeam(side) - 1], ring[abeam(side) + 1]);
            wall_beside(&ring, side) == Beside::Wall && (before - after).abs() < 0.5 * ONE_WALL
        };
        if let Some(side) = [Side::Right, Side::Left].into_iter().find(|side| whole(*side)) {
            self.align_beside(side).await?;
        }
        let strategy = if search.forward_first { Strategy::ForwardFirst } else { Strategy::Straight };
        let at = self.pose()?.then(before.between(search.at));
        self.reach(at, strategy).await?;
        if !self.is_wall_ahead().await? {
            return Err(Ended::NotFound(FeatureReason::NoWallAhead));
        }
        self.align_ahead().await?;
        self.close_up(self.config.clearance).await?;
        Ok(())
    }
}
