//! The rules one by one.
use super::*;

fn setup() -> (Protection, Odometry, SonarScan, Demand) {
    let (config, ring) = huey();
    let scan = SonarScan::from_echoes(Time::START, 1, &[Echo::Range(3.0); 16]);
    let odometry = Odometry { flags: flags::ENABLED, ..Odometry::default() };
    let demand = Demand { twist: Twist::new(0.3, 0.1), valid_until: Time::from_secs_f64(0.1), limits: Limits::NONE };
    (Protection::new(config.platform(), &ring, ProtectionConfig::default()), odometry, scan, demand)
}

fn reason(change: impl FnOnce(&mut Odometry, &mut SonarScan, &mut Demand, &mut LinkState, &mut Time)) -> (Twist, Option<Reason>) {
    let (mut protection, mut odometry, mut scan, mut demand) = setup();
    let (mut link, mut now) = (LinkState::Up, Time::START);
    change(&mut odometry, &mut scan, &mut demand, &mut link, &mut now);
    let permitted = protection.filter(now, &demand, &odometry, Some(&scan), link);
    (permitted.twist, permitted.reason)
}

#[test]
fn nothing_wrong_means_nothing_changed() {
    assert_eq!(reason(|_, _, _, _, _| ()), (Twist::new(0.3, 0.1), None));
}

#[test]
fn each_fault_stops_and_says_why() {
    let stop = |why| (Twist::STOP, Some(why));
    assert_eq!(reason(|_, _, demand, _, _| demand.twist.angular = f64::NAN), stop(Reason::BadDemand));
    assert_eq!(reason(|_, _, demand, _, _| demand.twist.linear = f64::INFINITY), stop(Reason::BadDemand));
    assert_eq!(reason(|_, _, _, link, _| *link = LinkState::Lost), stop(Reason::LinkLost));
    assert_eq!(reason(|odometry, _, _, _, _| odometry.pose.x = f64::NAN), stop(Reason::BadOdometry));
    assert_eq!(reason(|odometry, _, _, _, _| odometry.twist.linear = f64::NAN), stop(Reason::BadOdometry));
    let late = |odometry: &mut Odometry, _: &mut SonarScan, demand: &mut Demand, _: &mut LinkState, now: &mut Time| {
        *now = Time::from_secs_f64(1.0);
        demand.valid_until = Time::FAR;
        odometry.stamp = Time::START;
    };
    assert_eq!(reason(late), stop(Reason::BadOdometry));
    let pressed = flags::ENABLED | flags::EMERGENCY_STOP;
    assert_eq!(reason(|odometry, _, _, _, _| odometry.flags = pressed), stop(Reason::EmergencyStop));
    assert_eq!(reason(|odometry, _, _, _, _| odometry.flags = flags::EMERGENCY_STOP), stop(Reason::MotorsOff));
    assert_eq!(reason(|_, _, _, _, now| *now = Time::from_secs_f64(0.11)), stop(Reason::StaleCommand));
    assert_eq!(reason(|_, scan, _, _, _| *scan = SonarScan::unfired(16)).1, Some(Reason::StaleSonar));
    assert_eq!(reason(|_, scan, _, _, _| *scan = SonarScan::default()).0.linear, 0.0);
}

#[test]
fn the_first_rule_gives_the_reason() {
    let all = |odometry: &mut Odometry, _: &mut SonarScan, demand: &mut Demand, link: &mut LinkState, now: &mut Time| {
        demand.twist.linear = f64::NAN;
        *link = LinkState::Lost;
        odometry.flags = flags::EMERGENCY_STOP | flags::CONTACT;
        *now = Time::from_secs_f64(9.0);
    };
    assert_eq!(reason(all).1, Some(Reason::BadDemand));
}

#[test]
fn limits_keep_the_curve() {
    let (twist, why) = reason(|_, _, demand, _, _| demand.twist = Twist::new(2.0, 0.4));
    assert_eq!((twist, why), (Twist::new(1.0, 0.2), Some(Reason::Platform)));
    assert!(!Reason::Platform.is_protective());
    let (twist, why) = reason(|_, _, demand, _, _| demand.limits = Limits { linear: 0.15, angular: 1.0 });
    assert_eq!((twist, why), (Twist::new(0.15, 0.05), None));
    assert_eq!(reason(|_, _, demand, _, _| demand.limits.linear = f64::NAN).0.linear, 0.0);
}

#[test]
fn a_silent_sonar_stops_translation_but_not_a_turn_on_the_spot() {
    let (mut protection, mut odometry, scan, mut demand) = setup();
    demand.valid_until = Time::FAR;
    let mut stopped_at = None;
    for i in 0..40 {
        let now = Time::from_secs_f64(0.05 * f64::from(i));
        odometry.stamp = now;
        let permitted = protection.filter(now, &demand, &odometry, Some(&scan), LinkState::Up);
        if permitted.reason == Some(Reason::StaleSonar) {
            assert_eq!(permitted.twist, Twist::new(0.0, 0.1));
            stopped_at = stopped_at.or(Some(now));
        }
    }
    // half a second and two passes of 0.1 s
    assert_eq!(stopped_at, Some(Time::from_secs_f64(0.75)));
}

