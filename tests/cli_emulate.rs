//! `orienteer emulate`, as somebody sees it who watches its terminal.
#![allow(clippy::unwrap_used, missing_docs)]

mod cli_support;

use std::{
    fs::File,
    io::{BufRead, BufReader, Write},
    process::{Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use cli_support::orienteer;
use orienteer::hardware::wire::arcos::greeting::emit_sync;

/// A client for the other family: its user looks at two terminals, and either should say what is wrong.
#[test]
fn a_client_that_speaks_another_language_is_told_of() {
    let folder = tempfile::tempdir().unwrap();
    let port = folder.path().join("port");
    let mut command = Command::new(orienteer(folder.path()).get_program());
    command.args(["emulate", "create", "--for", "30", "--port", &format!("pty:{}", port.display())]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let give_up = Instant::now() + Duration::from_secs(20);
    while !port.exists() {
        assert!(Instant::now() < give_up, "it opens no port");
        thread::sleep(Duration::from_millis(10));
    }
    let mut client = File::options().read(true).write(true).open(&port).unwrap();
    let mut greeting = Vec::new();
    emit_sync(0, &mut greeting);
    thread::spawn(move || {
        // Until the emulator has gone.
        while client.write_all(&greeting).is_ok() {
            thread::sleep(Duration::from_millis(50));
        }
    });
    let lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let told = lines.map_while(Result::ok).any(|line| line.ends_with("somebody is there who does not speak its language"));
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(told);
}
