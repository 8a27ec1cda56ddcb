//! A quick run of each suite that is not about driving.
#![allow(clippy::unwrap_used, missing_docs)]

use orienteer::reproduce::{Effort, Row, suite};

fn run(name: &str, seeds: Option<u64>, quick: bool) -> Vec<Row> {
    let effort = Effort { seeds, quick, threads: 2, progress: Box::new(|_, _, _| {}) };
    let rows = (suite(name).unwrap().run)(&effort).unwrap();
    assert!(!rows.is_empty(), "`{name}` measures nothing");
    rows
}

fn all_hold(rows: &[Row]) {
    let short: Vec<_> = rows.iter().filter(|row| !row.holds).collect();
    assert!(short.is_empty(), "{short:#?}");
}

#[test]
fn arbitration() {
    all_hold(&run("arbitration", Some(2_000), false));
}

#[test]
fn determinism() {
    all_hold(&run("determinism", None, true));
}

#[test]
fn config() {
    all_hold(&run("config", Some(400), false));
}

#[test]
fn echo() {
    all_hold(&run("echo", Some(200), false));
}

/// A busy machine may take long, but everything comes to its end: times are held to a bound that no stalled machine needs.
#[test]
fn faults() {
    let rows = run("faults", Some(1), true);
    let (timed, untimed): (Vec<Row>, Vec<Row>) =
        rows.into_iter().partition(|row| row.unit == "ms" || row.row.contains("last second"));
    all_hold(&untimed);
    let late: Vec<_> = timed.iter().filter(|row| row.unit == "ms" && (row.measured.is_nan() || row.measured >= 1500.0)).collect();
    assert!(late.is_empty(), "{late:#?}");
}
