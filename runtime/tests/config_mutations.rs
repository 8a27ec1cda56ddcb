//! Thousands of single mistakes: each is refused with a place and a hint, or is valid and every key of it means something.
#![allow(clippy::unwrap_used)]

mod config_support;

use std::collections::BTreeMap;

use config_support::{Fake, MISSION, load_with};
use orienteer_runtime::config::{
    Problems,
    mutate::{Slip, Verdict, check_mutation, mutations},
};

/// Everything that was understood of a mission.
fn understood(text: &str, catalog: &Fake) -> Result<String, Problems> {
    load_with(text, catalog).map(|mission| serde_json::to_string(&mission).unwrap())
}

#[test]
fn every_mistake_is_refused_or_means_something() {
    let catalog = Fake::default();
    let load = |text: &str| understood(text, &catalog);
    let mut counts: BTreeMap<(Slip, bool), usize> = BTreeMap::new();
    for mutation in mutations(MISSION, 7).take(3000) {
        let verdict = check_mutation(MISSION, &mutation.text, &load);
        assert!(verdict.good(), "{:?} gives {verdict:?}\n{}", mutation.slip, mutation.text);
        if let Verdict::Refused(problems) = &verdict {
            assert!(problems.list().iter().all(|problem| !problem.render(false).is_empty()));
        }
        *counts.entry((mutation.slip, verdict == Verdict::Valid)).or_default() += 1;
    }
    let valid: usize = counts.iter().filter(|((_, valid), _)| *valid).map(|(_, count)| count).sum();
    println!("{valid} of 3000 are valid: {counts:?}");
    // Both outcomes are well represented, or this test would show little.
    assert!(valid > 300 && valid < 2700, "{counts:?}");
}

#[test]
fn every_key_of_the_good_mission_means_something() {
    let catalog = Fake::default();
    let load = |text: &str| understood(text, &catalog);
    // As if all of it had been written anew.
    assert_eq!(check_mutation("", MISSION, &load), Verdict::Valid);
}
