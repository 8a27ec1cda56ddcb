//! Place classifier: finds out what a place is, by looking for the features that tell most.
//!
//! Asked with a [`PlaceOrder`] where the robot stands at a place's start pose, it has the feature detector look for one feature after the
//! other, until one kind of place is probable enough; then it answers with a [`PlaceReport`] (Randazza 1989, §3.2). After each look the robot goes
//! back to the start pose, along the way that it came.
//!
//! * [`Catalogue`]: kinds of places and what is found there, from a file;
//! * [`Outcomes`]: how sure an outcome is;
//! * [`PlaceDiagram`]: the influence diagram, solved by `orienteer-influence`;
//! * [`Selection`]: by what the next look is chosen; [`Lookahead`] plans several ahead;
//! * `centre`: the start pose, corrected by the walls beside it;
//! * [`LearnedCosts`]: what looks cost, learned while they are taken;
//! * [`Session`]: all of it for one place, without a robot; [`rehearse`] compares rules by it.

mod catalogue;
mod centre;
mod costs;
mod diagram;
mod lookahead;
mod rehearsal;
mod selection;
mod sensor_model;
mod session;

use std::{cell::RefCell, rc::Rc, sync::Arc, time::Duration};

use orienteer_runtime::{
    agent::{Aborted, Agent, Behaviour, BuildError, Finish, Inputs, Outputs, Pilot, RobotContext, Script, Wiring},
    config::{Problem, Problems, Section, Sources, validate},
    geometry::Pose,
    robot_model::Ring,
    time::Time,
    topics::{
        FeatureOutcome, FeatureReport, FeatureRequest, FixedVec, Label, PlaceBelief, PlaceOrder, PlaceReport, PoseEstimate,
        SonarScan, Way,
    },
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{
    clock_ring::{Clockwork, Gathering, RingFilter},
    crumbs::Crumbs,
    places::Reckoning,
};
pub use catalogue::{Catalogue, CatalogueError, Feature, Hypothesis, MOST, Standing, Table};
pub use costs::{Costs, LearnedCosts};
pub use diagram::{PlaceDiagram, doubt};
pub use lookahead::{Lookahead, Plan};
pub use rehearsal::{Taken, rehearse};
pub use selection::Selection;
pub use sensor_model::{Ending, Outcomes};
pub use session::{Next, Session, Verdict};

/// Parameters of the place classifier.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PlaceClassifierConfig {
    /// A file with kinds of places, beside the twelve that are built in: `[[hypothesis]]` with `id`, `title`, `features`, `blocked` and
    /// `ways`, and `[[feature]]` with `id`, `kind` and `where`. One with a known `id` takes the place of the known one.
    pub places: Option<String>,
    /// By what the next look is chosen.
    pub selection: Selection,
    /// How sure outcomes are, and whether an abort says anything.
    pub outcomes: Outcomes,
    /// So probable a place must be, to be named without further looks.
    #[schemars(range(min = 0.1, max = 1.0))]
    pub content: f64,
    /// What a wrong name costs, in the units of `costs`.
    #[schemars(range(min = 0.0, max = 1e9))]
    pub loss: f64,
    /// What going round a feature costs, by its kind.
    pub costs: Costs,
    /// Take the mean of what looks did cost, once a kind of feature was found five times.
    pub learn_costs: bool,
    /// No place is looked at more often.
    #[schemars(range(min = 1, max = 100))]
    pub looks: u32,
    /// Looks in which somebody came between don't count; after so many the place is named anyhow.
    #[schemars(range(min = 1, max = 1000))]
    pub interruptions: u32,
    /// No feature is looked for more often at one place.
    #[schemars(range(min = 1, max = 10))]
    pub repeats: u32,
    /// A look must promise to tell more than this, bits.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub least_gain: f64,
    /// With `selection = "expectimax"`, how many looks to plan ahead. Where outcomes are certain, plans are made to the end.
    #[schemars(range(min = 1, max = 4))]
    pub horizon: u32,
    /// Begin with what the corridor follower says of open sides.
    pub hint: bool,
    /// The probability that its hint is wrong.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub elsewhere: f64,
    /// Go back to the start pose after each look; otherwise only as far as the next look needs.
    pub return_to_start: bool,
    /// Speed on the way back, m/s.
    #[schemars(range(min = 0.02, max = 1.0))]
    pub speed: f64,
    /// Turn rate on the way back, rad/s.
    #[schemars(range(min = 0.05, max = 3.0))]
    pub turn_rate: f64,
    /// Width of corridors where the order does not know it, m.
    #[schemars(range(min = 0.5, max = 5.0))]
    pub width: f64,
    /// Kinds of places, read from `places`.
    #[serde(skip, default = "corridors")]
    #[schemars(skip)]
    pub catalogue: Arc<Catalogue>,
}

fn corridors() -> Arc<Catalogue> {
    Arc::new(Catalogue::corridors())
}

impl Default for PlaceClassifierConfig {
    fn default() -> Self {
        Self {
            places: None,
            selection: Selection::GainPerCost,
            outcomes: Outcomes::ThreeValued,
            content: 0.95,
            loss: 20_000.0,
            costs: Costs::default(),
            learn_costs: true,
            looks: 12,
            interruptions: 20,
            repeats: 2,
            least_gain: 0.001,
            horizon: 2,
            hint: true,
            elsewhere: 0.02,
            return_to_start: true,
            speed: 0.2,
            turn_rate: 0.5,
            width: 1.12,
            catalogue: corridors(),
        }
    }
}

