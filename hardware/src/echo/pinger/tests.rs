#![allow(clippy::unwrap_used)]

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use nalgebra::Point2;
use orienteer_runtime::{
    robot_model::Transducer,
    topics::{Echo, FixedVec},
};
use proptest::prelude::*;
use rand::SeedableRng;
use rand_pcg::Pcg64;

use super::*;
use crate::{
    echo::{Source, Vertex, Wall},
    rings,
};

fn ms(millis: u64) -> Time {
    Time::from_nanos(millis * 1_000_000)
}

fn program(slots: &[u32], period: f32) -> FiringProgram {
    let mut masks = FixedVec::filled(0, slots.len());
    masks.copy_from_slice(slots);
    FiringProgram { slots: masks, period, rings: 1 }
}

/// Four transducers in the middle: front, left, back, right; a slot each, 10 ms.
fn cross() -> Ring {
    let transducer = |i: usize| Transducer { mount: Pose::new(0.0, 0.0, FRAC_PI_2 * i as f64), half_beam: 0.2 };
    Ring {
        name: "cross".into(),
        transducers: (0..4).map(transducer).collect(),
        min_range: 0.05,
        max_range: 5.0,
        slot_time: 0.01,
        program: program(&[0b0001, 0b0010, 0b0100, 0b1000], 0.0),
    }
}

fn walls(walls: &[[f64; 4]]) -> SegmentGrid {
    let wall = |[x1, y1, x2, y2]: &[f64; 4]| Wall::new(Point2::new(*x1, *y1), Point2::new(*x2, *y2));
    SegmentGrid::new(&walls.iter().map(wall).collect::<Vec<_>>(), &[], &[]).unwrap()
}

/// A room whose walls are 1, 2, 3 and 4 m from the origin: front, left, back, right.
fn room() -> SegmentGrid {
    walls(&[[1.0, -4.0, 1.0, 2.0], [1.0, 2.0, -3.0, 2.0], [-3.0, 2.0, -3.0, -4.0], [-3.0, -4.0, 1.0, -4.0]])
}

fn silent() -> SonarModel {
    SonarModel::default().noiseless()
}

/// Polls a still robot at the origin at these times.
fn poll(pinger: &mut Pinger, times: &[Time], world: &SegmentGrid) -> Vec<SonarScan> {
    let (mut out, mut rng) = (Vec::new(), Pcg64::seed_from_u64(3));
    for pair in times.windows(2) {
        pinger.poll(pair[0], pair[1], |_| Pose::default(), world, &[], &mut rng, &mut out);
    }
    out
}

fn stamps(scans: &[SonarScan]) -> Vec<u64> {
    scans.iter().map(|scan| scan.stamp.as_nanos() / 1_000_000).collect()
}

#[test]
fn walls_at_normal_incidence_read_exactly() {
    let mut pinger = Pinger::new(cross(), &silent(), Time::START).unwrap();
    let scans = poll(&mut pinger, &[ms(0), ms(40)], &room());
    assert_eq!(scans.len(), 1);
    assert_eq!(scans[0].echoes().collect::<Vec<_>>(), [1.0, 2.0, 3.0, 4.0].map(Echo::Range));
    assert_eq!((scans[0].stamp, scans[0].seq, scans[0].fired), (ms(40), 1, 0b1111));
    let ages: Vec<_> = (0..4).map(|i| (scans[0].age(i) * 1000.0).round()).collect();
    assert_eq!(ages, [30.0, 20.0, 10.0, 0.0]);
}

#[test]
fn passes_carry_over_from_call_to_call() {
    let mut pinger = Pinger::new(cross(), &silent(), Time::START).unwrap();
    assert_eq!(stamps(&poll(&mut pinger, &[ms(0), ms(35)], &room())), Vec::<u64>::new());
    assert_eq!(stamps(&poll(&mut pinger, &[ms(35), ms(170)], &room())), [40, 80, 120, 160]);
}

