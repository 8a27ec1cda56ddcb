//! Questions that have no answer are refused in words, and large ones before anything is allocated.
#![allow(clippy::unwrap_used)]

use orienteer_influence::{
    ChanceId, Diagram, DiagramBuilder, Evidence, MAX_CELLS, Memory, SolveError, entropy_of, joint, mutual_information, posterior,
    probability, samples, solve, value_of_observing,
};

fn coin(build: &mut DiagramBuilder, name: &str) -> ChanceId {
    build.chance(name, ["heads", "tails"]).table([0.5, 0.5])
}

#[test]
fn decisions_need_an_order_or_limited_memory() {
    let mut build = Diagram::builder("two");
    let a = build.decision("a", ["x", "y"]).id();
    let b = build.decision("b", ["x", "y"]).id();
    build.utility("u").given(a).given(b).table([0.0, 1.0, 2.0, 3.0]);
    let diagram = build.build().unwrap();
    let error = solve(&diagram, &Evidence::none()).unwrap_err();
    assert_eq!(error, SolveError::UnorderedDecisions { first: "a".to_owned(), second: "b".to_owned() });
    let limited = diagram.with_memory(Memory::Limited);
    assert_eq!(solve(&limited, &Evidence::none()).unwrap().expected_utility, 3.0);
}

#[test]
fn what_is_impossible_has_no_posterior() {
    let mut build = Diagram::builder("sure");
    let a = build.chance("a", ["x", "y"]).table([1.0, 0.0]);
    let b = coin(&mut build, "b");
    let d = build.decision("d", ["x", "y"]).id();
    build.utility("u").given(a).given(d).table([1.0, 2.0, 3.0, 4.0]);
    let diagram = build.build().unwrap();
    for impossible in [Evidence::none().observe(a, 1), Evidence::none().likelihood(b, [0.0, 0.0])] {
        assert_eq!(posterior(&diagram, b, &impossible), Err(SolveError::Impossible));
        assert_eq!(probability(&diagram, &impossible), Err(SolveError::Impossible));
        assert_eq!(solve(&diagram, &impossible), Err(SolveError::Impossible));
        assert_eq!(solve(&diagram.clone().with_memory(Memory::Limited), &impossible), Err(SolveError::Impossible));
        assert_eq!(entropy_of(&diagram, b, &impossible), Err(SolveError::Impossible));
        let solution = solve(&diagram, &Evidence::none()).unwrap();
        assert_eq!(solution.alternatives(&diagram, d, &impossible), Err(SolveError::Impossible));
    }
}

#[test]
fn nothing_is_known_that_an_open_decision_can_change() {
    let diagram = samples::oil_wildcatter().unwrap();
    let [oil, test, seismic, drill] = ["oil", "test", "seismic", "drill"].map(|name| diagram.variable(name).unwrap());
    let early = Evidence::none().observe(seismic, 2);
    let after = SolveError::EvidenceAfterDecision { variable: "seismic".to_owned(), decision: "test".to_owned() };
    assert_eq!(solve(&diagram, &early).unwrap_err(), after);
    assert_eq!(solve(&diagram.clone().with_memory(Memory::Limited), &early).unwrap_err(), after);
    // Once it has been tested, the result may be known.
    let tested = early.observe(test, 0);
    let solution = solve(&diagram, &tested).unwrap();
    assert!((solution.probability - 0.24).abs() < 1e-12);
    assert!((solution.expected_utility - (21.0 / 0.24 - 10.0)).abs() < 1e-9);
    let undecided = SolveError::Undecided { decision: "test".to_owned() };
    assert_eq!(posterior(&diagram, seismic, &Evidence::none()), Err(undecided));
    assert!(posterior(&diagram, oil, &Evidence::none()).is_ok(), "no decision bears on it");
    assert!(posterior(&diagram, drill, &Evidence::none()).is_err());
    assert_eq!(posterior(&diagram, drill, &Evidence::none().observe(drill, 1)).unwrap(), [0.0, 1.0]);
}

