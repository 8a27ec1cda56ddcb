//! Runs of several processes: finding each other, keeping apart, and leaving nothing behind, however they end.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod link_support;

use std::{
    fs,
    os::unix::fs::{PermissionsExt, symlink},
    path::Path,
};

use link_support::{
    Claim, NewReading, Reading, Root,
    actors::{self, Actor, RUN, robot_on},
    drained, segments_of,
};
use orienteer_runtime::{
    link::{Backend, Bus, BusOptions, LinkError},
    topics::limits,
};
use rustix::process::{Pid, Signal, kill_process};

fn mode(path: &Path) -> u32 {
    fs::metadata(path).unwrap().permissions().mode() & 0o777
}

#[test]
fn a_run_leaves_nothing_when_it_is_dropped() {
    let root = Root::new();
    let bus = Bus::open(Backend::Shared, &root.options(Some(RUN))).unwrap();
    let robot = robot_on(&bus);
    let mut publisher = robot.publisher().unwrap();
    let mut subscriber = robot.subscriber::<Reading>().unwrap();
    let bell = robot.bell().unwrap();
    publisher.publish(Reading::default()).unwrap();
    assert_eq!(drained(&mut subscriber).len(), 1);
    bell.ring();

    let [session] = root.sessions().try_into().unwrap();
    assert!(segments_of(&session) > 0);
    for directory in [root.path(), root.path().join(&session), root.path().join(format!("run-{RUN}"))] {
        assert_eq!(mode(&directory), 0o700, "{}", directory.display());
    }

    drop((publisher, subscriber, bell, robot, bus));
    assert_eq!(segments_of(&session), 0);
    assert!(!root.path().exists());
}

#[test]
fn nobody_else_can_read_or_write_what_a_run_has_in_shared_memory() {
    let root = Root::new();
    let bus = Bus::open(Backend::Shared, &root.options(Some(RUN))).unwrap();
    let robot = robot_on(&bus);
    let mut publisher = robot.publisher().unwrap();
    let _subscriber = robot.subscriber::<Reading>().unwrap();
    let (_bell, attached) = (robot.bell().unwrap(), Bus::attach(RUN, &root.options(None)).unwrap());
    let _elsewhere = robot_on(&attached).subscriber::<Reading>().unwrap();
    publisher.publish(Reading::default()).unwrap();
    let [session] = root.sessions().try_into().unwrap();
    let entries = || fs::read_dir("/dev/shm").unwrap().flatten();
    let segments: Vec<_> = entries().filter(|entry| entry.file_name().to_string_lossy().contains(&session)).collect();
    assert!(segments.len() > 3);
    for segment in segments {
        assert_eq!(mode(&segment.path()) & 0o077, 0, "{:?}", segment.path());
    }
}

#[test]
fn links_inside_the_process_take_no_files_and_no_descriptors() {
    let root = Root::new();
    let mut actor = Actor::start("frugal", &root);
    assert_eq!(actor.hear(), "0 descriptors, 0 maps of files");
    assert!(!root.path().exists());
}

#[test]
fn a_run_whose_directory_was_removed_leaves_nothing_either() {
    let root = Root::new();
    let bus = root.open(Backend::Shared);
    let publisher = robot_on(&bus).publisher::<Reading>().unwrap();
    let [session] = root.sessions().try_into().unwrap();
    drop(root);
    drop((publisher, bus));
    assert_eq!(segments_of(&session), 0);
}

#[test]
fn what_a_killed_run_leaves_is_swept_by_the_next() {
    let root = Root::new();
    let owner = Actor::start("owner", &root);
    let [dead] = root.sessions().try_into().unwrap();
    owner.kill();
    assert!(segments_of(&dead) > 0, "it had no chance to tidy up");

    let next = Bus::open(Backend::Shared, &root.options(Some(RUN))).unwrap();
    assert_eq!(segments_of(&dead), 0);
    let [alive] = root.sessions().try_into().unwrap();
    assert_ne!(alive, dead);
    robot_on(&next).publisher::<Reading>().unwrap();
    drop(next);
    assert_eq!(segments_of(&alive), 0);
    assert!(!root.path().exists());
}

#[test]
fn the_living_are_not_swept() {
    let root = Root::new();
    let mut owner = Actor::start("owner", &root);
    let attached = Bus::attach(RUN, &root.options(None)).unwrap();
    let mut subscriber = robot_on(&attached).subscriber::<Reading>().unwrap();
    for _ in 0..3 {
        drop(root.open(Backend::Shared));
    }
    owner.tell("publish");
    assert_eq!(owner.hear(), "published");
    assert_eq!(drained(&mut subscriber).len(), 1);
}