#[test]
fn a_pass_waits_for_its_period() {
    let mut pinger = Pinger::new(cross(), &silent(), Time::START).unwrap();
    pinger.set_program(&program(&[0b1, 0b10], 0.05));
    // Passes start at 10, 60, 110 ms and take one slot more.
    assert_eq!(stamps(&poll(&mut pinger, &[ms(0), ms(130)], &room())), [20, 70, 120]);
}

#[test]
fn a_new_program_waits_for_the_next_pass_and_leaves_the_rest_to_age() {
    let mut pinger = Pinger::new(cross(), &silent(), Time::START).unwrap();
    poll(&mut pinger, &[ms(0), ms(20)], &room());
    pinger.set_program(&program(&[0b1000], 0.0));
    let scans = poll(&mut pinger, &[ms(20), ms(60)], &room());
    assert_eq!(stamps(&scans), [40, 50, 60]);
    assert_eq!(scans.iter().map(|scan| scan.fired).collect::<Vec<_>>(), [0b1111, 0b1000, 0b1000]);
    assert_eq!(scans[2].echo(0), Echo::Range(1.0));
    assert!((scans[2].age(0) - 0.05).abs() < 1e-6);
    pinger.set_program(&FiringProgram::default());
    assert_eq!(poll(&mut pinger, &[ms(60), ms(100)], &room())[0].fired, 0b1111, "an empty program gives the ring back");
}

#[test]
fn every_slot_can_be_a_scan_of_its_own() {
    let mut pinger = Pinger::new(cross(), &silent(), Time::START).unwrap().telling_every_slot();
    let scans = poll(&mut pinger, &[ms(0), ms(25), ms(50)], &room());
    assert_eq!(stamps(&scans), [10, 20, 30, 40, 50]);
    assert_eq!(scans.iter().map(|scan| (scan.seq, scan.fired)).collect::<Vec<_>>(), [(1, 1), (2, 2), (3, 4), (4, 8), (5, 1)]);
    assert!((scans[2].age(0) - 0.02).abs() < 1e-6 && scans[2].echo(3) == Echo::NotFired);
}

#[test]
fn what_is_not_polled_is_not_fired() {
    let mut pinger = Pinger::new(cross(), &silent(), Time::START).unwrap();
    poll(&mut pinger, &[ms(0), ms(20)], &room());
    let scans = poll(&mut pinger, &[ms(1005), ms(1030)], &room());
    assert_eq!(stamps(&scans), [1020], "two slots were left, on the beat of 10 ms");
    assert!((scans[0].age(0) - 1.01).abs() < 1e-5);
}

#[test]
fn each_slot_fires_from_where_the_robot_is_then() {
    let mut pinger = Pinger::new(cross(), &silent(), Time::START).unwrap();
    let (mut out, mut rng) = (Vec::new(), Pcg64::seed_from_u64(3));
    // 1 m/s forward: the front is read after 10 ms, the back after 30 ms.
    pinger.poll(ms(0), ms(40), |t| Pose::new(t.as_secs_f64(), 0.0, 0.0), &room(), &[], &mut rng, &mut out);
    assert_eq!((out[0].echo(0), out[0].echo(2)), (Echo::Range(0.99), Echo::Range(3.03)));
}

#[test]
fn bodies_are_heard_and_hide_walls() {
    let mut pinger = Pinger::new(cross(), &silent(), Time::START).unwrap();
    let person = Disc { centre: Point2::new(-1.5, 0.0), radius: 0.25, reflectance: 0.5 };
    let far = Disc { centre: Point2::new(90.0, 0.0), ..person };
    let (mut out, mut rng) = (Vec::new(), Pcg64::seed_from_u64(3));
    pinger.poll(ms(0), ms(40), |_| Pose::default(), &room(), &[far, person], &mut rng, &mut out);
    assert_eq!((out[0].echo(0), out[0].echo(2)), (Echo::Range(1.0), Echo::Range(1.25)));
    // Inside a body everything is too near.
    out.clear();
    let hug = Disc { centre: Point2::new(0.1, 0.0), ..person };
    pinger.poll(ms(40), ms(80), |_| Pose::default(), &room(), &[hug], &mut rng, &mut out);
    assert!(out[0].echoes().all(|echo| echo == Echo::TooNear));
}

