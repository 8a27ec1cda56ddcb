//! The tour: follow, name, choose, leave, until every arm of every place has been gone (Randazza 1989, §2.6: master control).

mod arriving;
mod choosing;
mod following;
mod leaving;
mod naming;
mod reckoning;
mod traffic;

use std::{
    cell::RefCell,
    f64::consts::{FRAC_PI_2, PI},
    rc::Rc,
    sync::Arc,
    time::Duration,
};

use orienteer_runtime::{
    agent::{Aborted, Pilot},
    geometry::{Pose, angle},
    robot_model::Ring,
    topics::{Opening, PoseEstimate},
};
use petgraph::graph::NodeIndex;

use super::{GeographerConfig, chart::Chart, compass::Quarter, map::Change};
use crate::{crumbs::Crumbs, places::Reckoning};
use arriving::Arrived;
use leaving::SetOut;
use reckoning::BOTH;

/// A robot on its tour.
pub(super) struct Tour {
    pub pilot: Pilot,
    pub config: GeographerConfig,
    pub ring: Arc<Ring>,
    pub chart: Rc<RefCell<Chart>>,
    /// Where it has been since it left the last place.
    pub crumbs: Crumbs,
    /// Orders to follower and classifier are numbered on.
    pub orders: u32,
    /// How many ends of corridors it has come to since that were none that it should know.
    pub strange: u32,
    /// How often it could not go a corridor that it knows, since it came to the place where it thinks it is.
    pub lost: u32,
    /// It has come to where it is to let somebody pass.
    pub has_made_way: bool,
}

/// The robot stands at the start pose of a place.
#[derive(Debug, Clone, Copy)]
struct Standing {
    place: NodeIndex,
    facing: Quarter,
    /// The start pose, in the frame of the odometry.
    start: Pose,
    /// What the follower saw of the place.
    opening: Opening,
    reckoning: Reckoning,
    /// How far the place's middle is ahead, m.
    middle: f64,
}

/// The robot has left a place.
#[derive(Debug, Clone, Copy)]
struct Departure {
    place: NodeIndex,
    arm: Quarter,
    /// Where it was then, in the frame of the odometry, and how far from the place's middle, m.
    from: Pose,
    out: f64,
    /// Where it stood before it left.
    stood: Standing,
}

/// Somebody who stands in the way is given so long to go on.
const GIVE_WAY: Duration = Duration::from_secs(4);
/// Who can't go corridors that it knows so often is not where it thinks.
const MISPLACED: u32 = 2;
/// So often the robot finds the way ahead closed before it takes it for the end of a corridor.
const LOOKS: u32 = 3;
/// So often it tries to go where something keeps it from going.
const TRIES: u32 = 12;
/// What is told in a step is heard in the next one. Who has not heard itself after so many has missed something.
const HEARD: u32 = 5;

impl Tour {
    /// Goes on until nothing is left to be explored, or the robot has no part in it any more.
    pub async fn run(mut self) -> Result<(), Aborted> {
        self.pilot.next::<PoseEstimate>().await?;
        let mut departure: Option<Departure> = None;
        while !self.chart.borrow().own.stands_by {
            let set_out = match (self.go_to_next_place(departure.as_ref()).await, departure) {
                (Ok(Arrived::NoPlace), _) => continue,
                (Ok(Arrived::At(standing)), _) => self.set_out(standing).await,
                (Ok(Arrived::Lost), Some(left)) => self.give_up(left).await,
                (Ok(Arrived::TurnedBack), Some(left)) => self.turn_back(left).await,
                (Ok(Arrived::Lost | Arrived::TurnedBack), None) => {
                    self.try_another_direction().await;
                    continue;
                }
                (Ok(Arrived::Astray) | Err(_), _) => SetOut::Astray,
            };
            departure = match set_out {
                SetOut::On(left) => Some(left),
                SetOut::Done => break,
                SetOut::Astray => {
                    self.go_astray().await;
                    None
                }
            };
        }
        Ok(())
    }

    /// Notes that the arm by which the robot has left leads nowhere, goes back, and leaves by another one.
    async fn give_up(&mut self, left: Departure) -> SetOut {
        // A corridor that has been gone can be gone again, by who stands where it begins.
        self.lost += u32::from(self.chart.borrow().map.corridor((left.place, left.arm)).is_some());
        if self.lost >= MISPLACED {
            return SetOut::Astray;
        }
        self.pilot.say("this leads nowhere; goes back");
        self.commit(Change::GivenUp((left.place, left.arm))).await;
        self.go_back_to(left.stood).await
    }

    /// Goes back for somebody who comes the other way.
    async fn turn_back(&mut self, left: Departure) -> SetOut {
        self.pilot.say("turns back for somebody");
        self.has_made_way = true;
        self.go_back_to(left.stood).await
    }

    /// Goes back to where the robot stood before it left, and leaves once more.
    async fn go_back_to(&mut self, stood: Standing) -> SetOut {
        if self.regain(&stood).await && self.go_back(stood.start).await { self.set_out(stood).await } else { SetOut::Astray }
    }

    /// Nothing is known here: the other way may be better. Who has been at both ends may stand across its corridor, or in a doorway.
    async fn try_another_direction(&mut self) {
        self.strange += 1;
        let turn = if self.strange.is_multiple_of(BOTH) { FRAC_PI_2 } else { PI };
        self.pilot.rotate(turn, self.config.turn_rate).await.unwrap_or_default();
    }

    /// The robot does not know where it is. It still knows how corridors lie, and looks along the nearest direction.
    async fn go_astray(&mut self) {
        let (fix, compass) = {
            let mut chart = self.chart.borrow_mut();
            chart.own = chart.own.astray();
            (chart.fix, chart.map.compass())
        };
        let (Some(fix), Some(compass)) = (fix, compass) else { return };
        let heading = fix.in_map(self.here()).heading;
        let off = angle::turn(heading, compass.heading(compass.nearest(heading)));
        let to = angle::wrap(self.here().heading + off);
        self.face(to).await;
    }

    /// Where the robot thinks it is, in the frame of the odometry.
    fn here(&self) -> Pose {
        self.pilot.latest::<PoseEstimate>().map_or_else(Pose::default, |estimate| estimate.pose)
    }

    /// Tells the team of a change, and waits until it is in the map, which is the same for all. Answers with the place that it is about.
    async fn commit(&mut self, change: Change) -> Option<NodeIndex> {
        let told = self.chart.borrow_mut().tell(&change, self.pilot.now());
        self.pilot.publish(told);
        for _ in 0..HEARD {
            // Nobody can take the base from who does not have it; whatever ends the wait, it goes on in the next step.
            self.pilot.next_step().await.ok();
            let chart = self.chart.borrow();
            if chart.has_heard_itself() {
                return chart.last_place();
            }
        }
        let mut chart = self.chart.borrow_mut();
        chart.own = chart.own.standing_by();
        None
    }
}
