//! What all detectors are made of: looking, turning, aligning, following (Randazza 1989, §4.2–4.5).
//!
//! * here: looking, turning, driving, and noting points;
//! * `aligning`: facing a wall, or standing along it;
//! * `following`: going along a wall;
//! * `approaching`: getting to where a feature is expected, and into a doorway.
//!
//! Lengths and angles here are those of the robot frame: x ahead, y to the left, angles to the left.

mod aligning;
mod approaching;
mod following;

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
    topics::{FeatureReason, Odometry, PoseEstimate, Side, SonarScan},
};

use crate::clock_ring::{ClockRing, Clockwork, DIRECTIONS, Gathering, STEP, double};

pub use following::Followed;

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

/// The coarse steps of an alignment, rad; larger turns are less gentle.
const COARSE: f64 = 5.0 / 180.0 * std::f64::consts::PI;
/// Two neighbours of the perpendicular that differ by more than this do not look at one wall, m.
const ONE_WALL: f64 = 0.20;
/// Slower than this it stands, m/s.
const STANDS: f64 = 0.005;
/// Who has not come on by this, m, for so long is kept from it: the base protects itself.
const MOVES: f64 = 0.01;
const STUCK: Duration = Duration::from_secs(3);

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
}
