#![allow(clippy::unwrap_used)]

use std::{
    net::{TcpListener, TcpStream},
    time::Instant,
};

use super::*;

/// A time of the tests' own, in which waiting for a thread takes no longer than it must.
struct Asked {
    line: Line,
    began: Instant,
    heard: Vec<u8>,
}

impl Asked {
    fn new(address: &str) -> Self {
        Self { line: Line::new(address.parse().unwrap(), 9600), began: Instant::now(), heard: Vec::new() }
    }

    fn now(&self) -> Time {
        Time::START + self.began.elapsed()
    }

    /// Asks until the line stands like this.
    fn until(&mut self, wanted: impl Fn(&Self, Standing) -> bool) {
        let give_up = Instant::now() + Duration::from_secs(20);
        loop {
            let now = self.now();
            let standing = self.line.receive(now, &mut self.heard);
            if wanted(self, standing) {
                return;
            }
            assert!(Instant::now() < give_up, "{standing:?}, {}", self.line.trouble());
            thread::sleep(Duration::from_millis(2));
        }
    }
}

fn listen() -> (TcpListener, String) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("tcp://{}", listener.local_addr().unwrap());
    (listener, address)
}

#[test]
fn bytes_go_both_ways_and_a_line_that_breaks_is_opened_again() {
    let (listener, address) = listen();
    let mut asked = Asked::new(&address);
    for word in [b"one", b"two"] {
        asked.until(|_, standing| standing == Standing::Fresh);
        let (mut other, _) = listener.accept().unwrap();
        other.write_all(word).unwrap();
        asked.until(|asked, standing| standing == Standing::Open && asked.heard == word);
        asked.heard.clear();
        asked.line.send(asked.now(), b"back");
        let mut back = [0; 4];
        other.read_exact(&mut back).unwrap();
        assert_eq!(&back, b"back");
        drop(other);
        asked.until(|_, standing| standing == Standing::Down);
        assert!(asked.line.trouble().contains("hung up"), "{}", asked.line.trouble());
    }
}

#[test]
fn a_port_where_nobody_listens_is_tried_until_somebody_does() {
    let (listener, address) = listen();
    let place = listener.local_addr().unwrap();
    drop(listener);
    let mut asked = Asked::new(&address);
    asked.until(|asked, _| asked.line.trouble().contains("refused"));
    let _listener = TcpListener::bind(place).unwrap();
    asked.until(|_, standing| standing == Standing::Fresh);
}

#[test]
fn one_that_takes_nothing_is_shut_and_does_not_block() {
    let (listener, address) = listen();
    let mut asked = Asked::new(&address);
    asked.until(|_, standing| standing == Standing::Fresh);
    let _silent: (TcpStream, _) = listener.accept().unwrap();
    // The buffers of both sides fill up.
    for _ in 0..1000 {
        asked.line.send(Time::START, &[0; 1 << 16]);
    }
    assert!(asked.line.trouble().contains("takes nothing more"), "{}", asked.line.trouble());
}

#[test]
fn a_serial_port_that_is_not_there_is_named() {
    let mut asked = Asked::new("/dev/no-such-port");
    asked.until(|asked, _| asked.line.trouble().contains("can't be opened"));
    assert_eq!(asked.line.address().to_string(), "/dev/no-such-port");
}
