//! A line with a minder beside it, whose client dies in several ways. A program of its own, because it must begin by minding.
#![allow(clippy::unwrap_used)]

use std::{
    env, fs,
    io::{Read, Write},
    net::{TcpListener, TcpStream},
    process::{Child, Command},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::{Duration, Instant},
};

use orienteer_hardware::line::{Line, Minding, Standing, mind_if_asked};
use orienteer_runtime::time::Time;
use signal_hook::{consts::signal, flag};

/// What the client says as long as it is well.
const GO: u8 = b'g';
/// What the minder says when it is not.
const STOP: u8 = b's';
/// Nothing may take longer.
const PATIENCE: Duration = Duration::from_secs(20);

fn main() {
    mind_if_asked();
    match env::args().nth(1) {
        Some(address) if address.starts_with("tcp://") => client(&address),
        _ => {
            a_client_that_is_killed_or_held_up_is_spoken_for();
            a_minder_that_is_held_up_is_replaced();
            a_minder_that_is_held_up_leaves_no_device_that_goes_on();
            what_cannot_be_opened_is_told_by_the_minder();
            println!("a minded line: ok");
        }
    }
}

fn line(address: &str) -> Line {
    let minding = Minding { stop: vec![STOP], silence: Duration::from_millis(250) };
    Line::new(address.parse().unwrap(), 0).minded(minding)
}

/// Says every 20 ms that it goes on, until the device or a signal says that it may end.
fn client(address: &str) {
    let ending = Arc::new(AtomicBool::new(false));
    flag::register(signal::SIGTERM, ending.clone()).unwrap();
    let (mut line, began, mut heard) = (line(address), Instant::now(), Vec::new());
    while !heard.contains(&b'e') && !ending.load(Ordering::Relaxed) {
        let now = Time::START + began.elapsed();
        line.receive(now, &mut heard);
        line.send(now, &[GO]);
        thread::sleep(Duration::from_millis(20));
    }
}

/// A device with a client of its own.
struct Device {
    client: Child,
    listener: TcpListener,
    stream: TcpStream,
}

impl Device {
    fn new() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = format!("tcp://{}", listener.local_addr().unwrap());
        let client = Command::new(env::current_exe().unwrap()).arg(address).spawn().unwrap();
        let stream = accept(&listener);
        let mut device = Self { client, listener, stream };
        device.goes_on();
        device
    }

    fn goes_on(&mut self) {
        assert_eq!([self.read(), self.read()], [Some(GO), Some(GO)]);
    }

    /// Somebody else comes, as soon as whoever is there has gone.
    fn next(&mut self) {
        while self.read().is_some() {}
        self.stream = accept(&self.listener);
    }

    /// The process that minds the line.
    fn minder(&self) -> String {
        let client = self.client.id();
        let children = fs::read_to_string(format!("/proc/{client}/task/{client}/children")).unwrap();
        let minders: Vec<_> = children.split_whitespace().collect();
        assert_eq!(minders.len(), 1, "{children}");
        minders[0].to_owned()
    }

    /// The next byte; nothing when the line has ended.
    fn read(&mut self) -> Option<u8> {
        let mut byte = [0];
        (self.stream.read(&mut byte).unwrap() == 1).then_some(byte[0])
    }

    /// How long it takes to be told to stop.
    fn stops(&mut self) -> Duration {
        let began = Instant::now();
        while self.read() != Some(STOP) {
            assert!(began.elapsed() < PATIENCE, "nobody stops it");
        }
        began.elapsed()
    }

    fn signal(&self, signal: &str) {
        tell(&self.client.id().to_string(), signal);
    }
}

fn accept(listener: &TcpListener) -> TcpStream {
    let stream = listener.accept().unwrap().0;
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream
}

fn tell(process: &str, signal: &str) {
    assert!(Command::new("kill").args([signal, process]).status().unwrap().success());
}

impl Drop for Device {
    fn drop(&mut self) {
        let _ = self.client.kill();
        let _ = self.client.wait();
    }
}

fn a_client_that_is_killed_or_held_up_is_spoken_for() {
    // Killed: told at once, and the minder goes.
    let mut device = Device::new();
    device.signal("-KILL");
    let took = device.stops();
    while let Some(byte) = device.read() {
        assert_eq!(byte, STOP);
    }
    // Held up: told after the silence, again and again, until it goes on.
    let mut device = Device::new();
    device.signal("-STOP");
    let held_up = device.stops();
    assert_eq!([device.read(), device.read()], [Some(STOP), Some(STOP)]);
    device.signal("-CONT");
    while device.read() != Some(GO) {}
    // Asked to end: what the device says reaches it, and its minder stops the device all the same.
    device.stream.write_all(b"e").unwrap();
    device.stops();
    while device.read().is_some() {}
    assert!(device.client.wait().unwrap().success());
    println!("told to stop {} ms after a kill, {} ms after a halt", took.as_millis(), held_up.as_millis());
}

fn a_minder_that_is_held_up_is_replaced() {
    let mut device = Device::new();
    let held_up = device.minder();
    tell(&held_up, "-STOP");
    let began = Instant::now();
    // First the client itself, on a line of its own, then the next minder.
    device.next();
    assert_eq!(device.read(), Some(STOP));
    let stopped = began.elapsed();
    device.next();
    device.goes_on();
    assert_ne!(device.minder(), held_up);
    println!("told to stop {} ms after its minder was held up", stopped.as_millis());
}

fn a_minder_that_is_held_up_leaves_no_device_that_goes_on() {
    // Its client is killed: the system wakes it, and it does its duty.
    let mut device = Device::new();
    tell(&device.minder(), "-STOP");
    device.signal("-KILL");
    device.stops();
    // Its client ends in order, and does it itself.
    let mut device = Device::new();
    tell(&device.minder(), "-STOP");
    device.signal("-TERM");
    device.next();
    assert_eq!(device.read(), Some(STOP));
    while device.read().is_some() {}
    assert!(device.client.wait().unwrap().success());
    // Both are asked to end, as when a service is stopped.
    let mut device = Device::new();
    tell(&device.minder(), "-TERM");
    device.signal("-TERM");
    device.stops();
}

fn what_cannot_be_opened_is_told_by_the_minder() {
    let (mut line, began) = (line("/dev/there-is-no-such-port"), Instant::now());
    while !line.trouble().contains("No such file") {
        assert_eq!(line.receive(Time::START + began.elapsed(), &mut Vec::new()), Standing::Down);
        assert!(began.elapsed() < PATIENCE, "{}", line.trouble());
        thread::sleep(Duration::from_millis(5));
    }
}
