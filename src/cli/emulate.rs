//! `orienteer emulate`: a simulated robot for drivers of real ones.

use std::{
    sync::mpsc::{SyncSender, TrySendError, sync_channel},
    thread::{self, JoinHandle},
    time::Duration,
};

use serde::Serialize;

use crate::{
    emulate::{self, Beat, Language, Options, Robot, Start},
    hardware::{
        emulator::{Caller, Port},
        wire::Counts,
    },
    runtime::{
        fleet::{Ear, FleetControl},
        geometry::Pose,
        time::Time,
        topics::Truth,
    },
};

use super::{EmulateArguments, Outcome, Refusal, style};

/// Emulates a robot until somebody stops it.
pub fn emulate(arguments: &EmulateArguments) -> Result<Outcome, Refusal> {
    let robot = Robot::find(arguments.language, arguments.robot.as_deref()).ok_or_else(|| {
        let name = arguments.robot.as_deref().unwrap_or_default();
        Refusal::misused(format!("no robot `{name}` speaks this language"), "`p3dx` and `amigobot` speak arcos, `create2` create")
    })?;
    let options = Options {
        world: arguments.world.clone(),
        robot: robot.name.to_owned(),
        model: arguments.model.clone(),
        start: arguments.start.clone().unwrap_or(Start::Anywhere),
        seed: arguments.seed,
    };
    let mut rig = emulate::build(&options)?;
    let port = arguments.port.as_deref().unwrap_or(arguments.language.usual_port());
    let mut port = Port::open(port).map_err(|error| Refusal::misused(error.to_string(), "name another with `--port`"))?;
    let mut teller = Teller::new(Voice::raise()?, arguments.json);
    teller.say(format!("{} at {}", options.robot, port.name()));
    let control = FleetControl::default();
    let ear = Ear::open(control.clone());
    let duration = arguments.duration.map(Duration::from_secs_f64);
    emulate::live(&mut rig, &mut port, duration, &control, |beat| {
        teller.tell(beat);
        if teller.voice.failed {
            control.stop();
        }
    });
    let truth = rig.truth();
    teller.say(format!("{:.0} s, {} collisions", rig.now().as_secs_f64(), truth.collisions));
    teller.voice.settle()?;
    drop(ear);
    Ok(if control.is_stopped() { Outcome::Interrupted } else { Outcome::Well })
}

/// So many lines wait for whoever reads them.
const WAITING: usize = 1 << 12;

/// Standard output, on a thread of its own: a robot does not stand still because nobody reads what is said of it.
struct Voice {
    lines: SyncSender<String>,
    thread: JoinHandle<Result<(), Refusal>>,
    /// Lines that found no room.
    missing: u64,
    /// Nothing can be written any more.
    failed: bool,
}

impl Voice {
    fn raise() -> Result<Self, Refusal> {
        let (lines, incoming) = sync_channel::<String>(WAITING);
        let speak = move || incoming.iter().try_for_each(|line| style::print(&line));
        let thread = thread::Builder::new().name("voice".to_owned()).spawn(speak).map_err(|error| {
            Refusal::failed(format!("no thread can be started: {error}"), "look at the limits of this user: `ulimit -u`")
        })?;
        Ok(Self { lines, thread, missing: 0, failed: false })
    }

    fn say(&mut self, line: String) {
        match self.lines.try_send(line + "\n") {
            Ok(()) => {}
            Err(TrySendError::Full(_)) => self.missing += 1,
            Err(TrySendError::Disconnected(_)) => self.failed = true,
        }
    }

    /// Waits until all is written.
    fn settle(self) -> Result<(), Refusal> {
        drop(self.lines);
        let written = self.thread.join().unwrap_or(Ok(()));
        if self.missing > 0 {
            style::complain_of(&format!("({} lines are left out: they came faster than they were read)", self.missing));
        }
        written
    }
}

/// Tells people what changes, and programs how it stands.
struct Teller {
    voice: Voice,
    /// Programs: a line of JSON so often, s.
    to: Option<f64>,
    status: String,
    collisions: u32,
    told: Time,
    /// What had come over the wire before the one who is there now.
    before: Counts,
}

