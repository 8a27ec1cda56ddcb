//! Arbitration against an independent oracle.

use orienteer_runtime::arbitration::oracle::{Counterexample, Property, Stats, check_range};

use super::{Effort, Row, Suite, SuiteError, in_parallel};

pub(super) const SUITE: Suite =
    Suite { name: "arbitration", help: "the arbiter of the base against an independent oracle, on random histories", run };

/// Histories that make up a full run.
const HISTORIES: u64 = 1_000_000;
/// Histories that a thread checks at a time.
const PORTION: u64 = 2_000;
/// After so many counterexamples a portion is given up; the suite has failed anyway.
const ENOUGH: usize = 5;
const SEED: u64 = 1;

const PROPERTIES: [(Property, &str); 7] = [
    (Property::Protocol, "histories on which arbiter and oracle disagree"),
    (Property::LowerPriority, "a lower priority alters the output while a higher transaction is held"),
    (Property::Limits, "a limit raises a speed"),
    (Property::ToldOnce, "a preempted owner is not told exactly once"),
    (Property::WaitsEnd, "a wait in the queue does not end"),
    (Property::Holder, "something moves without a live claim of its holder"),
    (Property::LostClaims, "an outdated claim makes a difference"),
];

fn run(effort: &Effort) -> Result<Vec<Row>, SuiteError> {
    let histories = effort.seeds(HISTORIES);
    let portions = histories.div_ceil(PORTION);
    let checked = in_parallel(effort, "arbitration", portions, |portion| {
        let start = portion * PORTION;
        Ok(check_portion(start, histories.min(start + PORTION)))
    })?;

    let mut all = Stats::default();
    let mut broken = Vec::new();
    for (stats, counterexamples) in checked {
        all += stats;
        broken.extend(counterexamples);
    }
    for counterexample in broken.iter().take(ENOUGH) {
        tracing::error!("{counterexample}");
    }
    let mut rows: Vec<Row> = PROPERTIES
        .iter()
        .map(|(property, words)| {
            let count = broken.iter().filter(|counterexample| counterexample.property == *property).count();
            Row::exactly(*words, 0.0, count as f64, "histories")
        })
        .collect();
    rows.insert(0, Row::exactly("histories checked", histories as f64, all.histories as f64, "histories"));
    rows.extend(coverage(&all));
    Ok(rows)
}

/// A comparison proves little unless the things that could go wrong did happen.
fn coverage(stats: &Stats) -> Vec<Row> {
    let happened = [
        ("decisions compared", stats.decisions),
        ("of these under a limit", stats.limited),
        ("overrides in them", stats.overridden),
        ("owners who hung on and got the base back", stats.regained),
        ("waits that ended without a grant", stats.busy),
        ("transactions that lapsed", stats.lapsed),
    ];
    happened.into_iter().map(|(what, count)| Row::at_least(what, 1.0, count as f64, "")).collect()
}

/// Checks histories one counterexample after the other.
fn check_portion(mut start: u64, end: u64) -> (Stats, Vec<Counterexample>) {
    let (mut stats, mut broken) = (Stats::default(), Vec::new());
    // What was checked before a counterexample is not told, so it is counted again up to there.
    while start < end && broken.len() < ENOUGH {
        match check_range(SEED, start..end) {
            Ok(more) => {
                stats += more;
                break;
            }
            Err(counterexample) => {
                let found = counterexample.found.1;
                stats += check_range(SEED, start..found).unwrap_or_default();
                start = found + 1;
                broken.push(*counterexample);
            }
        }
    }
    (stats, broken)
}
