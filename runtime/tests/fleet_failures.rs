//! What goes wrong in a fleet costs nobody else anything: panics anywhere, a disk that hangs, a start that fails.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod fleet_support;

use std::{
    fs::{self, File},
    io::{self, Read},
    ops::ControlFlow,
    sync::{
        Arc, Mutex,
        atomic::{AtomicU32, Ordering},
        mpsc::{RecvTimeoutError, Sender, channel},
    },
    thread,
    time::Duration,
};

use fleet_support::{Count, UNSPEAKABLE, fly, plan, robot};
use orienteer_runtime::{
    agent::{Behaviour, BuildError, Finish, Inputs, Outputs},
    clock::Pace,
    fleet::{self, Ended, FleetControl, FleetPlan, Still},
    host::Factory,
    link::{Backend, Bus, BusOptions},
    recording::{ChunkLimits, Mission, Reader, Recorder, RobotInfo, Sink},
    time::Time,
    topics::BaseDecision,
};

#[test]
fn a_panic_costs_the_others_nothing_and_the_behaviour_comes_back() {
    std::panic::set_hook(Box::new(|_| {}));
    let report = fly(Backend::Direct, 1, 2, Some(10));
    for robot in &report.robots {
        let follower = robot.nodes.iter().find(|node| node.name == "follower").unwrap();
        assert_eq!(follower.panics, 1);
        // 9 steps before the panic; half a second later it drives again, less the interrupter's 20 steps.
        assert_eq!(robot.fact("forward"), Some(101.0 - 20.0 - 10.0));
        assert_eq!(robot.fact("backward"), Some(20.0), "the interrupter is not affected");
    }
}

/// A base that tells when it is told to stop.
struct Parting(Sender<()>);

impl Behaviour for Parting {
    fn step(&mut self, _now: Time, _inputs: &Inputs, _out: &mut Outputs) {}

    fn finish(&mut self, _now: Time, _last_words: &mut Finish) {
        let _ = self.0.send(());
    }
}

fn parting(told: Sender<()>) -> Factory {
    let told = Mutex::new(told);
    Box::new(move |_| Ok(Box::new(Parting(told.lock().unwrap().clone()))))
}

#[test]
fn bases_stop_at_the_end_even_if_the_disk_hangs() {
    // A pipe that nobody empties is a disk that hangs.
    let directory = tempfile::tempdir().unwrap();
    let pipe = directory.path().join("recording");
    rustix::fs::mkfifoat(rustix::fs::CWD, &pipe, rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR).unwrap();
    let (told, hears) = channel();
    let disk = {
        let pipe = pipe.clone();
        thread::spawn(move || -> io::Result<(Result<(), RecvTimeoutError>, u64)> {
            let mut file = File::open(pipe)?;
            let stopped = hears.recv_timeout(Duration::from_secs(20));
            Ok((stopped, io::copy(&mut file.by_ref(), &mut io::sink())?))
        })
    };
    let bus = Bus::open(Backend::Direct, &BusOptions::default()).unwrap();
    let mut robots: Vec<_> = (0..4).map(|number| robot(number, &bus, None)).collect();
    robots[0].nodes[4].factory = parting(told);
    let period = Duration::from_millis(50);
    let mission = Mission { control_period: period, ..Mission::default() };
    // The first chunk is longer than what a pipe holds, and closes shortly before the end.
    let limits = ChunkLimits { chunk_seconds: 10.0, ..ChunkLimits::default() };
    let plan = FleetPlan {
        robots,
        environment: Box::new(Still),
        period,
        duration: Some(Duration::from_secs(12)),
        pace: Pace::AsFastAsPossible,
        leader: None,
        threads: 1,
        recorder: Some(Recorder::start(Sink::File(pipe), &mission, limits).unwrap()),
        control: FleetControl::default(),
        epoch: Default::default(),
        observer: Box::new(|_| ControlFlow::Continue(())),
    };
    let report = fleet::run(plan).unwrap();
    let (stopped, bytes) = disk.join().unwrap().unwrap();
    assert!(bytes > 100_000, "{bytes} bytes would not have filled the pipe");
    assert_eq!(stopped, Ok(()), "the base waited for the disk");
    let written = report.recording.unwrap().unwrap();
    assert_eq!(written.bytes, bytes);
}

