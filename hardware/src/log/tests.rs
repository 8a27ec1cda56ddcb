#![allow(clippy::unwrap_used)]
use std::{path::Path, sync::Arc, time::Duration};

use orienteer_runtime::{
    geometry::{Twist, angle},
    time::Time,
    topics::Echo,
};
use proptest::prelude::*;

use super::*;
use crate::driver::{BaseDriver, DriverError, SonarDriver};

const POSES_TEXT: &str = "1000 0 0 0\n1200 100 0 3590\n\n1600 300 -10 10\n";
const READINGS_TEXT: &str = "1000 5110 10 20 30 40 50 60 70\n1200 1000 2000 3000 4000 5000 400 0 5100\n1600 1 1 1 1 1 1 1 1\n";

fn parse(poses: &str, readings: &str) -> Result<SonarLog, LogError> {
    SonarLog::parse(("p.txt", poses), ("m.txt", readings))
}

/// The recorded log beside the workspace; `None`, with a message, where it is not there.
fn real_log() -> Option<SonarLog> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/robond-8sonar");
    if !folder.is_dir() {
        println!("skipped: no log in {}", folder.display());
        return None;
    }
    Some(SonarLog::load(&folder).unwrap())
}

#[test]
fn units_are_converted_and_times_begin_at_zero() {
    let log = parse(POSES_TEXT, READINGS_TEXT).unwrap();
    let [first, second, third] = log.entries() else { panic!("three entries") };
    assert_eq!((first.time, second.time), (Time::START, Time::START + Duration::from_millis(200)));
    assert_eq!(log.end(), third.time);
    assert!((second.pose.x - 0.1).abs() < 1e-12 && (second.pose.heading + 1f64.to_radians()).abs() < 1e-12);
    assert_eq!(first.echoes[0], Echo::Nothing);
    assert_eq!((second.echoes[0], second.echoes[6], second.echoes[7]), (Echo::Range(1.0), Echo::TooNear, Echo::Range(5.1)));
}

#[test]
fn every_error_names_file_and_line() {
    let swap = |text: &str, from: &str, to: &str| text.replacen(from, to, 1);
    let cases = [
        (swap(POSES_TEXT, "100 0 3590", "100 0"), READINGS_TEXT.into(), "p.txt:2: expected 4 numbers, found 3"),
        (swap(POSES_TEXT, "300", "3OO"), READINGS_TEXT.into(), "p.txt:4: \"3OO\" is not a number that makes sense here"),
        (swap(POSES_TEXT, "300", "NaN"), READINGS_TEXT.into(), "p.txt:4: \"NaN\" is not a number that makes sense here"),
        (swap(POSES_TEXT, "1200", "-5"), READINGS_TEXT.into(), "p.txt:2: \"-5\" is not a time in milliseconds"),
        (swap(POSES_TEXT, "1600", "1200"), READINGS_TEXT.into(), "p.txt:4: time 1200 is not later than the time before"),
        (POSES_TEXT.into(), swap(READINGS_TEXT, "5110", "5120"), "m.txt:1: 5120 mm is not a range from 0 to 5110"),
        (POSES_TEXT.into(), swap(READINGS_TEXT, "5110", "-10"), "m.txt:1: -10 mm is not a range from 0 to 5110"),
        (POSES_TEXT.into(), swap(READINGS_TEXT, "1200", "1300"), "m.txt:2: time 1300 does not match 1200 at p.txt:2"),
        ("1000 0 0 0".into(), READINGS_TEXT.into(), "m.txt:2: has no counterpart in p.txt"),
        (format!("{POSES_TEXT}2000 0 0 0\n"), READINGS_TEXT.into(), "p.txt:5: has no counterpart in m.txt"),
        ("\n \n".into(), READINGS_TEXT.into(), "p.txt: no entries"),
    ];
    for (poses, readings, message) in cases {
        assert_eq!(parse(&poses, &readings).unwrap_err().to_string(), message);
    }
    let missing = SonarLog::load(Path::new("/nowhere")).unwrap_err();
    assert!(missing.to_string().starts_with("/nowhere/poses.txt: "), "{missing}");
}