#[test]
fn corners_are_heard_from_near_only() {
    // The end of a wall that is met far too obliquely itself
    let (end, other) = (Point2::new(1.0, 0.05), Point2::new(3.0, 0.6));
    let vertex = Vertex { at: end, strength: 1.0 };
    let world = SegmentGrid::new(&[Wall::new(end, other)], &[vertex], &[]).unwrap();
    let acoustics = Acoustics::new(&silent()).unwrap();
    let listen = |x: f64| cone(&world, &[], &Beam::new(Pose::new(x, 0.0, 0.0), 0.2, 5.0), &acoustics, &mut Scratch::default());
    let answer = listen(-0.4).unwrap();
    assert_eq!(answer.source, Source::Vertex(0));
    assert!((answer.range - 1.4f64.hypot(0.05)).abs() < 1e-12);
    assert_eq!(listen(-0.6), None, "beyond 1.5 m");
}

#[test]
fn a_slanted_wall_sends_the_sound_elsewhere() {
    // At 45° the first wall is only a mirror: forward becomes left, where a wall 2 m on answers squarely.
    let world = walls(&[[0.5, -0.5, 1.5, 0.5], [-3.0, 2.0, 3.0, 2.0]]);
    let acoustics = Acoustics::new(&silent()).unwrap();
    let beam = Beam::new(Pose::default(), 0.1, 5.0);
    assert_eq!(cone(&world, &[], &beam, &acoustics, &mut Scratch::default()), None);
    let far = second_bounce(&world, &[], &beam, &acoustics, &mut Scratch::default()).unwrap();
    assert!((far - 3.0).abs() < 1e-12);

    let mut pinger = Pinger::new(cross(), &SonarModel { second_bounce: true, ..silent() }, Time::START).unwrap();
    assert_eq!(poll(&mut pinger, &[ms(0), ms(40)], &world)[0].echo(0), Echo::Range(3.0));
    let short = Beam::new(Pose::default(), 0.1, 2.9);
    assert_eq!(second_bounce(&world, &[], &short, &acoustics, &mut Scratch::default()), None, "the whole path must be in range");
}

#[test]
fn neighbours_of_a_slot_hear_each_other() {
    // Two transducers 40 cm apart whose beams cross on a disc that only the first meets near its normal
    let transducers = vec![
        Transducer { mount: Pose::new(0.0, 0.2, 0.0), half_beam: 0.3 },
        Transducer { mount: Pose::new(0.0, -0.2, 0.0), half_beam: 0.3 },
    ];
    let ring = Ring { transducers, program: program(&[0b11], 0.0), ..cross() };
    let world = walls(&[[1.0, 0.1, 1.0, 0.3]]);
    let model = silent().with_incidence_limit(5.0);
    let hear = |cross_talk: f64| {
        let mut pinger = Pinger::new(ring.clone(), &SonarModel { cross_talk, ..model.clone() }, Time::START).unwrap();
        let scan = poll(&mut pinger, &[ms(0), ms(10)], &world)[0];
        [scan.echo(0), scan.echo(1)]
    };
    assert_eq!(hear(0.0), [Echo::Range(1.0), Echo::Nothing]);
    let other = Echo::Range((0.5 * (1.0 + 1f64.hypot(0.4))) as f32);
    // The wall's answering point is 0.38 rad off the second axis: outside a beam of 0.3, inside one of 0.4.
    assert_eq!(hear(1.0), [Echo::Range(1.0), Echo::Nothing]);
    let mut wide = ring.clone();
    wide.transducers[1].half_beam = 0.4;
    let mut pinger = Pinger::new(wide, &SonarModel { cross_talk: 1.0, ..model }, Time::START).unwrap();
    assert_eq!(poll(&mut pinger, &[ms(0), ms(10)], &world)[0].echo(1), other);
}

