//! What the robot does at a place: looks for one feature after the other, goes back in between, and answers.

use std::{cell::RefCell, rc::Rc, sync::Arc, time::Duration};

use orienteer_runtime::{
    agent::{Aborted, Inputs, Pilot},
    geometry::Pose,
    robot_model::Ring,
    time::Time,
    topics::{
        FeatureOutcome, FeatureReport, FeatureRequest, FixedVec, Label, PlaceBelief, PlaceOrder, PlaceReport, PoseEstimate,
        SonarScan, Way,
    },
};

use super::{
    PlaceClassifierConfig,
    catalogue::{Catalogue, Feature, Hypothesis},
    centre,
    costs::LearnedCosts,
    sensor_model::Ending,
    session::{Next, Session, Verdict},
};
use crate::{
    clock_ring::{Clockwork, Gathering, RingFilter},
    crumbs::Crumbs,
    places::Reckoning,
};

/// What stays from place to place.
#[derive(Debug)]
pub(super) struct Mind {
    pub config: PlaceClassifierConfig,
    pub ring: Arc<Ring>,
    pub clockwork: Clockwork,
    pub costs: RefCell<LearnedCosts>,
    /// Requests to the feature detector are numbered on.
    pub requests: RefCell<u32>,
    pub tally: RefCell<Tally>,
    /// A visit that was cut short, and what it has told.
    pub cut_short: RefCell<Option<(PlaceOrder, Session)>>,
}

/// Figures for the summary.
#[derive(Debug, Default)]
pub(super) struct Tally {
    pub places: u32,
    pub sure: u32,
    pub looks: u32,
    /// Centimetres and degrees.
    pub cost: f64,
}

/// Passes of the sonar by which a robot centres itself.
const PASSES: usize = 12;
/// A start pose so near to that of a visit that was cut short is that of the same place, m.
const SAME_PLACE: f64 = 0.8;
/// A detector that says nothing for so long is not there.
const LONGEST_LOOK: Duration = Duration::from_secs(1200);

impl Mind {
    /// What is known of the place of this order: that of a visit there that was cut short, or nothing.
    fn session(&self, order: &PlaceOrder) -> Option<Session> {
        let same = |before: &PlaceOrder| before.opening() == order.opening() && before.start.distance(&order.start) < SAME_PLACE;
        let known = self.cut_short.take().filter(|(before, _)| same(before));
        known.map(|(_, session)| session).or_else(|| Session::new(&self.config, order.opening()).ok())
    }

    /// What each look would cost now: going round the feature, and the way to it.
    fn prices(&self, reckoning: &Reckoning, start: Pose, here: Pose) -> Vec<f64> {
        let way = |feature: &Feature| {
            let search = reckoning.search(feature.kind, feature.whereabouts, start);
            search.map_or(0.0, |search| 100.0 * here.distance(&search.at))
        };
        let costs = self.costs.borrow();
        self.config.catalogue.feature.iter().map(|feature| costs.of(feature.kind) + way(feature)).collect()
    }

    fn learn(&self, feature: &Feature, report: &FeatureReport, way: f64) {
        let cost = cost_of(report);
        self.tally.borrow_mut().cost += cost;
        if report.outcome() == FeatureOutcome::Found && self.config.learn_costs {
            self.costs.borrow_mut().learn(feature.kind, (cost - way).max(1.0));
        }
    }
}

/// Centimetres and degrees.
fn cost_of(report: &FeatureReport) -> f64 {
    100.0 * report.driven + report.turned.to_degrees()
}

/// Names the place of an order.
pub(super) struct Visit {
    mind: Rc<Mind>,
    pilot: Pilot,
    order: PlaceOrder,
    /// The place's start pose, corrected by what was heard since.
    start: Pose,
    reckoning: Reckoning,
    crumbs: Crumbs,
    report: PlaceReport,
}

impl Visit {
    pub fn new(mind: Rc<Mind>, pilot: Pilot, order: PlaceOrder) -> Self {
        let width = if order.width > 0.0 { order.width } else { mind.config.width };
        let reckoning = Reckoning::new(width, &mind.ring);
        let report = PlaceReport::new(order.stamp, order.order);
        Self { mind, pilot, start: order.start, order, reckoning, crumbs: Crumbs::default(), report }
    }

