//! What every driver has to do, as tests that any driver can be put through.
//!
//! A [`Bench`] is a driver with its device beneath it, and somebody who can cut the line between them. [`conformance!`](crate::conformance!) makes one test of
//! each rule for it. Time is the bench's own, so a driver that keeps to the rule of having no clock is through in no time at all.
//!
//! ```
//! use std::time::Duration;
//! use orienteer_hardware::{
//!     base::{odometry::OdometryConfig, presets},
//!     conformance::Bench,
//!     driver::BaseDriver,
//!     sim::{Arena, SimBase, SimBodyConfig},
//!     world::World,
//! };
//! use orienteer_runtime::{geometry::{Pose, Twist}, random::Streams, time::Time};
//!
//! /// The simulated base in an empty hall.
//! struct Simulated(SimBase, Time);
//!
//! impl Bench for Simulated {
//!     fn new() -> Self {
//!         let plan = toml::from_str("[[room]]\ncorners = [[-50, -50], [50, 50]]").unwrap();
//!         let world = World::from_plan(&plan, &|_| unreachable!()).unwrap();
//!         let arena = Arena::new(world, Streams::new(1)).unwrap();
//!         let base = presets::by_name("p3dx").unwrap();
//!         let platform = base.platform();
//!         let body = arena.add("r", Pose::default(), SimBodyConfig { base, odometry: OdometryConfig::exact() }).unwrap();
//!         std::mem::forget(arena); // it lives as long as the test
//!         Self(SimBase::new(body, platform), Time::START)
//!     }
//!     fn base(&mut self) -> &mut dyn BaseDriver { &mut self.0 }
//!     fn pass(&mut self, span: Duration) { self.1 = self.1 + span; }
//!     fn now(&self) -> Time { self.1 }
//!     fn moves(&self) -> Twist { self.0.truth().unwrap().twist }
//! }
//!
//! mod simulated {
//!     orienteer_hardware::conformance!(super::Simulated);
//! }
//! # for (name, rule) in orienteer_hardware::conformance::RULES { println!("{name}"); rule(&mut Simulated::new()); }
//! ```
// What breaks a rule fails a test.
#![allow(clippy::panic)]

use std::time::{Duration, Instant};

use orienteer_runtime::{
    geometry::Twist,
    time::Time,
    topics::{Odometry, flags},
};

use crate::driver::{BaseDriver, DriverError};

/// How often a base is polled: as the guard does.
const BEAT: Duration = Duration::from_millis(10);
/// A device that is there must have answered by then, s.
const COMES: f64 = 10.0;
/// A driver must notice within this that its device has gone, s.
const NOTICES: f64 = 2.0;
/// A call that takes longer than this has waited for something; and so many are made.
const AT_ONCE: Duration = Duration::from_millis(4);
const CALLS: usize = 100;
/// Packets and their counts make odometry a little late and a little coarse: m or rad, and a share.
const COARSE: (f64, f64) = (0.06, 0.03);

/// A driver with its device beneath it, all round it free floor.
pub trait Bench {
    /// A device that stands, and a driver that has not been polled.
    fn new() -> Self
    where
        Self: Sized;

    /// The driver.
    fn base(&mut self) -> &mut dyn BaseDriver;

    /// Lets time pass for the device.
    fn pass(&mut self, span: Duration);

    /// The time.
    fn now(&self) -> Time;

    /// How the device truly moves.
    fn moves(&self) -> Twist;

    /// Cuts the line between driver and device, or mends it; `false` if there is none to be cut.
    fn cut(&mut self, _cut: bool) -> bool {
        false
    }

    /// How long the device goes on when it hears nothing, before it begins to brake.
    fn watchdog(&self) -> Duration {
        Duration::ZERO
    }

    /// False for a driver that repeats a log and obeys nobody.
    fn obeys(&self) -> bool {
        true
    }
}

