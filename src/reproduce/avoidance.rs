//! Avoidance: does the robot give way to people, and only to them?
//!
//! Randazza (1989) describes the avoidance module of Huey and reports no figures. Two experiments are run here:
//!
//! * **encounters** with one person who pays no heed to the robot: head-on, crossing, overtaking; in a hall of 10 m × 10 m and in
//!   corridors of 2.46 m and 1.5 m; while the robot stands, and while something else drives it. Each is drawn from its seed.
//!   Being touched by somebody who does not look is no fault; moving toward them at that moment is.
//! * **the office floor** as it is shipped, with two robots on patrol; once without people, where nothing but the other robot ever
//!   comes, and once with them.

mod encounter;
mod judge;
mod office;
mod witness;

use super::{Effort, Row, Suite, SuiteError, in_parallel};
use encounter::{Encounter, Task};
use judge::Verdict;

pub(super) const SUITE: Suite =
    Suite { name: "avoidance", help: "gives way to people who walk into its way, and to nothing else", run };

/// Encounters unless told otherwise.
const ENCOUNTERS: u64 = 500;
/// Runs of the office floor, each with and without people.
const FLOORS: u64 = 6;

fn run(effort: &Effort) -> Result<Vec<Row>, SuiteError> {
    let count = effort.seeds(ENCOUNTERS);
    let met = in_parallel(effort, "encounters", count, |seed| {
        let encounter = Encounter::draw(seed);
        let verdict = judge::judge(&encounter)?;
        if verdict.toward > 0 || verdict.collisions > 0 || (encounter.must_evade() && verdict.contacts > 0) || verdict.lost {
            tracing::info!("encounter {seed} went wrong: {verdict:?} in {encounter:?}");
        }
        Ok((encounter, verdict))
    })?;
    // Seeds are for encounters; a floor takes as long as a hundred of them.
    let floors = if effort.quick { 1 } else { FLOORS };
    let floors = in_parallel(effort, "office floors", 2 * floors, |job| office::run(job / 2 + 1, job % 2 == 1))?;

    let mut rows = encounter_rows(&met);
    rows.extend(office_rows(&floors));
    Ok(rows)
}

fn encounter_rows(met: &[(Encounter, Verdict)]) -> Vec<Row> {
    let share = |what: &dyn Fn(&Encounter) -> bool, good: &dyn Fn(&Verdict) -> bool| {
        let all: Vec<_> = met.iter().filter(|(encounter, _)| what(encounter)).collect();
        let well = all.iter().filter(|(_, verdict)| good(verdict)).count();
        (100.0 * well as f64 / all.len().max(1) as f64, all.len())
    };
    let count = |bad: &dyn Fn(&Verdict) -> bool| met.iter().filter(|(_, verdict)| bad(verdict)).count() as f64;
    let evaded = |verdict: &Verdict| verdict.contacts == 0;
    let (standing, stood) = share(&|encounter| encounter.must_evade() && encounter.task == Task::Stand, &evaded);
    let (driving, drove) = share(&|encounter| encounter.must_evade() && encounter.task != Task::Stand, &evaded);
    let overridden = met.iter().filter(|(encounter, verdict)| encounter.task == Task::Follow && verdict.overrides > 0).count();
    let lost = count(&|verdict| verdict.lost);
    vec![
        Row::at_least("encounters", 1.0, met.len() as f64, ""),
        Row::exactly("contacts while moving toward the person", 0.0, count(&|v| v.toward > 0), ""),
        Row::exactly("collisions with anything else", 0.0, count(&|v| v.collisions > 0), ""),
        Row::at_least(format!("evaded: head-on at 0.4 m/s or less, hall, robot stands (n = {stood})"), 95.0, standing, "%"),
        Row::at_least(format!("evaded: head-on at 0.4 m/s or less, hall, robot drives (n = {drove})"), 95.0, driving, "%"),
        Row::at_least(
            format!("overridden corridor follower resumes its way (n = {overridden})"),
            99.0,
            100.0 * (1.0 - lost / overridden.max(1) as f64),
            "%",
        ),
        Row::information(
            "encounters with a touch, whoever is to blame",
            100.0 * count(&|v| v.contacts > 0) / met.len() as f64,
            "%",
        ),
    ]
}

fn office_rows(floors: &[office::Floor]) -> Vec<Row> {
    let mean = |people: bool, figure: &dyn Fn(&office::Floor) -> f64| {
        let of: Vec<f64> = floors.iter().filter(|floor| floor.people == people).map(figure).collect();
        of.iter().sum::<f64>() / of.len().max(1) as f64
    };
    vec![
        Row::at_most(
            "office floor without people: steps aside with nobody within 2.5 m, per robot and 10 min",
            1.0,
            mean(false, &|floor| floor.false_alarms),
            "",
        ),
        Row::at_most(
            "office floor without people: all steps aside, per robot and 10 min",
            3.0,
            mean(false, &|floor| floor.overrides),
            "",
        ),
        Row::at_most("office floor with three people: avoidance holds the base", 15.0, mean(true, &|floor| floor.held), "%"),
        Row::exactly("office floor: driven into something", 0.0, floors.iter().map(|floor| floor.collisions).sum(), ""),
    ]
}
