#![allow(clippy::unwrap_used)]

use std::{
    io::Read,
    thread,
    time::{Duration, Instant},
};

use super::*;

/// Asks until somebody like this is there and has said this.
fn hear(port: &mut Port, now: Time, wanted: Caller, words: &[u8]) {
    let give_up = Instant::now() + Duration::from_secs(20);
    let (mut heard, mut callers) = (Vec::new(), Vec::new());
    while !(callers.contains(&wanted) && heard == words) {
        callers.push(port.receive(now, &mut heard));
        assert!(Instant::now() < give_up, "{heard:?}, {:?}", callers.last());
        thread::sleep(Duration::from_millis(1));
    }
}

fn connect(port: &Port) -> TcpStream {
    TcpStream::connect(port.name().trim_start_matches("tcp://")).unwrap()
}

#[test]
fn one_client_at_a_time_comes_in_by_tcp() {
    let mut port = Port::open("tcp://127.0.0.1:0").unwrap();
    let now = Time::START;
    hear(&mut port, now, Caller::Nobody, b"");
    let mut first = connect(&port);
    first.write_all(b"hello").unwrap();
    hear(&mut port, now, Caller::New, b"hello");
    let mut second = connect(&port);
    hear(&mut port, now, Caller::Same, b"");
    assert_eq!(second.read(&mut [0]).unwrap_or(0), 0, "shut at once");
    port.send(b"you");
    let mut answer = [0; 3];
    first.read_exact(&mut answer).unwrap();
    assert_eq!(&answer, b"you");
    drop(first);
    hear(&mut port, now, Caller::Nobody, b"");
}

#[test]
fn a_client_that_has_fallen_silent_gives_way() {
    let mut port = Port::open("tcp://127.0.0.1:0").unwrap();
    let _silent = connect(&port);
    hear(&mut port, Time::START, Caller::New, b"");
    let mut second = connect(&port);
    second.write_all(b"me").unwrap();
    hear(&mut port, Time::START + PATIENCE, Caller::New, b"me");
}

#[test]
fn a_pseudo_terminal_looks_like_a_serial_port() {
    let directory = tempfile::tempdir().unwrap();
    let link = directory.path().join("pioneer");
    let mut port = Port::open(&format!("pty:{}", link.display())).unwrap();
    let now = Time::START;
    hear(&mut port, now, Caller::Nobody, b"");
    for _ in 0..2 {
        let mut client = serialport::new(link.to_string_lossy(), 9600).timeout(Duration::from_secs(5)).open_native().unwrap();
        client.write_all(&[0xFA, 0x0A, 0x0D, 0x03, 0x04]).unwrap();
        hear(&mut port, now, Caller::New, &[0xFA, 0x0A, 0x0D, 0x03, 0x04]);
        port.send(&[0xFB, 0x0D, 0x11]);
        let mut answer = [0; 3];
        client.read_exact(&mut answer).unwrap();
        assert_eq!(answer, [0xFB, 0x0D, 0x11]);
        drop(client);
        hear(&mut port, now, Caller::Nobody, b"");
    }
    drop(port);
    assert!(fs::symlink_metadata(&link).is_err(), "nothing is left");
}

#[test]
fn a_link_replaces_what_an_emulator_has_left_and_nothing_else() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("port");
    symlink("/dev/pts/99999", &path).unwrap();
    assert!(Port::open(&format!("pty:{}", path.display())).is_ok());
    let name = format!("pty:{}", path.display());
    let first = Port::open(&name).unwrap();
    let second = Port::open(&name).unwrap();
    drop(first);
    assert!(fs::symlink_metadata(&path).is_ok(), "that is the second one's");
    drop(second);
    assert!(fs::symlink_metadata(&path).is_err());
    fs::write(&path, "precious").unwrap();
    assert!(matches!(Port::open(&format!("pty:{}", path.display())), Err(PortError::Taken(_))));
    assert_eq!(fs::read(&path).unwrap(), b"precious");
    for name in ["", "pty:", "udp://x", "/dev/ttyUSB0"] {
        assert!(matches!(Port::open(name), Err(PortError::Name(_))), "{name}");
    }
    assert!(matches!(Port::open("tcp://nowhere"), Err(PortError::Listen { .. })));
}
