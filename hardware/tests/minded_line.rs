//! A line with a minder beside it, whose client dies in several ways. A program of its own, because it must begin by minding.
#![allow(clippy::unwrap_used)]

use std::{
    env,
    io::{Read, Write},
    net::{TcpListener, TcpStream},
    process::{Child, Command},
    thread,
    time::{Duration, Instant},
};

use orienteer_hardware::line::{Line, Minding, Standing, mind_if_asked};
use orienteer_runtime::time::Time;

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
            what_cannot_be_opened_is_told_by_the_minder();
            println!("a minded line: ok");
        }
    }
}

fn line(address: &str) -> Line {
    let minding = Minding { stop: vec![STOP], silence: Duration::from_millis(250) };
    Line::new(address.parse().unwrap(), 0).minded(minding)
}

/// Says every 20 ms that it goes on, until somebody says that it may end.
fn client(address: &str) {
    let (mut line, began, mut heard) = (line(address), Instant::now(), Vec::new());
    while !heard.contains(&b'e') {
        let now = Time::START + began.elapsed();
        line.receive(now, &mut heard);
        line.send(now, &[GO]);
        thread::sleep(Duration::from_millis(20));
    }
}

/// A device with a client of its own.
struct Device {
    client: Child,
    stream: TcpStream,
}

impl Device {
    fn new() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = format!("tcp://{}", listener.local_addr().unwrap());
        let client = Command::new(env::current_exe().unwrap()).arg(address).spawn().unwrap();
        let stream = listener.accept().unwrap().0;
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut device = Self { client, stream };
        assert_eq!([device.read(), device.read()], [Some(GO), Some(GO)]);
        device
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
        assert!(Command::new("kill").args([signal, &self.client.id().to_string()]).status().unwrap().success());
    }
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

fn what_cannot_be_opened_is_told_by_the_minder() {
    let (mut line, began) = (line("/dev/there-is-no-such-port"), Instant::now());
    while !line.trouble().contains("No such file") {
        assert_eq!(line.receive(Time::START + began.elapsed(), &mut Vec::new()), Standing::Down);
        assert!(began.elapsed() < PATIENCE, "{}", line.trouble());
        thread::sleep(Duration::from_millis(5));
    }
}
