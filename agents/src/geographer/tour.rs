//! The tour: follow, name, choose, leave, until every arm of every place has been gone (Randazza 1989, §2.6: master control).

use std::{cell::RefCell, f64::consts::PI, rc::Rc, sync::Arc, time::Duration};

use nalgebra::Matrix2;
use orienteer_runtime::{
    agent::{Aborted, Pilot},
    geometry::{Pose, angle},
    robot_model::Ring,
    topics::{CorridorOrder, CorridorReport, Opening, PlaceOrder, PlaceReport, PoseEstimate, Way},
};
use petgraph::graph::NodeIndex;

use super::{
    GeographerConfig,
    compass::Quarter,
    map::{Arm, Place, TopologicalMap},
};
use crate::{crumbs::Crumbs, places::Reckoning};

/// A robot on its tour.
pub(super) struct Tour {
    pub pilot: Pilot,
    pub config: GeographerConfig,
    pub ring: Arc<Ring>,
    pub map: Rc<RefCell<TopologicalMap>>,
    /// Where it has been since it left the last place.
    pub crumbs: Crumbs,
    /// Orders to follower and classifier are numbered on.
    pub orders: u32,
}

/// The robot stands at the start pose of a place.
#[derive(Debug, Clone, Copy)]
struct Standing {
    place: NodeIndex,
    facing: Quarter,
    /// The start pose, in the frame of the odometry.
    start: Pose,
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
}

/// A place that stops the follower this far from where it should be is another one, m.
const ELSEWHERE: f64 = 1.0;
/// Two places are farther from each other than this, m.
const LEAST: f64 = 1.5;
/// Who is so far off its line, m, or its course, rad, does not look along its corridor.
const OFF_LINE: f64 = 0.35;
const OFF_COURSE: f64 = 0.4;
/// By so much the odometry may be off the course of a corridor, rad.
const DRIFT: f64 = 0.1;
/// Who comes on by less has been stopped by the same thing again, m.
const STUCK: f64 = 0.30;
/// Somebody who stands in the way is given so long to go on.
const GIVE_WAY: Duration = Duration::from_secs(4);
/// So often the robot finds the way ahead closed before it takes it for the end of a corridor.
const LOOKS: u32 = 3;
/// So often it tries to go where something keeps it from going.
const TRIES: u32 = 12;
/// What is between a robot and the first place that it knows anything about: its middle may be off by this, m, one standard deviation.
const FIRST: f64 = 0.05;

impl Tour {
    /// Goes on until nothing is left to be explored.
    pub async fn run(mut self) -> Result<(), Aborted> {
        self.pilot.next::<PoseEstimate>().await?;
        let mut departure: Option<Departure> = None;
        loop {
            match self.stretch(departure.as_ref()).await? {
                Arrived::Nowhere => {}
                Arrived::At(standing) => match self.set_out(standing).await {
                    Some(left) => departure = Some(left),
                    None => return Ok(()),
                },
                Arrived::Lost => match departure {
                    Some(lost) => {
                        self.give_up(&lost).await;
                        match self.set_out(lost.stood).await {
                            Some(left) => departure = Some(left),
                            None => return Ok(()),
                        }
                    }
                    // Nothing is known yet: the other way may be better.
                    None => self.pilot.rotate(PI, self.config.turn_rate).await.unwrap_or_default(),
                },
            }
        }
    }

    /// Follows the corridor to its next place, and names it if it is new.
    async fn stretch(&mut self, departure: Option<&Departure>) -> Result<Arrived, Aborted> {
        let report = self.follow(departure.map_or_else(|| self.here(), |departure| departure.from)).await?;
        if report.opening() == Opening::Lost {
            return Ok(Arrived::Lost);
        }
        let width = if report.width > 0.0 { report.width } else { self.config.width };
        let reckoning = Reckoning::new(width, &self.ring);
        let middle = if report.opening() == Opening::DeadEnd { 0.0 } else { reckoning.face + 0.5 * width };
        let facing = match departure {
            Some(departure) => departure.arm,
            None => {
                let compass = self.map.borrow_mut().compass(report.pose.heading);
                compass.nearest(report.pose.heading)
            }
        };
        let (at, covariance, length) = match departure {
            None => (report.pose.then(Pose::new(middle, 0.0, 0.0)).point(), Matrix2::identity() * FIRST * FIRST, 0.0),
            Some(departure) => {
                let length = departure.out + departure.from.distance(&report.pose) + middle;
                let reached = self.map.borrow().reached(departure.place, departure.arm, length);
                let Some((at, covariance)) = reached else { return Ok(Arrived::Lost) };
                (at, covariance, length)
            }
        };
        let expected = departure.and_then(|departure| self.map.borrow().corridor(departure.place, departure.arm));
        let known = match expected {
            Some((usual, (place, _))) if (length - usual).abs() < ELSEWHERE => Some(place),
            // Something stopped it on a way that it knows.
            Some((usual, _)) if length < usual => return Ok(Arrived::Nowhere),
            _ => self.map.borrow().recognise(at, &covariance),
        };
        // Who has not come out of the place where it was has come to no other.
        if departure.is_some_and(|departure| known == Some(departure.place) || (known.is_none() && length < LEAST)) {
            return Ok(Arrived::Lost);
        }
        let mut standing = Standing { place: NodeIndex::end(), facing, start: report.pose, reckoning, middle };
        if let Some(known) = known {
            standing.place = known;
            let mut map = self.map.borrow_mut();
            map.seen_again(known, at, &covariance);
            let name = map.place(known).map(|place| place.name.clone()).unwrap_or_default();
            drop(map);
            self.pilot.announce(format!("at {name} again"));
        } else {
            let Some(place) = self.name(&mut standing, &report).await else { return Ok(Arrived::Nowhere) };
            standing.place = self.map.borrow_mut().add(Place { at, covariance, ..place });
        }
        if let Some(departure) = departure {
            self.map.borrow_mut().join((departure.place, departure.arm), (standing.place, facing.back()), length);
        }
        self.tell(standing.place);
        Ok(Arrived::At(standing))
    }

