//! How fast the reference problem is: 6 classes, 8 tests with two outcomes, one report.
//!
//! "Evidence query" means: forget, tell the outcome of up to all 8 tests, ask. "Solve" means: from the numbers of the diagram to the policy tables; with a plan that was made before, and
//! from scratch.
#![allow(clippy::unwrap_used, missing_docs)]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use orienteer_influence::{
    CompiledPolicy, CompiledQuery, Evidence, Plan, VariableId,
    samples::{classifier, next_test},
    solve,
};

const CLASSES: usize = 6;
const TESTS: usize = 8;

/// The outcome of each test in the nth query: 0, 1 or not known, all 3⁸ combinations in turn.
fn outcomes(query: usize) -> impl Iterator<Item = (usize, usize)> {
    let digit = move |test: usize| query / 3usize.pow(test as u32) % 3;
    (0..TESTS).map(move |test| (test, digit(test))).filter(|(_, outcome)| *outcome < 2)
}

fn queries(criterion: &mut Criterion) {
    let reference = classifier(CLASSES, TESTS).unwrap();
    let tests: Vec<VariableId> = reference.tests.iter().map(|test| (*test).into()).collect();
    let solution = solve(&reference.diagram, &Evidence::none()).unwrap();
    let mut group = criterion.benchmark_group("query");
    group.throughput(Throughput::Elements(1));
    let mut policy = CompiledPolicy::new(&reference.diagram, &solution, reference.report, &tests).unwrap();
    let mut query = 0;
    group.bench_function("policy: value of all 6 reports", |bencher| {
        bencher.iter(|| {
            query += 1;
            policy.forget();
            for (test, outcome) in outcomes(query) {
                policy.observe(tests[test], outcome).unwrap();
            }
            black_box(policy.advise().unwrap().best)
        });
    });
    let mut posterior = CompiledQuery::new(&reference.diagram, &[reference.class.into()], &tests).unwrap();
    group.bench_function("posterior of the class", |bencher| {
        bencher.iter(|| {
            query += 1;
            posterior.forget();
            for (test, outcome) in outcomes(query) {
                posterior.observe(tests[test], outcome).unwrap();
            }
            black_box(posterior.posterior().unwrap()[0])
        });
    });
    group.finish();
}

fn solves(criterion: &mut Criterion) {
    let reference = classifier(CLASSES, TESTS).unwrap();
    let next = next_test(CLASSES, TESTS).unwrap();
    let mut group = criterion.benchmark_group("solve");
    group.throughput(Throughput::Elements(1));
    let none = Evidence::none();
    let mut plan = Plan::new(&reference.diagram, &[], &[]).unwrap();
    group.bench_function("report after 8 tests, planned", |bencher| {
        bencher.iter(|| black_box(plan.solve(black_box(&reference.diagram), &none).unwrap().expected_utility));
    });
    group.bench_function("report after 8 tests, from scratch", |bencher| {
        bencher.iter(|| black_box(solve(black_box(&reference.diagram), &none).unwrap().expected_utility));
    });
    let known = Evidence::none().likelihood(next.class, [0.9, 0.1, 0.2, 0.9, 0.3, 0.5]);
    let mut plan = Plan::new(&next.diagram, &[], &[next.class.into()]).unwrap();
    group.bench_function("choice of the next test, planned", |bencher| {
        bencher.iter(|| black_box(plan.solve(black_box(&next.diagram), &known).unwrap().expected_utility));
    });
    group.bench_function("choice of the next test, from scratch", |bencher| {
        bencher.iter(|| black_box(solve(black_box(&next.diagram), &known).unwrap().expected_utility));
    });
    group.finish();
}

criterion_group!(benches, queries, solves);
criterion_main!(benches);
