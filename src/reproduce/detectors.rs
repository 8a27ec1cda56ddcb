//! Feature detectors at the twelve places: what is found where, without noise and with all of it.
//!
//! Thirteen searches at each of twelve places make 156 cells: at 37 of them the feature is there, at 18 the robot can't carry its manoeuvre out
//! (it would have to drive through a wall), and at 101 it is not there. The noisy worlds have corridors and branches up to 10 % wider or
//! narrower than Randazza's, and the robot stands off its start pose by 5 cm and 2° (one standard deviation).

mod trial;

use super::{Effort, Row, Suite, SuiteError, at_a_place::PLACES, in_parallel};
use crate::{
    agents::place_classifier::{Catalogue, Standing},
    hardware::world::floors::Hypothesis,
    runtime::topics::{FeatureKind, FeatureOutcome},
};
use trial::{Seen, Trial};

pub(super) const SUITE: Suite =
    Suite { name: "detectors", help: "looks for thirteen features at twelve places, without and with noise", run };

/// Seeds from here on were not looked at while the detectors were made.
const FIRST_SEED: u64 = 1001;
const FEATURES: usize = 13;
const CELLS: u64 = (PLACES * FEATURES) as u64;

fn cell(trial: &Trial) -> Standing {
    Catalogue::corridors().standing(trial.feature, trial.at.place as usize)
}

fn trial(number: u64, make: impl Fn(Hypothesis, usize) -> Trial) -> Trial {
    let (place, feature) = (number as usize / FEATURES % PLACES, number as usize % FEATURES);
    make(Hypothesis::ALL[place], feature)
}

fn run(effort: &Effort) -> Result<Vec<Row>, SuiteError> {
    let exact = in_parallel(effort, "without noise", CELLS, |number| {
        let trial = trial(number, Trial::exact);
        let seen = trial.run()?;
        Ok((trial, seen))
    })?;
    let seeds = effort.seeds(14);
    let noisy = in_parallel(effort, "with noise", seeds * CELLS, |number| {
        let trial = trial(number % CELLS, |place, feature| Trial::perturbed(place, feature, FIRST_SEED + number / CELLS));
        let seen = trial.run()?;
        Ok((trial, seen))
    })?;
    let mut rows = exact_rows(&exact);
    rows.extend(noisy_rows(&noisy));
    Ok(rows)
}

fn exact_rows(runs: &[(Trial, Seen)]) -> Vec<Row> {
    let count = |of: Standing, outcome: FeatureOutcome| {
        runs.iter().filter(|(trial, seen)| cell(trial) == of && seen.outcome == outcome).count() as f64
    };
    vec![
        Row::exactly("without noise: found of those that are there", 37.0, count(Standing::Present, FeatureOutcome::Found), ""),
        Row::exactly("without noise: found of those that are not", 0.0, count(Standing::Absent, FeatureOutcome::Found), ""),
        Row::exactly(
            "without noise: not found of those that are not there",
            101.0,
            count(Standing::Absent, FeatureOutcome::NotFound),
            "",
        ),
        Row::exactly(
            "without noise: aborted of those that can't be reached",
            18.0,
            count(Standing::Blocked, FeatureOutcome::Abort),
            "",
        ),
    ]
}

