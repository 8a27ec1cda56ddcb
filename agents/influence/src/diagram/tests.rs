#![allow(clippy::unwrap_used)]

use super::*;

fn only_fault(build: DiagramBuilder) -> Fault {
    let error = build.build().unwrap_err();
    assert_eq!(error.faults().len(), 1, "{error}");
    error.faults()[0].1.clone()
}

/// What this fault tells people.
fn told(build: DiagramBuilder) -> String {
    only_fault(build).to_string()
}

fn coin(build: &mut DiagramBuilder, name: &str) -> ChanceId {
    build.chance(name, ["heads", "tails"]).table([0.5, 0.5])
}

#[test]
fn a_sound_diagram_answers_questions_about_itself() {
    let mut build = Diagram::builder("umbrella");
    let weather = build.chance("weather", ["sun", "rain"]).table([0.7, 0.3]);
    let forecast = build.chance("forecast", ["fine", "mixed", "wet"]).given(weather).table([0.7, 0.2, 0.1, 0.15, 0.25, 0.6]);
    let umbrella = build.decision("umbrella", ["take", "leave"]).given(forecast).id();
    let comfort = build.utility("comfort").given(weather).given(umbrella).table([20.0, 100.0, 70.0, 0.0]);
    let diagram = build.build().unwrap();
    assert_eq!(diagram.chances().collect::<Vec<_>>(), [weather, forecast]);
    assert_eq!(diagram.decisions().collect::<Vec<_>>(), [umbrella]);
    assert_eq!(diagram.parents(comfort), [weather.into(), umbrella.into()]);
    assert_eq!(diagram.node("comfort"), Some(comfort.into()));
    assert_eq!(diagram.variable("forecast"), Some(forecast.into()));
    assert_eq!(diagram.variable("comfort"), None);
    assert_eq!(diagram.state(forecast, "wet"), Some(2));
    assert_eq!(diagram.table(comfort), [20.0, 100.0, 70.0, 0.0]);
    assert!(diagram.table(umbrella).is_empty());
}

#[test]
fn a_node_of_another_diagram_has_nothing_here() {
    let mut large = Diagram::builder("large");
    coin(&mut large, "a");
    let b = coin(&mut large, "b");
    let utility = large.utility("u").table([1.0]);
    let mut empty = Diagram::builder("empty").build().unwrap();
    assert_eq!(empty.name_of(b), "");
    assert_eq!(empty.extent(b), 0);
    assert!(empty.parents(utility).is_empty() && empty.table(utility).is_empty());
    assert_eq!(empty.as_chance(b.into()), None);
    assert_eq!(
        empty.set_probabilities(b, vec![0.5, 0.5]),
        Err(Fault::TableSize { node: String::new(), expected: 0, found: 2, shape: "0: one for each state of ".to_owned() })
    );
    assert_eq!(empty.set_probabilities(b, vec![]), Err(Fault::NoSuchNode));
    assert!(empty.set_utilities(utility, vec![3.0]).is_err());
}

#[test]
fn parents_come_first_whatever_the_order_of_making() {
    let mut build = Diagram::builder("backwards");
    let late = build.chance("late", ["x"]).id();
    let early = coin(&mut build, "early");
    build.arc(early, late).table(late, [1.0, 1.0]);
    let diagram = build.build().unwrap();
    assert_eq!(diagram.topological(), [early.into(), late.into()]);
}

#[test]
fn a_circle_is_told_with_its_whole_way() {
    let mut build = Diagram::builder("ring");
    let a = build.decision("a", ["x"]).id();
    let b = build.decision("b", ["x"]).given(a).id();
    let c = build.decision("c", ["x"]).given(b).id();
    build.decision("after", ["x"]).given(c);
    build.arc(c, a);
    assert_eq!(told(build), "the arcs go round in a circle: a -> b -> c -> a; take one of them out");
    let mut build = Diagram::builder("self");
    let a = build.decision("a", ["x"]).id();
    build.arc(a, a);
    assert_eq!(only_fault(build), Fault::Cycle { path: vec!["a".to_owned(), "a".to_owned()] });
}

