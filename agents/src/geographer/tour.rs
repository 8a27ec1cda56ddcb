//! The tour: follow, name, choose, leave, until every arm of every place has been gone (Randazza 1989, §2.6: master control).

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

use super::{
    GeographerConfig,
    chart::Chart,
    compass::Quarter,
    map::{Change, Place},
};
use crate::{crumbs::Crumbs, places::Reckoning};
use leaving::SetOut;
use naming::Named;
use reckoning::{BOTH, Reached, Which};

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

/// How a stretch of corridor ended.
enum Arrived {
    /// At a place.
    At(Standing),
    /// Where there is no place: go on.
    Nowhere,
    /// The corridor is none, or the way is lost.
    Lost,
    /// The robot is not where it would have to be, and can't get there: it has to find a place that it knows.
    Astray,
}

/// Somebody who stands in the way is given so long to go on.
const GIVE_WAY: Duration = Duration::from_secs(4);
/// Who can't go corridors that it knows so often is not where it thinks.
const MISPLACED: u32 = 2;
/// So often the robot finds the way ahead closed before it takes it for the end of a corridor.
const LOOKS: u32 = 3;
/// So often it tries to go where something keeps it from going.
const TRIES: u32 = 12;

impl Tour {
    /// Goes on until nothing is left to be explored.
    pub async fn run(mut self) -> Result<(), Aborted> {
        self.pilot.next::<PoseEstimate>().await?;
        let mut departure: Option<Departure> = None;
        loop {
            let set_out = match self.stretch(departure.as_ref()).await? {
                Arrived::Nowhere => continue,
                Arrived::At(standing) => self.set_out(standing).await,
                Arrived::Astray => SetOut::Astray,
                Arrived::Lost => match departure {
                    Some(lost) if !self.is_misplaced(&lost) && self.give_up(&lost).await => self.set_out(lost.stood).await,
                    Some(_) => SetOut::Astray,
                    // Nothing is known here: the other way may be better.
                    None => {
                        self.strange += 1;
                        // Who has been at both ends may stand across its corridor, or in a doorway.
                        let turn = if self.strange.is_multiple_of(BOTH) { FRAC_PI_2 } else { PI };
                        self.pilot.rotate(turn, self.config.turn_rate).await.unwrap_or_default();
                        continue;
                    }
                },
            };
            departure = match set_out {
                SetOut::On(left) => Some(left),
                SetOut::Done => return Ok(()),
                SetOut::Astray => {
                    self.chart.borrow_mut().go_astray();
                    self.look_along_the_nearest_direction().await;
                    None
                }
            };
        }
    }

    /// A corridor that has been gone can be gone again, by who stands where it begins.
    fn is_misplaced(&mut self, lost: &Departure) -> bool {
        self.lost += u32::from(self.chart.borrow().map.corridor((lost.place, lost.arm)).is_some());
        self.lost >= MISPLACED
    }

    /// Who does not know what corridor it is in still knows how corridors lie.
    async fn look_along_the_nearest_direction(&mut self) {
        let (fix, compass) = (self.chart.borrow().fix, self.chart.borrow().map.known_compass());
        let (Some(fix), Some(compass)) = (fix, compass) else { return };
        let heading = fix.in_map(self.here()).heading;
        let off = angle::turn(heading, compass.heading(compass.nearest(heading)));
        let to = angle::wrap(self.here().heading + off);
        self.face(to).await;
    }

    /// Follows the corridor to its next place, and names it if it is new.
    async fn stretch(&mut self, departure: Option<&Departure>) -> Result<Arrived, Aborted> {
        let from = departure.map_or_else(|| self.here(), |departure| departure.from);
        let Some(mut report) = self.follow(from).await? else { return Ok(Arrived::Lost) };
        if self.chart.borrow().map.known_compass().is_none() {
            self.commit(Change::Compass(report.pose.heading)).await;
        }
        for _ in 0..LOOKS {
            if report.overrides == 0 {
                break;
            }
            // Who was driven about near the corner may stand anywhere before it, or behind it.
            let Some(again) = self.come_again(from, &report).await? else { return Ok(Arrived::Astray) };
            report = again;
        }
        let width = if report.width > 0.0 { report.width } else { self.config.width };
        let reckoning = Reckoning::new(width, &self.ring);
        let middle = if report.opening() == Opening::DeadEnd { 0.0 } else { reckoning.face + 0.5 * width };
        let Some(reached) = self.reached(departure, &report, middle) else { return Ok(Arrived::Lost) };
        let (known, short) = match self.which_place(departure, &reached, report.opening()) {
            Which::Known(place, short) => (Some(place), short),
            Which::New => (None, 0.0),
            Which::None => return Ok(Arrived::Nowhere),
            Which::Lost => return Ok(Arrived::Lost),
        };
        let Reached { at, covariance, facing, length } = reached;
        let start = report.pose.then(Pose::new(short, 0.0, 0.0));
        let mut standing = Standing { place: NodeIndex::end(), facing, start, opening: report.opening(), reckoning, middle };
        if let Some(known) = known {
            standing.place = known;
            if short == 0.0 {
                self.commit(Change::SeenAgain { place: known, at, covariance }).await;
            }
            let name = self.chart.borrow().map.place(known).map(|place| place.name.clone()).unwrap_or_default();
            self.pilot.announce(format!("at {name} again"));
        } else {
            self.chart.borrow_mut().arrive_at_new(at);
            let place = match self.name_at_last(&mut standing, report).await {
                Named::Place(place) => place,
                Named::Nothing => return Ok(Arrived::Nowhere),
                Named::Astray => return Ok(Arrived::Astray),
            };
            let Some(place) = self.commit(Change::Found(Place { at, covariance, ..place })).await else {
                return Ok(Arrived::Astray);
            };
            standing.place = place;
            self.chart.borrow_mut().added += 1;
        }
        if let (Some(departure), Some(length)) = (departure, length.filter(|_| short == 0.0)) {
            let (from, to) = ((departure.place, departure.arm), (standing.place, facing.back()));
            self.commit(Change::Joined { from, to, length }).await;
        }
        let fix = self.fix_at(&standing);
        (self.strange, self.lost) = (0, 0);
        {
            let mut chart = self.chart.borrow_mut();
            chart.fix = fix;
            chart.arrive_at(standing.place);
        }
        self.tell(standing.place);
        Ok(Arrived::At(standing))
    }

    /// Where the robot thinks it is, in the frame of the odometry.
    fn here(&self) -> Pose {
        self.pilot.latest::<PoseEstimate>().map_or_else(Pose::default, |estimate| estimate.pose)
    }

    /// Tells the team of a change, and waits until it is in the map, which is the same for all. Answers with the place that it is about.
    async fn commit(&mut self, change: Change) -> Option<NodeIndex> {
        let told = self.chart.borrow_mut().tell(&change, self.pilot.now());
        self.pilot.publish(told);
        loop {
            // Nobody can take the base from who does not have it; whatever ends the wait, it goes on in the next step.
            self.pilot.next_step().await.ok();
            if let Some(place) = self.chart.borrow().is_up_to_date() {
                return place;
            }
        }
    }

    /// Says what is known now.
    fn tell(&self, place: NodeIndex) {
        let map = &self.chart.borrow().map;
        let Some(at) = map.place(place).filter(|place| place.visits == 1) else { return };
        let (places, corridors, open) = (map.places().len(), map.corridors().count(), map.unexplored());
        let counts = format!("places {places}, corridors {corridors}, ways to go {open}");
        self.pilot.announce(format!("{}: {}, {:.1} % sure; {counts}", at.name, at.title, 100.0 * at.belief));
    }
}
