//! Wander: straight on until something is touched, back a little, turn, and on.
//!
//! All that a robot needs for it is a bumper, so it is what a base without sonar does, and the simplest behaviour that is of use: whoever
//! wanders for long enough has been everywhere. The turn is drawn by chance, because any fixed one leads round in circles in some
//! room (Brooks 1986 has the robot's lowest level but one *wander* for the same reason).
//!
//! A robot that has a sonar is held by its base before it touches anything; that counts as much as a touch.

use std::{cell::RefCell, rc::Rc, time::Duration};

use orienteer_runtime::{
    agent::{Aborted, Agent, Behaviour, BuildError, Finish, Inputs, Outputs, Pilot, RobotContext, Script, Wiring},
    geometry::Twist,
    time::Time,
    topics::{Odometry, flags},
};
use rand::RngExt;
use rand_pcg::Pcg64;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of wandering.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WanderConfig {
    /// Speed straight on, m/s: what touches something at this speed must bear it.
    #[schemars(range(min = 0.02, max = 1.0))]
    pub speed: f64,
    /// Speed back from what was touched, m/s.
    #[schemars(range(min = 0.02, max = 0.5))]
    pub back_speed: f64,
    /// How far back from what was touched, m.
    #[schemars(range(min = 0.02, max = 1.0))]
    pub back_off: f64,
    /// Turn rate, rad/s.
    #[schemars(range(min = 0.05, max = 3.0))]
    pub turn_rate: f64,
    /// The least turn away from what was touched, degrees.
    #[schemars(range(min = 5.0, max = 180.0))]
    pub least_turn_deg: f64,
    /// The largest, degrees.
    #[schemars(range(min = 5.0, max = 180.0))]
    pub largest_turn_deg: f64,
    /// Who wants to go on and has not for this long, s, is as good as held by something.
    #[schemars(range(min = 0.2, max = 60.0))]
    pub patience: f64,
}

impl Default for WanderConfig {
    fn default() -> Self {
        Self {
            speed: 0.2,
            back_speed: 0.1,
            back_off: 0.12,
            turn_rate: 1.0,
            least_turn_deg: 60.0,
            largest_turn_deg: 150.0,
            patience: 2.0,
        }
    }
}

/// The agent.
#[derive(Debug)]
pub struct Wander {
    script: Script,
    met: Rc<RefCell<Met>>,
}

/// What it has met on its way.
#[derive(Debug, Default)]
struct Met {
    touched: u32,
    held: u32,
}

/// Who touches something again after less than this turns on the same way round: to and fro leads out of no corner. m
const CORNER: f64 = 0.5;
/// Whoever else had the base is given so long before it is taken again.
const RESPECT: Duration = Duration::from_millis(500);
/// Less than this is no way, m.
const STILL: f64 = 0.005;

async fn wander(pilot: Pilot, config: WanderConfig, mut random: Pcg64, met: Rc<RefCell<Met>>) -> Result<(), Aborted> {
    // Where it stands must be known before anything else.
    pilot.next::<Odometry>().await?;
    let (mut side, mut turned_at) = (1.0, f64::NEG_INFINITY);
    loop {
        let end = async {
            let touched = ahead(&pilot, &config).await?;
            let count = |met: &mut Met| if touched { met.touched += 1 } else { met.held += 1 };
            count(&mut met.borrow_mut());
            // Behind it may be something, too; it turns then where it stands.
            match pilot.translate(-config.back_off, config.back_speed).await {
                Ok(()) | Err(Aborted::Blocked) => {}
                Err(lost) => return Err(lost),
            }
            let here = travelled(&pilot);
            if here - turned_at > CORNER + config.back_off {
                side = if random.random_bool(0.5) { 1.0 } else { -1.0 };
            }
            turned_at = here;
            let degrees = config.least_turn_deg + random.random::<f64>() * (config.largest_turn_deg - config.least_turn_deg);
            pilot.rotate(side * degrees.to_radians(), config.turn_rate).await
        };
        if let Err(aborted) = end.await {
            pilot.release();
            if aborted != Aborted::Blocked {
                pilot.sleep(RESPECT).await.ok();
            }
            pilot.next_step().await.ok();
        }
    }
}

/// Straight on until it goes on no more; true if that is because something is touched.
async fn ahead(pilot: &Pilot, config: &WanderConfig) -> Result<bool, Aborted> {
    pilot.drive(Twist::new(config.speed, 0.0));
    let (mut mark, mut since) = (travelled(pilot), pilot.now());
    loop {
        pilot.next_step().await?;
        let Some(odometry) = pilot.latest::<Odometry>() else { continue };
        if odometry.flags & (flags::CONTACT | flags::STALLED) != 0 {
            return Ok(true);
        }
        // In somebody's hands, or with the red button pressed, there is nothing to turn from.
        if odometry.travelled - mark > STILL || odometry.flags & flags::EMERGENCY_STOP != 0 {
            (mark, since) = (odometry.travelled, pilot.now());
        }
        if pilot.now().secs_since(since) > config.patience {
            return Ok(false);
        }
    }
}

fn travelled(pilot: &Pilot) -> f64 {
    pilot.latest::<Odometry>().map_or(0.0, |odometry| odometry.travelled)
}

impl Behaviour for Wander {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        self.script.step(now, inputs, out);
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        let met = self.met.borrow();
        last_words.fact("touched", f64::from(met.touched));
        last_words.fact("held", f64::from(met.held));
    }
}

impl Agent for Wander {
    const KIND: &'static str = "wander";
    const HELP: &'static str = "goes straight on until it touches something, turns away, and goes on";
    const PRIORITY: u8 = 3;
    type Config = WanderConfig;

    fn topics(wiring: &mut Wiring) {
        wiring.reads::<Odometry>();
    }

    fn build(config: Self::Config, robot: &RobotContext) -> Result<Self, BuildError> {
        if robot.platform.turning_radius > 0.0 {
            return Err(BuildError::new("wandering needs a base that can turn on the spot"));
        }
        if config.least_turn_deg > config.largest_turn_deg {
            return Err(BuildError::new("`least_turn_deg` is more than `largest_turn_deg`"));
        }
        let mut wiring = Wiring::default();
        Self::topics(&mut wiring);
        let met = Rc::new(RefCell::new(Met::default()));
        let (random, counter) = (robot.stream("turns"), met.clone());
        let script = Script::new(&wiring, move |pilot| wander(pilot, config, random, counter));
        Ok(Self { script, met })
    }
}

#[cfg(test)]
mod tests;
