//! A mission, its robot's hardware and the robot itself, each in a process of its own: whichever dies, the robot stands, and whichever
//! comes back, it goes on.
#![allow(clippy::unwrap_used, missing_docs)]

mod cli_support;

use std::{
    fs,
    io::{BufRead, BufReader},
    path::Path,
    process::{Child, Command, Stdio},
    sync::mpsc::{Receiver, channel},
    thread,
    time::{Duration, Instant},
};

use cli_support::orienteer;
use serde_json::Value;

/// A process that does not outlive the test.
struct Process(Child);

impl Process {
    fn start(folder: &Path, arguments: &[&str]) -> Self {
        let mut command = Command::new(orienteer(folder).get_program());
        let log = fs::File::options().create(true).append(true).open(folder.join(format!("{}.log", arguments[0]))).unwrap();
        command.args(arguments).current_dir(folder).stdout(Stdio::piped()).stderr(log);
        Self(command.spawn().unwrap())
    }

    fn signal(&self, signal: &str) {
        assert!(Command::new("kill").args([signal, &self.0.id().to_string()]).status().unwrap().success());
    }

    fn end(mut self, signal: &str) -> Option<i32> {
        self.signal(signal);
        self.0.wait().unwrap().code()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A robot as the world sees it, told a hundred times a second.
struct Robot {
    told: Receiver<Value>,
    _process: Process,
}

impl Robot {
    fn start(folder: &Path, arguments: &[&str]) -> Self {
        let mut process = Process::start(folder, arguments);
        let lines = BufReader::new(process.0.stdout.take().unwrap()).lines();
        let (tell, told) = channel();
        // The last line of one that is killed may be cut off.
        let whole = lines.map_while(Result::ok).filter_map(|line| serde_json::from_str(&line).ok());
        thread::spawn(move || whole.into_iter().try_for_each(|line| tell.send(line)));
        Self { told, _process: process }
    }

    /// Watches until this is so, and says how long that took.
    fn until(&self, what: &str, folder: &Path, wanted: impl Fn(f64) -> bool) -> Duration {
        while self.told.try_recv().is_ok() {}
        let started = Instant::now();
        loop {
            let now = self.told.recv_timeout(Duration::from_secs(20)).unwrap();
            assert_eq!(now["collisions"], 0);
            if wanted(now["speed"].as_f64().unwrap().abs() + now["turn_rate"].as_f64().unwrap().abs()) {
                return started.elapsed();
            }
            if started.elapsed() > Duration::from_secs(30) {
                let logs = ["emulate", "hardware", "run"].map(|log| fs::read_to_string(folder.join(format!("{log}.log"))));
                panic!("it never {what}: {logs:?}");
            }
        }
    }

    fn moves(&self, folder: &Path) {
        self.until("moves", folder, |speed| speed > 0.1);
    }

    fn stands(&self, folder: &Path) -> Duration {
        self.until("stands", folder, |speed| speed == 0.0)
    }
}

fn mission(folder: &Path) {
    let text = format!(
        "[mission]\nclock = 'wall'\nduration = 600\nrun = 'test-{}'\n[record]\nenabled = false\n[[robot]]\nname = 'pioneer'\n\
         hardware = 'elsewhere'\nbase = {{ driver = 'arcos', port = '{}' }}\nsonar = {{ driver = 'arcos' }}\n\
         [robot.agent.where-am-i]\n[robot.agent.avoidance]\n[robot.agent.corridor-follower]\ncruise_speed = 0.3\nautostart = true\n",
        std::process::id(),
        folder.join("port").display(),
    );
    fs::write(folder.join("mission.toml"), text).unwrap();
}

#[test]
fn whoever_dies_the_robot_stands_and_goes_on_when_they_are_back() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    mission(at);
    let port = format!("pty:{}", at.join("port").display());
    let world = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/worlds/hallway.toml");
    let robot = || Robot::start(at, &["emulate", "arcos", "--port", &port, "--world", world, "--json", "0.01"]);
    let first_robot = robot();
    let hardware = || Process::start(at, &["hardware", "mission.toml"]);
    let run = || Process::start(at, &["run", "mission.toml", "--out", "out"]);
    let (first_run, first_hardware) = (run(), hardware());
    first_robot.moves(at);

    // Somebody switches the robot off and on, and carries it back.
    drop(first_robot);
    let robot = robot();
    robot.moves(at);

    // The mission dies: its last word holds for two and a half periods, and 0.3 m/s take a second at 0.3 m/s².
    first_run.end("-KILL");
    assert!(robot.stands(at) < Duration::from_secs(4));
    let second_run = run();
    robot.moves(at);

    // The hardware dies: the base's own watchdog waits for two seconds, if the line does not break.
    first_hardware.end("-KILL");
    assert!(robot.stands(at) < Duration::from_secs(6));
    let second_hardware = hardware();
    robot.moves(at);

    // It is only held up: as good as dead for its base.
    second_hardware.signal("-STOP");
    assert!(robot.stands(at) < Duration::from_secs(6));
    second_hardware.signal("-CONT");
    robot.moves(at);

    assert_eq!(second_run.end("-INT"), Some(130));
    robot.stands(at);
    assert_eq!(second_hardware.end("-TERM"), Some(130));

    // Who was told that the hardware has gone is told that it is back, and that is no warning.
    let log = fs::read_to_string(at.join("run.log")).unwrap();
    let gone = log.find("the hardware is gone").unwrap();
    let back = log[gone..].lines().find(|line| line.contains("the hardware is there")).unwrap();
    assert!(back.contains("INFO") && !log.contains("DEBUG"), "{log}");
}

#[test]
fn a_robot_that_does_not_answer_its_hardware_fails_the_mission() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    mission(at);
    let text = fs::read_to_string(at.join("mission.toml")).unwrap();
    fs::write(at.join("mission.toml"), text.replace("run = 'test", "run = 'alone")).unwrap();
    let _hardware = Process::start(at, &["hardware", "mission.toml"]);
    let (code, _, errors) = cli_support::call(at, &["run", "mission.toml", "--for", "4", "--out", "out"]);
    assert_eq!(code, 3, "{errors}");
    assert!(errors.contains("the hardware's own output tells why"), "{errors}");
    assert!(errors.contains("it never was there"), "{errors}");
}

