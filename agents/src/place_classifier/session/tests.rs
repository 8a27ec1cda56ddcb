//! Figures that were worked out beforehand: posteriors, and what naming a place costs under each rule.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use super::*;
use crate::{
    place_classifier::{
        catalogue::Standing,
        rehearsal::{Taken, rehearse},
    },
    places::Reckoning,
};
use orienteer_runtime::geometry::Pose;

/// What each look costs in Huey's corridors, the way from the start pose included.
fn costs(config: &PlaceClassifierConfig) -> Vec<f64> {
    let huey = Reckoning { width: 1.12, face: 0.08 };
    let cost = |feature: &crate::place_classifier::Feature| {
        let search = huey.search(feature.kind, feature.whereabouts, Pose::default()).unwrap();
        config.costs.of(feature.kind) + 100.0 * search.at.x.hypot(search.at.y)
    };
    config.catalogue.feature.iter().map(cost).collect()
}

fn certain(selection: Selection) -> PlaceClassifierConfig {
    PlaceClassifierConfig { selection, outcomes: Outcomes::Certain, looks: 1000, ..PlaceClassifierConfig::default() }
}

fn named(session: &Session, ids: &[(&str, f64)]) {
    let beliefs = session.beliefs();
    for (id, expected) in ids {
        let number = session.catalogue.hypothesis.iter().position(|hypothesis| hypothesis.id == *id).unwrap();
        assert!((beliefs[number] - expected).abs() < 5e-6, "{id}: {} instead of {expected}", beliefs[number]);
    }
}

/// Found, found, found: first the wall on the left, then the near and the far corner on the right.
#[test]
fn three_findings_name_a_t() {
    let config = PlaceClassifierConfig { outcomes: Outcomes::TwoValued, ..PlaceClassifierConfig::default() };
    let mut session = Session::new(&config, Opening::Lost).unwrap();
    let found = |session: &mut Session, id: &str| {
        let feature = config.catalogue.feature_by_id(id).unwrap();
        session.observe(feature, Ending::Found);
        crate::place_classifier::diagram::doubt(&session.beliefs())
    };
    assert!((found(&mut session, "WL") - 1.8249).abs() < 5e-5);
    named(&session, &[("H1", 0.32343), ("H3", 0.32343), ("H4", 0.32343), ("H2", 0.00330), ("H12", 0.00330)]);
    assert!((found(&mut session, "NRC") - 1.2046).abs() < 5e-5);
    named(&session, &[("H1", 0.48744), ("H3", 0.48744)]);
    named(&session, &["H2", "H4", "H10", "H11", "H12"].map(|id| (id, 0.00497)));
    assert!((found(&mut session, "FRC") - 0.2459).abs() < 5e-5);
    let beliefs = session.beliefs();
    for (h, expected) in [(0, 0.96990), (2, 0.0099), (3, 0.0099), (11, 0.0099)] {
        assert!((beliefs[h] - expected).abs() < 5e-5, "{h}: {}", beliefs[h]);
    }
    let Next::Report(verdict) = session.next(&costs(&config)).unwrap() else { panic!("it is enough") };
    assert!(verdict.sure && verdict.hypothesis == Some(0));
}

fn taken(config: &PlaceClassifierConfig, hinted: bool) -> Taken {
    taken_at(config, hinted, &costs(config))
}

/// The same if looks are chosen as if they cost `priced`.
fn taken_at(config: &PlaceClassifierConfig, hinted: bool, priced: &[f64]) -> Taken {
    let taken = rehearse(config, hinted, &costs(config), priced).unwrap();
    assert!((taken.right - 1.0).abs() < 1e-9, "{taken:?}");
    taken
}