/// Panics in its tenth step, and once more when it is dropped.
#[derive(Default)]
struct Twice(u64);

impl Behaviour for Twice {
    fn step(&mut self, _now: Time, _inputs: &Inputs, _out: &mut Outputs) {
        self.0 += 1;
        assert!(self.0 != 10, "as planned");
    }
}

impl Drop for Twice {
    fn drop(&mut self) {
        assert!(self.0 != 10, "as planned, too");
    }
}

#[test]
fn a_behaviour_that_panics_when_it_is_dropped_costs_the_others_nothing() {
    std::panic::set_hook(Box::new(|_| {}));
    let (told, result) = channel();
    thread::spawn(move || {
        let bus = Bus::open(Backend::Direct, &BusOptions::default()).unwrap();
        let mut robots = vec![robot(0, &bus, None)];
        robots[0].nodes[2].factory = Box::new(|_| Ok(Box::new(Twice::default())));
        told.send(fleet::run(plan(robots, 1))).ok();
    });
    let report = result.recv_timeout(Duration::from_secs(20)).expect("the fleet does not wait for ever").unwrap();
    assert_eq!((report.ended, report.robots[0].fact("forward")), (Ended::Complete, Some(101.0)));
    // It comes back after half a second, then after one and two more, and again dies in its tenth step.
    assert_eq!(report.robots[0].nodes[2].panics, 3);
}

/// Publishes what can't be recorded.
#[derive(Default)]
struct Unspeakable(u64);

impl Behaviour for Unspeakable {
    fn step(&mut self, _now: Time, _inputs: &Inputs, out: &mut Outputs) {
        self.0 += 1;
        if self.0 == 10 {
            out.publish(Count { value: UNSPEAKABLE });
        }
    }
}

#[test]
fn a_robot_that_dies_ends_the_mission_with_an_error() {
    std::panic::set_hook(Box::new(|_| {}));
    for threads in [1, 2] {
        let (told, result) = channel();
        let (stopped, stops) = channel();
        thread::spawn(move || {
            let bus = Bus::open(Backend::Direct, &BusOptions::default()).unwrap();
            let mut robots: Vec<_> = (0..2).map(|number| robot(number, &bus, None)).collect();
            robots[1].nodes[0].factory = Box::new(|_| Ok(Box::new(Unspeakable::default())));
            robots[0].nodes[4].factory = parting(stopped);
            // Nothing is encoded unless somebody records.
            let recorder = Recorder::start(Sink::Hash, &Mission::default(), ChunkLimits::default()).unwrap();
            told.send(fleet::run(FleetPlan { recorder: Some(recorder), ..plan(robots, threads) })).ok();
        });
        let result = result.recv_timeout(Duration::from_secs(20)).expect("the fleet does not wait for ever");
        let error = result.unwrap_err().to_string();
        assert!(error.contains("robot `robot-1` panicked"), "{error}");
        assert_eq!(stops.try_recv(), Ok(()), "the others are told to stop");
    }
}

#[test]
fn what_can_be_built_only_once_stays_down_and_says_so_once() {
    std::panic::set_hook(Box::new(|_| {}));
    let bus = Bus::open(Backend::Direct, &BusOptions::default()).unwrap();
    let mut robots = vec![robot(0, &bus, None)];
    let (once, again) = (AtomicU32::new(0), Arc::new(AtomicU32::new(0)));
    let asked = again.clone();
    robots[0].nodes[2].factory = Box::new(move |_| {
        if once.fetch_add(1, Ordering::Relaxed) == 0 {
            return Ok(Box::new(Twice::default()));
        }
        asked.fetch_add(1, Ordering::Relaxed);
        Err(BuildError::for_good("it was the only one"))
    });
    let mission = Mission { control_period: Duration::from_millis(50), ..Mission::default() };
    let recorder = Recorder::start(Sink::Memory, &mission, ChunkLimits::default()).unwrap();
    let report = fleet::run(FleetPlan { recorder: Some(recorder), ..plan(robots, 1) }).unwrap();
    assert_eq!((report.robots[0].nodes[2].panics, again.load(Ordering::Relaxed)), (1, 1));
    let recording = report.recording.unwrap().unwrap().memory.unwrap();
    assert_eq!(recording.windows(13).filter(|text| text == b"it stays down").count(), 1);
}

