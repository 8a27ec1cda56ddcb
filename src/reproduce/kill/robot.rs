//! The robot, as the world sees it.

use std::{
    collections::VecDeque,
    ops::ControlFlow,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

use orienteer_hardware::emulator::{self, Caller, Emulator, Port};
use orienteer_runtime::{
    geometry::{Pose, Twist},
    time::Time,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::{super::SuiteError, family::Family};
use crate::emulate::{self, EmulatedRobot, Options, Start};

/// No robot here needs longer to brake.
pub const BRAKING: Duration = Duration::from_millis(1200);
/// A robot that moves faster than this, m/s, drives.
const DRIVES: f64 = 0.1;
/// A robot that turns faster than this, rad/s, turns.
const TURNS: f64 = 0.2;
/// For so long it is known how the robot moved.
const REMEMBERED: Duration = Duration::from_secs(20);

/// A corridor that has no end: around a block.
const WORLD: &str = "
name = \"ring\"
[[room]]
corners = [[0, 0], [14, 12]]
[[box]]
name = \"block\"
center = [7, 6]
size = [10.4, 8.4]
";

/// What becomes of the bytes on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wire {
    /// They get through.
    Whole,
    /// None gets through.
    Silent,
    /// Others do instead.
    Garbage,
    /// Of each piece only the first half does.
    Half,
    /// There is no wire.
    Off,
}

/// An emulated robot on a thread of its own.
pub struct Watched {
    /// Where its driver finds it.
    pub port: String,
    state: Arc<Mutex<State>>,
    quit: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

struct State {
    wire: Wire,
    /// How it moved at the end of each beat.
    moved: VecDeque<(Instant, Twist)>,
    collisions: u32,
    pose: Pose,
    status: String,
}

impl Watched {
    pub fn start(family: &Family, seed: u64) -> Result<Self, SuiteError> {
        let folder = tempfile::tempdir().map_err(SuiteError::from_display)?;
        let world = folder.path().join("ring.toml");
        std::fs::write(&world, WORLD).map_err(SuiteError::from_display)?;
        let start = Start::Pose(Pose::new(3.0, 0.9, 0.0));
        let options = Options { world: Some(world), robot: family.robot.into(), model: None, start, seed };
        let rig = emulate::build(&options).map_err(SuiteError::from_display)?;
        let port = Port::open("tcp://127.0.0.1:0").map_err(SuiteError::from_display)?;
        let name = port.name().to_owned();
        let state = Arc::new(Mutex::new(State {
            wire: Wire::Whole,
            moved: VecDeque::new(),
            collisions: 0,
            pose: Pose::default(),
            status: String::new(),
        }));
        let quit = Arc::new(AtomicBool::new(false));
        let (watched, ended) = (state.clone(), quit.clone());
        let body = move || live(rig, port, &watched, &ended, seed);
        let thread = thread::Builder::new().name("robot".into()).spawn(body).map_err(SuiteError::from_display)?;
        Ok(Self { port: name, state, quit, thread: Some(thread) })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        lock(&self.state)
    }

    /// What becomes of the bytes from now on.
    pub fn wire(&self, wire: Wire) {
        self.state().wire = wire;
    }

    /// Where it is and what it does.
    pub fn describe(&self) -> String {
        let state = self.state();
        let Pose { x, y, heading } = state.pose;
        let (speed, rate) = state.moved.back().map_or((0.0, 0.0), |(_, twist)| (twist.linear, twist.angular));
        format!("at ({x:.2}, {y:.2}), {:.0}°, {speed:.2} m/s, {rate:.2} rad/s, {}", heading.to_degrees(), state.status)
    }

    pub fn collisions(&self) -> u32 {
        self.state().collisions
    }

    /// Waits until it drives, and says when it did.
    pub fn drives(&self, patience: Duration) -> Option<Instant> {
        self.moves(patience, |twist| twist.linear.abs() > DRIVES)
    }

    /// Waits until it drives, or turns on the spot: who was left across its corridor has to find the way first. Says when it did.
    pub fn goes_on(&self, patience: Duration) -> Option<Instant> {
        self.moves(patience, |twist| twist.linear.abs() > DRIVES || twist.angular.abs() > TURNS)
    }

    fn moves(&self, patience: Duration, so: impl Fn(&Twist) -> bool) -> Option<Instant> {
        let began = Instant::now();
        while began.elapsed() < patience {
            if let Some((when, twist)) = self.state().moved.back()
                && so(twist)
            {
                return Some(*when);
            }
            thread::sleep(Duration::from_millis(5));
        }
        None
    }

    /// Time from an instant until it stood and stayed so, less that which such brakes need from the highest speed that it had meanwhile,
    /// s: until it was told to stop, that is. `None` if it does not stand; one that does so `for_a_moment` need not stay.
    pub fn stood_after(&self, began: Instant, brakes: (f64, f64), for_a_moment: bool) -> Option<f64> {
        let mut state = self.state();
        let stands = |(when, twist): &(Instant, Twist)| *when >= began && twist.is_stop();
        if for_a_moment && let Some(first) = state.moved.iter().position(stands) {
            state.moved.truncate(first + 1);
        }
        if !state.moved.back().is_some_and(stands) {
            return None;
        }
        let told = |speed: fn(&Twist) -> f64, brakes: f64| {
            let (mut fastest, mut last) = (0.0_f64, began);
            for (when, twist) in state.moved.iter().filter(|(when, twist)| *when >= began && speed(twist) != 0.0) {
                (fastest, last) = (fastest.max(speed(twist).abs()), *when);
            }
            last.saturating_duration_since(began).as_secs_f64() - fastest / brakes
        };
        Some(told(|twist| twist.linear, brakes.0).max(told(|twist| twist.angular, brakes.1)).max(0.0))
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        self.quit.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn live(mut rig: EmulatedRobot, port: Port, state: &Mutex<State>, quit: &AtomicBool, seed: u64) {
    let mut wire = Meddled { name: port.name().to_owned(), port: Some(port), random: Pcg64::seed_from_u64(seed), state };
    emulator::live(&mut rig, &mut wire, |rig, _| {
        note(state, rig);
        if quit.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
}

/// A port with somebody at the wire.
struct Meddled<'a> {
    name: String,
    /// There is none while the wire is off.
    port: Option<Port>,
    random: Pcg64,
    state: &'a Mutex<State>,
}

impl emulator::Wire for Meddled<'_> {
    fn receive(&mut self, now: Time, into: &mut Vec<u8>) -> Caller {
        let wire = lock(self.state).wire;
        match (wire, self.port.is_some()) {
            (Wire::Off, true) => self.port = None,
            (Wire::Off, false) | (_, true) => {}
            // Somebody else may have the number for a moment.
            (_, false) => self.port = Port::open(&self.name).ok(),
        }
        let caller = self.port.as_mut().map_or(Caller::Nobody, |port| port.receive(now, into));
        spoil(into, wire, &mut self.random);
        caller
    }

    fn send(&mut self, bytes: &[u8]) {
        let wire = lock(self.state).wire;
        let mut bytes = bytes.to_vec();
        spoil(&mut bytes, wire, &mut self.random);
        if let Some(port) = &mut self.port {
            port.send(&bytes);
        }
    }
}

fn spoil(bytes: &mut Vec<u8>, wire: Wire, random: &mut Pcg64) {
    match wire {
        Wire::Whole => {}
        Wire::Silent | Wire::Off => bytes.clear(),
        Wire::Garbage => bytes.iter_mut().for_each(|byte| *byte = random.random()),
        Wire::Half => bytes.truncate(bytes.len() / 2),
    }
}

fn note(state: &Mutex<State>, rig: &EmulatedRobot) {
    let (now, truth) = (Instant::now(), rig.truth());
    let mut state = lock(state);
    (state.collisions, state.pose) = (truth.collisions, truth.pose);
    state.status = rig.emulator().status();
    state.moved.push_back((now, truth.twist));
    while state.moved.front().is_some_and(|(when, _)| now.duration_since(*when) > REMEMBERED) {
        state.moved.pop_front();
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