/// Policy costs at a uniform prior.
#[test]
fn every_rule_costs_what_was_worked_out() {
    let table = [
        (Selection::Expectimax, 3.67, 4, 3593.0, 4203.0),
        (Selection::EliminatePerCost, 4.00, 6, 3709.0, 5546.0),
        (Selection::GainPerCost, 4.08, 6, 3739.0, 5546.0),
        (Selection::Cheapest, 4.25, 7, 3905.0, 6608.0),
    ];
    let mut wrong = Vec::new();
    for (selection, mean, worst, cost, worst_cost) in table {
        let taken = taken(&certain(selection), false);
        let same = (taken.looks - mean).abs() < 0.005
            && taken.most_looks == worst
            && (taken.cost - cost).abs() < 1.0
            && (taken.most_cost - worst_cost).abs() < 1.0;
        if !same {
            wrong.push(format!("{selection:?}: {taken:?}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Rules that don't ask for the price meet many equals. Who takes the first of them pays for it; who takes the cheapest finds the best plan.
#[test]
fn of_equals_the_cheaper_one_is_worth_taking() {
    for selection in [Selection::InfoGain, Selection::Eliminate] {
        let config = certain(selection);
        let first = taken_at(&config, false, &[1.0; 13]);
        assert!((first.looks - 3.67).abs() < 0.005 && (first.cost - 4714.0).abs() < 1.0, "{first:?}");
        assert!((first.most_cost - 6480.0).abs() < 1.0, "{first:?}");
        let cheaper = taken(&config, false);
        assert!((cheaper.looks - 3.67).abs() < 0.005 && (cheaper.cost - 3593.0).abs() < 1.0, "{cheaper:?}");
    }
}

/// The best plan, as a tree. It never looks for an edge.
#[test]
fn the_best_plan_is_the_tree_that_was_worked_out() {
    let config = certain(Selection::Expectimax);
    let costs = costs(&config);
    let expected = BTreeMap::from([
        ("H1", "NRC WL FRC"),
        ("H2", "NRC WL NLC KL"),
        ("H3", "NRC WL FRC"),
        ("H4", "NRC WR WL"),
        ("H5", "NRC WR NLC FLC"),
        ("H6", "NRC WR WL KR"),
        ("H7", "NRC WR NLC"),
        ("H8", "NRC WR NLC FLC"),
        ("H9", "NRC WR WL KR"),
        ("H10", "NRC WL NLC KL"),
        ("H11", "NRC WL NLC WA"),
        ("H12", "NRC WL NLC WA"),
    ]);
    for (truth, hypothesis) in config.catalogue.hypothesis.iter().enumerate() {
        let mut session = Session::new(&config, Opening::Lost).unwrap();
        let mut looks = Vec::new();
        while let Next::Look(feature) = session.next(&costs).unwrap() {
            looks.push(config.catalogue.feature[feature].id.as_str());
            let there = config.catalogue.standing(feature, truth) == Standing::Present;
            session.observe(feature, if there { Ending::Found } else { Ending::NotFound });
        }
        assert_eq!(looks.join(" "), expected[hypothesis.id.as_str()], "{}", hypothesis.id);
    }
}

/// With the follower's hint four hypotheses are left.
#[test]
fn with_a_hint_half_as_many_looks_will_do() {
    let config = |selection| PlaceClassifierConfig { elsewhere: 0.0, ..certain(selection) };
    let best = taken(&config(Selection::Expectimax), true);
    assert!((best.looks - 2.0).abs() < 1e-9 && (best.cost - 2142.0).abs() < 1.0, "{best:?}");
    let greedy = taken(&config(Selection::GainPerCost), true);
    assert!((greedy.looks - 2.25).abs() < 1e-9 && (2151.0..2193.0).contains(&greedy.cost), "{greedy:?}");
}

#[test]
fn an_abort_says_nothing_unless_it_shall() {
    let two = PlaceClassifierConfig { outcomes: Outcomes::TwoValued, ..PlaceClassifierConfig::default() };
    let mut session = Session::new(&two, Opening::Lost).unwrap();
    let before = session.beliefs();
    session.observe(0, Ending::Blocked);
    assert_eq!((session.beliefs(), session.looks()), (before, 1));
    let three = PlaceClassifierConfig { outcomes: Outcomes::ThreeValued, ..PlaceClassifierConfig::default() };
    let mut session = Session::new(&three, Opening::Lost).unwrap();
    let left_wall = three.catalogue.feature_by_id("WL").unwrap();
    session.observe(left_wall, Ending::Blocked);
    let beliefs = session.beliefs();
    assert!(beliefs[1] > 0.5, "only at an L right the way to that wall is blocked: {beliefs:?}");
}

#[test]
fn what_contradicts_itself_is_no_known_place() {
    let config = certain(Selection::GainPerCost);
    let mut session = Session::new(&config, Opening::Lost).unwrap();
    for (feature, outcome) in [("WL", Ending::Found), ("WR", Ending::Found)] {
        session.observe(config.catalogue.feature_by_id(feature).unwrap(), outcome);
    }
    let expected = Verdict { hypothesis: None, belief: 0.0, sure: false };
    assert_eq!(session.next(&costs(&config)).unwrap(), Next::Report(expected));
}

#[test]
fn it_ends_however_looks_end() {
    for selection in Selection::ALL {
        let config = PlaceClassifierConfig { selection, ..PlaceClassifierConfig::default() };
        for outcome in [Ending::Blocked, Ending::Found, Ending::NotFound, Ending::Interrupted] {
            let mut session = Session::new(&config, Opening::Both).unwrap();
            let costs = costs(&config);
            while let Next::Look(feature) = session.next(&costs).unwrap() {
                session.observe(feature, outcome);
                assert!(session.looks() <= config.looks);
            }
        }
    }
}

#[test]
fn what_seems_so_three_times_in_a_row_is_so() {
    let config = PlaceClassifierConfig::default();
    let left_wall = config.catalogue.feature_by_id("WL").unwrap();
    let mut session = Session::new(&config, Opening::Lost).unwrap();
    let before = session.beliefs();
    for seemed in [Ending::Blocked, Ending::Blocked, Ending::NotFound, Ending::Blocked, Ending::Blocked] {
        session.interrupt(left_wall, seemed);
        assert_eq!((session.beliefs(), session.looks()), (before.clone(), 0));
    }
    session.interrupt(left_wall, Ending::Blocked);
    let mut told = Session::new(&config, Opening::Lost).unwrap();
    told.observe(left_wall, Ending::Blocked);
    assert_eq!((session.beliefs(), session.looks()), (told.beliefs(), 1));
    for _ in 0..9 {
        session.interrupt(left_wall, Ending::Interrupted);
    }
    assert_eq!(session.looks(), 1, "who never gets to look has seen nothing");
}