/// A rule by its name.
pub type Rule = (&'static str, fn(&mut dyn Bench));

/// Makes [`RULES`] and [`conformance!`](crate::conformance!) of one list.
macro_rules! rules {
    (($dollar:tt) $($rule:ident),+ $(,)?) => {
        /// All rules.
        pub const RULES: &[Rule] = &[$((stringify!($rule), $rule)),+];

        /// Makes a test of each rule for a [`Bench`](crate::conformance::Bench).
        #[macro_export]
        macro_rules! conformance {
            ($dollar bench:ty) => {
                $(#[test]
                fn $rule() {
                    $crate::conformance::$rule(&mut <$dollar bench as $crate::conformance::Bench>::new());
                })+
            };
        }
    };
}

rules! {
    ($)
    the_platform_makes_sense,
    the_device_is_found,
    it_never_waits,
    nothing_moves_before_it_is_meant_to,
    it_goes_as_it_is_told,
    no_command_exceeds_the_limits,
    what_is_no_number_moves_nothing,
    it_stops_by_all_means,
    odometry_goes_on,
    a_line_that_is_cut_is_noticed_and_mended,
}

/// What a beat has brought.
fn beat(bench: &mut dyn Bench) -> Result<Odometry, DriverError> {
    bench.pass(BEAT);
    let now = bench.now();
    let polled = bench.base().poll(now);
    if let Ok(odometry) = &polled {
        assert!(odometry.stamp <= now, "odometry from the future: {} at {now}", odometry.stamp);
        assert!(odometry.pose.is_sound() && odometry.twist.is_finite(), "odometry is no number: {odometry:?}");
    }
    polled
}

/// Polls until the device is there.
fn find(bench: &mut dyn Bench) -> Odometry {
    let give_up = bench.now() + Duration::from_secs_f64(COMES);
    loop {
        match beat(bench) {
            // Some devices are heard before their motors are on.
            Ok(odometry) if odometry.flags & flags::ENABLED != 0 || !bench.obeys() => return odometry,
            Ok(_) => {}
            Err(error) => assert!(error.may_recover(), "{error}"),
        }
        assert!(bench.now() < give_up, "the device was not found within {COMES} s");
    }
}

/// The same; `None` if the device obeys nobody, so that most rules mean nothing to it.
fn obedient(bench: &mut dyn Bench) -> Option<Odometry> {
    let found = find(bench);
    bench.obeys().then_some(found)
}

/// Drives for a while; gives the newest odometry.
fn drive(bench: &mut dyn Bench, twist: Twist, seconds: f64) -> Odometry {
    let until = bench.now() + Duration::from_secs_f64(seconds);
    let mut newest = None;
    while bench.now() < until {
        let now = bench.now();
        if let Err(error) = bench.base().command(now, twist) {
            panic!("it does not take {twist:?}: {error}");
        }
        newest = Some(beat(bench).unwrap_or_else(|error| panic!("it can't be read while it drives: {error}")));
    }
    newest.unwrap_or_default()
}

/// A velocity that every platform can have: half of what it can do along, or about.
fn half(bench: &mut dyn Bench) -> (Twist, f64) {
    let platform = bench.base().platform().clone();
    let speed = 0.5 * platform.limits.linear.min(1.0);
    (Twist::new(speed, 0.0), 1.5 * speed / platform.acceleration + 1.0)
}

/// Its numbers can be.
pub fn the_platform_makes_sense(bench: &mut dyn Bench) {
    assert_eq!(bench.base().platform().flaw(), None);
}

/// A device that is there is found, and until then a driver waits in words.
pub fn the_device_is_found(bench: &mut dyn Bench) {
    find(bench);
}

/// Whoever reads or commands has the answer at once, whether the device is there or not; the guard of a base calls nothing that waits.
/// This one rule is about time on the wall: of so many calls on a busy machine a few may be late, but not most.
pub fn it_never_waits(bench: &mut dyn Bench) {
    find(bench);
    let may_be_cut = bench.cut(false);
    for cut in [false, true] {
        if cut && !may_be_cut {
            return;
        }
        bench.cut(cut);
        let late = (0..CALLS).filter(|_| {
            bench.pass(BEAT);
            let (now, began) = (bench.now(), Instant::now());
            let base = bench.base();
            let _ = base.poll(now);
            let _ = base.command(now, Twist::STOP);
            base.stop();
            began.elapsed() > AT_ONCE
        });
        let late = late.count();
        assert!(
            late <= CALLS / 2,
            "{late} of {CALLS} calls took longer than {AT_ONCE:?}, with the line {}",
            if cut { "cut" } else { "whole" }
        );
    }
}

/// Neither by being found, nor by being told to stand.
pub fn nothing_moves_before_it_is_meant_to(bench: &mut dyn Bench) {
    if obedient(bench).is_none() {
        return;
    }
    drive(bench, Twist::STOP, 1.0);
    for _ in 0..100 {
        let _ = beat(bench);
        assert!(bench.moves().is_stop(), "{:?}", bench.moves());
    }
}

/// Ahead, and to the left.
pub fn it_goes_as_it_is_told(bench: &mut dyn Bench) {
    if obedient(bench).is_none() {
        return;
    }
    let (ahead, seconds) = half(bench);
    drive(bench, ahead, seconds);
    let speed = bench.moves().linear;
    assert!((speed - ahead.linear).abs() < 0.05 * ahead.linear + 0.01, "{speed} m/s instead of {}", ahead.linear);
    if bench.base().platform().turning_radius == 0.0 {
        drive(bench, Twist::STOP, seconds + 1.0);
        drive(bench, Twist::new(0.0, 0.5), 2.0);
        let rate = bench.moves().angular;
        assert!((rate - 0.5).abs() < 0.05, "{rate} rad/s to the left instead of 0.5");
    }
}

/// Whatever is asked for.
pub fn no_command_exceeds_the_limits(bench: &mut dyn Bench) {
    if obedient(bench).is_none() {
        return;
    }
    let limits = bench.base().platform().limits;
    for twist in [Twist::new(1e6, 0.0), Twist::new(0.0, -1e6), Twist::new(-1e6, 1e6)] {
        let until = bench.now() + Duration::from_secs(6);
        while bench.now() < until {
            let now = bench.now();
            // To refuse is as good as to obey in bounds.
            let _ = bench.base().command(now, twist);
            let _ = beat(bench);
            let moves = bench.moves();
            assert!(moves.linear.abs() <= 1.02 * limits.linear + 0.01, "{moves:?} of {limits:?}");
            assert!(moves.angular.abs() <= 1.02 * limits.angular + 0.02, "{moves:?} of {limits:?}");
        }
    }
}

/// NaN and infinity.
pub fn what_is_no_number_moves_nothing(bench: &mut dyn Bench) {
    if obedient(bench).is_none() {
        return;
    }
    for twist in [Twist::new(f64::NAN, 0.0), Twist::new(0.0, f64::NAN), Twist::new(f64::INFINITY, 0.2)] {
        for _ in 0..100 {
            let now = bench.now();
            let _ = bench.base().command(now, twist);
            let _ = beat(bench);
            assert!(bench.moves().is_stop(), "{twist:?}: {:?}", bench.moves());
        }
    }
}

/// [`BaseDriver::stop`], with nobody who polls or commands afterwards but the guard.
pub fn it_stops_by_all_means(bench: &mut dyn Bench) {
    if obedient(bench).is_none() {
        return;
    }
    let (ahead, seconds) = half(bench);
    drive(bench, ahead, seconds);
    bench.base().stop();
    let braking = ahead.linear / bench.base().platform().acceleration + 0.3;
    for _ in 0..(braking / BEAT.as_secs_f64()).ceil() as u64 {
        let _ = beat(bench);
    }
    assert!(bench.moves().is_stop(), "{:?} {braking:.2} s after it was stopped", bench.moves());
}

/// It adds up to what the device did, never jumps, and never runs backward.
pub fn odometry_goes_on(bench: &mut dyn Bench) {
    let Some(begun) = obedient(bench) else { return };
    let (ahead, _) = half(bench);
    let (mut way, mut last) = (0.0, begun);
    let turns = if bench.base().platform().turning_radius == 0.0 { 0.3 } else { 0.0 };
    let until = bench.now() + Duration::from_secs(20);
    while bench.now() < until {
        let now = bench.now();
        let twist = if now.as_secs_f64() % 8.0 < 6.0 { Twist::new(ahead.linear, turns) } else { Twist::STOP };
        let taken = bench.base().command(now, twist);
        assert!(taken.is_ok(), "{taken:?}");
        let odometry = beat(bench).unwrap_or_else(|error| panic!("{error}"));
        way += bench.moves().linear.abs() * BEAT.as_secs_f64();
        let (seconds, step) = (odometry.stamp.secs_since(last.stamp), odometry.pose.distance(&last.pose));
        assert!(
            odometry.stamp >= last.stamp && odometry.travelled >= last.travelled - 1e-9,
            "it runs backward: {last:?} {odometry:?}"
        );
        let most = bench.base().platform().limits.linear * seconds + COARSE.0;
        assert!(step <= most, "it jumps by {step} m in {seconds} s");
        last = odometry;
    }
    let travelled = last.travelled - begun.travelled;
    assert!((travelled - way).abs() <= COARSE.0 + COARSE.1 * way, "{travelled} m by odometry, {way} m in truth");
}

/// The driver says so, the device stands by its own watchdog, and all goes on when the line is mended.
pub fn a_line_that_is_cut_is_noticed_and_mended(bench: &mut dyn Bench) {
    find(bench);
    if !bench.cut(false) {
        return;
    }
    let (ahead, seconds) = half(bench);
    let before = drive(bench, ahead, seconds);
    bench.cut(true);
    let cut = bench.now();
    let braking = ahead.linear / bench.base().platform().acceleration;
    let stands = cut + bench.watchdog() + Duration::from_secs_f64(braking + 0.3);
    let mut noticed = None;
    while bench.now() < stands.max(cut + Duration::from_secs_f64(NOTICES)) {
        let now = bench.now();
        let _ = bench.base().command(now, ahead);
        if let Err(error) = beat(bench) {
            assert!(error.may_recover(), "{error}");
            noticed.get_or_insert(bench.now());
        }
    }
    assert!(noticed.is_some_and(|when| when.secs_since(cut) <= NOTICES), "noticed: {noticed:?}, cut at {cut}");
    assert!(bench.moves().is_stop(), "{:?} at {}, cut at {cut}", bench.moves(), bench.now());
    bench.cut(false);
    let after = find(bench);
    assert!(
        after.travelled >= before.travelled - COARSE.0,
        "the way was forgotten: {} m, {} m",
        before.travelled,
        after.travelled
    );
    drive(bench, ahead, seconds);
    assert!(bench.moves().linear > 0.5 * ahead.linear, "it does not drive again: {:?}", bench.moves());
}
