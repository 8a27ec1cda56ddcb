//! How a mission ends that is asked to.
#![allow(clippy::unwrap_used, missing_docs)]

mod cli_support;

use std::{
    fs,
    path::Path,
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use cli_support::{call, orienteer};
use orienteer::runtime::recording::{Ending, Reader};

/// A mission that runs in the background and listens for signals.
struct Running(Child);

impl Running {
    fn start(mut command: Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
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
    let running = Running(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap());
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
    command.args(["run", "--speed", "20", "--for", "20", "--no-record", "-v"]).stdin(Stdio::null());
    let running = Running::start(command);
    running.signal("-HUP");
    assert_eq!(running.end().0, 0);
}