#[test]
fn senseless_rings_are_refused() {
    let refused = |change: fn(&mut Ring)| {
        let mut ring = cross();
        change(&mut ring);
        Pinger::new(ring, &silent(), Time::START).unwrap_err()
    };
    assert_eq!(refused(|ring| ring.transducers[2].half_beam = 1.0), PingerError::Transducer(2));
    assert_eq!(refused(|ring| ring.transducers[1].mount.x = f64::NAN), PingerError::Transducer(1));
    assert_eq!(refused(|ring| ring.slot_time = 0.0), PingerError::SlotTime(0.0));
    assert_eq!(refused(|ring| ring.min_range = 6.0), PingerError::Ranges { min: 6.0, max: 5.0 });
    assert_eq!(refused(|ring| ring.transducers = vec![ring.transducers[0]; 33]), PingerError::TooMany(33));
}

/// How far past the end of a wall Huey drives at 8 cm/s, with 40 cm between the wall and the face of his right sonar, before
/// he believes that it has ended: two tries in a row whose mean of 12 rings is not within 20 cm of the clearance.
fn overshoot(seed: u64) -> f64 {
    let named = rings::find("denning-16").unwrap();
    let model = SonarModel { spurious: 0.0, ..named.model };
    let mut pinger = Pinger::new(named.ring, &model, Time::START).unwrap();
    let mut rng = Pcg64::seed_from_u64(seed);
    let start = -1.0 - rng.random_range(0.0..0.1);
    let x = |t: Time| start + 0.08 * t.as_secs_f64();
    let end = Vertex { at: Point2::new(0.0, -0.48), strength: 1.0 };
    let world = SegmentGrid::new(&[Wall::new(Point2::new(-9.0, -0.48), end.at)], &[end], &[]).unwrap();
    let (mut scans, mut now, mut misses) = (Vec::new(), Time::START, 0);
    while misses < 2 {
        pinger.poll(now, now + Duration::from_millis(50), |t| Pose::new(x(t), 0.0, 0.0), &world, &[], &mut rng, &mut scans);
        now = now + Duration::from_millis(50);
        if scans.len() == 12 {
            let reading = |scan: &SonarScan| scan.echo(4).free_distance(7.77).unwrap();
            let mean = scans.iter().map(reading).sum::<f32>() / 12.0;
            misses = if (mean - 0.40).abs() > 0.2 { misses + 1 } else { 0 };
            scans.clear();
        }
    }
    x(now)
}

#[test]
fn a_wall_is_believed_for_14_cm_past_its_end() {
    let overshoots: Vec<_> = (0..40).map(overshoot).collect();
    let mean = overshoots.iter().sum::<f64>() / 40.0;
    // Randazza 1989 gives about 14 cm.
    assert!((mean - 0.14).abs() < 0.03, "{mean}");
}

proptest! {
    #[test]
    fn how_the_time_is_cut_does_not_matter(
        cuts in proptest::collection::vec(1u64..60_000_000, 1..20),
        period in 0.0..0.2f32,
        ring in 0usize..8,
    ) {
        let named = rings::all().nth(ring).unwrap();
        let model = SonarModel { spurious: 0.1, dropout: 0.1, cross_talk: 0.1, second_bounce: true, ..named.model };
        let drive = |t: Time| Pose::new(0.2 * t.as_secs_f64() - 1.0, -1.0, FRAC_PI_4 * t.as_secs_f64());
        let run = |cuts: &[u64]| {
            let mut pinger = Pinger::new(named.ring.clone(), &model, Time::START).unwrap();
            pinger.set_program(&FiringProgram { period, ..named.ring.program });
            let (mut out, mut rng, mut now) = (Vec::new(), Pcg64::seed_from_u64(9), 0);
            for cut in cuts {
                let next = now + cut;
                pinger.poll(Time::from_nanos(now), Time::from_nanos(next), drive, &room(), &[], &mut rng, &mut out);
                now = next;
            }
            out
        };
        prop_assert_eq!(run(&cuts), run(&[cuts.iter().sum()]));
    }
}
