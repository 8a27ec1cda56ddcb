//! Naming places: the twelve of Randazza (1989), each in corridors of its own, by every rule.
//!
//! Corridors and branches are up to 10 % wider or narrower than hers, the robot stands off its start pose by 5 cm and 2° (one standard
//! deviation), and all noise is on. The prior is uniform, or the follower has told which sides are open.

mod trial;

use super::{Effort, Row, Suite, SuiteError, at_a_place::PLACES, in_parallel};
use crate::{
    agents::{
        place_classifier::{Outcomes, PlaceClassifierConfig, Selection, rehearse},
        places::Reckoning,
    },
    hardware::world::floors::Hypothesis,
    runtime::geometry::Pose,
};
use trial::{Named, Trial};

pub(super) const SUITE: Suite =
    Suite { name: "classify", help: "names places of twelve kinds, with and without a hint, by every rule", run };

/// Seeds from here on were not looked at while the classifier was made.
const FIRST_SEED: u64 = 5001;
/// Huey's corridors and ring.
const HUEY: Reckoning = Reckoning { width: 1.12, face: 0.08 };

fn run(effort: &Effort) -> Result<Vec<Row>, SuiteError> {
    let mut rows = Vec::new();
    for (hinted, name, most) in [(false, "uniform prior", 4.7), (true, "hint of open sides", 2.7)] {
        let runs = visits(effort, name, 50, hinted, Selection::GainPerCost)?;
        rows.extend(main_rows(name, most, &runs));
    }
    for selection in Selection::ALL {
        rows.extend(certain_rows(selection)?);
    }
    for selection in Selection::ALL {
        let runs = visits(effort, name_of(selection), 10, false, selection)?;
        rows.extend(rule_rows(selection, &runs));
    }
    Ok(rows)
}

/// Visits to places of every kind, so many of each.
fn visits(effort: &Effort, what: &str, each: u64, hinted: bool, selection: Selection) -> Result<Vec<(Trial, Named)>, SuiteError> {
    let places = PLACES as u64;
    in_parallel(effort, what, effort.seeds(each) * places, |number| {
        let place = Hypothesis::ALL[(number % places) as usize];
        let trial = Trial::new(place, FIRST_SEED + number / places, hinted, selection);
        let named = trial.run()?;
        Ok((trial, named))
    })
}

fn main_rows(name: &str, most: f64, runs: &[(Trial, Named)]) -> Vec<Row> {
    let collisions: u32 = runs.iter().map(|(_, named)| named.collisions).sum();
    vec![
        Row::information(format!("{name}: places"), runs.len() as f64, ""),
        Row::at_least(format!("{name}: named right"), 99.0, right(runs), "%"),
        Row::at_most(format!("{name}: looks, mean"), most, mean(runs, |named| named.looks), ""),
        Row::information(format!("{name}: way and turns, mean"), mean(runs, |named| named.cost), "cm + °"),
        Row::information(format!("{name}: time, mean"), mean(runs, |named| named.took), "s"),
        Row::information(format!("{name}: off the start pose at the end, median"), 100.0 * median_off(runs), "cm"),
        Row::exactly(format!("{name}: collisions"), 0.0, f64::from(collisions), ""),
    ]
}

/// Looks and costs if every look ends as it should. The best that can be done is 3.67 looks and a cost of 3593.
fn certain_rows(selection: Selection) -> Result<Vec<Row>, SuiteError> {
    let config = PlaceClassifierConfig { selection, outcomes: Outcomes::Certain, ..PlaceClassifierConfig::default() };
    let cost = |feature: &crate::agents::place_classifier::Feature| {
        let way = HUEY.search(feature.kind, feature.whereabouts, Pose::default());
        config.costs.of(feature.kind) + way.map_or(0.0, |search| 100.0 * search.at.x.hypot(search.at.y))
    };
    let costs: Vec<f64> = config.catalogue.feature.iter().map(cost).collect();
    let taken = rehearse(&config, false, &costs, &costs).map_err(SuiteError::from_display)?;
    let name = name_of(selection);
    Ok(vec![
        Row::information(format!("{name}, every look right: looks, mean (optimum 3.67)"), taken.looks, ""),
        Row::information(format!("{name}, every look right: cost, mean (optimum 3593)"), taken.cost, "cm + °"),
    ])
}

fn rule_rows(selection: Selection, runs: &[(Trial, Named)]) -> Vec<Row> {
    let name = name_of(selection);
    vec![
        Row::information(format!("{name}, uniform prior: looks, mean"), mean(runs, |named| named.looks), ""),
        Row::information(format!("{name}, uniform prior: way and turns, mean"), mean(runs, |named| named.cost), "cm + °"),
        Row::information(format!("{name}, uniform prior: named right (n = {})", runs.len()), right(runs), "%"),
    ]
}

fn right(runs: &[(Trial, Named)]) -> f64 {
    let right = runs.iter().filter(|(trial, named)| named.is(trial.at.place)).count();
    100.0 * right as f64 / runs.len().max(1) as f64
}

fn mean(runs: &[(Trial, Named)], figure: impl Fn(&Named) -> f64) -> f64 {
    runs.iter().map(|(_, named)| figure(named)).sum::<f64>() / runs.len().max(1) as f64
}

fn median_off(runs: &[(Trial, Named)]) -> f64 {
    let mut off: Vec<f64> = runs.iter().map(|(_, named)| named.off).collect();
    off.sort_by(f64::total_cmp);
    off.get(off.len() / 2).copied().unwrap_or_default()
}

/// As configurations have it.
fn name_of(selection: Selection) -> &'static str {
    match selection {
        Selection::Eliminate => "eliminate",
        Selection::EliminatePerCost => "eliminate-per-cost",
        Selection::GainPerCost => "gain-per-cost",
        Selection::InfoGain => "info-gain",
        Selection::Evsi => "evsi",
        Selection::Expectimax => "expectimax",
        Selection::Cheapest => "cheapest",
    }
}
