//! The solver and the enumerator, which share nothing but the model, agree on random diagrams.
#![allow(clippy::unwrap_used)]

use orienteer_influence::{
    Memory, Optimum,
    check::{Comparison, survey},
};
use rand::SeedableRng;
use rand_pcg::Pcg64;

fn compare_many(seed: u64, count: usize, memory: Memory) -> Vec<Comparison> {
    let comparisons = survey(&mut Pcg64::seed_from_u64(seed), count, memory).unwrap();
    let worst = comparisons.iter().map(|comparison| comparison.largest_error).fold(0.0, f64::max);
    assert!(worst < 1e-9, "{worst}");
    comparisons
}

#[test]
fn with_perfect_memory_everything_agrees() {
    let comparisons = compare_many(1, 10_000, Memory::Perfect);
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
