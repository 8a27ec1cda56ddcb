//! What every back end of the links promises, each promise tried on each back end.
#![allow(clippy::unwrap_used, missing_docs)]

mod link_support;

use link_support::{Claim, NewReading, Reading, Root, drained};
use orienteer_runtime::{
    link::{Backend, LinkError, RETIRED_WRITERS, RobotBus},
    topics::limits,
};

/// Runs each function on each back end, as tests of their own.
macro_rules! on_every_back_end {
    ($($promise:ident),* $(,)?) => {
        mod shared { $(#[test] fn $promise() { super::with(super::Backend::Shared, super::$promise); })* }
        mod local { $(#[test] fn $promise() { super::with(super::Backend::Local, super::$promise); })* }
        mod direct { $(#[test] fn $promise() { super::with(super::Backend::Direct, super::$promise); })* }
    };
}

on_every_back_end!(
    samples_come_in_the_order_of_publication,
    a_full_queue_keeps_the_newest,
    nothing_comes_twice,
    the_first_sample_reaches_every_reader,
    a_late_joiner_hears_only_what_comes_after,
    publishing_without_readers_is_no_error,
    publishing_counts_readers,
    many_writers_come_in_the_order_of_their_making,
    a_writers_place_in_the_order_is_not_inherited,
    every_writer_has_a_queue_of_its_own,
    topics_do_not_mix,
    a_second_writer_is_refused_until_the_first_is_gone,
    samples_outlive_their_writer,
    a_writer_that_was_never_looked_at_is_heard,
    only_so_many_dead_writers_are_remembered,
    the_writers_that_went_first_are_remembered,
    a_restarted_reader_hears_again,
    readers_are_limited,
    writers_are_limited,
    take_gives_one_at_a_time,
    drain_gives_what_take_left,
    what_is_published_while_draining_waits,
    a_panic_while_draining_loses_one_sample,
    another_payload_on_a_topic_is_refused_by_name,
);

fn with(backend: Backend, promise: fn(&RobotBus)) {
    let root = Root::new();
    let bus = root.open(backend);
    promise(&bus.robot("huey").unwrap().open());
}

fn reading(value: u32) -> Reading {
    Reading { writer: 0, value }
}

fn values(samples: &[Reading]) -> Vec<u32> {
    samples.iter().map(|sample| sample.value).collect()
}

fn samples_come_in_the_order_of_publication(robot: &RobotBus) {
    let mut publisher = robot.publisher().unwrap();
    let mut subscriber = robot.subscriber().unwrap();
    for value in 1..=4 {
        publisher.publish(reading(value)).unwrap();
    }
    assert_eq!(values(&drained(&mut subscriber)), [1, 2, 3, 4]);
}

fn a_full_queue_keeps_the_newest(robot: &RobotBus) {
    let mut publisher = robot.publisher().unwrap();
    let mut subscriber = robot.subscriber().unwrap();
    for round in 0..3 {
        for value in 1..=9 {
            publisher.publish(reading(10 * round + value)).unwrap();
        }
        assert_eq!(values(&drained(&mut subscriber)), [6, 7, 8, 9].map(|value| 10 * round + value));
    }
}

fn nothing_comes_twice(robot: &RobotBus) {
    let mut publisher = robot.publisher().unwrap();
    let mut subscriber = robot.subscriber().unwrap();
    assert_eq!(drained(&mut subscriber), []);
    publisher.publish(reading(1)).unwrap();
    assert_eq!(values(&drained(&mut subscriber)), [1]);
    assert_eq!(drained(&mut subscriber), []);
    assert_eq!(subscriber.take(), None);
}

fn the_first_sample_reaches_every_reader(robot: &RobotBus) {
    let mut older = robot.subscriber().unwrap();
    let mut publisher = robot.publisher().unwrap();
    let mut younger = robot.subscriber().unwrap();
    publisher.publish(reading(1)).unwrap();
    assert_eq!(values(&drained(&mut older)), [1]);
    assert_eq!(values(&drained(&mut younger)), [1]);
}

fn a_late_joiner_hears_only_what_comes_after(robot: &RobotBus) {
    let mut publisher = robot.publisher().unwrap();
    publisher.publish(reading(1)).unwrap();
    let mut late = robot.subscriber().unwrap();
    assert_eq!(drained(&mut late), []);
    publisher.publish(reading(2)).unwrap();
    assert_eq!(values(&drained(&mut late)), [2]);
}

fn publishing_without_readers_is_no_error(robot: &RobotBus) {
    let mut publisher = robot.publisher().unwrap();
    for value in 0..100 {
        assert_eq!(publisher.publish(reading(value)).unwrap(), 0);
    }
}

fn publishing_counts_readers(robot: &RobotBus) {
    let mut publisher = robot.publisher().unwrap();
    let one = robot.subscriber::<Reading>().unwrap();
    let two = robot.subscriber::<Reading>().unwrap();
    assert_eq!(publisher.publish(reading(1)).unwrap(), 2);
    drop(one);
    assert_eq!(publisher.publish(reading(2)).unwrap(), 1);
    drop(two);
    assert_eq!(publisher.publish(reading(3)).unwrap(), 0);
}

fn claims(of: &[(u32, u32)]) -> Vec<Claim> {
    of.iter().map(|&(writer, value)| Claim { writer, value }).collect()
}

fn many_writers_come_in_the_order_of_their_making(robot: &RobotBus) {
    let mut first = robot.publisher().unwrap();
    let mut subscriber = robot.subscriber::<Claim>().unwrap();
    let mut second = robot.publisher().unwrap();
    let mut third = robot.publisher().unwrap();
    for value in 0..2 {
        third.publish(Claim { writer: 3, value }).unwrap();
        first.publish(Claim { writer: 1, value }).unwrap();
        second.publish(Claim { writer: 2, value }).unwrap();
    }
    assert_eq!(drained(&mut subscriber), claims(&[(1, 0), (1, 1), (2, 0), (2, 1), (3, 0), (3, 1)]));
}

fn a_writers_place_in_the_order_is_not_inherited(robot: &RobotBus) {
    let mut subscriber = robot.subscriber::<Claim>().unwrap();
    let first = robot.publisher::<Claim>().unwrap();
    let mut second = robot.publisher().unwrap();
    drop(first); // Its slot goes to the next, which must come last nevertheless.
    let mut third = robot.publisher().unwrap();
    third.publish(Claim { writer: 3, value: 0 }).unwrap();
    second.publish(Claim { writer: 2, value: 0 }).unwrap();
    assert_eq!(drained(&mut subscriber), claims(&[(2, 0), (3, 0)]));
}

fn every_writer_has_a_queue_of_its_own(robot: &RobotBus) {
    let mut loud = robot.publisher().unwrap();
    let mut quiet = robot.publisher().unwrap();
    let mut subscriber = robot.subscriber::<Claim>().unwrap();
    quiet.publish(Claim { writer: 2, value: 0 }).unwrap();
    for value in 0..20 {
        loud.publish(Claim { writer: 1, value }).unwrap();
    }
    assert_eq!(drained(&mut subscriber), claims(&[(1, 17), (1, 18), (1, 19), (2, 0)]));
}

fn topics_do_not_mix(robot: &RobotBus) {
    let mut readings = robot.publisher().unwrap();
    let mut claimer = robot.publisher().unwrap();
    let mut of_readings = robot.subscriber::<Reading>().unwrap();
    let mut of_claims = robot.subscriber::<Claim>().unwrap();
    readings.publish(reading(1)).unwrap();
    claimer.publish(Claim { writer: 9, value: 2 }).unwrap();
    assert_eq!(drained(&mut of_readings), [reading(1)]);
    assert_eq!(drained(&mut of_claims), [Claim { writer: 9, value: 2 }]);
}

fn a_second_writer_is_refused_until_the_first_is_gone(robot: &RobotBus) {
    let first = robot.publisher::<Reading>().unwrap();
    let refused = robot.publisher::<Reading>().unwrap_err();
    assert!(matches!(&refused, LinkError::TooManyWriters { topic: "test/reading", limit: 1, robot } if robot == "huey"));
    assert!(refused.hint().contains("exactly one node may write"));
    drop(first);
    robot.publisher::<Reading>().unwrap();
}

fn samples_outlive_their_writer(robot: &RobotBus) {
    let mut subscriber = robot.subscriber().unwrap();
    let mut before = robot.publisher().unwrap();
    before.publish(reading(1)).unwrap();
    before.publish(reading(2)).unwrap();
    drop(before);
    let mut after = robot.publisher().unwrap();
    after.publish(reading(3)).unwrap();
    assert_eq!(values(&drained(&mut subscriber)), [1, 2, 3]);
}

fn a_writer_that_was_never_looked_at_is_heard(robot: &RobotBus) {
    let mut subscriber = robot.subscriber().unwrap();
    for value in 1..=3 {
        robot.publisher().unwrap().publish(reading(value)).unwrap();
    }
    assert_eq!(values(&drained(&mut subscriber)), [1, 2, 3]);
}

fn only_so_many_dead_writers_are_remembered(robot: &RobotBus) {
    let mut subscriber = robot.subscriber().unwrap();
    let remembered = u32::try_from(RETIRED_WRITERS).unwrap();
    for value in 0..remembered + 3 {
        robot.publisher().unwrap().publish(reading(value)).unwrap();
    }
    assert_eq!(values(&drained(&mut subscriber)), (0..remembered).collect::<Vec<_>>());
    robot.publisher().unwrap().publish(reading(99)).unwrap();
    assert_eq!(values(&drained(&mut subscriber)), [99]);
}

fn the_writers_that_went_first_are_remembered(robot: &RobotBus) {
    let mut subscriber = robot.subscriber::<Claim>().unwrap();
    let last = u32::try_from(RETIRED_WRITERS).unwrap() + 1;
    let mut writers: Vec<_> = (0..=last).map(|_| robot.publisher().unwrap()).collect();
    for (writer, publisher) in (0..).zip(&mut writers) {
        publisher.publish(Claim { writer, value: 0 }).unwrap();
    }
    while writers.pop().is_some() {} // From the last to the first, so the first two are one too many.
    let remembered: Vec<_> = (2..=last).map(|writer| (writer, 0)).collect();
    assert_eq!(drained(&mut subscriber), claims(&remembered));
}

fn a_restarted_reader_hears_again(robot: &RobotBus) {
    let mut publisher = robot.publisher().unwrap();
    for value in 0..40 {
        let mut subscriber = robot.subscriber().unwrap();
        publisher.publish(reading(value)).unwrap();
        assert_eq!(values(&drained(&mut subscriber)), [value]);
        publisher.publish(reading(1000)).unwrap(); // Left unread.
    }
}

fn readers_are_limited(robot: &RobotBus) {
    let readers: Vec<_> = (0..limits::READERS).map(|_| robot.subscriber::<Reading>().unwrap()).collect();
    let refused = robot.subscriber::<Reading>().unwrap_err();
    assert!(matches!(refused, LinkError::TooManyReaders { topic: "test/reading", limit: limits::READERS, .. }));
    drop(readers);
    robot.subscriber::<Reading>().unwrap();
}

fn writers_are_limited(robot: &RobotBus) {
    let mut subscriber = robot.subscriber::<Claim>().unwrap();
    let mut writers: Vec<_> = (0..limits::NODES).map(|_| robot.publisher::<Claim>().unwrap()).collect();
    let refused = robot.publisher::<Claim>().unwrap_err();
    assert!(matches!(refused, LinkError::TooManyWriters { topic: "test/claims", limit: limits::NODES, .. }));
    let mut expected = Vec::new();
    for (writer, publisher) in (0..).zip(&mut writers) {
        for value in 0..3 {
            publisher.publish(Claim { writer, value }).unwrap();
            expected.push(Claim { writer, value });
        }
    }
    assert_eq!(drained(&mut subscriber), expected);
}

fn take_gives_one_at_a_time(robot: &RobotBus) {
    let mut publisher = robot.publisher().unwrap();
    let mut subscriber = robot.subscriber().unwrap();
    for value in 1..=3 {
        publisher.publish(reading(value)).unwrap();
    }
    let taken: Vec<_> = std::iter::from_fn(|| subscriber.take()).collect();
    assert_eq!(values(&taken), [1, 2, 3]);
}

fn drain_gives_what_take_left(robot: &RobotBus) {
    let mut publisher = robot.publisher().unwrap();
    let mut subscriber = robot.subscriber().unwrap();
    for value in 1..=4 {
        publisher.publish(reading(value)).unwrap();
    }
    assert_eq!(subscriber.take(), Some(reading(1)));
    for value in 5..=9 {
        publisher.publish(reading(value)).unwrap();
    }
    // 2, 3 and 4 were fetched together with 1 and keep their places; 5 was overwritten in the link's queue.
    assert_eq!(values(&drained(&mut subscriber)), [2, 3, 4, 6, 7, 8, 9]);
}

fn what_is_published_while_draining_waits(robot: &RobotBus) {
    let mut publisher = robot.publisher().unwrap();
    let mut subscriber = robot.subscriber::<Reading>().unwrap();
    publisher.publish(reading(1)).unwrap();
    publisher.publish(reading(2)).unwrap();
    let shown = subscriber.drain(|sample| {
        publisher.publish(reading(sample.value + 10)).unwrap();
    });
    assert_eq!(shown, 2);
    assert_eq!(values(&drained(&mut subscriber)), [11, 12]);
}

fn a_panic_while_draining_loses_one_sample(robot: &RobotBus) {
    let mut publisher = robot.publisher().unwrap();
    let mut subscriber = robot.subscriber::<Reading>().unwrap();
    for value in 1..=3 {
        publisher.publish(reading(value)).unwrap();
    }
    let caught = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        subscriber.drain(|sample| assert_ne!(sample.value, 2, "meant to fail"));
    }));
    assert!(caught.is_err());
    assert_eq!(values(&drained(&mut subscriber)), [3]);
}

fn another_payload_on_a_topic_is_refused_by_name(robot: &RobotBus) {
    let _subscriber = robot.subscriber::<Reading>().unwrap();
    let refused = robot.publisher::<NewReading>().unwrap_err();
    let LinkError::IncompatiblePayload { found, wanted, .. } = &refused else { panic!("{refused}") };
    assert_eq!((found.name.as_str(), found.size), ("test::Reading.v1", 8));
    assert_eq!((wanted.name.as_str(), wanted.size), ("test::Reading.v2", 16));
    robot.publisher::<Reading>().unwrap();
}