/// The agent.
#[derive(Debug)]
pub struct PlaceClassifier {
    mind: Rc<Mind>,
    wiring: Wiring,
    /// The order that it carries out, or has carried out.
    order: u32,
    script: Option<Script>,
}

/// What stays from place to place.
#[derive(Debug)]
struct Mind {
    config: PlaceClassifierConfig,
    ring: Arc<Ring>,
    clockwork: Clockwork,
    costs: RefCell<LearnedCosts>,
    /// Requests to the feature detector are numbered on.
    requests: RefCell<u32>,
    tally: RefCell<Tally>,
    /// A visit that was cut short, and what it has told.
    cut_short: RefCell<Option<(PlaceOrder, Session)>>,
}

#[derive(Debug, Default)]
struct Tally {
    places: u32,
    sure: u32,
    looks: u32,
    cost: f64,
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
struct Visit {
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
    fn new(mind: Rc<Mind>, pilot: Pilot, order: PlaceOrder) -> Self {
        let width = if order.width > 0.0 { order.width } else { mind.config.width };
        let reckoning = Reckoning::new(width, &mind.ring);
        let report = PlaceReport::new(order.stamp, order.order);
        Self { mind, pilot, start: order.start, order, reckoning, crumbs: Crumbs::default(), report }
    }

    async fn run(mut self) -> Result<(), Aborted> {
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

impl PlaceClassifier {
    fn take_orders(&mut self, inputs: &Inputs, out: &mut Outputs) {
        let Some(order) = inputs.fresh::<PlaceOrder>().filter(|order| order.order != self.order).copied() else { return };
        self.order = order.order;
        if self.script.take().is_some() {
            out.base.release();
            out.publish(FeatureRequest::default());
        }
        if order.order == 0 || !order.start.is_sound() {
            return;
        }
        let mind = self.mind.clone();
        self.script = Some(Script::new(&self.wiring, move |pilot| Visit::new(mind, pilot, order).run()));
    }
}

impl Behaviour for PlaceClassifier {
    fn step(&mut self, now: Time, inputs: &Inputs, out: &mut Outputs) {
        self.take_orders(inputs, out);
        let Some(script) = &mut self.script else { return };
        if script.step(now, inputs, out).is_some() {
            self.script = None;
        }
    }

    fn finish(&mut self, _now: Time, last_words: &mut Finish) {
        let tally = self.mind.tally.borrow();
        last_words.fact("places_named", f64::from(tally.places));
        last_words.fact("places_sure", f64::from(tally.sure));
        last_words.fact("looks", f64::from(tally.looks));
        last_words.fact("looks_cost", tally.cost);
    }
}

impl Agent for PlaceClassifier {
    const KIND: &'static str = "place-classifier";
    const HELP: &'static str = "names the place that a robot has come to, by an influence diagram";
    type Config = PlaceClassifierConfig;

    fn topics(wiring: &mut Wiring) {
        wiring.reads::<SonarScan>().reads::<PoseEstimate>().reads::<FeatureReport>().reads::<PlaceOrder>();
        wiring.writes::<FeatureRequest>().writes::<PlaceBelief>().writes::<PlaceReport>();
    }

    fn read_files(config: &mut Self::Config, parameters: &Section, sources: &mut Sources) -> Result<(), Problems> {
        let Some(name) = &config.places else { return Ok(()) };
        let named = parameters.span_of("places");
        let file = sources.read_for(name, &named)?;
        let section = Section::parse(sources, file)?;
        let mut catalogue = Catalogue::corridors();
        catalogue.extend(validate::read(&section, sources)?);
        if let Err(error) = catalogue.check() {
            let at = place_of(&error, &section).unwrap_or_else(|| sources.start_of(file));
            let problem = Problem::new(sources, &at, error.message, error.hint);
            return Err(problem.note(sources, &named, "the file is named here").into());
        }
        config.catalogue = Arc::new(catalogue);
        Ok(())
    }

    fn build(config: Self::Config, robot: &RobotContext) -> Result<Self, BuildError> {
        let mut wiring = Wiring::default();
        Self::topics(&mut wiring);
        let mind = Mind {
            costs: RefCell::new(LearnedCosts::new(config.costs)),
            ring: robot.ring.clone(),
            clockwork: Clockwork::new(&robot.ring).map_err(BuildError::new)?,
            config,
            requests: RefCell::default(),
            tally: RefCell::default(),
            cut_short: RefCell::default(),
        };
        Ok(Self { mind: Rc::new(mind), wiring, order: 0, script: None })
    }
}

/// Where in a file the table stands that an error is about.
fn place_of(error: &CatalogueError, file: &Section) -> Option<orienteer_runtime::config::Span> {
    let (table, id) = error.about.as_ref()?;
    let key = match table {
        Table::Feature => "feature",
        Table::Hypothesis => "hypothesis",
    };
    let found = file.entries(key).find(|entry| entry.text("id") == Some(id));
    found.map(|entry| entry.span_of("id"))
}