/// Who says so many bytes and no packet speaks another language.
const STRANGE: u64 = 32;

/// How an emulated robot stands.
#[derive(Serialize)]
struct Line<'a> {
    time_s: f64,
    status: &'a str,
    x: f64,
    y: f64,
    heading: f64,
    speed: f64,
    turn_rate: f64,
    collisions: u32,
    bumped: u32,
    /// What came over the wire: whole packets, how many of them nobody understood, broken ones, and bytes of none.
    packets: u64,
    unknown: u64,
    broken: u64,
    noise: u64,
}

impl Teller {
    fn new(voice: Voice, to: Option<f64>) -> Self {
        Self { voice, to, status: String::new(), collisions: 0, told: Time::START, before: Counts::default() }
    }

    fn tell(&mut self, beat: Beat<'_>) {
        let status = self.status_at(&beat);
        if let Some(every) = self.to {
            if beat.now.secs_since(self.told) + 1e-9 >= every {
                self.told = beat.now;
                let Truth { pose, twist, collisions, bumped, .. } = *beat.truth;
                let Counts { frames, unknown, broken, noise } = beat.emulator.counts();
                let line = Line {
                    time_s: (beat.now.as_secs_f64() * 100.0).round() / 100.0,
                    status: &status,
                    x: pose.x,
                    y: pose.y,
                    heading: pose.heading,
                    speed: twist.linear,
                    turn_rate: twist.angular,
                    collisions,
                    bumped,
                    packets: frames,
                    unknown,
                    broken,
                    noise,
                };
                self.voice.say(serde_json::to_string(&line).unwrap_or_default());
            }
            return;
        }
        if status != self.status {
            self.say(format!("{:7.1} s  {status}", beat.now.as_secs_f64()));
            self.status = status;
        }
        if beat.truth.collisions > self.collisions {
            self.collisions = beat.truth.collisions;
            let Pose { x, y, .. } = beat.truth.pose;
            self.say(format!("{:7.1} s  it has run into something at ({x:.2}, {y:.2})", beat.now.as_secs_f64()));
        }
    }

    fn status_at(&mut self, beat: &Beat<'_>) -> String {
        let now = beat.emulator.counts();
        if beat.caller != Caller::Same {
            self.before = now;
        }
        match beat.caller {
            Caller::Nobody => "nobody is there".to_owned(),
            _ if now.frames == self.before.frames && now.noise >= self.before.noise + STRANGE => {
                "somebody is there who does not speak its language".to_owned()
            }
            Caller::New | Caller::Same => beat.emulator.status(),
        }
    }

    fn say(&mut self, text: String) {
        if self.to.is_none() {
            self.voice.say(text);
        }
    }
}

/// Reads the name of a language.
///
/// # Errors
/// If there is no such language.
pub fn language(text: &str) -> Result<Language, String> {
    match text {
        "arcos" => Ok(Language::Arcos),
        "create" => Ok(Language::Create),
        _ => Err("`arcos` and `create` are spoken".to_owned()),
    }
}

/// Reads `PLACE` or `X,Y` or `X,Y,DEGREES`.
///
/// # Errors
/// If it begins like numbers and is none.
pub fn start(text: &str) -> Result<Start, String> {
    if !text.contains(',') {
        return Ok(Start::Place(text.to_owned()));
    }
    let numbers: Vec<f64> = text.split(',').filter_map(|number| number.trim().parse().ok()).collect();
    match numbers[..] {
        _ if numbers.len() != text.split(',').count() || !numbers.iter().all(|number| number.abs() <= 1e6) => {}
        [x, y] => return Ok(Start::Pose(Pose::new(x, y, 0.0))),
        [x, y, degrees] => return Ok(Start::Pose(Pose::new(x, y, degrees.to_radians()))),
        _ => {}
    }
    Err("a place of the world is needed, or metres and degrees as `2.5,1.0,90`".to_owned())
}
