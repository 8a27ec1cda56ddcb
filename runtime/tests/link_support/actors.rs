//! Processes of their own for tests, each of which plays a part until it is told to stop or is killed.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::{
    fs,
    io::{BufRead, BufReader, Write},
    process::{Child, Command, Stdio},
};

use orienteer_runtime::link::{Backend, Bus, BusOptions, LinkError, RobotBus};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use super::{Claim, Reading, Root, drained};

/// The name of the public run that actors open or attach to.
pub const RUN: &str = "mission";

/// A process of its own that plays one of the parts of [`play`]. Killed when dropped.
pub struct Actor {
    pub child: Child,
    lines: std::io::Lines<BufReader<std::process::ChildStdout>>,
}

impl Actor {
    /// Starts this test's program once more, to run its `play_a_part`, and waits until it is ready.
    pub fn start(part: &str, root: &Root) -> Self {
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--ignored", "--exact", "play_a_part", "--nocapture", "--test-threads=1"])
            .env("LINK_TEST_PART", part)
            .env("LINK_TEST_ROOT", root.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::inherit())
            .spawn()
            .unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let mut actor = Self { child, lines };
        assert_eq!(actor.hear(), "ready");
        actor
    }

    /// The next thing it says.
    pub fn hear(&mut self) -> String {
        loop {
            let line = self.lines.next().expect("the other process has ended").unwrap();
            if let Some((_, said)) = line.split_once("SAYS ") {
                return said.to_owned();
            }
        }
    }

    pub fn tell(&mut self, line: &str) {
        writeln!(self.child.stdin.as_mut().unwrap(), "{line}").unwrap();
    }

    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// As `kill -9` does.
    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

impl Drop for Actor {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn say(what: &str) {
    println!("SAYS {what}");
}

pub fn robot_on(bus: &Bus) -> RobotBus {
    bus.robot("huey").unwrap().open()
}

/// What a process does that [`Actor::start`] has started.
pub fn play() {
    let Ok(part) = std::env::var("LINK_TEST_PART") else { return };
    let options = BusOptions { run: None, root: Some(std::env::var_os("LINK_TEST_ROOT").unwrap().into()) };
    let public = BusOptions { run: Some(RUN.into()), ..options.clone() };
    let lines = || std::io::stdin().lines().map(Result::unwrap);
    match part.as_str() {
        "owner" => {
            let bus = Bus::open(Backend::Shared, &public).unwrap();
            let robot = robot_on(&bus);
            let mut publisher = robot.publisher().unwrap();
            let _subscriber = robot.subscriber::<Reading>().unwrap();
            let _bell = robot.bell().unwrap();
            say("ready");
            for _ in lines() {
                publisher.publish(Reading { writer: 0, value: 1 }).unwrap();
                say("published");
            }
        }
        "interruptible owner" => {
            let bus = Bus::open(Backend::Shared, &public).unwrap();
            let robot = robot_on(&bus);
            let _ports = (robot.publisher::<Reading>().unwrap(), robot.bell().unwrap());
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
            runtime.block_on(async {
                let mut interrupts = tokio::signal::unix::signal(tokio::signal::unix::SignalKind::interrupt()).unwrap();
                say("ready");
                interrupts.recv().await.unwrap();
            });
            say("interrupted");
        }
        "monitor" => {
            let bus = Bus::attach(RUN, &options).unwrap();
            let robot = robot_on(&bus);
            let mut subscriber = robot.subscriber::<Reading>().unwrap();
            let mut publisher = robot.publisher().unwrap();
            say("ready");
            for line in lines() {
                if line == "look" {
                    say(&format!("{:?}", subscriber.take().unwrap()));
                } else {
                    publisher.publish(Claim { writer: 99, value: 3 }).unwrap();
                    say("claimed");
                }
            }
        }
        "driver" => {
            let bus = Bus::attach(RUN, &options).unwrap();
            let mut publisher = robot_on(&bus).publisher().unwrap();
            say("ready");
            for _ in lines() {
                assert_eq!(publisher.publish(Reading { writer: 0, value: 1 }).unwrap(), 1);
                say("published");
            }
        }
        "modest owner" => {
            setrlimit(Resource::Nofile, Rlimit { current: Some(64), maximum: Some(512) }).unwrap();
            let _bus = Bus::open(Backend::Shared, &public).unwrap();
            say("ready");
            say(&getrlimit(Resource::Nofile).current.unwrap().to_string());
            lines().count();
        }
        "starving owner" => {
            setrlimit(Resource::Nofile, Rlimit { current: Some(100), maximum: Some(100) }).unwrap();
            let bus = Bus::open(Backend::Shared, &public).unwrap();
            let ports = |n: usize| {
                let robot = bus.robot(&format!("robot-{n}"))?.open();
                Ok((robot.publisher::<Reading>()?, robot.subscriber::<Reading>()?, robot.publisher::<Claim>()?, robot))
            };
            say("ready");
            let mut made = Vec::new();
            let error: LinkError = (0..).find_map(|n| ports(n).map(|ports| made.push(ports)).err()).unwrap();
            say(&format!("{error}; {}", error.hint()));
            let (publisher, subscriber, ..) = &mut made[0];
            publisher.publish(Reading { writer: 0, value: 1 }).unwrap();
            assert_eq!(drained(subscriber).len(), 1);
            say("the first robot still works");
            lines().count();
        }
        "frugal" => {
            let descriptors = || fs::read_dir("/proc/self/fd").unwrap().count();
            let maps = || fs::read_to_string("/proc/self/maps").unwrap().matches("/dev/shm").count();
            say("ready");
            let before = descriptors();
            let kept: Vec<_> = [Backend::Local, Backend::Direct]
                .map(|backend| {
                    let robot = robot_on(&Bus::open(backend, &public).unwrap());
                    let mut publisher = robot.publisher().unwrap();
                    let mut subscriber = robot.subscriber::<Reading>().unwrap();
                    publisher.publish(Reading::default()).unwrap();
                    assert_eq!(drained(&mut subscriber).len(), 1);
                    (robot.bell().unwrap(), publisher, subscriber, robot)
                })
                .into();
            say(&format!("{} descriptors, {} maps of files", descriptors() - before, maps()));
            drop(kept);
        }
        other => panic!("no such part: {other}"),
    }
}