#[test]
fn an_interrupted_run_tidies_up() {
    let root = Root::new();
    let mut owner = Actor::start("interruptible owner", &root);
    let [session] = root.sessions().try_into().unwrap();
    kill_process(Pid::from_child(&owner.child), Signal::INT).unwrap();
    assert_eq!(owner.hear(), "interrupted");
    assert!(owner.child.wait().unwrap().success());
    assert_eq!(segments_of(&session), 0);
    assert!(!root.path().exists());
}

#[test]
fn a_public_name_is_had_by_one_process_at_a_time() {
    let root = Root::new();
    let owner = Actor::start("owner", &root);
    let refused = Bus::open(Backend::Shared, &root.options(Some(RUN))).unwrap_err();
    assert!(matches!(&refused, LinkError::RunTaken { run, pid: Some(pid) } if run == RUN && *pid == owner.pid()));
    assert!(refused.to_string().contains(&format!("process {}", owner.pid())));
    Bus::open(Backend::Shared, &root.options(Some("another"))).unwrap();
    owner.kill();
    Bus::open(Backend::Shared, &root.options(Some(RUN))).unwrap();
}

#[test]
fn a_process_can_attach_and_is_heard() {
    let root = Root::new();
    let bus = Bus::open(Backend::Shared, &root.options(Some(RUN))).unwrap();
    let robot = robot_on(&bus);
    let mut readings = robot.publisher().unwrap();
    let mut claims = robot.subscriber::<Claim>().unwrap();
    let mut own = robot.publisher().unwrap();

    let mut monitor = Actor::start("monitor", &root);
    assert_eq!(readings.publish(Reading { writer: 0, value: 7 }).unwrap(), 1);
    monitor.tell("look");
    assert_eq!(monitor.hear(), "Reading { writer: 0, value: 7 }");
    monitor.tell("claim");
    assert_eq!(monitor.hear(), "claimed");
    own.publish(Claim { writer: 1, value: 1 }).unwrap();
    // Writers of this process come first.
    assert_eq!(drained(&mut claims), [Claim { writer: 1, value: 1 }, Claim { writer: 99, value: 3 }]);
}

#[test]
fn there_must_be_a_run_to_attach_to() {
    let root = Root::new();
    let refused = |run| matches!(Bus::attach(run, &root.options(None)), Err(LinkError::NoSuchRun { .. }));
    assert!(refused(RUN));
    assert!(!root.path().exists());
    let private = root.open(Backend::Shared);
    assert!(refused(RUN));
    drop(private);
    Actor::start("owner", &root).kill();
    assert!(refused(RUN));
    assert!(!root.path().exists(), "what the killed run left is gone");
}

#[test]
fn the_attached_survive_their_run_and_do_not_disturb_the_next() {
    let root = Root::new();
    let owner = Actor::start("owner", &root);
    let attached = Bus::attach(RUN, &root.options(None)).unwrap();
    let old = robot_on(&attached);
    let mut old_subscriber = old.subscriber::<Reading>().unwrap();
    owner.kill();

    let next = Bus::open(Backend::Shared, &root.options(Some(RUN))).unwrap();
    assert_eq!(root.sessions().len(), 2);
    let robot = robot_on(&next);
    let mut publisher = robot.publisher().unwrap();
    assert_eq!(publisher.publish(Reading::default()).unwrap(), 0);
    assert_eq!(drained(&mut old_subscriber), []);
    let late = old.subscriber::<Claim>().unwrap();
    drop((late, old_subscriber, old, attached));
    assert_eq!(root.sessions().len(), 1, "the last to leave the old session has removed it");

    let mut subscriber = robot.subscriber::<Reading>().unwrap();
    publisher.publish(Reading { writer: 0, value: 4 }).unwrap();
    assert_eq!(drained(&mut subscriber), [Reading { writer: 0, value: 4 }]);
}

#[test]
fn the_place_of_a_killed_driver_is_free_for_its_successor() {
    let root = Root::new();
    let bus = Bus::open(Backend::Shared, &root.options(Some(RUN))).unwrap();
    let mut subscriber = robot_on(&bus).subscriber::<Reading>().unwrap();
    for _ in 0..3 {
        let mut driver = Actor::start("driver", &root);
        driver.tell("publish");
        assert_eq!(driver.hear(), "published");
        driver.kill();
        // What it published before it was killed is not lost.
        assert_eq!(drained(&mut subscriber), [Reading { writer: 0, value: 1 }]);
    }
}

#[test]
fn another_version_of_a_payload_is_refused_by_name_across_processes() {
    let root = Root::new();
    let _owner = Actor::start("owner", &root);
    let attached = Bus::attach(RUN, &root.options(None)).unwrap();
    let refused = robot_on(&attached).subscriber::<NewReading>().unwrap_err();
    let LinkError::IncompatiblePayload { found, wanted, .. } = &refused else { panic!("{refused}") };
    assert_eq!((found.name.as_str(), wanted.name.as_str()), ("test::Reading.v1", "test::Reading.v2"));
    assert!(refused.hint().contains("one version"));
}

