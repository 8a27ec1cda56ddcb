//! The arbiter of the base against its oracle. `orienteer reproduce arbitration` runs the same with more histories.
#![allow(clippy::unwrap_used)]

use orienteer_runtime::arbitration::oracle::{Stats, check_histories, check_range};

#[test]
fn agrees_with_the_protocol_on_random_histories() {
    let stats = check_histories(1989, 5000).unwrap_or_else(|wrong| panic!("{wrong}"));
    // Nothing is proven by histories in which nothing happens.
    let Stats { histories, decisions, claims, limited, granted, overridden, overrider_moves, busy, lapsed, regained } = stats;
    assert_eq!(histories, 5000);
    for often in [decisions, claims, limited, granted, overridden, overrider_moves, busy, lapsed, regained] {
        assert!(often > 500, "{stats:?}");
    }
}

#[test]
fn histories_can_be_shared_out() {
    let mut sum = check_range(7, 0..40).unwrap();
    sum += check_range(7, 40..100).unwrap();
    assert_eq!(sum, check_histories(7, 100).unwrap());
}

#[test]
#[ignore = "10^6 histories take minutes unless optimised; `orienteer reproduce arbitration` runs them"]
fn agrees_on_a_million_histories() {
    let stats = check_histories(1, 1_000_000).unwrap_or_else(|wrong| panic!("{wrong}"));
    println!("{stats:?}");
}
