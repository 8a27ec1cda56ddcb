//! The solver and the enumerator, which share nothing but the model, agree on random diagrams.
#![allow(clippy::unwrap_used)]

use orienteer_influence::{
    Memory, Optimum,
    check::{Comparison, Shape, compare, random_diagram, random_evidence},
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Compares on so many random diagrams of all sizes.
fn compare_many(seed: u64, count: usize, memory: Memory) -> Vec<Comparison> {
    let mut random = Pcg64::seed_from_u64(seed);
    let compare_one = |_| {
        let decisions = random.random_range(0..=3);
        let shape = Shape {
            chances: random.random_range(0..=7 - decisions),
            decisions,
            utilities: random.random_range(0..=3),
            zeros: random.random_range(0.0..0.4),
            memory,
            ..Shape::default()
        };
        let diagram = random_diagram(&mut random, &shape);
        assert_eq!(diagram.variables().len(), shape.chances + shape.decisions);
        let evidence = random_evidence(&mut random, &diagram);
        let comparison = compare(&diagram, &evidence).unwrap_or_else(|error| panic!("{error}: {diagram:?} {evidence:?}"));
        assert!(comparison.is_none_or(|c| c.largest_error < 1e-9), "{comparison:?}: {diagram:?} {evidence:?}");
        comparison
    };
    (0..count).filter_map(compare_one).collect()
}

#[test]
fn with_perfect_memory_everything_agrees() {
    let comparisons = compare_many(1, 10_000, Memory::Perfect);
    assert!(comparisons.len() > 7000, "most of the evidence is possible");
    assert!(comparisons.iter().all(|comparison| comparison.optimum == Optimum::Global));
    assert!(comparisons.iter().map(|comparison| comparison.numbers).sum::<usize>() > 100_000);
}

#[test]
fn with_limited_memory_nothing_is_better_by_one_change_and_no_maximum_is_claimed_in_vain() {
    let comparisons = compare_many(2, 3000, Memory::Limited);
    let count = |optimum| comparisons.iter().filter(|comparison| comparison.exhausted && comparison.optimum == optimum).count();
    assert!(count(Optimum::Global) > 200, "{}", count(Optimum::Global));
    assert!(count(Optimum::Local) > 20, "{}", count(Optimum::Local));
}