#[test]
fn evidence_and_questions_have_to_fit() {
    let diagram = samples::umbrella().unwrap();
    let weather = diagram.as_chance(diagram.variable("weather").unwrap()).unwrap();
    let umbrella = diagram.as_decision(diagram.variable("umbrella").unwrap()).unwrap();
    let ask = |evidence: Evidence| posterior(&diagram, weather, &evidence).unwrap_err();
    assert!(matches!(ask(Evidence::none().observe(weather, 2)), SolveError::UnknownState { states: 2, state: 2, .. }));
    assert!(matches!(ask(Evidence::none().likelihood(weather, [1.0])), SolveError::LikelihoodSize { states: 2, found: 1, .. }));
    for odd in [-0.1, 1.5, f64::NAN, f64::INFINITY] {
        assert!(matches!(ask(Evidence::none().likelihood(weather, [odd, 0.5])), SolveError::Likelihood { .. }));
    }
    assert!(matches!(joint(&diagram, &[weather.into(), weather.into()], &Evidence::none()), Err(SolveError::Repeated { .. })));
    assert!(matches!(mutual_information(&diagram, weather, weather, &Evidence::none()), Err(SolveError::Repeated { .. })));
    let pigs = samples::pigs().unwrap();
    let stranger = pigs.variable("health 4").unwrap();
    assert!(matches!(ask(Evidence::none().observe(stranger, 0)), SolveError::UnknownVariable { .. }));
    assert!(matches!(posterior(&diagram, stranger, &Evidence::none()), Err(SolveError::UnknownVariable { .. })));
    let first = pigs.decisions().next().unwrap();
    assert_eq!(value_of_observing(&pigs, &[], first, &Evidence::none()), Err(SolveError::OnlyLocal));
    let solution = solve(&diagram, &Evidence::none()).unwrap();
    let missing = SolveError::MissingPast { variable: "forecast".to_owned() };
    assert_eq!(solution.best(&diagram, umbrella, &Evidence::none()), Err(missing));
    // A solution of one diagram does no harm to another.
    assert_eq!(solution.applied_to(&pigs).variables().len(), pigs.variables().len());
}

#[test]
fn what_is_too_large_is_told_without_trying() {
    let mut build = Diagram::builder("remembers everything");
    let class = coin(&mut build, "class");
    let test =
        |build: &mut DiagramBuilder, i| build.chance(format!("test {i}"), ["x", "y"]).given(class).table([0.9, 0.1, 0.2, 0.8]);
    let tests: Vec<_> = (0..200).map(|i| test(&mut build, i)).collect();
    let report = build.decision("report", ["heads", "tails"]).given_all(tests.iter().copied()).id();
    build.utility("u").given(class).given(report).table([1.0, 0.0, 0.0, 1.0]);
    let diagram = build.build().unwrap();
    for memory in [Memory::Perfect, Memory::Limited] {
        let error = solve(&diagram.clone().with_memory(memory), &Evidence::none()).unwrap_err();
        assert!(matches!(error, SolveError::TooLarge { cells, limit: MAX_CELLS } if cells > MAX_CELLS), "{error}");
    }
    // What is known need not be remembered, so with evidence it is small.
    let known = tests.iter().fold(Evidence::none(), |known, test| known.observe(*test, 0));
    assert!(posterior(&diagram, class, &known).unwrap()[0] > 0.999_999);
    let solution = solve(&diagram, &known).unwrap();
    assert!((solution.expected_utility - 1.0).abs() < 1e-9);
    assert!(joint(&diagram, &tests.iter().map(|test| (*test).into()).collect::<Vec<_>>(), &Evidence::none()).is_err());
}

#[test]
fn long_chains_are_cheap() {
    let mut build = Diagram::builder("chain");
    let mut last = coin(&mut build, "0");
    for i in 1..1000 {
        last = build.chance(i.to_string(), ["heads", "tails"]).given(last).table([0.9, 0.1, 0.1, 0.9]);
    }
    let diagram = build.build().unwrap();
    let first = diagram.as_chance(diagram.variable("0").unwrap()).unwrap();
    assert!((posterior(&diagram, last, &Evidence::none()).unwrap()[0] - 0.5).abs() < 1e-12);
    let known = Evidence::none().observe(first, 0);
    let fourth = diagram.variable("3").unwrap();
    // The correlation falls by 0.8 with each step.
    assert!((posterior(&diagram, fourth, &known).unwrap()[0] - 0.5 * (1.0 + 0.8f64.powi(3))).abs() < 1e-12);
}