#[test]
fn a_mission_with_another_configuration_does_not_touch_the_robot() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let world = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/worlds/hallway.toml");
    let mission = |file: &str, rate: u32, ring: &str| {
        let text = format!(
            "[mission]\nclock = 'wall'\nduration = 600\nrun = 'alike-{}'\ncontrol_rate_hz = {rate}\n[record]\nenabled = false\n\
             [world]\nfile = '{world}'\n[[robot]]\nname = 'r'\nhardware = 'elsewhere'\n\
             base = {{ driver = 'sim', platform = 'p3dx' }}\nstart.place = 'west end'\nsonar = {{ driver = 'sim', ring = '{ring}' }}\n\
             [robot.agent.where-am-i]\n[robot.agent.corridor-follower]\nautostart = true\n",
            std::process::id()
        );
        fs::write(at.join(file), text).unwrap();
    };
    mission("one.toml", 20, "p3dx-16");
    mission("other.toml", 10, "denning-16");
    let hardware = Process::start(at, &["hardware", "one.toml"]);
    let run = |file| cli_support::call(at, &["run", file, "--for", "3", "--json", "--out", "out"]);
    let (code, _, errors) = run("other.toml");
    assert_eq!(code, 3, "{errors}");
    assert!(errors.contains("its control rate is 20.000 Hz, the mission's 10.000 Hz, its sonar ring is another"), "{errors}");
    assert!(errors.contains("the hardware was started with another configuration"), "{errors}");
    let (code, said, errors) = run("one.toml");
    let robot = &serde_json::from_str::<Value>(&said).unwrap()["robots"][0];
    assert!(code == 0 && robot["distance_m"].as_f64().unwrap() > 0.1, "{code} {said} {errors}");
    assert_eq!(hardware.end("-TERM"), Some(130));
    let log = fs::read_to_string(at.join("hardware.log")).unwrap();
    assert_eq!(log.matches("a mission drives").count(), 1, "{log}");
}

#[test]
fn who_has_no_hardware_elsewhere_is_told_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    mission(folder.path());
    let call = |arguments: &[&str]| cli_support::call(folder.path(), arguments);
    let (code, _, errors) = call(&["hardware", "mission.toml", "--robot", "pionier"]);
    assert!(code == 2 && errors.contains("did you mean `pioneer`?"), "{code} {errors}");
    let text = fs::read_to_string(folder.path().join("mission.toml")).unwrap();
    fs::write(folder.path().join("mission.toml"), text.replace("hardware = 'elsewhere'\n", "")).unwrap();
    let (code, _, errors) = call(&["hardware", "mission.toml", "--robot", "pioneer"]);
    assert!(code == 2 && errors.contains("mission.toml:8:8") && errors.contains("elsewhere"), "{code} {errors}");
}