    /// Has the follower go to where something opens or ends, from `from` on in that direction. What blocks the way is given time to go away first.
    async fn follow(&mut self, from: Pose) -> Result<CorridorReport, Aborted> {
        let (mut closed, mut lost) = (0, 0);
        loop {
            let report = self.order_follower().await?;
            let on_line = self.is_on_line(from);
            match report.opening() {
                Opening::DeadEnd => {
                    // Who stepped aside for somebody may have met nobody but them.
                    closed = match report {
                        CorridorReport { overrides: 1.., .. } => 0,
                        _ if !on_line => 0,
                        CorridorReport { length, .. } if length < STUCK => closed + 1,
                        _ => 1,
                    };
                    if closed >= LOOKS {
                        return Ok(report);
                    }
                }
                Opening::Lost => {
                    lost += 1;
                    if lost >= LOOKS {
                        return Ok(report);
                    }
                }
                _ => return Ok(report),
            }
            self.pilot.sleep(GIVE_WAY).await?;
            if !on_line {
                self.back_on_line(from).await;
            }
        }
    }

    /// True if the robot is about where it should be that has gone straight on from there.
    fn is_on_line(&self, from: Pose) -> bool {
        let off = from.between(self.here());
        // The odometry may be off its course as well, after all the turns at a place.
        off.y.abs() < OFF_LINE + DRIFT * off.x.abs() && off.heading.abs() < OFF_COURSE
    }

    /// Whoever stepped aside may stand beside its way, or across it.
    async fn back_on_line(&mut self, from: Pose) {
        let along = from.between(self.here()).x.max(0.0);
        self.go_back(from.then(Pose::new(along, 0.0, 0.0))).await;
    }

    /// The order is repeated in every step: a follower that was built anew has heard none.
    async fn order_follower(&mut self) -> Result<CorridorReport, Aborted> {
        self.pilot.release();
        self.orders += 1;
        let order = self.orders;
        loop {
            self.pilot.publish(CorridorOrder { stamp: self.pilot.now(), order });
            self.pilot.next_step().await?;
            self.crumbs.drop(self.here());
            if let Some(report) = self.pilot.latest::<CorridorReport>().filter(|report| report.order == order) {
                return Ok(report);
            }
        }
    }

    /// What the new place is that the robot stands at; `None` if it is nothing that is known.
    async fn name(&mut self, standing: &mut Standing, arrival: &CorridorReport) -> Option<Place> {
        let facing = standing.facing;
        let mut place = Place {
            name: String::new(),
            at: standing.start.point(),
            covariance: Matrix2::zeros(),
            kind: "dead-end".to_owned(),
            title: "dead end".to_owned(),
            belief: 1.0,
            seen: facing,
            arms: [Arm::Closed; 4],
            visits: 1,
        };
        place.arms[facing.back().index()] = Arm::Unexplored;
        if arrival.opening() == Opening::DeadEnd {
            return Some(place);
        }
        let report = self.order_classifier(arrival, standing.reckoning.width).await.ok()?;
        if report.kind.as_str().is_empty() {
            return None;
        }
        for way in report.ways() {
            place.arms[facing.toward(way).index()] = Arm::Unexplored;
        }
        standing.start = report.start;
        (place.kind, place.title) = (report.kind.to_string(), report.title.to_string());
        place.belief = report.belief;
        Some(place)
    }

    async fn order_classifier(&mut self, arrival: &CorridorReport, width: f64) -> Result<PlaceReport, Aborted> {
        self.pilot.release();
        self.orders += 1;
        let order = PlaceOrder::new(self.pilot.now(), self.orders, arrival.opening(), arrival.pose, width);
        loop {
            self.pilot.publish(order);
            self.pilot.next_step().await?;
            if let Some(report) = self.pilot.latest::<PlaceReport>().filter(|report| report.order == order.order) {
                return Ok(report);
            }
        }
    }

