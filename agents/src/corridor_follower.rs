//! Corridor follower: takes the robot along the middle of a corridor to the next place.
//!
//! It answers a [`CorridorOrder`] with a [`CorridorReport`]: the robot has come to an opening on one or both sides, or to a
//! dead end, and stands at the *start pose* from which the place can be explored: in the middle of the corridor, facing along
//! it, the front sonar level with the near corner (Randazza 1989, §3.1 and figure 2, which says what the follower does and
//! prints no law for it).
//!
//! * [`CorridorFilter`] works out where the robot is between the walls, from all transducers that can see one.
//!   Where it starts, the walls are found by vote; where they step in or out by less than an opening, it takes them where they
//!   now are, so that the middle is always that of the free way between cupboards.
//! * [`SideWatch`] notices where a wall ends and where its corner must be.
//! * [`Follower`] is the manoeuvre: settle, follow, look past the corner, come back to the start pose, report.
//!
//! While a higher priority has the base the follower hangs on, goes on listening, and resumes when the base comes back.

mod acquire;
mod corridor_filter;
mod follower;
mod median;
mod side_watch;
mod wall_shift;

use orienteer_runtime::{
    agent::{Agent, Behaviour, BuildError, Finish, Inputs, Outputs, RobotContext, Wiring},
    arbitration::client::BaseState,
    time::Time,
    topics::{CorridorOrder, CorridorReport, Odometry, Opening, PoseEstimate, SonarScan},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use corridor_filter::{Comparison, CorridorFilter};
pub use follower::{Follower, Wish};
pub use orienteer_runtime::topics::Side;
pub use side_watch::SideWatch;

/// Parameters of the corridor follower.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CorridorFollowerConfig {
    /// Speed along a corridor, m/s. Randazza (1989) creeps at 0.08; 0.20 keeps the corner of an opening within 2 cm.
    #[schemars(range(min = 0.02, max = 2.0))]
    pub cruise_speed: f64,
    /// Speed while looking past a corner and coming back to the start pose, m/s (Randazza 1989, §1.4: 0.08).
    #[schemars(range(min = 0.01, max = 0.5))]
    pub creep_speed: f64,
    /// Largest turn rate, rad/s.
    #[schemars(range(min = 0.05, max = 3.0))]
    pub turn_rate: f64,
    /// Distance ahead at which the course meets the middle of the corridor, m. Shorter corrects harder.
    #[schemars(range(min = 0.2, max = 5.0))]
    pub look_ahead: f64,
    /// Clear distance ahead of the front sonar at which the follower stops, m (Randazza 1989, §3: 0.48).
    #[schemars(range(min = 0.1, max = 3.0))]
    pub front_stop: f64,
    /// A side must have been a wall for this long, m, before its end counts as an opening.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub wall_before_opening: f64,
    /// An opening is at least so much deeper than the wall, m: the robot's body fits into it. Less is a recess, or the end of a
    /// cupboard.
    #[schemars(range(min = 0.1, max = 5.0))]
    pub opening_depth: f64,
    /// How far to go on past the first corner to see whether the other side opens as well, m.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub probe: f64,
    /// Seconds that something must block the way before the follower takes it for a dead end; people move on.
    #[schemars(range(min = 0.0, max = 600.0))]
    pub patience: f64,
    /// Drive on without seeing any wall for at most this far, m, then report that the way is lost.
    #[schemars(range(min = 0.0, max = 20.0))]
    pub blind: f64,
    /// Start following at once, without waiting for an order.
    pub autostart: bool,
}

impl Default for CorridorFollowerConfig {
    fn default() -> Self {
        Self {
            cruise_speed: 0.2,
            creep_speed: 0.08,
            turn_rate: 0.8,
            look_ahead: 0.8,
            front_stop: 0.48,
            wall_before_opening: 0.5,
            opening_depth: 0.65,
            probe: 0.1,
            patience: 5.0,
            blind: 2.5,
            autostart: false,
        }
    }
}

