//! Having places named.

use nalgebra::Matrix2;
use orienteer_runtime::{
    agent::Aborted,
    geometry::Pose,
    topics::{CorridorReport, Opening, PlaceOrder, PlaceReport},
};

use super::{
    Standing, TRIES, Tour,
    following::{Followed, RUN_UP},
    reckoning::ELSEWHERE,
};
use crate::geographer::map::{Arm, Change, Place};

/// What is less probable than this is not believed.
const BELIEVED: f64 = 0.75;

/// What came of naming a place.
pub(super) enum Named {
    Place(Place),
    /// It is nothing that is known.
    Nothing,
    /// See [`Arrived::TurnedBack`](super::Arrived::TurnedBack).
    TurnedBack,
    /// See [`Arrived::Astray`](super::Arrived::Astray).
    Astray,
}

impl Tour {
    /// As [`name`](Self::name). Where nothing came of it the robot comes to the place again, so that it knows where it stands.
    pub(super) async fn name_at_last(&mut self, standing: &mut Standing, mut arrival: CorridorReport) -> Named {
        for _ in 0..TRIES {
            if let Some(place) = self.name(standing).await {
                return Named::Place(place);
            }
            let begin = arrival.pose.then(Pose::new(-2.0 * RUN_UP, 0.0, 0.0));
            let again = match self.come_again(begin, &arrival).await {
                Ok(Followed::To(again)) => again,
                Ok(Followed::TurnedBack) => return Named::TurnedBack,
                Ok(Followed::Lost) | Err(_) => return Named::Astray,
            };
            if arrival.pose.distance(&again.pose) > ELSEWHERE {
                return Named::Astray;
            }
            // Somebody may have stood in the corner.
            if again.opening() != Opening::DeadEnd || arrival.opening() == Opening::DeadEnd {
                (standing.start, standing.opening, arrival) = (again.pose, again.opening(), again);
            }
        }
        Named::Nothing
    }

    /// A way out of a place that can't be gone may be none: has the place named once more, from where the robot stands. True if it is something else than it was thought to be.
    pub(super) async fn think_again(&mut self, standing: &mut Standing) -> bool {
        // Whoever stood in the way made it look like the end of a corridor.
        if standing.opening == Opening::DeadEnd {
            return false;
        }
        let Some(place) = self.name(standing).await else { return false };
        let Some(known) = self.chart.borrow().map.place(standing.place).cloned() else { return false };
        let is_way = |arm: Arm| arm != Arm::Closed;
        if known.arms.map(is_way) == place.arms.map(is_way) {
            return false;
        }
        self.pilot.announce(format!(
            "{}: not {}, but {}, {:.1} % sure",
            known.name,
            known.title,
            place.title,
            100.0 * place.belief
        ));
        self.commit(Change::Renamed { place: standing.place, to: place }).await;
        true
    }

    /// What the place is that the robot stands at; `None` if it is nothing that is known.
    async fn name(&mut self, standing: &mut Standing) -> Option<Place> {
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
        if standing.opening == Opening::DeadEnd {
            return Some(place);
        }
        let report = self.order_classifier(standing).await.ok()?;
        if report.kind.as_str().is_empty() || report.belief < BELIEVED {
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

    async fn order_classifier(&mut self, standing: &Standing) -> Result<PlaceReport, Aborted> {
        self.pilot.release();
        self.orders += 1;
        let order = PlaceOrder::new(self.pilot.now(), self.orders, standing.opening, standing.start, standing.reckoning.width);
        loop {
            self.pilot.publish(order);
            self.pilot.next_step().await?;
            if let Some(report) = self.pilot.latest::<PlaceReport>().filter(|report| report.order == order.order) {
                return Ok(report);
            }
        }
    }
}