    /// Leaves a place on the way to the nearest arm that nobody has gone; `None` if there is none left.
    async fn set_out(&mut self, standing: Standing) -> Option<Departure> {
        loop {
            let route = self.map.borrow().nearest_unexplored(standing.place, standing.facing)?;
            let (_, arm) = *route.first()?;
            self.crumbs = Crumbs::default();
            self.crumbs.drop(standing.start);
            if self.leave(&standing, arm).await.is_ok() {
                let out = if standing.middle > 0.0 { standing.reckoning.face + 0.5 * standing.reckoning.width } else { 0.0 };
                return Some(Departure { place: standing.place, arm, from: self.here(), out, stood: standing });
            }
            self.pilot.say("can't get out that way");
            self.go_back(standing.start).await;
            if self.map.borrow().corridor(standing.place, arm).is_some() {
                // That way is known to be one: the follower makes the best of wherever the robot stands.
                return Some(Departure {
                    place: standing.place,
                    arm,
                    from: self.toward(&standing, arm),
                    out: 0.0,
                    stood: standing,
                });
            }
            self.map.borrow_mut().give_up(standing.place, arm);
        }
    }

    /// Drives into an arm, from the start pose.
    async fn leave(&mut self, standing: &Standing, arm: Quarter) -> Result<(), Aborted> {
        let Some(way) = standing.facing.way_to(arm) else {
            return self.persist(|tour| Leg::Face(angle::wrap(standing.start.heading + PI)).drive(tour)).await;
        };
        let port = standing.reckoning.port(way, standing.start);
        if way != Way::Ahead {
            let middle = standing.reckoning.middle(standing.start);
            self.persist(|tour| Leg::Go(middle).drive(tour)).await?;
        }
        self.persist(|tour| Leg::Go(port).drive(tour)).await?;
        self.persist(|tour| Leg::Face(port.heading).drive(tour)).await
    }

    /// Where the robot is, as if it faced an arm.
    fn toward(&self, standing: &Standing, arm: Quarter) -> Pose {
        let turn = standing.facing.way_to(arm).map_or(PI, |way| standing.reckoning.port(way, Pose::default()).heading);
        Pose { heading: angle::wrap(standing.start.heading + turn), ..self.here() }
    }

    /// Tries again where somebody came between.
    async fn persist(&mut self, leg: impl Fn(&Self) -> Drive) -> Result<(), Aborted> {
        let mut ended = Ok(());
        for _ in 0..TRIES {
            ended = leg(self).await;
            self.crumbs.drop(self.here());
            self.pilot.release();
            if ended.is_ok() {
                break;
            }
            self.pilot.sleep(GIVE_WAY).await.ok();
        }
        ended
    }

    /// Notes that an arm leads nowhere, and goes back to where the robot stood before it took it.
    async fn give_up(&mut self, lost: &Departure) {
        self.pilot.say("this leads nowhere; goes back");
        self.map.borrow_mut().give_up(lost.place, lost.arm);
        self.go_back(lost.stood.start).await;
    }

    async fn go_back(&mut self, to: Pose) {
        let (speed, rate) = (self.config.speed, self.config.turn_rate);
        if self.crumbs.go_back(&self.pilot, to, speed, rate).await.is_err() {
            self.pilot.say("can't get back to where it came from");
        }
        self.pilot.release();
    }

    /// Where the robot thinks it is, in the frame of the odometry.
    fn here(&self) -> Pose {
        self.pilot.latest::<PoseEstimate>().map_or_else(Pose::default, |estimate| estimate.pose)
    }

    /// Says what is known now.
    fn tell(&self, place: NodeIndex) {
        let map = self.map.borrow();
        let Some(at) = map.place(place).filter(|place| place.visits == 1) else { return };
        let (places, corridors, open) = (map.places().len(), map.corridors().count(), map.unexplored());
        let counts = format!("places {places}, corridors {corridors}, ways to go {open}");
        self.pilot.announce(format!("{}: {}, {:.1} % sure; {counts}", at.name, at.title, 100.0 * at.belief));
    }
}

type Drive = std::pin::Pin<Box<dyn Future<Output = Result<(), Aborted>>>>;

/// A part of the way out of a place.
#[derive(Debug, Clone, Copy)]
enum Leg {
    Go(Pose),
    Face(f64),
}

impl Leg {
    fn drive(self, tour: &Tour) -> Drive {
        let (pilot, speed, rate) = (tour.pilot.clone(), tour.config.speed, tour.config.turn_rate);
        Box::pin(async move {
            match self {
                Self::Go(to) => pilot.go(to.point(), speed, rate).await,
                Self::Face(heading) => pilot.face(heading, rate).await,
            }
        })
    }
}
