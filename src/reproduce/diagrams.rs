//! Influence diagrams: the solver against one that walks through everything, on random diagrams.

use orienteer_influence::{
    Memory, Optimum,
    check::{Comparison, survey},
};
use orienteer_runtime::random::Streams;

use super::{Effort, Row, Suite, SuiteError, in_parallel};

pub(super) const SUITE: Suite =
    Suite { name: "diagrams", help: "solves random influence diagrams in two ways, and compares", run };

/// Diagrams of one run.
const PORTION: u64 = 500;

fn run(effort: &Effort) -> Result<Vec<Row>, SuiteError> {
    let mut rows = Vec::new();
    for (memory, name, diagrams) in [(Memory::Perfect, "perfect memory", 20_000), (Memory::Limited, "limited memory", 5000)] {
        let portions = effort.seeds(diagrams / PORTION);
        let found = in_parallel(effort, name, portions, |portion| {
            let mut random = Streams::new(portion).stream("diagrams", name);
            survey(&mut random, PORTION as usize, memory).map_err(SuiteError::from_display)
        })?;
        rows.extend(rows_of(name, memory, &found.concat(), effort.quick || effort.seeds.is_some()));
    }
    Ok(rows)
}

fn rows_of(name: &str, memory: Memory, compared: &[Comparison], fewer: bool) -> Vec<Row> {
    let worst = compared.iter().map(|comparison| comparison.largest_error).fold(0.0, f64::max);
    let numbers: usize = compared.iter().map(|comparison| comparison.numbers).sum();
    let count = |optimum| compared.iter().filter(|comparison| comparison.optimum == optimum).count() as f64;
    let diagrams = compared.len() as f64;
    let least = if fewer || memory == Memory::Limited { 1.0 } else { 10_000.0 };
    let mut rows = vec![
        Row::at_least(format!("{name}: random diagrams"), least, diagrams, ""),
        Row::information(format!("{name}: probabilities, values and policies compared"), numbers as f64, ""),
        Row::at_most(format!("{name}: largest difference from enumeration"), 1e-9, worst, ""),
    ];
    match memory {
        Memory::Perfect => rows.push(Row::exactly(format!("{name}: maxima found"), diagrams, count(Optimum::Global), "")),
        Memory::Limited => {
            rows.push(Row::information(format!("{name}: maxima that are surely the largest"), count(Optimum::Global), ""))
        }
    }
    rows
}
