//! Prepared answers are the answers, and cost no allocation.
#![allow(clippy::unwrap_used)]

use allocation_counter::measure;
use orienteer_influence::{
    CompiledPolicy, CompiledQuery, Diagram, Evidence, Finding, Plan, SolveError, VariableId,
    check::{Shape, enumerate, random_diagram, random_evidence},
    posterior, samples, solve,
};
use rand::SeedableRng;
use rand_pcg::Pcg64;

/// The first or second state of a third of the tests each; nothing of the rest.
fn some_findings(tests: &[VariableId], query: usize) -> impl Iterator<Item = (VariableId, usize)> {
    let outcome = move |(i, test): (usize, &VariableId)| (*test, query / 3usize.pow(i as u32) % 3);
    tests.iter().enumerate().map(outcome).filter(|(_, outcome)| *outcome < 2)
}

#[test]
fn a_compiled_policy_says_what_the_solution_and_the_enumerator_say() {
    let reference = samples::classifier(3, 4).unwrap();
    let tests: Vec<VariableId> = reference.tests.iter().map(|test| (*test).into()).collect();
    let solution = solve(&reference.diagram, &Evidence::none()).unwrap();
    let mut policy = CompiledPolicy::new(&reference.diagram, &solution, reference.report, &tests).unwrap();
    let mut query = CompiledQuery::new(&reference.diagram, &[reference.class.into()], &tests).unwrap();
    for number in 0..81 {
        policy.forget();
        query.forget();
        let mut known = Evidence::none();
        for (test, outcome) in some_findings(&tests, number) {
            policy.observe(test, outcome).unwrap();
            query.observe(test, outcome).unwrap();
            known.insert(test, Finding::State(outcome));
        }
        let slow: Vec<f64> = (0..3)
            .map(|report| {
                enumerate::solve(&reference.diagram, &known.clone().observe(reference.report, report)).unwrap().expected_utility
            })
            .collect();
        let exact = solution.alternatives(&reference.diagram, reference.report, &known).unwrap();
        let advice = policy.advise().unwrap();
        for ((fast, slow), exact) in advice.alternatives.iter().zip(&slow).zip(&exact) {
            assert!((fast - slow).abs() < 1e-9 * 20_000.0 && (fast - exact).abs() < 1e-9 * 20_000.0);
        }
        assert!(slow.iter().all(|value| *value <= slow[advice.best] + 1e-6));
        let class = posterior(&reference.diagram, reference.class, &known).unwrap();
        assert!(query.posterior().unwrap().iter().zip(class).all(|(fast, slow)| (fast - slow).abs() < 1e-12));
    }
}

#[test]
fn one_plan_serves_all_numbers_and_findings() {
    let mut random = Pcg64::seed_from_u64(3);
    let mut served = 0;
    for _ in 0..300 {
        let diagram = random_diagram(&mut random, &Shape::default());
        let evidence = random_evidence(&mut random, &diagram);
        let weighed: Vec<_> = evidence.iter().map(|(variable, _)| variable).filter(|v| diagram.as_chance(*v).is_some()).collect();
        let fixed: Vec<_> = evidence.iter().map(|(variable, _)| variable).filter(|v| diagram.as_decision(*v).is_some()).collect();
        let mut plan = Plan::new(&diagram, &fixed, &weighed).unwrap();
        // What was solved before must leave no trace.
        let decided = fixed.iter().fold(Evidence::none(), |known, decision| known.observe(*decision, 0));
        let _ = plan.solve(&diagram, &decided);
        match (plan.solve(&diagram, &evidence), solve(&diagram, &evidence)) {
            (Ok(planned), Ok(solved)) => {
                assert!((planned.expected_utility - solved.expected_utility).abs() < 1e-9);
                assert!((planned.probability - solved.probability).abs() < 1e-12);
                served += 1;
            }
            (planned, solved) => assert_eq!(planned.map(|_| ()).unwrap_err(), solved.unwrap_err()),
        }
    }
    assert!(served > 200, "{served}");
}

