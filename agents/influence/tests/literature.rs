//! Diagrams of which the answers have been printed.
#![allow(clippy::unwrap_used)]

use orienteer_influence::{
    ChanceId, DecisionId, Diagram, Evidence, Memory, Optimum, check::enumerate, entropy_of, mutual_information, posterior,
    samples, solve, value_of_observing, value_of_perfect_information,
};

fn chance(diagram: &Diagram, name: &str) -> ChanceId {
    diagram.as_chance(diagram.variable(name).unwrap()).unwrap()
}

fn decision(diagram: &Diagram, name: &str) -> DecisionId {
    diagram.as_decision(diagram.variable(name).unwrap()).unwrap()
}

#[track_caller]
fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9, "{found} is not {expected}");
}

#[test]
fn the_umbrella_stays_at_home_unless_rain_is_forecast() {
    let diagram = samples::umbrella().unwrap();
    let (forecast, umbrella) = (chance(&diagram, "forecast"), decision(&diagram, "umbrella"));
    let solution = solve(&diagram, &Evidence::none()).unwrap();
    near(solution.expected_utility, 77.0);
    assert_eq!(solution.policy(umbrella).unwrap().best(), [1, 1, 0]);
    let rainy = Evidence::none().observe(forecast, 2);
    let alternatives = solution.alternatives(&diagram, umbrella, &rainy).unwrap();
    near(alternatives[0], 14.0 / 0.25);
    near(alternatives[1], 7.0 / 0.25);
    // Known from the beginning it is the same.
    near(solve(&diagram, &rainy).unwrap().expected_utility, 14.0 / 0.25);
}

#[test]
fn the_wildcatter_tests_and_drills_unless_there_is_no_structure() {
    let diagram = samples::oil_wildcatter().unwrap();
    let (test, drill) = (decision(&diagram, "test"), decision(&diagram, "drill"));
    let solution = solve(&diagram, &Evidence::none()).unwrap();
    near(solution.expected_utility, 22.5);
    let alternatives = solution.alternatives(&diagram, test, &Evidence::none()).unwrap();
    near(alternatives[0], 22.5);
    near(alternatives[1], 20.0);
    let drilled = |result| {
        let past = Evidence::none().observe(test, 0).observe(chance(&diagram, "seismic"), result);
        solution.best(&diagram, drill, &past).unwrap() == 0
    };
    assert_eq!([0, 1, 2].map(drilled), [false, true, true]);
    // Who knew what is down there would drill where it is wet: 0.3 * 50 + 0.2 * 200, and not pay for tests.
    near(value_of_perfect_information(&diagram, drill, &Evidence::none()).unwrap(), 55.0 - 22.5);
    near(value_of_observing(&diagram, &[chance(&diagram, "oil")], test, &Evidence::none()).unwrap(), 55.0 - 22.5);
    assert!(value_of_observing(&diagram, &[chance(&diagram, "seismic")], test, &Evidence::none()).is_err());
}

#[test]
fn under_its_policies_the_wildcatters_ground_can_be_asked_about() {
    let diagram = samples::oil_wildcatter().unwrap();
    let followed = solve(&diagram, &Evidence::none()).unwrap().applied_to(&diagram);
    let drill = diagram.variable("drill").unwrap();
    near(posterior(&followed, drill, &Evidence::none()).unwrap()[0], 0.24 + 0.35);
    let oil = chance(&diagram, "oil");
    let drilled = posterior(&followed, oil, &Evidence::none().observe(drill, 0)).unwrap();
    near(drilled[2], (0.10 + 0.08) / 0.59);
}

#[test]
fn pigs_are_treated_on_the_newest_test_for_726_8_and_on_all_of_them_for_a_little_more() {
    let limited = samples::pigs().unwrap();
    let solution = solve(&limited, &Evidence::none()).unwrap();
    assert_eq!(solution.optimum, Optimum::Local);
    assert!((solution.expected_utility - 726.8).abs() < 0.05, "{}", solution.expected_utility);
    let treated = |month: &str| solution.policy(decision(&limited, month)).unwrap().best() == [0, 1];
    assert_eq!(["treat 1", "treat 2", "treat 3"].map(treated), [false, true, true], "not in the first month");
    let perfect = limited.with_memory(Memory::Perfect);
    let solution = solve(&perfect, &Evidence::none()).unwrap();
    assert_eq!(solution.optimum, Optimum::Global);
    near(solution.expected_utility, enumerate::solve(&perfect, &Evidence::none()).unwrap().expected_utility);
    assert!((solution.expected_utility - 729.2).abs() < 0.05);
}

#[test]
fn a_forecast_is_worth_what_it_changes() {
    let diagram = samples::umbrella().unwrap();
    let (weather, forecast) = (chance(&diagram, "weather"), chance(&diagram, "forecast"));
    let umbrella = decision(&diagram, "umbrella");
    // With perfect information: 0.7 * 100 + 0.3 * 70.
    near(value_of_observing(&diagram, &[weather], umbrella, &Evidence::none()).unwrap(), 91.0 - 77.0);
    near(value_of_observing(&diagram, &[forecast], umbrella, &Evidence::none()).unwrap(), 0.0);
    near(value_of_perfect_information(&diagram, umbrella, &Evidence::none()).unwrap(), 91.0 - 77.0);
    // I(weather; forecast) = H(weather) - Σ P(f) H(weather | f), by hand.
    let h = |p: f64| -p * p.log2() - (1.0 - p) * (1.0 - p).log2();
    near(entropy_of(&diagram, weather, &Evidence::none()).unwrap(), h(0.7));
    let left = 0.535 * h(0.49 / 0.535) + 0.215 * h(0.14 / 0.215) + 0.25 * h(0.07 / 0.25);
    near(mutual_information(&diagram, weather, forecast, &Evidence::none()).unwrap(), h(0.7) - left);
}

#[test]
fn the_next_test_is_the_one_whose_report_pays_for_it() {
    let next = samples::next_test(6, 8).unwrap();
    let solution = solve(&next.diagram, &Evidence::none()).unwrap();
    assert_ne!(solution.policy(next.test).unwrap().best(), [8], "knowing nothing, it pays to look");
    let sure = Evidence::none().likelihood(next.class, [1.0, 0.001, 0.001, 0.001, 0.001, 0.001]);
    let solution = solve(&next.diagram, &sure).unwrap();
    assert_eq!(solution.policy(next.test).unwrap().best(), [8], "being sure, it does not");
    let untested = Evidence::none().observe(next.test, 8).observe(next.result, 2);
    assert_eq!(solution.best(&next.diagram, next.report, &untested).unwrap(), 0);
}
