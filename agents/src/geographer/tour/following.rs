//! Following corridors, and getting back to where the robot came from.

use std::time::Duration;

use nalgebra::Point2;
use orienteer_runtime::{
    agent::Aborted,
    geometry::Pose,
    topics::{CorridorOrder, CorridorReport, Opening},
};

use super::{GIVE_WAY, LOOKS, Tour, reckoning::is_on_line, traffic::Ahead};

/// Who is stopped so near to where it was stopped before, m, has been stopped by the same thing.
const STUCK: f64 = 0.30;
/// Whoever stands where a corridor may end has so long to go away, each time that the robot looks.
const GO_AWAY: Duration = Duration::from_secs(8);
/// Who has followed a corridor for less than this, m, may have missed that it opens to a side.
const RUN_IN: f64 = 1.2;
/// By following its corridor for so long a robot learns where it stands, m.
pub(super) const RUN_UP: f64 = 1.5;

/// How following a corridor ended.
pub(super) enum Followed {
    /// Where something opens, or the corridor ends.
    To(CorridorReport),
    /// The way is lost, or somebody blocks it for good.
    Lost,
    /// Somebody comes the other way, and the robot has to make way.
    TurnedBack,
}

impl Tour {
    /// Has the follower go to where something opens or ends, from `from` on in that direction. What blocks the way is given time to go away first.
    pub(super) async fn follow(&mut self, from: Pose) -> Result<Followed, Aborted> {
        let (mut closed, mut lost, mut overrides) = (0, 0, 0);
        // Where the way was last found closed.
        let mut end: Option<Pose> = None;
        loop {
            let mut report = match self.order_follower().await? {
                Followed::To(report) => report,
                ended => return Ok(ended),
            };
            let disturbed = report.overrides > 0;
            overrides += report.overrides;
            report.overrides = overrides;
            let on_line = is_on_line(from, self.here());
            let is_closed = report.opening() == Opening::DeadEnd;
            match report.opening() {
                Opening::DeadEnd => {
                    lost += u32::from(!on_line);
                    let again = end.replace(report.pose).is_some_and(|end| end.distance(&report.pose) < STUCK);
                    // Who stepped aside for somebody may have met nobody but them.
                    closed = match again {
                        _ if disturbed || !on_line => 0,
                        true => closed + 1,
                        false => 1,
                    };
                    if closed >= LOOKS {
                        if report.length >= RUN_IN {
                            return Ok(Followed::To(report));
                        }
                        // Somebody stood in a corner, perhaps, and has gone: the follower has to see the walls before it.
                        (closed, lost) = (0, lost + 1);
                    }
                }
                Opening::Lost => lost += 1,
                _ => return Ok(Followed::To(report)),
            }
            if lost >= LOOKS {
                return Ok(Followed::Lost);
            }
            self.rest(if closed > 0 { GO_AWAY } else { GIVE_WAY }).await?;
            if is_closed {
                // If it was somebody, they may have stood where the corridor opens to a side.
                self.back_on_line(from, report.pose.then(Pose::new(-RUN_UP, 0.0, 0.0))).await;
            } else if !on_line {
                self.back_on_line(from, self.here()).await;
            }
        }
    }

    /// Goes a little back to where it has come straight from `from`, and follows the corridor once more; lost if it can't get there.
    pub(super) async fn come_again(&mut self, from: Pose, arrival: &CorridorReport) -> Result<Followed, Aborted> {
        let is_back = self.back_on_line(from, arrival.pose.then(Pose::new(-RUN_UP, 0.0, 0.0))).await;
        if is_back { self.follow(from).await } else { Ok(Followed::Lost) }
    }

    /// Whoever stepped aside may stand beside its way, or across it. Of where it has been, what lies about straight on from `from` is the
    /// corridor's middle; goes there, as near to the goal as that is.
    async fn back_on_line(&mut self, from: Pose, goal: Pose) -> bool {
        let on_line = |at: Point2<f64>| is_on_line(from, Pose::new(at.x, at.y, from.heading));
        let at = self.crumbs.nearest_of(goal.point(), on_line).unwrap_or_else(|| from.point());
        self.go_back(Pose::new(at.x, at.y, from.heading)).await
    }

    /// The order is repeated in every step: a follower that was built anew has heard none. Nobody comes too near to another robot meanwhile.
    async fn order_follower(&mut self) -> Result<Followed, Aborted> {
        self.pilot.release();
        self.orders += 1;
        loop {
            let order = self.orders;
            self.pilot.publish(CorridorOrder { stamp: self.pilot.now(), order });
            self.pilot.next_step().await?;
            self.crumbs.drop(self.here());
            if let Some(report) = self.pilot.latest::<CorridorReport>().filter(|report| report.order == order) {
                return Ok(Followed::To(report));
            }
            if self.ahead().is_some() {
                self.pilot.publish(CorridorOrder { stamp: self.pilot.now(), order: 0 });
                match self.wait_for_those_ahead().await {
                    Ahead::Clear => {}
                    Ahead::GiveWay => return Ok(Followed::TurnedBack),
                    Ahead::Blocked => return Ok(Followed::Lost),
                }
                self.orders += 1;
            }
        }
    }

    /// False if it can't.
    pub(super) async fn go_back(&mut self, to: Pose) -> bool {
        let (speed, rate) = (self.config.speed, self.config.turn_rate);
        let is_back = self.crumbs.go_back(&self.pilot, to, speed, rate).await.is_ok();
        if !is_back {
            self.pilot.say("can't get back to where it came from");
        }
        self.pilot.release();
        is_back
    }

    pub(super) async fn rest(&mut self, span: Duration) -> Result<(), Aborted> {
        let pilot = self.pilot.clone();
        self.crumbs.along(&pilot, pilot.sleep(span)).await
    }
}