/// The agent: runs a [`Follower`] for each order.
#[derive(Debug)]
pub struct CorridorFollower {
    follower: Follower,
    /// The order that it carries out; 0 for none.
    order: u32,
    /// The last one that it has reported. Whoever gave it repeats it until the report has arrived.
    done: u32,
    autostart: bool,
    /// Whether a higher priority has the base, and how often one has taken it during this order.
    overridden: bool,
    overrides: u32,
    stretches: u32,
    /// How the stretches ended.
    endings: [u32; ENDINGS.len()],
}

/// Names under which the follower counts how its stretches ended.
const ENDINGS: [(Opening, &str); 5] = [
    (Opening::Left, "openings_left"),
    (Opening::Right, "openings_right"),
    (Opening::Both, "openings_both"),
    (Opening::DeadEnd, "dead_ends"),
    (Opening::Lost, "lost"),
];

impl CorridorFollower {
    fn take_orders(&mut self, inputs: &Inputs, out: &mut Outputs) {
        let order = match inputs.fresh::<CorridorOrder>() {
            Some(order) => order.order,
            None if self.autostart && self.stretches == 0 && self.order == 0 => 1,
            None => return,
        };
        if order == self.order || (order == self.done && order != 0) {
            return;
        }
        self.order = order;
        if order == 0 {
            self.follower.call_off();
            out.base.release();
        } else {
            self.overrides = 0;
            self.follower.begin();
        }
    }
}

impl Behaviour for CorridorFollower {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        self.take_orders(inputs, out);
        for odometry in inputs.each::<Odometry>() {
            self.follower.moved(odometry);
        }
        for scan in inputs.each::<SonarScan>() {
            self.follower.heard(scan);
        }
        let overridden = matches!(out.base.state(), BaseState::Overridden { .. });
        if overridden {
            self.follower.overridden();
        }
        self.overrides += u32::from(overridden && !std::mem::replace(&mut self.overridden, overridden));
        self.overridden = overridden;
        match self.follower.wish(now) {
            Wish::Nothing => {}
            Wish::Drive(twist) => out.base.drive(twist),
            Wish::Report { opening, width, ahead, length } => {
                let pose = inputs.latest::<PoseEstimate>().map_or_else(Default::default, |estimate| estimate.pose);
                let mut report = CorridorReport::new(now, self.order, opening);
                (report.pose, report.width, report.ahead, report.length) = (pose, width, ahead, length);
                report.overrides = std::mem::take(&mut self.overrides);
                out.publish(report);
                out.say(format!("{opening:?} after {length:.2} m"));
                out.base.release();
                self.stretches += 1;
                for (count, _) in self.endings.iter_mut().zip(ENDINGS).filter(|(_, (ending, _))| *ending == opening) {
                    *count += 1;
                }
                self.done = self.order;
                self.order = 0;
            }
        }
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        last_words.fact("corridors", f64::from(self.stretches));
        for (count, (_, name)) in self.endings.iter().zip(ENDINGS) {
            last_words.fact(name, f64::from(*count));
        }
    }
}

impl Agent for CorridorFollower {
    const KIND: &'static str = "corridor-follower";
    const HELP: &'static str = "keeps to the middle of a corridor and stops at its next opening or end";
    type Config = CorridorFollowerConfig;

    fn topics(wiring: &mut Wiring) {
        wiring.reads::<SonarScan>().reads::<Odometry>().reads::<PoseEstimate>().reads_if_any::<CorridorOrder>();
        wiring.writes::<CorridorReport>();
    }

    fn build(config: Self::Config, robot: &RobotContext) -> Result<Self, BuildError> {
        let follower = Follower::new(config, robot.ring.clone(), robot.platform.clone()).map_err(BuildError::new)?;
        Ok(Self {
            follower,
            order: 0,
            done: 0,
            autostart: config.autostart,
            overridden: false,
            overrides: 0,
            stretches: 0,
            endings: Default::default(),
        })
    }
}