    pub async fn run(mut self) -> Result<(), Aborted> {
        let mind = self.mind.clone();
        let (config, catalogue) = (&mind.config, &mind.config.catalogue);
        let began = self.pilot.now();
        self.centre().await?;
        let Some(mut session) = mind.session(&self.order) else { return Ok(()) };
        self.crumbs.drop(self.start);
        let verdict = loop {
            let prices = mind.prices(&self.reckoning, self.start, self.here());
            let next = session.next(&prices).unwrap_or(Next::Report(Verdict { hypothesis: None, belief: 0.0, sure: false }));
            self.tell(&session, next);
            let feature = match next {
                Next::Report(verdict) => break verdict,
                Next::Look(feature) => feature,
            };
            let disturbed = self.look(feature, &mut session).await;
            // The next look, if there is one, may begin from nearer than the start pose.
            let next = session.next(&mind.prices(&self.reckoning, self.start, self.here()));
            let toward = match next {
                Ok(Next::Look(feature)) if !config.return_to_start => catalogue.feature.get(feature),
                _ => None,
            };
            // Who had to give way knows no longer where it stands. From somewhere else all that is to be seen would be taken for what it is not.
            let is_back = self.go_back(toward).await.is_ok();
            if !is_back || (disturbed && !matches!(next, Ok(Next::Report(_)))) {
                self.pilot.say("somebody came between; the place has to be come to again");
                mind.cut_short.replace(Some((self.order, session.rested())));
                break Verdict { hypothesis: None, belief: 0.0, sure: false };
            }
            self.centre().await?;
        };
        if !verdict.sure && session.is_interrupted() {
            mind.cut_short.replace(Some((self.order, session.rested())));
        }
        self.report.looks = session.looks();
        self.report.took = self.pilot.now().secs_since(began);
        self.answer(verdict);
        Ok(())
    }

    /// Where the robot thinks it is.
    fn here(&self) -> Pose {
        self.pilot.latest::<PoseEstimate>().map_or(self.start, |estimate| estimate.pose)
    }

    /// Says what is thought of the place, and what is looked for next.
    fn tell(&self, session: &Session, next: Next) {
        let catalogue = &self.mind.config.catalogue;
        let beliefs = session.beliefs();
        let mut published = FixedVec::default();
        // A catalogue has no more than there is room for.
        beliefs.iter().for_each(|belief| _ = published.push(*belief));
        let best = (0..beliefs.len()).max_by(|a, b| beliefs[*a].total_cmp(&beliefs[*b]).then(b.cmp(a)));
        let best = best.and_then(|best| catalogue.hypothesis.get(best)).map_or("", |hypothesis| hypothesis.id.as_str());
        let feature = if let Next::Look(feature) = next { catalogue.feature.get(feature) } else { None };
        self.pilot.publish(PlaceBelief {
            stamp: self.pilot.now(),
            order: self.order.order,
            looks: session.looks(),
            beliefs: published,
            best: Label::new(best),
            looking_for: Label::new(feature.map_or("", |feature| feature.id.as_str())),
        });
        if let Some(feature) = feature {
            self.pilot.announce(format!("{}; looks for {}", likely(catalogue, &beliefs), feature.id));
        }
    }

    /// Has the feature detector look for a feature, and notes how that ended. Nobody who answers is as good as somebody in the way. True if somebody came between.
    async fn look(&mut self, number: usize, session: &mut Session) -> bool {
        let Some(report) = self.detect(number).await else {
            session.observe(number, Ending::Interrupted);
            return false;
        };
        let ending = Ending::of(&report);
        match ending {
            Ending::Interrupted => session.interrupt(number, Ending::seeming(&report)),
            ending => session.observe(number, ending),
        }
        report.is_disturbed()
    }