#[test]
fn only_so_many_processes_may_attach() {
    let root = Root::new();
    let owner = Bus::open(Backend::Shared, &root.options(Some(RUN))).unwrap();
    let mut publisher = robot_on(&owner).publisher().unwrap();
    let guests: Vec<_> = (1..limits::PROCESSES)
        .map(|_| robot_on(&Bus::attach(RUN, &root.options(None)).unwrap()).subscriber::<Reading>().unwrap())
        .collect();
    assert_eq!(publisher.publish(Reading::default()).unwrap(), guests.len());
    let one_too_many = robot_on(&Bus::attach(RUN, &root.options(None)).unwrap());
    let refused = one_too_many.subscriber::<Reading>().unwrap_err();
    assert!(matches!(refused, LinkError::TooManyProcesses { limit: limits::PROCESSES, .. }), "{refused}");
    drop(guests);
    one_too_many.subscriber::<Reading>().unwrap();
}

#[test]
fn directories_that_others_could_meddle_with_are_refused() {
    let refused = |root: &Root| match Bus::open(Backend::Shared, &root.options(None)) {
        Err(error @ LinkError::NoPermission { .. }) => error.to_string(),
        other => panic!("{other:?}"),
    };
    let root = Root::new();
    fs::create_dir(root.path()).unwrap();
    fs::set_permissions(root.path(), fs::Permissions::from_mode(0o755)).unwrap();
    assert!(refused(&root).contains("755"));

    let root = Root::new();
    symlink("/tmp", root.path()).unwrap();
    assert!(refused(&root).contains("not a directory"));

    if rustix::process::geteuid().is_root() {
        let root = Root::new();
        fs::create_dir(root.path()).unwrap();
        std::os::unix::fs::chown(root.path(), Some(12_345), None).unwrap();
        assert!(refused(&root).contains("belongs to user 12345"));
        fs::remove_dir(root.path()).unwrap();
    }

    let root = Root::new();
    fs::write(root.path(), "").unwrap();
    assert!(refused(&root).contains("not a directory"));
}

#[test]
fn a_directory_with_a_name_too_long_for_sockets_is_refused() {
    let root = Root::new();
    let longest = |length: usize| {
        let path = root.path();
        let rest = length - path.as_os_str().len();
        BusOptions { run: None, root: Some(format!("{}{}", path.display(), "x".repeat(rest)).into()) }
    };
    let refused = Bus::open(Backend::Shared, &longest(42)).unwrap_err();
    assert!(matches!(refused, LinkError::PathTooLong { length: 42, limit: 41, .. }));

    let bus = Bus::open(Backend::Shared, &longest(41)).unwrap();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let _inside = runtime.enter();
    robot_on(&bus).doorbell().unwrap(); // Makes a socket.
}

#[test]
fn run_names_that_are_no_file_names_are_refused() {
    let root = Root::new();
    for run in ["", "a/b", "..//x", "a b", &"x".repeat(65)] {
        let refused = Bus::open(Backend::Shared, &root.options(Some(run))).unwrap_err();
        assert!(matches!(refused, LinkError::BadName { kind: "run", .. }), "{run}");
        assert!(matches!(Bus::attach(run, &root.options(None)), Err(LinkError::BadName { kind: "run", .. })), "{run}");
    }
    assert!(!root.path().exists());
}

#[test]
fn runs_come_and_go_in_parallel() {
    let root = Root::new();
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                for value in 0..10 {
                    let bus = root.open(Backend::Shared);
                    let robot = robot_on(&bus);
                    let mut publisher = robot.publisher().unwrap();
                    let mut subscriber = robot.subscriber::<Reading>().unwrap();
                    publisher.publish(Reading { writer: 0, value }).unwrap();
                    assert_eq!(drained(&mut subscriber), [Reading { writer: 0, value }]);
                }
            });
        }
    });
    assert!(!root.path().exists());
}

#[test]
fn the_limit_on_descriptors_is_raised() {
    let root = Root::new();
    let mut actor = Actor::start("modest owner", &root);
    assert_eq!(actor.hear(), "512");
}

#[test]
fn running_out_of_descriptors_names_the_key_that_helps() {
    let root = Root::new();
    let mut actor = Actor::start("starving owner", &root);
    let said = actor.hear();
    assert!(said.contains("out of file descriptors") && said.contains("`mission.links`"), "{said}");
    assert_eq!(actor.hear(), "the first robot still works");
}

/// Not a test: the entry of the processes that the tests start.
#[test]
#[ignore = "no test, but the entry of the processes that the tests above start"]
fn play_a_part() {
    actors::play();
}
