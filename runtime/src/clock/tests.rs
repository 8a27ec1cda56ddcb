//! Periods are an hour long and the past is made up, so that no test waits and none minds a slow machine.

use super::*;

const PERIOD: Duration = Duration::from_secs(3600);
/// What a test may take on a machine that is busy.
const SLOW: Duration = Duration::from_secs(600);

/// As if so much more time had passed since the mission started.
fn pass(clock: &mut Clock, time: Duration) {
    clock.started -= time;
    clock.origin -= time;
}

/// True if a wait is what is left of `expected` after the little time that the test takes.
fn is_about(wait: Duration, expected: Duration) -> bool {
    (expected.saturating_sub(SLOW)..=expected).contains(&wait)
}

/// The machine's speed must not show in what a recording holds.
#[test]
fn lockstep_counts_periods_however_late_it_is() {
    for pace in [Pace::AsFastAsPossible, Pace::Factor(0.5), Pace::Factor(1e6)] {
        let mut clock = Clock::new(pace, PERIOD);
        for step in 0..5 {
            assert_eq!((clock.now(), clock.tick()), (Time::START + PERIOD * step, u64::from(step)), "{pace:?}");
            pass(&mut clock, 7 * PERIOD);
            clock.advance();
        }
        assert_eq!(clock.missed(), 0, "{pace:?}");
    }
}

#[test]
fn as_fast_as_possible_waits_for_nothing() {
    let mut clock = Clock::new(Pace::AsFastAsPossible, PERIOD);
    assert!((0..5).all(|_| clock.advance().is_zero()));
}

#[test]
fn a_factor_divides_the_wait_by_itself() {
    for factor in [0.5, 1.0, 2.0] {
        let mut clock = Clock::new(Pace::Factor(factor), PERIOD);
        for step in 1..=3 {
            let wait = clock.advance();
            assert!(is_about(wait, (PERIOD * step).div_f64(factor)), "{factor}: {wait:?}");
        }
        // A step that took three periods of real time leaves so much less to wait for, and no less than nothing.
        pass(&mut clock, 3 * PERIOD);
        let wait = clock.advance();
        assert!(is_about(wait, (PERIOD * 4).div_f64(factor).saturating_sub(3 * PERIOD)), "{factor}: {wait:?}");
    }
}

/// Otherwise a mission that was held would rush through all that it has missed.
#[test]
fn a_pause_at_a_factor_is_not_made_up_for() {
    let mut clock = Clock::new(Pace::Factor(1.0), PERIOD);
    clock.advance();
    pass(&mut clock, 10 * PERIOD);
    clock.resume();
    let wait = clock.advance();
    assert!(is_about(wait, PERIOD), "{wait:?}");
    assert_eq!((clock.tick(), clock.missed()), (2, 0));
}

#[test]
fn at_wall_time_it_is_as_late_as_the_machine_says() {
    let mut clock = Clock::new(Pace::Wall, PERIOD);
    pass(&mut clock, PERIOD / 2);
    let before = Time::START + clock.elapsed();
    let now = clock.now();
    assert!(before <= now && now <= Time::START + clock.elapsed());
    clock.advance();
    // The world does not wait while a mission is held.
    clock.resume();
    assert!(clock.now() >= now);
    assert!(clock.elapsed() < PERIOD);
}

/// Three periods and a half after the start, the first two steps after it are gone, and the third is due at once.
#[test]
fn at_wall_time_steps_that_come_late_are_skipped_and_counted() {
    let mut clock = Clock::new(Pace::Wall, PERIOD);
    pass(&mut clock, 7 * PERIOD / 2);
    assert_eq!((clock.advance(), clock.tick(), clock.missed()), (Duration::ZERO, 3, 2));
    let wait = clock.advance();
    assert!(is_about(wait, PERIOD / 2), "{wait:?}");
    assert_eq!((clock.tick(), clock.missed()), (4, 2), "in time again");
}

#[test]
fn steps_are_measured_at_wall_time_only() {
    for (pace, measures) in [(Pace::Wall, true), (Pace::AsFastAsPossible, false), (Pace::Factor(1.0), false)] {
        assert_eq!(Clock::stopwatch(pace).start().elapsed().is_some(), measures, "{pace:?}");
    }
}

/// Its own steps would be due at the full periods; the other's come a third later, and then its own are counted from there.
#[test]
fn at_wall_time_it_follows_somebody_elses_beat() {
    let mut clock = Clock::new(Pace::Wall, PERIOD);
    clock.advance();
    pass(&mut clock, 4 * PERIOD / 3);
    assert!(clock.remaining().is_zero() && is_about(clock.grace(), PERIOD / 6));
    assert!(clock.follow());
    let wait = clock.advance();
    assert!(is_about(wait, PERIOD), "{wait:?}");
    // Twice as fast as it should be.
    pass(&mut clock, PERIOD / 3);
    assert!(!clock.follow());
    // Not there in time, nor half a period later.
    pass(&mut clock, 7 * PERIOD / 6);
    assert!(clock.grace().is_zero());
    assert_eq!((clock.tick(), clock.missed()), (2, 0));
}

#[test]
fn in_lockstep_nobody_else_sets_the_beat() {
    assert!(![Pace::AsFastAsPossible, Pace::Factor(1.0)].into_iter().any(|pace| Clock::new(pace, PERIOD).follow()));
}