    /// What the feature detector answers, if it does.
    async fn detect(&mut self, number: usize) -> Option<FeatureReport> {
        let mind = self.mind.clone();
        let feature = mind.config.catalogue.feature.get(number)?;
        let search = self.reckoning.search(feature.kind, feature.whereabouts, self.start)?;
        let way = 100.0 * self.here().distance(&search.at);
        let request = {
            let mut requests = mind.requests.borrow_mut();
            *requests += 1;
            FeatureRequest::new(self.pilot.now(), *requests, &search)
        };
        mind.tally.borrow_mut().looks += 1;
        let end = self.pilot.now() + LONGEST_LOOK;
        let report = self.await_report(&request, end).await?;
        mind.learn(feature, &report, way);
        self.report.driven += report.driven;
        self.report.turned += report.turned;
        self.pilot.say(format!("{}: {:?}, {:?}", feature.id, Ending::of(&report), report.reason()));
        Some(report)
    }

    /// The request is repeated in every step: a detector that was built anew has heard none.
    async fn await_report(&mut self, request: &FeatureRequest, end: Time) -> Option<FeatureReport> {
        self.pilot.release();
        loop {
            self.pilot.publish(*request);
            // Who does not hold the base can't lose it.
            self.pilot.next_step().await.ok()?;
            self.crumbs.drop(self.here());
            let answer = self.pilot.latest::<FeatureReport>().filter(|report| report.request == request.request);
            if answer.is_some() || self.pilot.now() > end {
                return answer;
            }
        }
    }

    /// Listens to the walls beside, and corrects the start pose by them.
    async fn centre(&mut self) -> Result<(), Aborted> {
        let mut gathering = Gathering::new(PASSES);
        let clockwork = self.mind.clockwork.clone();
        let listens = |inputs: &Inputs| {
            inputs.each::<SonarScan>().iter().for_each(|scan| gathering.hear(&clockwork, scan));
            gathering.is_full()
        };
        let pilot = self.pilot.clone();
        self.crumbs.along(&pilot, pilot.until(listens)).await?;
        let ring = gathering.ring(RingFilter::Median);
        self.start = centre::centred(self.start, self.here(), &ring, &self.reckoning);
        Ok(())
    }

    /// Goes back along the way that it came: to the start pose, or to where a look in the direction of `toward` can begin.
    async fn go_back(&mut self, toward: Option<&Feature>) -> Result<(), Aborted> {
        let start = self.start;
        let search = toward.and_then(|feature| self.reckoning.search(feature.kind, feature.whereabouts, start));
        let goal = search.map_or(start, |search| self.crumbs.nearest_on_line(start, search.at));
        let (speed, rate) = (self.mind.config.speed, self.mind.config.turn_rate);
        self.crumbs.go_back(&self.pilot, goal, speed, rate).await
    }

    fn answer(&mut self, verdict: Verdict) {
        let hypothesis = verdict.hypothesis.and_then(|number| self.mind.config.catalogue.hypothesis.get(number));
        let ways = hypothesis.map_or(&[][..], |hypothesis| &hypothesis.ways);
        let report = &mut self.report;
        (report.stamp, report.start, report.belief) = (self.pilot.now(), self.start, verdict.belief);
        report.kind = Label::new(hypothesis.map_or("", |hypothesis| &hypothesis.id));
        report.title = Label::new(hypothesis.map_or("", Hypothesis::name));
        report.ports = Way::ALL.map(|way| self.reckoning.port(way, self.start));
        self.pilot.publish(report.with(verdict.sure, ways));
        let mut tally = self.mind.tally.borrow_mut();
        tally.places += 1;
        tally.sure += u32::from(verdict.sure);
        let name = hypothesis.map_or("no place that is known", Hypothesis::name);
        let looks = if self.report.looks == 1 { "look" } else { "looks" };
        self.pilot.announce(format!("{name}, {:.1} % sure, after {} {looks}", 100.0 * verdict.belief, self.report.looks));
    }
}

/// The most probable places, for people.
fn likely(catalogue: &Catalogue, beliefs: &[f64]) -> String {
    const FEW: usize = 3;
    let mut order: Vec<usize> = (0..beliefs.len().min(catalogue.hypothesis.len())).collect();
    order.sort_by(|a, b| beliefs[*b].total_cmp(&beliefs[*a]));
    let named = |h: &usize| format!("{} {:.0} %", catalogue.hypothesis[*h].id, 100.0 * beliefs[*h]);
    order.iter().take(FEW).map(named).collect::<Vec<_>>().join(", ")
}
