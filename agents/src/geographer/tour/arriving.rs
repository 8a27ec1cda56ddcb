//! From place to place: follow the corridor, tell what it has led to.

use orienteer_runtime::{
    agent::Aborted,
    geometry::Pose,
    topics::{CorridorReport, Opening},
};
use petgraph::graph::NodeIndex;

use super::{
    Departure, LOOKS, Standing, Tour,
    following::Followed,
    naming::Named,
    reckoning::{Reached, Which},
};
use crate::{
    geographer::map::{Change, Place},
    places::Reckoning,
};

/// How the way to the next place ended.
pub(super) enum Arrived {
    /// At a place.
    At(Standing),
    /// Where there is no place: go on.
    NoPlace,
    /// The corridor is none, or the way is lost.
    Lost,
    /// Somebody comes the other way, and the robot has to make way.
    TurnedBack,
    /// The robot is not where it would have to be, and can't get there: it has to find a place that it knows.
    Astray,
}

impl Tour {
    /// Follows the corridor to its next place, and names it if it is new.
    pub(super) async fn go_to_next_place(&mut self, departure: Option<&Departure>) -> Result<Arrived, Aborted> {
        let from = departure.map_or_else(|| self.here(), |departure| departure.from);
        let report = match self.follow_undisturbed(from).await? {
            Ok(report) => report,
            Err(arrived) => return Ok(arrived),
        };
        let width = if report.width > 0.0 { report.width } else { self.config.width };
        let reckoning = Reckoning::new(width, &self.ring);
        let middle = if report.opening() == Opening::DeadEnd { 0.0 } else { reckoning.face + 0.5 * width };
        let Some(reached) = self.reached(departure, &report, middle) else { return Ok(Arrived::Lost) };
        let (known, short) = match self.which_place(departure, &reached, report.opening()) {
            Which::Known(place, short) => (Some(place), short),
            Which::New => (None, 0.0),
            Which::None => return Ok(Arrived::NoPlace),
            Which::Lost => return Ok(Arrived::Lost),
        };
        let start = report.pose.then(Pose::new(short, 0.0, 0.0));
        let place = known.unwrap_or_else(NodeIndex::end);
        let mut standing = Standing { place, facing: reached.facing, start, opening: report.opening(), reckoning, middle };
        if known.is_none() {
            if let Err(arrived) = self.find(&mut standing, &reached, report).await {
                return Ok(arrived);
            }
        } else {
            self.come_again_to(&standing, &reached, short == 0.0).await;
        }
        if let (Some(departure), Some(length)) = (departure, reached.length.filter(|_| short == 0.0)) {
            let (from, to) = ((departure.place, departure.arm), (standing.place, standing.facing.back()));
            self.commit(Change::Joined { from, to, length }).await;
        }
        self.settle_at(&standing);
        Ok(Arrived::At(standing))
    }

    /// Follows the corridor to its end, and once more as long as it was driven about on the way.
    async fn follow_undisturbed(&mut self, from: Pose) -> Result<Result<CorridorReport, Arrived>, Aborted> {
        let mut followed = self.follow(from).await?;
        let mut looks = 0;
        loop {
            let report = match followed {
                Followed::To(report) => report,
                Followed::TurnedBack => return Ok(Err(Arrived::TurnedBack)),
                Followed::Lost if looks == 0 => return Ok(Err(Arrived::Lost)),
                Followed::Lost => return Ok(Err(Arrived::Astray)),
            };
            if looks == 0 && self.chart.borrow().map.compass().is_none() {
                self.commit(Change::Compass(report.pose.heading)).await;
            }
            if report.overrides == 0 || looks == LOOKS {
                return Ok(Ok(report));
            }
            // Who was driven about near the corner may stand anywhere before it, or behind it.
            looks += 1;
            followed = self.come_again(from, &report).await?;
        }
    }

    /// Has a place named that nobody has been to, and adds it to the map.
    async fn find(&mut self, standing: &mut Standing, reached: &Reached, report: CorridorReport) -> Result<(), Arrived> {
        let Reached { at, covariance, .. } = *reached;
        self.present(|own| own.comes_to(at));
        let place = match self.name_at_last(standing, report).await {
            Named::Place(place) => place,
            Named::Nothing => {
                self.present(|own| own.passes());
                return Err(Arrived::NoPlace);
            }
            Named::TurnedBack => return Err(Arrived::TurnedBack),
            Named::Astray => return Err(Arrived::Astray),
        };
        standing.place = self.commit(Change::Found(Place { at, covariance, ..place })).await.ok_or(Arrived::Astray)?;
        Ok(())
    }

    /// The robot has come to a place that is known. It has seen where that is if it `stands` where the follower says that it begins.
    async fn come_again_to(&mut self, standing: &Standing, reached: &Reached, stands: bool) {
        let Reached { at, covariance, .. } = *reached;
        if stands {
            self.commit(Change::SeenAgain { place: standing.place, at, covariance }).await;
        }
        let name = self.chart.borrow().map.place(standing.place).map(|place| place.name.clone()).unwrap_or_default();
        self.pilot.announce(format!("at {name} again"));
    }

    /// The robot knows where it is.
    fn settle_at(&mut self, standing: &Standing) {
        let fix = self.fix_at(standing);
        (self.strange, self.lost) = (0, 0);
        let mut chart = self.chart.borrow_mut();
        chart.fix = fix;
        chart.arrive_at(standing.place);
        let map = &chart.map;
        let Some(at) = map.place(standing.place).filter(|place| place.visits == 1) else { return };
        let (places, corridors, open) = (map.places().len(), map.corridors().count(), map.unexplored());
        let counts = format!("places {places}, corridors {corridors}, ways to go {open}");
        self.pilot.announce(format!("{}: {}, {:.1} % sure; {counts}", at.name, at.title, 100.0 * at.belief));
    }
}