/// Has nothing to say in the end.
struct Speechless;

impl Behaviour for Speechless {
    fn step(&mut self, _now: Time, _inputs: &Inputs, _out: &mut Outputs) {}

    fn finish(&mut self, _now: Time, _last_words: &mut Finish) {
        panic!("as planned");
    }
}

#[test]
fn last_words_that_panic_are_a_failure_that_a_person_learns_of() {
    std::panic::set_hook(Box::new(|_| {}));
    let bus = Bus::open(Backend::Direct, &BusOptions::default()).unwrap();
    let mut robots = vec![robot(0, &bus, None)];
    robots[0].nodes[2].factory = Box::new(|_| Ok(Box::new(Speechless)));
    let report = fleet::run(plan(robots, 1)).unwrap();
    assert_eq!(report.robots[0].nodes[2].finish.failures.len(), 1);
}

/// The threads of this process.
fn threads() -> usize {
    fs::read_dir("/proc/self/task").unwrap().count()
}

#[test]
fn a_start_that_fails_leaves_no_threads_and_no_shared_memory() {
    // Other tests of this process come and go; a process of its own counts only what is its own.
    const ALONE: &str = "ORIENTEER_TEST_ALONE";
    if std::env::var_os(ALONE).is_none() {
        let program = std::env::current_exe().unwrap();
        let name = "a_start_that_fails_leaves_no_threads_and_no_shared_memory";
        let alone = std::process::Command::new(program).args(["--exact", name]).env(ALONE, "1").output().unwrap();
        assert!(alone.status.success(), "{}", String::from_utf8_lossy(&alone.stdout));
        return;
    }
    let directory = tempfile::tempdir_in("/dev/shm").unwrap();
    let root = directory.path().join("runs");
    let before = threads();
    let bus = Bus::open(Backend::Shared, &BusOptions { root: Some(root.clone()), ..BusOptions::default() }).unwrap();
    let mut robots: Vec<_> = (0..4).map(|number| robot(number, &bus, None)).collect();
    // The second robot of the second thread.
    robots[3].nodes[1].factory = Box::new(|_| Err(BuildError::new("as planned")));
    let error = fleet::run(plan(robots, 2)).unwrap_err().to_string();
    assert!(error.contains("as planned"), "{error}");
    drop(bus);
    assert!(!root.exists(), "something was left in {}", root.display());
    assert_eq!(threads(), before);
}

/// Forgets to declare what it reads and what it writes.
struct Forgetful;

impl Behaviour for Forgetful {
    fn step(&mut self, _now: Time, inputs: &Inputs, out: &mut Outputs) {
        let _ = inputs.latest::<BaseDecision>();
        out.publish(Count { value: 1 });
    }
}

/// A line in every step would bury everything else that the robot says.
#[test]
fn a_topic_that_was_not_declared_is_told_of_once() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("recording.mcap");
    let bus = Bus::open(Backend::Direct, &BusOptions::default()).unwrap();
    let mut robots = vec![robot(0, &bus, None)];
    robots[0].nodes[2].factory = Box::new(|_| Ok(Box::new(Forgetful)));
    let info = RobotInfo::new("robot-0", robots[0].nodes.iter().map(|node| node.context.node.to_string()));
    let mission = Mission { control_period: Duration::from_millis(50), robots: vec![info], ..Mission::default() };
    let recorder = Recorder::start(Sink::File(file.clone()), &mission, ChunkLimits::default()).unwrap();
    fleet::run(FleetPlan { recorder: Some(recorder), ..plan(robots, 1) }).unwrap();

    let reader = Reader::open(&file).unwrap();
    let lines = reader.log_lines("robot-0").unwrap().map(|line| line.unwrap().1.text);
    let mut told: Vec<String> = lines.filter(|text| text.contains("declared")).collect();
    told.sort();
    assert_eq!(told.len(), 2, "{told:?}");
    assert!(told[0].contains("`base/decision`") && told[1].contains("`test/count`"), "{told:?}");
}
