//! How a mission ends that is asked to.
#![allow(clippy::unwrap_used, missing_docs)]

mod cli_support;

use std::{
    fs,
    io::{PipeReader, PipeWriter, Read, Write, pipe},
    path::Path,
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use cli_support::{call, orienteer};
use orienteer::runtime::recording::{Ending, Reader};
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};

/// A mission that runs in the background and listens for signals.
struct Running(Child);

impl Running {
    fn start(mut command: Command) -> Self {
        let mut child = command.spawn().unwrap();
        while !listens(child.id()) {
            assert!(child.try_wait().unwrap().is_none(), "it has ended");
            thread::sleep(Duration::from_millis(10));
        }
        Self(child)
    }

    fn signal(&self, signal: &str) {
        assert!(Command::new("kill").args([signal, &self.0.id().to_string()]).status().unwrap().success());
    }

    /// Waits for its end and returns its exit code and what it printed.
    fn end(self) -> (i32, String) {
        let output = self.0.wait_with_output().unwrap();
        (output.status.code().unwrap_or(-1), String::from_utf8(output.stdout).unwrap())
    }
}

/// True once a process has a handler of its own for Ctrl-C and for SIGTERM.
fn listens(process: u32) -> bool {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let mask = status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigCgt:")?.trim(), 16).ok());
    let (interrupt, terminate) = (1 << 1, 1 << 14);
    mask.unwrap() & (interrupt | terminate) == interrupt | terminate
}

/// Time that a process has worked, in ticks of the kernel.
fn work(process: u32) -> u64 {
    let status = fs::read_to_string(format!("/proc/{process}/stat")).unwrap();
    status.rsplit(") ").next().unwrap().split(' ').nth(11).unwrap().parse().unwrap()
}

/// The program, heeding all signals even if whoever runs the tests was told to ignore some.
fn program(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new("env");
    command.arg("--default-signal=INT,TERM,HUP").arg(orienteer(folder).get_program()).args(arguments).current_dir(folder);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

#[test]
fn signals_end_a_mission_in_good_order() {
    for signal in ["-INT", "-TERM", "-HUP"] {
        let folder = tempfile::tempdir().unwrap();
        let running = Running::start(program(folder.path(), &["run", "--speed", "5", "--out", "out", "-v"]));
        running.signal(signal);
        let (code, out) = running.end();
        assert!(code == 130 && out.contains("stopped by") && out.contains("ann") && out.contains("bob"), "{code} {out}");

        let recording = folder.path().join("out/office-floor.mcap");
        assert_eq!(*Reader::open(&recording).unwrap().ending(), Ending::Complete);
        let (code, out, errors) = call(folder.path(), &["verify", "out/office-floor.mcap"]);
        assert_eq!(code, 0, "{out}{errors}");
    }
}

/// Steps that are a minute apart must not keep anybody waiting.
#[test]
fn a_mission_that_waits_for_its_next_step_stops_all_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let running = Running::start(program(folder.path(), &["run", "--speed", "0.001", "-v"]));
    let started = Instant::now();
    running.signal("-INT");
    assert_eq!(running.end().0, 130);
    assert!(started.elapsed() < Duration::from_secs(20), "{:?}", started.elapsed());
}

/// The mission is over, and its files go into a pipe that nobody reads: the program must not be deaf then.
#[test]
fn a_program_that_still_writes_its_files_can_be_ended() {
    let folder = tempfile::tempdir().unwrap();
    let map = folder.path().join("out/ann");
    fs::create_dir_all(&map).unwrap();
    let draft = "map.part-";
    let mut command = program(folder.path(), &["run", "--for", "2", "--no-record", "--out", "out"]);
    let running = Running(command.spawn().unwrap());
    let pipe = map.join(format!("{draft}{}", running.0.id()));
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    // Once it does nothing any more, it waits for somebody to read from the pipe.
    let give_up = Instant::now() + Duration::from_secs(60);
    let mut worked = u64::MAX;
    while worked != work(running.0.id()) || worked == 0 {
        worked = work(running.0.id());
        assert!(Instant::now() < give_up, "it works on and on");
        thread::sleep(Duration::from_millis(500));
    }
    running.signal("-TERM");
    assert_eq!(running.end().0, 130);
}

/// Who uses `nohup` closes the terminal on purpose.
#[test]
fn nohup_outlives_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new("nohup");
    command.arg(orienteer(folder.path()).get_program()).current_dir(folder.path());
    command.args(["run", "--speed", "20", "--for", "20", "--no-record", "-v"]);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let running = Running::start(command);
    running.signal("-HUP");
    assert_eq!(running.end().0, 0);
}

/// A pipe that takes nothing more, and how much is in it.
fn full_pipe() -> (PipeReader, PipeWriter, usize) {
    let (reader, mut writer) = pipe().unwrap();
    let usual = fcntl_getfl(&writer).unwrap();
    fcntl_setfl(&writer, usual | OFlags::NONBLOCK).unwrap();
    let mut size = 0;
    while writer.write_all(b"-").is_ok() {
        size += 1;
    }
    fcntl_setfl(&writer, usual).unwrap();
    (reader, writer, size)
}

/// Waits until it has ended, and sends signals in the meantime.
fn signal_until_it_ends(mut child: Child) -> Option<i32> {
    let give_up = Instant::now() + Duration::from_secs(60);
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            return status.code();
        }
        if Instant::now() > give_up {
            child.kill().unwrap();
            panic!("it does not end");
        }
        let _ = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
        thread::sleep(Duration::from_millis(700));
    }
}

/// As when somebody has pressed Ctrl-S: nobody reads what the program says.
#[test]
fn signals_are_heard_while_nobody_reads() {
    let folder = tempfile::tempdir().unwrap();
    let (reader, writer, _) = full_pipe();
    let mut command = program(folder.path(), &["run", "--speed", "1", "-v", "--no-record"]);
    command.stderr(writer);
    let running = Running::start(command);
    assert_eq!(signal_until_it_ends(running.0), Some(130));
    drop(reader);
}

/// Not all that ends is a mission.
#[test]
fn an_emulator_that_is_told_to_end_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let running = Running::start(program(folder.path(), &["emulate", "arcos", "--port", "pty", "-v"]));
    running.signal("-TERM");
    let output = running.0.wait_with_output().unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(130));
    assert!(errors.contains("SIGTERM: ending") && !errors.contains("mission"), "{errors}");
}

/// Nobody reads until the mission is over; then all that it said comes, in order.
#[test]
fn a_mission_goes_on_while_nobody_reads_its_log() {
    let folder = tempfile::tempdir().unwrap();
    let (mut reader, writer, full) = full_pipe();
    let mut command = program(folder.path(), &["run", "--for", "60", "-vv", "--out", "out"]);
    let mut child = command.stdout(Stdio::null()).stderr(writer).spawn().unwrap();
    drop(command);
    let picture = folder.path().join("out/office-floor.png");
    let give_up = Instant::now() + Duration::from_secs(120);
    while !picture.exists() {
        assert!(child.try_wait().unwrap().is_none() && Instant::now() < give_up, "the mission waits for its reader");
        thread::sleep(Duration::from_millis(50));
    }
    let mut text = String::new();
    reader.read_to_string(&mut text).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(0));
    let times: Vec<&str> = text[full..].lines().filter_map(|line| line.trim_start().split(' ').nth(1)).collect();
    assert!(times.len() > 10 && times.is_sorted(), "{}", &text[full..]);
}
