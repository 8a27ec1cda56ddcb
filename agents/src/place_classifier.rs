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
//! * [`Session`]: all of it for one place, without a robot; [`rehearse`] compares rules by it;
//! * `visit`: what the robot does at a place.

mod catalogue;
mod centre;
mod costs;
mod diagram;
mod lookahead;
mod rehearsal;
mod selection;
mod sensor_model;
mod session;
mod visit;

use std::{cell::RefCell, rc::Rc, sync::Arc};

use orienteer_runtime::{
    agent::{Agent, Behaviour, BuildError, Finish, Inputs, Outputs, RobotContext, Script, Wiring},
    config::{Problem, Problems, Section, Sources, validate},
    time::Time,
    topics::{FeatureReport, FeatureRequest, PlaceBelief, PlaceOrder, PlaceReport, PoseEstimate, SonarScan},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::clock_ring::Clockwork;
pub use catalogue::{Catalogue, CatalogueError, Feature, Hypothesis, MOST, Standing, Table};
pub use costs::{Costs, LearnedCosts};
pub use diagram::{PlaceDiagram, doubt};
pub use lookahead::{Lookahead, Plan};
pub use rehearsal::{Taken, rehearse};
pub use selection::Selection;
pub use sensor_model::{Ending, Outcomes};
pub use session::{Next, Session, Verdict};
use visit::{Mind, Visit};

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
