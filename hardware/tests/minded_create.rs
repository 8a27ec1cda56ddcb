//! A Create goes on for ever with its last speed; here its client dies, and is held up. A program of its own, because it must begin by
//! minding.
#![allow(clippy::unwrap_used)]

use std::{
    env,
    ops::ControlFlow,
    process::{Child, Command},
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering},
    },
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

use orienteer_hardware::{
    base::{odometry::OdometryConfig, presets},
    driver::BaseDriver,
    emulator::{CreateEmulator, Port, Rig, live},
    line::mind_if_asked,
    oi::{Client, CreateBase, Profile},
    sim::{Arena, SimBase, SimBodyConfig},
    wire::oi::units::Model,
    world::World,
};
use orienteer_runtime::{
    geometry::{Pose, Twist},
    random::Streams,
    time::Time,
    topics::flags,
};

/// How the client drives.
const AHEAD: Twist = Twist { linear: 0.3, angular: 0.0 };
/// Nothing may take longer.
const PATIENCE: Duration = Duration::from_secs(20);
/// A quarter of a second until it is noticed, and a little for a busy machine and for the wheels.
const SOON: Duration = Duration::from_millis(1500);

fn main() {
    mind_if_asked();
    match env::args().nth(1) {
        Some(port) if port.starts_with("/dev/") => client(&port),
        _ => {
            a_client_that_is_killed_or_held_up_leaves_a_base_that_stands();
            println!("a minded Create: ok");
        }
    }
}

/// Drives ahead until it is killed.
fn client(port: &str) {
    let platform = presets::create2().platform();
    let client = Client::new(port.parse().unwrap(), None, Profile::new(Model::CREATE_2, &platform));
    let (mut base, began) = (CreateBase::new(client, platform), Instant::now());
    loop {
        let now = Time::START + began.elapsed();
        // As protection does: what can't be read or is an emergency stop is told to stand.
        let well = base.poll(now).is_ok_and(|odometry| odometry.flags & flags::EMERGENCY_STOP == 0);
        let twist = if well { AHEAD } else { Twist::STOP };
        base.command(now, twist).unwrap();
        thread::sleep(Duration::from_millis(10));
    }
}

/// An emulated Create on a thread of its own.
struct Robot {
    speed: Arc<Mutex<f64>>,
    quit: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Robot {
    fn new(port: Port) -> Self {
        let (speed, quit) = (Arc::new(Mutex::new(0.0)), Arc::new(AtomicBool::new(false)));
        let (tell, quits) = (speed.clone(), quit.clone());
        let thread = Some(thread::spawn(move || run(port, &tell, &quits)));
        Self { speed, quit, thread }
    }

    /// How long it takes until the speed is like this.
    fn until(&self, what: &str, wanted: impl Fn(f64) -> bool) -> Duration {
        let began = Instant::now();
        while !wanted(*self.speed.lock().unwrap()) {
            assert!(began.elapsed() < PATIENCE, "it never {what}");
            thread::sleep(Duration::from_millis(2));
        }
        began.elapsed()
    }

    fn drives(&self) {
        self.until("drives", |speed| speed > 0.29);
    }

    fn stands(&self) -> Duration {
        self.until("stands", |speed| speed == 0.0)
    }
}

impl Drop for Robot {
    fn drop(&mut self) {
        self.quit.store(true, Ordering::Relaxed);
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

fn run(mut port: Port, tell: &Mutex<f64>, quit: &AtomicBool) {
    let plan = toml::from_str("[[room]]\ncorners = [[-80, -80], [80, 80]]").unwrap();
    let arena = Arena::new(World::from_plan(&plan, &|_| unreachable!()).unwrap(), Streams::new(1)).unwrap();
    let base = CreateEmulator::body();
    let config = SimBodyConfig { base: base.clone(), odometry: OdometryConfig::exact() };
    let body = arena.add("create", Pose::new(-70.0, 0.0, 0.0), config).unwrap();
    let mut rig = Rig::new(CreateEmulator::new(Model::CREATE_2), arena, SimBase::new(body, base.platform()), None);
    live(&mut rig, &mut port, |rig, _| {
        *tell.lock().unwrap() = rig.truth().twist.linear;
        if quit.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
}

/// A client that does not outlive the test.
struct Driving(Child);

impl Driving {
    fn start(port: &str) -> Self {
        Self(Command::new(env::current_exe().unwrap()).arg(port).spawn().unwrap())
    }

    fn signal(&self, signal: &str) {
        assert!(Command::new("kill").args([signal, &self.0.id().to_string()]).status().unwrap().success());
    }
}

impl Drop for Driving {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn a_client_that_is_killed_or_held_up_leaves_a_base_that_stands() {
    let port = Port::open("pty").unwrap();
    let name = port.name().to_owned();
    let robot = Robot::new(port);
    let mut driving = Driving::start(&name);
    robot.drives();
    driving.signal("-KILL");
    let killed = robot.stands();
    driving.0.wait().unwrap();
    // The next one finds it as the last one left it.
    let driving = Driving::start(&name);
    robot.drives();
    driving.signal("-STOP");
    let held_up = robot.stands();
    driving.signal("-CONT");
    robot.drives();
    assert!(killed < SOON && held_up < SOON, "{killed:?} {held_up:?}");
    println!("it stood {} ms after a kill, {} ms after a halt", killed.as_millis(), held_up.as_millis());
}