fn noisy_rows(runs: &[(Trial, Seen)]) -> Vec<Row> {
    let features = Catalogue::corridors().feature;
    let kind = |trial: &Trial| features[trial.feature].kind;
    let share = |of: &dyn Fn(&Trial) -> bool, outcome: FeatureOutcome| {
        let all = runs.iter().filter(|(trial, _)| of(trial)).count();
        let such = runs.iter().filter(|(trial, seen)| of(trial) && seen.outcome == outcome).count();
        100.0 * such as f64 / all.max(1) as f64
    };
    let present = |trial: &Trial| cell(trial) == Standing::Present;
    let absent = |trial: &Trial| cell(trial) != Standing::Present;
    let outcome_of = |standing: Standing, outcome| share(&|trial: &Trial| cell(trial) == standing, outcome);
    let collisions: u32 = runs.iter().map(|(_, seen)| seen.collisions).sum();
    let mut rows = vec![
        Row::information("with noise: detections", runs.len() as f64, ""),
        Row::at_least("with noise: found of those that are there", 97.0, share(&present, FeatureOutcome::Found), "%"),
        Row::at_least(
            "with noise: found of edges that are there",
            90.0,
            share(&|trial| present(trial) && kind(trial) == FeatureKind::Edge, FeatureOutcome::Found),
            "%",
        ),
        Row::at_most("with noise: found of those that are not", 0.3, share(&absent, FeatureOutcome::Found), "%"),
        Row::information("with noise: aborted of those that are there", share(&present, FeatureOutcome::Abort), "%"),
        Row::information(
            "with noise: aborted of those that are not there",
            outcome_of(Standing::Absent, FeatureOutcome::Abort),
            "%",
        ),
        Row::information(
            "with noise: aborted of those that can't be reached",
            outcome_of(Standing::Blocked, FeatureOutcome::Abort),
            "%",
        ),
        Row::exactly("with noise: collisions", 0.0, f64::from(collisions), ""),
    ];
    for (kind, name, cost, time) in [
        (FeatureKind::Wall, "wall", 680.0, 73.0),
        (FeatureKind::Concave, "concave corner", 1050.0, 103.0),
        (FeatureKind::Convex, "convex corner", 1076.0, 112.0),
        (FeatureKind::Edge, "wall edge", 2000.0, 330.0),
    ] {
        let found: Vec<&Seen> = runs
            .iter()
            .filter(|(trial, seen)| features[trial.feature].kind == kind && seen.outcome == FeatureOutcome::Found)
            .map(|(_, seen)| seen)
            .collect();
        let mean = |figure: fn(&Seen) -> f64| found.iter().map(|seen| figure(seen)).sum::<f64>() / found.len().max(1) as f64;
        let mut row = Row::information(format!("{name}: way and turns when found, mean"), mean(|seen| seen.cost), "cm + °");
        row = row.reported(format!("{cost:.0}"));
        rows.push(row);
        rows.push(
            Row::information(format!("{name}: time when found, mean"), mean(|seen| seen.took), "s")
                .reported(format!("{time:.0}")),
        );
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{agents::places::Whereabouts, hardware::world::floors::Flank, runtime::topics::Side};

    /// True if that feature belongs to this place.
    fn has(place: Hypothesis, kind: FeatureKind, whereabouts: Whereabouts) -> bool {
        let view = place.view();
        let flank = |side: Side| if side == Side::Left { view.left } else { view.right };
        match (kind, whereabouts) {
            (FeatureKind::Convex, Whereabouts::Near(side)) => matches!(flank(side), Flank::Corridor | Flank::CornerThenEdge),
            (FeatureKind::Convex, Whereabouts::Far(side)) => {
                view.ahead && matches!(flank(side), Flank::Corridor | Flank::EdgeThenCorner)
            }
            (FeatureKind::Edge, Whereabouts::Near(side)) => flank(side) == Flank::EdgeThenCorner,
            (FeatureKind::Edge, Whereabouts::Far(side)) => flank(side) == Flank::CornerThenEdge,
            (FeatureKind::Wall, Whereabouts::Beside(side)) => view.ahead && flank(side) == Flank::Wall,
            (FeatureKind::Wall, Whereabouts::Ahead) => {
                !view.ahead && view.left == Flank::Corridor && view.right == Flank::Corridor
            }
            (FeatureKind::Concave, Whereabouts::Beside(side)) => !view.ahead && flank(side) == Flank::Wall,
            _ => false,
        }
    }

    /// What the classifier is told about the twelve places is true of the worlds.
    #[test]
    fn the_catalogue_is_that_of_the_worlds() {
        let catalogue = Catalogue::corridors();
        assert_eq!((catalogue.feature.len(), catalogue.hypothesis.len()), (FEATURES, PLACES));
        for place in Hypothesis::ALL.into_iter().take(PLACES) {
            assert_eq!(catalogue.hypothesis[place as usize].id, place.id());
            for (number, feature) in catalogue.feature.iter().enumerate() {
                let there = catalogue.standing(number, place as usize) == Standing::Present;
                assert_eq!(there, has(place, feature.kind, feature.whereabouts), "{place} {}", feature.id);
            }
        }
    }
}
