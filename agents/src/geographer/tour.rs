//! The tour: follow, name, choose, leave, until every arm of every place has been gone (Randazza 1989, §2.6: master control).

use std::{cell::RefCell, f64::consts::PI, rc::Rc, sync::Arc, time::Duration};

use nalgebra::{Matrix2, Point2};
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
    /// Where it last stood at a place that it knows.
    pub fix: Option<Fix>,
    /// How many ends of corridors it has come to since that were none that it should know.
    pub strange: u32,
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

/// Where the robot stood at a place: one pose, in the frame of the map and in that of the odometry.
///
/// From place to place the odometry is good enough to tell in which of the four directions the robot faces and about where it is, whatever it
/// had to do on the way to let somebody pass.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fix {
    map: Pose,
    odometry: Pose,
}

impl Fix {
    fn in_map(&self, odometry: Pose) -> Pose {
        self.map.then(self.odometry.between(odometry))
    }
}

/// Where a stretch has led, by reckoning.
#[derive(Debug, Clone, Copy)]
struct Reached {
    /// The middle of the place that may be there, map frame, m; with covariance, m².
    at: Point2<f64>,
    covariance: Matrix2<f64>,
    facing: Quarter,
    /// How far it is from the place that was left, m, if the robot came straight along its arm.
    length: Option<f64>,
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

/// How a robot has left a place.
enum SetOut {
    On(Departure),
    /// Not at all: nothing is left to be explored.
    Done,
    /// See [`Arrived::Astray`].
    Astray,
}

/// What came of naming a place.
enum Named {
    Place(Place),
    /// It is nothing that is known.
    Nothing,
    /// See [`Arrived::Astray`].
    Astray,
}

/// A place that stops the follower this far from where it should be is another one, m.
const ELSEWHERE: f64 = 1.0;
/// A start pose that is so far from where a known corridor should end is wrong, m.
const AMISS: f64 = 0.3;
/// Two places are farther from each other than this, m.
const LEAST: f64 = 1.5;
/// Who is so far off its line, m, or its course, rad, does not look along its corridor.
const OFF_LINE: f64 = 0.35;
const OFF_COURSE: f64 = 0.4;
/// By so much the odometry may be off the course of a corridor, rad.
const DRIFT: f64 = 0.1;
/// Where a robot is that did not come straight: off by this, m, and by its drift, one standard deviation.
const ASTRAY: f64 = 0.1;
/// Who comes on by less has been stopped by the same thing again, m.
const STUCK: f64 = 0.30;
/// Somebody who stands in the way is given so long to go on.
const GIVE_WAY: Duration = Duration::from_secs(4);
/// Whoever stands where a corridor may end has so long to go away, each time that the robot looks.
const GO_AWAY: Duration = Duration::from_secs(8);
/// So often the robot finds the way ahead closed before it takes it for the end of a corridor.
const LOOKS: u32 = 3;
/// Who has followed a corridor for less than this, m, may have missed that it opens to a side.
const RUN_IN: f64 = 1.2;
/// Ends of a corridor.
const BOTH: u32 = 2;
/// By following its corridor for so long a robot learns where it stands, m.
const RUN_UP: f64 = 1.5;
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
            let set_out = match self.stretch(departure.as_ref()).await? {
                Arrived::Nowhere => continue,
                Arrived::At(standing) => self.set_out(standing).await,
                Arrived::Astray => SetOut::Astray,
                Arrived::Lost => match departure {
                    Some(lost) if self.give_up(&lost).await => self.set_out(lost.stood).await,
                    Some(_) => SetOut::Astray,
                    // Nothing is known here: the other way may be better.
                    None => {
                        self.strange += 1;
                        self.pilot.rotate(PI, self.config.turn_rate).await.unwrap_or_default();
                        continue;
                    }
                },
            };
            departure = match set_out {
                SetOut::On(left) => Some(left),
                SetOut::Done => return Ok(()),
                SetOut::Astray => {
                    self.look_along_the_nearest_direction().await;
                    None
                }
            };
        }
    }

    /// Who does not know what corridor it is in still knows how corridors lie.
    async fn look_along_the_nearest_direction(&mut self) {
        let compass = self.map.borrow().known_compass();
        let (Some(fix), Some(compass)) = (self.fix, compass) else { return };
        let heading = fix.in_map(self.here()).heading;
        let off = angle::turn(heading, compass.heading(compass.nearest(heading)));
        let to = angle::wrap(self.here().heading + off);
        self.persist(|tour| Leg::Face(to).drive(tour)).await.ok();
    }

    /// Follows the corridor to its next place, and names it if it is new.
    async fn stretch(&mut self, departure: Option<&Departure>) -> Result<Arrived, Aborted> {
        let from = departure.map_or_else(|| self.here(), |departure| departure.from);
        let Some(mut report) = self.follow(from).await? else { return Ok(Arrived::Lost) };
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
        let Some(Reached { at, covariance, facing, length }) = self.reached(departure, &report, middle) else {
            return Ok(Arrived::Lost);
        };
        let mut short = 0.0;
        let known = match (length, departure) {
            (Some(length), Some(departure)) => {
                let expected = self.map.borrow().corridor(departure.place, departure.arm);
                match expected {
                    Some((usual, (place, _))) if (length - usual).abs() < ELSEWHERE => {
                        // The corner that the follower has found is nearer to the truth, unless it was none.
                        short = Some(usual - length).filter(|short| short.abs() > AMISS).unwrap_or_default();
                        Some(place)
                    }
                    // Something stopped it on a way that it knows.
                    Some((usual, _)) if length < usual => return Ok(Arrived::Nowhere),
                    _ => self.map.borrow().recognise(at, &covariance),
                }
            }
            _ => self.map.borrow().recognise(at, &covariance),
        };
        let is_lost = match (length, known, departure) {
            // Who has not come out of the place where it was has come to no other.
            (Some(length), known, Some(departure)) => known == Some(departure.place) || (known.is_none() && length < LEAST),
            // Who came some other way knows a place again that is open on that side, or nothing.
            (_, Some(known), _) if self.strange < BOTH => {
                self.map.borrow().place(known).is_none_or(|place| place.arms[facing.back().index()] == Arm::Closed)
            }
            (_, None, _) => self.fix.is_some() && self.strange < BOTH,
            // Neither end is known: the corridor is a new one.
            _ => false,
        };
        if is_lost {
            return Ok(Arrived::Lost);
        }
        let start = report.pose.then(Pose::new(short, 0.0, 0.0));
        let mut standing = Standing { place: NodeIndex::end(), facing, start, reckoning, middle };
        if let Some(known) = known {
            standing.place = known;
            let mut map = self.map.borrow_mut();
            map.seen_again(known, at, &covariance);
            let name = map.place(known).map(|place| place.name.clone()).unwrap_or_default();
            drop(map);
            self.pilot.announce(format!("at {name} again"));
        } else {
            let place = match self.name_at_last(&mut standing, report).await {
                Named::Place(place) => place,
                Named::Nothing => return Ok(Arrived::Nowhere),
                Named::Astray => return Ok(Arrived::Astray),
            };
            standing.place = self.map.borrow_mut().add(Place { at, covariance, ..place });
        }
        if let (Some(departure), Some(length)) = (departure, length.filter(|_| short == 0.0)) {
            self.map.borrow_mut().join((departure.place, departure.arm), (standing.place, facing.back()), length);
        }
        (self.fix, self.strange) = (self.fix_at(&standing), 0);
        self.tell(standing.place);
        Ok(Arrived::At(standing))
    }

    /// Where the robot has come to; `None` if that can't be said.
    fn reached(&self, departure: Option<&Departure>, report: &CorridorReport, middle: f64) -> Option<Reached> {
        let ahead = Pose::new(middle, 0.0, 0.0);
        let Some(fix) = self.fix else {
            let facing = self.map.borrow_mut().compass(report.pose.heading).nearest(report.pose.heading);
            let at = report.pose.then(ahead).point();
            return Some(Reached { at, covariance: Matrix2::identity() * FIRST * FIRST, facing, length: None });
        };
        let map = self.map.borrow();
        let (compass, pose) = (map.known_compass()?, fix.in_map(report.pose));
        let facing = compass.nearest(pose.heading);
        let straight = |departure: &&Departure| facing == departure.arm && is_on_line(departure.from, report.pose);
        if let Some(departure) = departure.filter(straight) {
            let length = departure.out + departure.from.distance(&report.pose) + middle;
            let (at, covariance) = map.reached(departure.place, departure.arm, length)?;
            return Some(Reached { at, covariance, facing, length: Some(length) });
        }
        let at = Pose { heading: compass.heading(facing), ..pose }.then(ahead).point();
        let astray = ASTRAY + DRIFT * fix.odometry.distance(&report.pose);
        Some(Reached { at, covariance: Matrix2::identity() * astray * astray, facing, length: None })
    }

    /// What is known of where the robot is when it stands at the start pose of a place.
    fn fix_at(&self, standing: &Standing) -> Option<Fix> {
        let map = self.map.borrow();
        let (at, heading) = (map.place(standing.place)?.at, map.known_compass()?.heading(standing.facing));
        let middle = Pose::new(at.x, at.y, heading);
        Some(Fix { map: middle.then(Pose::new(-standing.middle, 0.0, 0.0)), odometry: standing.start })
    }

    /// Has the follower go to where something opens or ends, from `from` on in that direction. What blocks the way is given time to go away first.
    /// `None` if the way is lost.
    async fn follow(&mut self, from: Pose) -> Result<Option<CorridorReport>, Aborted> {
        let (mut closed, mut lost, mut overrides) = (0, 0, 0);
        // How far it followed the corridor to where it is now, m.
        let mut came = 0.0;
        loop {
            let mut report = self.order_follower().await?;
            let disturbed = report.overrides > 0;
            overrides += report.overrides;
            report.overrides = overrides;
            let on_line = is_on_line(from, self.here());
            match report.opening() {
                Opening::DeadEnd => {
                    lost += u32::from(!on_line);
                    let moved = report.length.abs() >= STUCK;
                    if moved {
                        came = report.length;
                    }
                    // Who stepped aside for somebody may have met nobody but them.
                    closed = match moved {
                        _ if disturbed || !on_line => 0,
                        true => 1,
                        false => closed + 1,
                    };
                    if closed >= LOOKS {
                        if came >= RUN_IN {
                            return Ok(Some(report));
                        }
                        // Somebody stood in a corner, perhaps, and has gone: the follower has to see the walls before it.
                        (closed, lost) = (0, lost + 1);
                        self.back_on_line(from, report.pose.then(Pose::new(-RUN_UP, 0.0, 0.0))).await;
                    }
                }
                Opening::Lost => lost += 1,
                _ => return Ok(Some(report)),
            }
            if lost >= LOOKS {
                return Ok(None);
            }
            self.rest(if closed > 0 { GO_AWAY } else { GIVE_WAY }).await?;
            if !on_line {
                self.back_on_line(from, self.here()).await;
            }
        }
    }

    /// Goes a little back to where it has come straight from `from`, and follows the corridor once more; `None` if it can't get there.
    async fn come_again(&mut self, from: Pose, arrival: &CorridorReport) -> Result<Option<CorridorReport>, Aborted> {
        let is_back = self.back_on_line(from, arrival.pose.then(Pose::new(-RUN_UP, 0.0, 0.0))).await;
        if is_back { self.follow(from).await } else { Ok(None) }
    }

    /// Whoever stepped aside may stand beside its way, or across it. Of where it has been, what lies about straight on from `from` is the
    /// corridor's middle; goes there, as near to the goal as that is.
    async fn back_on_line(&mut self, from: Pose, goal: Pose) -> bool {
        let on_line = |at: Point2<f64>| is_on_line(from, Pose::new(at.x, at.y, from.heading));
        let at = self.crumbs.nearest_of(goal.point(), on_line).unwrap_or_else(|| from.point());
        self.go_back(Pose::new(at.x, at.y, from.heading)).await
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

    /// As [`name`](Self::name). Where nothing came of it the robot comes to the place again, so that it knows where it stands.
    async fn name_at_last(&mut self, standing: &mut Standing, mut arrival: CorridorReport) -> Named {
        for _ in 0..TRIES {
            if let Some(place) = self.name(standing, &arrival).await {
                return Named::Place(place);
            }
            let begin = arrival.pose.then(Pose::new(-2.0 * RUN_UP, 0.0, 0.0));
            let Ok(Some(again)) = self.come_again(begin, &arrival).await else { return Named::Astray };
            if arrival.pose.distance(&again.pose) > ELSEWHERE {
                return Named::Astray;
            }
            // Somebody may have stood in the corner.
            if again.opening() != Opening::DeadEnd || arrival.opening() == Opening::DeadEnd {
                (standing.start, arrival) = (again.pose, again);
            }
        }
        Named::Nothing
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

    /// Leaves a place on the way to the nearest arm that nobody has gone.
    async fn set_out(&mut self, standing: Standing) -> SetOut {
        loop {
            let route = self.map.borrow().nearest_unexplored(standing.place, standing.facing);
            let Some((_, arm)) = route.and_then(|route| route.first().copied()) else { return SetOut::Done };
            self.crumbs = Crumbs::default();
            self.crumbs.drop(standing.start);
            if self.leave(&standing, arm).await {
                let out = if standing.middle > 0.0 { standing.reckoning.face + 0.5 * standing.reckoning.width } else { 0.0 };
                // Not where it is: somebody may have driven it on.
                let from = self.way_out(&standing, arm);
                return SetOut::On(Departure { place: standing.place, arm, from, out, stood: standing });
            }
            self.pilot.say("can't get out that way");
            if !self.go_back(standing.start).await {
                return SetOut::Astray;
            }
            if self.map.borrow().corridor(standing.place, arm).is_some() {
                // That way is known to be one: the follower makes the best of wherever the robot stands.
                return SetOut::On(Departure {
                    place: standing.place,
                    arm,
                    from: Pose { heading: self.way_out(&standing, arm).heading, ..self.here() },
                    out: 0.0,
                    stood: standing,
                });
            }
            self.map.borrow_mut().give_up(standing.place, arm);
        }
    }

    /// Drives into an arm; once more from the start pose if somebody has driven it off. False if it can't.
    async fn leave(&mut self, standing: &Standing, arm: Quarter) -> bool {
        for _ in 0..LOOKS {
            if self.drive_into(standing, arm).await.is_ok() {
                return true;
            }
            if !self.go_back(standing.start).await {
                return false;
            }
        }
        false
    }

    /// Where a robot stands that has left by an arm, facing along it.
    fn way_out(&self, standing: &Standing, arm: Quarter) -> Pose {
        let back = || Pose { heading: angle::wrap(standing.start.heading + PI), ..standing.start };
        standing.facing.way_to(arm).map_or_else(back, |way| standing.reckoning.port(way, standing.start))
    }

    async fn drive_into(&mut self, standing: &Standing, arm: Quarter) -> Result<(), Aborted> {
        let port = self.way_out(standing, arm);
        let Some(way) = standing.facing.way_to(arm) else {
            return self.persist(|tour| Leg::Face(port.heading).drive(tour)).await;
        };
        if way != Way::Ahead {
            let middle = standing.reckoning.middle(standing.start);
            self.persist(|tour| Leg::Go(middle).drive(tour)).await?;
        }
        self.persist(|tour| Leg::Go(port).drive(tour)).await?;
        self.persist(|tour| Leg::Face(port.heading).drive(tour)).await
    }

    /// Tries again where somebody came between.
    async fn persist(&mut self, leg: impl Fn(&Self) -> Drive) -> Result<(), Aborted> {
        let mut ended = Ok(());
        for _ in 0..LOOKS {
            let (motion, pilot) = (leg(self), self.pilot.clone());
            ended = self.crumbs.along(&pilot, motion).await;
            self.pilot.release();
            if ended.is_ok() {
                break;
            }
            self.rest(GIVE_WAY).await.ok();
        }
        ended
    }

    /// Notes that an arm leads nowhere, and goes back to where the robot stood before it took it; false if it can't.
    async fn give_up(&mut self, lost: &Departure) -> bool {
        self.pilot.say("this leads nowhere; goes back");
        self.map.borrow_mut().give_up(lost.place, lost.arm);
        self.go_back(lost.stood.start).await
    }

    /// False if it can't.
    async fn go_back(&mut self, to: Pose) -> bool {
        let (speed, rate) = (self.config.speed, self.config.turn_rate);
        let is_back = self.crumbs.go_back(&self.pilot, to, speed, rate).await.is_ok();
        if !is_back {
            self.pilot.say("can't get back to where it came from");
        }
        self.pilot.release();
        is_back
    }

    async fn rest(&mut self, span: Duration) -> Result<(), Aborted> {
        let pilot = self.pilot.clone();
        self.crumbs.along(&pilot, pilot.sleep(span)).await
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

/// True if a robot is about where it should be that has gone straight on from there.
fn is_on_line(from: Pose, here: Pose) -> bool {
    let off = from.between(here);
    // The odometry may be off its course as well, after all the turns at a place.
    off.y.abs() < OFF_LINE + DRIFT * off.x.abs() && off.heading.abs() < OFF_COURSE
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