#[test]
fn warm_questions_allocate_nothing() {
    let reference = samples::classifier(6, 8).unwrap();
    let tests: Vec<VariableId> = reference.tests.iter().map(|test| (*test).into()).collect();
    let known = Evidence::none().observe(reference.tests[0], 1).likelihood(reference.tests[1], [0.5, 0.25]);
    let solution = solve(&reference.diagram, &Evidence::none()).unwrap();
    let mut policy = CompiledPolicy::new(&reference.diagram, &solution, reference.report, &tests).unwrap();
    let mut query = CompiledQuery::new(&reference.diagram, &[reference.class.into()], &tests).unwrap();
    let mut plan = Plan::new(&reference.diagram, &tests[..1], &tests[1..]).unwrap();
    let allocations = measure(|| {
        for number in 0..100 {
            policy.forget();
            query.forget();
            for (test, outcome) in some_findings(&tests, number) {
                policy.observe(test, outcome).unwrap();
                query.observe(test, outcome).unwrap();
            }
            query.likelihood(reference.tests[7], &[0.25, 0.75]).unwrap();
            assert!(policy.advise().unwrap().best < 6);
            assert!(query.posterior().unwrap()[0] > 0.0);
            assert!(plan.solve(&reference.diagram, &known).unwrap().expected_utility < 0.0);
        }
    });
    assert_eq!(allocations.count_total, 0);
    assert!(measure(|| drop(Plan::new(&reference.diagram, &[], &[]))).count_total > 0, "the counter counts");
}

#[test]
fn what_was_not_prepared_is_refused() {
    let reference = samples::classifier(2, 3).unwrap();
    let [a, b, c] = reference.tests[..] else { panic!() };
    let diagram = &reference.diagram;
    let mut query = CompiledQuery::new(diagram, &[reference.class.into()], &[a.into()]).unwrap();
    assert!(matches!(query.observe(b, 0), Err(SolveError::Unprepared { told: true, .. })));
    assert!(matches!(query.observe(a, 2), Err(SolveError::UnknownState { states: 2, state: 2, .. })));
    assert!(matches!(query.likelihood(a, &[1.0]), Err(SolveError::LikelihoodSize { found: 1, .. })));
    assert!(matches!(query.likelihood(a, &[1.0, 2.0]), Err(SolveError::Likelihood { .. })));
    query.likelihood(a, &[0.0, 0.0]).unwrap();
    assert_eq!(query.posterior().unwrap_err(), SolveError::Impossible);
    query.forget();
    assert!(query.posterior().is_ok());
    let mut plan = Plan::new(diagram, &[a.into()], &[b.into()]).unwrap();
    let solve = |plan: &mut Plan, known: Evidence| plan.solve(diagram, &known).map(|_| ()).unwrap_err();
    assert!(matches!(solve(&mut plan, Evidence::none()), SolveError::Unprepared { told: false, .. }));
    assert!(matches!(solve(&mut plan, Evidence::none().observe(a, 0).observe(c, 0)), SolveError::Unprepared { told: true, .. }));
    let other = samples::umbrella().unwrap();
    assert!(matches!(plan.solve(&other, &Evidence::none()), Err(SolveError::OtherStructure { .. })));
    assert!(matches!(Plan::new(diagram, &[a.into()], &[a.into()]), Err(SolveError::Repeated { .. })));
    assert!(matches!(Plan::new(&samples::pigs().unwrap(), &[], &[]), Err(SolveError::LimitedMemory { .. })));
    assert!(matches!(CompiledQuery::new(diagram, &[reference.report.into()], &[]), Err(SolveError::Undecided { .. })));
    let empty = Diagram::builder("").build().unwrap();
    assert!(matches!(Plan::new(&empty, &[a.into()], &[]), Err(SolveError::UnknownVariable { .. })));
}