#[test]
fn tables_must_be_there_and_fit() {
    let mut build = Diagram::builder("missing");
    let a = coin(&mut build, "a");
    build.chance("b", ["x", "y", "z"]).given(a);
    assert_eq!(told(build), r#""b" has no table; it needs 6 = 2 (a) x 3 (b)"#);
    let mut build = Diagram::builder("short");
    let a = coin(&mut build, "a");
    build.utility("u").given(a).table([1.0]);
    assert_eq!(told(build), r#"the table of "u" has 1 numbers, but needs 2: one for each state of a"#);
}

#[test]
fn probabilities_are_probabilities() {
    let mut build = Diagram::builder("rows");
    let a = coin(&mut build, "a");
    let b = coin(&mut build, "b");
    build.chance("c", ["x", "y"]).given(a).given(b).table([0.5, 0.5, 0.5, 0.5, 0.5, 0.25, 1.0, 0.0]);
    assert_eq!(told(build), r#""c", row 3 (a = tails, b = heads): the probabilities sum to 0.75, not to 1"#);
    for odd in [-0.5, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut build = Diagram::builder("odd");
        build.chance("a", ["x", "y"]).table([odd, 1.0 - odd]);
        assert!(matches!(only_fault(build), Fault::Probability { state, .. } if state == "x"));
    }
}

#[test]
fn utilities_are_finite() {
    for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut build = Diagram::builder("odd");
        let a = coin(&mut build, "a");
        build.utility("u").given(a).table([1.0, odd]);
        assert!(matches!(only_fault(build), Fault::Utility { row, .. } if row == "row 2 (a = tails)"));
    }
}

#[test]
fn names_are_names_and_differ() {
    let mut build = Diagram::builder("twice");
    coin(&mut build, "a");
    build.utility("a").table([1.0]);
    assert_eq!(only_fault(build), Fault::DuplicateName { name: "a".to_owned() });
    let mut build = Diagram::builder("twice");
    build.decision("a", ["x", "y", "x"]);
    assert_eq!(only_fault(build), Fault::DuplicateState { node: "a".to_owned(), state: "x".to_owned() });
    for odd in ["", " a", "a\n", "a\u{0}b", "\u{fffe}"] {
        let mut build = Diagram::builder("odd");
        build.decision(odd, ["x"]);
        assert_eq!(only_fault(build), Fault::BadName { name: odd.to_owned() });
    }
    let mut build = Diagram::builder("none");
    build.chance("a", [""; 0]).table([]);
    assert_eq!(only_fault(build), Fault::NoStates { node: "a".to_owned() });
}

#[test]
fn arcs_begin_at_variables_of_the_diagram_and_once() {
    let mut build = Diagram::builder("utility with a child");
    let u = build.utility("u").table([1.0]);
    let d = build.decision("d", ["x"]).id();
    build.arc(u, d);
    assert_eq!(only_fault(build), Fault::UtilityWithChildren { utility: "u".to_owned(), child: "d".to_owned() });
    let mut other = Diagram::builder("other");
    coin(&mut other, "a");
    let stranger = coin(&mut other, "b");
    let mut build = Diagram::builder("stranger");
    build.decision("d", ["x"]).given(stranger);
    assert!(matches!(only_fault(build), Fault::UnknownParent { .. }));
    let mut build = Diagram::builder("twice");
    let a = coin(&mut build, "a");
    build.decision("d", ["x"]).given(a).given(a);
    assert_eq!(only_fault(build), Fault::DuplicateParent { node: "d".to_owned(), parent: "a".to_owned() });
}

#[test]
fn a_table_beyond_counting_is_refused() {
    let mut build = Diagram::builder("vast");
    let parents: Vec<_> = (0..70).map(|i| coin(&mut build, &format!("p{i}"))).collect();
    build.utility("u").given_all(parents).table([0.0]);
    assert!(matches!(only_fault(build), Fault::TableTooLarge { parents: 70, .. }));
}

#[test]
fn all_faults_are_told_at_once() {
    let mut build = Diagram::builder("bad");
    build.chance("a", ["x", "y"]).table([0.5, 0.6]);
    build.chance("b", ["x", "y"]);
    build.utility("u");
    let error = build.build().unwrap_err();
    assert_eq!(error.faults().len(), 3);
    assert_eq!(error.to_string().lines().count(), 3);
}

#[test]
fn new_numbers_are_checked_as_the_first_ones_were() {
    let mut build = Diagram::builder("coin");
    let a = coin(&mut build, "a");
    let mut diagram = build.build().unwrap();
    let before = diagram.clone();
    assert!(diagram.set_probabilities(a, vec![0.5, 0.6]).is_err());
    assert!(diagram.set_probabilities(a, vec![1.0]).is_err());
    assert_eq!(diagram, before);
    diagram.set_probabilities(a, vec![0.25, 0.75]).unwrap();
    assert_eq!(diagram.table(a), [0.25, 0.75]);
    assert!(diagram.same_structure(&before) && diagram != before);
}