proptest! {
    #[test]
    fn no_text_makes_it_panic(poses in "[0-9 \n.eE+-]{0,80}", readings in "[0-9 \n.eE+-]{0,80}") {
        let _ = parse(&poses, &readings);
        let _ = parse(POSES_TEXT, &readings);
    }
}

#[test]
fn between_entries_the_base_moves_on_and_at_the_end_it_says_so() {
    let (mut base, mut sonar) = players(Arc::new(parse(POSES_TEXT, READINGS_TEXT).unwrap()));
    let at = |millis: u64| Time::START + Duration::from_millis(millis);
    let mut scans = Vec::new();
    let mut seen = Vec::new();
    for millis in (0..=600).step_by(50) {
        base.command(at(millis), Twist::new(9.0, 9.0)).unwrap();
        let odometry = base.poll(at(millis)).unwrap();
        sonar.poll(at(millis), &mut scans).unwrap();
        seen.push((millis, odometry));
    }
    assert_eq!(scans.iter().map(|scan| (scan.seq, scan.stamp)).collect::<Vec<_>>(), [(1, at(0)), (2, at(200)), (3, at(600))]);
    assert!((seen[2].1.pose.x - 0.05).abs() < 1e-4 && (seen[2].1.twist.linear - 0.5).abs() < 1e-3);
    assert!((seen[12].1.pose.x - 0.3).abs() < 1e-12 && (seen[12].1.travelled - 0.3).abs() < 1e-3);
    assert!((seen[12].1.turned - 1f64.to_radians()).abs() < 1e-12);
    assert!(matches!(base.poll(at(601)), Err(DriverError::EndOfLog { .. })));
    assert!(matches!(sonar.poll(at(601), &mut scans), Err(DriverError::EndOfLog { .. })));
    assert_eq!(scans.len(), 3);
}

#[test]
fn a_coarse_poll_gives_every_scan() {
    let (_, mut sonar) = players(Arc::new(parse(POSES_TEXT, READINGS_TEXT).unwrap()));
    let mut scans = Vec::new();
    assert!(sonar.poll(Time::from_secs_f64(5.0), &mut scans).is_err());
    assert_eq!(scans.len(), 3);
}

#[test]
fn the_real_log_is_read_whole() {
    let Some(log) = real_log() else { return };
    assert_eq!(log.entries().len(), 413);
    assert!((log.end().as_secs_f64() - 92.837).abs() < 1e-9);
    let nothing = log.entries().iter().flat_map(|entry| entry.echoes).filter(|echo| *echo == Echo::Nothing).count();
    assert_eq!(nothing, 59 + 124 + 105 + 177 + 332 + 125 + 125 + 21);
    let (mut base, mut sonar) = players(Arc::new(log));
    let (mut last, mut scans) = (base.poll(Time::START).unwrap(), Vec::new());
    for i in 0..=928 * 2 {
        let now = Time::START + Duration::from_millis(50 * i);
        last = base.poll(now).unwrap();
        sonar.poll(now, &mut scans).unwrap();
    }
    assert!((24.9..25.1).contains(&last.travelled), "{}", last.travelled);
    assert_eq!(scans.len(), 412);
}

/// What the module's documentation says of the heading: it is counted counter-clockwise, and the robot never reverses.
#[test]
fn motion_agrees_with_headings_that_count_counter_clockwise() {
    let Some(log) = real_log() else { return };
    let (mut agree, mut mirrored, mut steps, mut worst) = (0, 0, 0, 0.0f64);
    for pair in log.entries().windows(2) {
        let (a, b) = (pair[0].pose, pair[1].pose);
        if a.distance(&b) < 0.03 {
            continue;
        }
        let direction = (b.y - a.y).atan2(b.x - a.x);
        let heading = a.interpolate(b, 0.5).heading;
        let off = angle::turn(heading, direction).abs();
        steps += 1;
        worst = worst.max(off);
        agree += usize::from(off < 1.2f64.to_radians());
        mirrored += usize::from(angle::turn(-heading, direction).abs() < 10f64.to_radians());
    }
    assert_eq!((steps, agree), (362, 362), "worst {}°", worst.to_degrees());
    assert!(mirrored < 200, "{mirrored}");
}