#[test]
fn where_no_transducer_looks_it_creeps() {
    let (config, mut ring) = huey();
    ring.transducers.truncate(5);
    let mut protection = Protection::new(config.platform(), &ring, ProtectionConfig::default());
    let (_, odometry, scan, mut demand) = setup();
    demand.twist = Twist::new(-0.5, 0.0);
    let permitted = protection.filter(Time::START, &demand, &odometry, Some(&scan), LinkState::Up);
    assert_eq!(permitted, Permitted { twist: Twist::new(-0.1, 0.0), reason: Some(Reason::Blind) });
}

/// To creep is for who sees something elsewhere. Who has no sonar at all knows nothing of any way.
#[test]
fn without_any_transducer_it_stands() {
    let (config, mut ring) = huey();
    ring.transducers.clear();
    let mut protection = Protection::new(config.platform(), &ring, ProtectionConfig::default());
    let (_, odometry, _, mut demand) = setup();
    for speed in [0.3, -0.3] {
        demand.twist = Twist::new(speed, 0.0);
        let permitted = protection.filter(Time::START, &demand, &odometry, None, LinkState::Up);
        assert_eq!(permitted, Permitted { twist: Twist::STOP, reason: Some(Reason::Blind) });
    }
}

#[test]
fn after_a_contact_it_may_only_back_off() {
    let (mut protection, mut odometry, scan, mut demand) = setup();
    let mut filter = |odometry: &Odometry, demand: &Demand| {
        let permitted = protection.filter(Time::START, demand, odometry, Some(&scan), LinkState::Up);
        (permitted.twist, permitted.reason)
    };
    assert_eq!(filter(&odometry, &demand).1, None);
    odometry.flags |= flags::CONTACT;
    assert_eq!(filter(&odometry, &demand), (Twist::STOP, Some(Reason::Contact)));
    demand.twist = Twist::new(0.0, 0.5);
    assert_eq!(filter(&odometry, &demand), (Twist::STOP, Some(Reason::Contact)));
    demand.twist = Twist::new(-0.5, 0.3);
    assert_eq!(filter(&odometry, &demand), (Twist::new(-0.1, 0.0), Some(Reason::Contact)));
    demand.twist = Twist::new(0.3, 0.0);
    assert_eq!(filter(&odometry, &demand).0, Twist::STOP);
    odometry.flags = flags::ENABLED;
    assert_eq!(filter(&odometry, &demand), (Twist::new(0.3, 0.0), None));
}

/// A bumper that springs back is pressed again while the base backs off along a wall: taken for a thing behind, it held the base there
/// for ever.
#[test]
fn what_a_bumper_says_goes_before_the_way_that_was_driven() {
    for (bumper, away) in [(flags::CONTACT_AHEAD, -0.1), (flags::CONTACT_BEHIND, 0.1)] {
        let (mut protection, mut odometry, scan, mut demand) = setup();
        let mut permitted = |flags: u32, speed: f64| {
            odometry.flags = flags;
            demand.twist = Twist::new(speed, 0.0);
            protection.filter(Time::START, &demand, &odometry, Some(&scan), LinkState::Up).twist.linear
        };
        let pressed = flags::ENABLED | flags::CONTACT | bumper;
        // Also where it has just begun to listen, and never moved.
        assert_eq!([permitted(pressed, -away), permitted(pressed, away)], [0.0, away]);
        assert!(permitted(flags::ENABLED, away) != 0.0);
        assert_eq!([permitted(pressed, away), permitted(pressed, -away)], [away, 0.0]);
        assert_eq!(permitted(flags::ENABLED | flags::CONTACT | flags::CONTACT_AHEAD | flags::CONTACT_BEHIND, away), 0.0);
    }
}

#[test]
fn pushed_while_standing_it_moves_only_away_from_what_it_sees() {
    for (echoes_behind, forward_allowed) in [(0.25, true), (3.0, false)] {
        let (mut protection, mut odometry, _, mut demand) = setup();
        let mut echoes = [Echo::Range(3.0); 16];
        echoes[8] = Echo::Range(echoes_behind);
        let scan = SonarScan::from_echoes(Time::START, 1, &echoes);
        odometry.flags |= flags::CONTACT;
        demand.twist = Twist::new(0.3, 0.0);
        let permitted = protection.filter(Time::START, &demand, &odometry, Some(&scan), LinkState::Up);
        assert_eq!(permitted.twist.linear > 0.0, forward_allowed);
        demand.twist = Twist::new(-0.3, 0.0);
        let permitted = protection.filter(Time::START, &demand, &odometry, Some(&scan), LinkState::Up);
        assert!(permitted.twist.is_stop());
    }
}

#[test]
fn too_near_ahead_stops_and_behind_does_not() {
    for (index, stops) in [(0, true), (1, true), (8, false)] {
        let (mut protection, odometry, _, demand) = setup();
        let mut echoes = [Echo::Nothing; 16];
        echoes[index] = Echo::TooNear;
        let scan = SonarScan::from_echoes(Time::START, 1, &echoes);
        let permitted = protection.filter(Time::START, &demand, &odometry, Some(&scan), LinkState::Up);
        assert_eq!(permitted.twist.linear == 0.0, stops, "{index}");
    }
}
