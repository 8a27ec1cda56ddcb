//! Leaving places.

use std::{f64::consts::PI, pin::Pin};

use orienteer_runtime::{
    agent::Aborted,
    geometry::{Pose, angle},
    topics::Way,
};

use super::{Departure, GIVE_WAY, LOOKS, Standing, Tour};
use crate::{
    crumbs::Crumbs,
    geographer::{compass::Quarter, map::Change},
};

/// How a robot has left a place.
pub(super) enum SetOut {
    On(Departure),
    /// Not at all: nothing is left to be explored.
    Done,
    /// See [`Arrived::Astray`](super::Arrived::Astray).
    Astray,
}

impl Tour {
    /// Leaves a place on the way to the nearest arm that nobody has gone.
    pub(super) async fn set_out(&mut self, mut standing: Standing) -> SetOut {
        let mut is_sure = false;
        loop {
            let Some(arm) = self.choose(&standing).await else { return SetOut::Done };
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
            let is_known = self.chart.borrow().map.corridor((standing.place, arm)).is_some();
            if is_known {
                // That way is known to be one: the follower makes the best of wherever the robot stands.
                return SetOut::On(Departure {
                    place: standing.place,
                    arm,
                    from: Pose { heading: self.way_out(&standing, arm).heading, ..self.here() },
                    out: 0.0,
                    stood: standing,
                });
            }
            self.present(|own| own.lets_go());
            if !std::mem::replace(&mut is_sure, true) && self.think_again(&mut standing).await {
                continue;
            }
            self.commit(Change::GivenUp((standing.place, arm))).await;
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

    /// Turns to this heading, in the frame of the odometry, rad.
    pub(super) async fn face(&mut self, heading: f64) {
        self.persist(|tour| Leg::Face(heading).drive(tour)).await.ok();
    }
}

type Drive = Pin<Box<dyn Future<Output = Result<(), Aborted>>>>;

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
