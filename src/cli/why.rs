//! `orienteer why`: who had the base at some time, and why.

use std::{fmt::Write as _, time::Duration};

use crate::{
    Registry,
    runtime::{
        arbitration::{Clients, explain},
        recording::{ReadError, Reader},
        time::Time,
        topics::{BaseDecision, BaseNotice, ClientId, NoticeKind, Odometry, PoseEstimate, SonarDecision, flags},
    },
};
use serde_json::{Value, json};

use super::{
    Outcome, Refusal, WhyArguments,
    style::{self, Paint},
    verify,
};

/// How long before the time asked for, s, notices and log lines still matter, and how many of them.
const BEFORE: (Duration, usize) = (Duration::from_secs(60), 8);
/// How long after it.
const AFTER: (Duration, usize) = (Duration::from_secs(5), 3);
/// Where the second column begins.
const INDENT: usize = 10;

/// Says why a robot did what it did.
pub fn why(arguments: &WhyArguments, registry: &Registry) -> Result<Outcome, Refusal> {
    let reader = verify::open(&arguments.recording)?;
    let robot = robot(&reader, arguments.robot.as_deref())?;
    let at = Time::from_secs_f64(arguments.at);
    let moment = Moment::find(&reader, registry, robot, at)?;
    if arguments.json {
        style::print_json(&moment.json())?;
    } else {
        style::print(&moment.text(&arguments.recording.display().to_string(), Paint::stdout()))?;
    }
    Ok(Outcome::Well)
}

fn robot<'a>(reader: &'a Reader, asked: Option<&'a str>) -> Result<&'a str, Refusal> {
    let robots = &reader.mission().robots;
    match (asked, robots.as_slice()) {
        (Some(name), _) => Ok(name),
        (None, [only]) => Ok(&only.name),
        (None, all) => {
            let names: Vec<_> = all.iter().map(|robot| robot.name.as_str()).collect();
            let hint = names.first().map_or_else(String::new, |name| format!("say which one: `--robot {name}`"));
            Err(Refusal::misused(format!("the recording has {} robots: {}", names.len(), names.join(", ")), hint))
        }
    }
}

/// Names and priorities of a robot's nodes. The recording names them, its configuration has the priorities.
fn clients(reader: &Reader, registry: &Registry, robot: &str) -> Clients {
    let loaded = verify::load(reader, registry);
    let config = loaded.as_ref().ok().and_then(|loaded| loaded.mission.robots.iter().find(|config| config.name == robot));
    if config.is_none() {
        tracing::warn!("the recording's configuration can't be read any more: all priorities are shown as 0");
    }
    let priority = |name: &str| {
        let agent = config.and_then(|config| config.agents.iter().find(|agent| agent.name == name));
        agent.map_or(0, |agent| agent.priority)
    };
    let info = reader.mission().robots.iter().find(|info| info.name == robot);
    info.into_iter().flat_map(|info| &info.clients).map(|name| (name.clone(), priority(name))).collect()
}

/// Something that happened.
struct Event {
    time: Time,
    from: String,
    text: String,
}

/// All that is known of a robot at one time.
struct Moment<'a> {
    robot: &'a str,
    at: Time,
    clients: Clients,
    decided: Time,
    base: BaseDecision,
    sonar: Option<SonarDecision>,
    odometry: Option<Odometry>,
    pose: Option<PoseEstimate>,
    before: Vec<Event>,
    after: Vec<Event>,
}

impl<'a> Moment<'a> {
    fn find(reader: &Reader, registry: &Registry, robot: &'a str, at: Time) -> Result<Self, Refusal> {
        // Asks for the robot first, so that a wrong name is told of rather than a wrong time.
        let Some((decided, base)) = reader.decision_at(robot, at)? else {
            let message = format!("nothing was decided on `{robot}` until {}", style::time(at));
            return Err(Refusal::misused(message, "ask for a later time with `--at`"));
        };
        let end = reader.end_time() + reader.mission().control_period;
        if at > end {
            let end = reader.end_time();
            let message =
                format!("the recording ends at {} ({:.3} s), before {}", style::time(end), end.as_secs_f64(), style::time(at));
            return Err(Refusal::misused(message, "ask for an earlier time with `--at`"));
        }
        let clients = clients(reader, registry, robot);
        let sample = |error: ReadError| Refusal::from(error);
        let (before, after) = events(reader, robot, at, &clients)?;
        Ok(Self {
            robot,
            at,
            decided,
            base,
            sonar: reader.latest::<SonarDecision>(robot, at).map_err(sample)?.map(|(_, sonar)| sonar),
            odometry: reader.latest::<Odometry>(robot, at).map_err(sample)?.map(|(_, odometry)| odometry),
            pose: reader.latest::<PoseEstimate>(robot, at).map_err(sample)?.map(|(_, pose)| pose),
            clients,
            before,
            after,
        })
    }

    fn name(&self, client: ClientId) -> Option<&str> {
        self.clients.get(client.known()?).map(|client| client.name.as_str())
    }

    fn is_protected(&self) -> bool {
        self.odometry.is_some_and(|odometry| odometry.flags & flags::PROTECTED != 0)
    }

    fn text(&self, recording: &str, paint: Paint) -> String {
        let mut text =
            format!("{} at {} {}\n\n", paint.bold(self.robot), style::time(self.at), paint.dim(format!("in {recording}")));
        let mut line = |name: &str, value: String| {
            // Writing to a string can't fail.
            let _ = writeln!(text, "{}{}", paint.bold(format!("{name:INDENT$}")), style::wrap(&value, INDENT));
        };
        line("base", explain::base(&self.base, &self.clients).to_string());
        if let Some(sonar) = &self.sonar {
            line("sonar", explain::sonar(sonar, &self.clients).to_string());
        }
        line("limits", self.limits());
        if let Some(odometry) = self.odometry {
            let (linear, angular) = (figure(odometry.twist.linear, 2), figure(odometry.twist.angular.to_degrees(), 1));
            line("moved", format!("at {linear} m/s, turning at {angular} deg/s"));
        }
        if self.is_protected() {
            line("", "the base protected itself: it was slower than it was told to be, or stood".to_owned());
        }
        if let Some(PoseEstimate { pose, .. }) = self.pose {
            let (x, y, heading) = (figure(pose.x, 2), figure(pose.y, 2), figure(pose.heading.to_degrees(), 0));
            line("pose", format!("x {x} m, y {y} m, heading {heading} deg, as far as it knew"));
        }
        for (title, events) in [("what had happened", &self.before), ("what came next", &self.after)] {
            if !events.is_empty() {
                let _ = write!(text, "\n{}\n{}", paint.bold(title), listing(events, paint));
            }
        }
        text
    }

    fn limits(&self) -> String {
        let limits = self.base.limits;
        let by = |client| self.name(client).unwrap_or("nobody").to_owned();
        let speed = self.base.limited_by.known().map(|client| format!("speed {:.2} m/s by {}", limits.linear, by(client)));
        let turn = self.base.turn_limited_by.known();
        let turn = turn.map(|client| format!("turn rate {:.1} deg/s by {}", limits.angular.to_degrees(), by(client)));
        let all: Vec<String> = speed.into_iter().chain(turn).collect();
        if all.is_empty() { "none".to_owned() } else { all.join(", ") }
    }

    fn json(&self) -> Value {
        let held_back: Vec<Value> = self
            .base
            .held_back()
            .iter()
            .map(|held| json!({ "client": self.name(held.client), "rule": format!("{:?}", held.rule()) }))
            .collect();
        let limit = |value: f64| (value < f64::MAX).then_some(value);
        let events = |events: &[Event]| -> Vec<Value> {
            let event = |event: &Event| json!({ "time_s": event.time.as_secs_f64(), "from": event.from, "text": event.text });
            events.iter().map(event).collect()
        };
        let clients = self.clients.iter().map(|(_, client)| (client.name.clone(), json!(client.priority)));
        json!({
            "robot": self.robot,
            "at_s": self.at.as_secs_f64(),
            "decided_s": self.decided.as_secs_f64(),
            "base": {
                "text": explain::base(&self.base, &self.clients).to_string(),
                "holder": self.name(self.base.holder),
                "rule": format!("{:?}", self.base.rule()),
                "since_s": self.base.since.as_secs_f64(),
                "held_back": held_back,
                "limit_m_s": limit(self.base.limits.linear),
                "limited_by": self.name(self.base.limited_by),
                "turn_limit_rad_s": limit(self.base.limits.angular),
                "turn_limited_by": self.name(self.base.turn_limited_by),
            },
            "sonar": self.sonar.as_ref().map(|sonar| json!({
                "text": explain::sonar(sonar, &self.clients).to_string(),
                "holder": self.name(sonar.holder),
            })),
            "protected": self.is_protected(),
            "odometry": self.odometry.map(|odometry| json!({ "linear_m_s": odometry.twist.linear, "angular_rad_s": odometry.twist.angular })),
            "pose": self.pose.map(|pose| json!({ "x_m": pose.pose.x, "y_m": pose.pose.y, "heading_rad": pose.pose.heading })),
            "clients": clients.collect::<serde_json::Map<_, _>>(),
            "before": events(&self.before),
            "after": events(&self.after),
        })
    }
}

/// A number with so many digits; zero without a sign.
fn figure(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let is_zero = text.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.'));
    if is_zero { text.trim_start_matches('-').to_owned() } else { text }
}

fn listing(events: &[Event], paint: Paint) -> String {
    let mut text = String::new();
    for event in events {
        let time = event.time.to_string();
        let from = if event.from.is_empty() { String::new() } else { format!("{}: ", event.from) };
        let _ = writeln!(text, "{} {}", paint.dim(format!("{time:>9}")), style::wrap(&format!("{from}{}", event.text), INDENT));
    }
    text
}

/// The last notices and log lines up to a time, and the first ones after it.
fn events(reader: &Reader, robot: &str, at: Time, clients: &Clients) -> Result<(Vec<Event>, Vec<Event>), Refusal> {
    let (since, until) = (at - BEFORE.0, at + AFTER.0);
    let mut all: Vec<Event> = Vec::new();
    for notice in reader.messages::<BaseNotice>(robot)? {
        let (time, notice) = notice?;
        if time > until {
            break;
        }
        // What an overrider commands is told with every change, and who has the base is in arbitration's log.
        if time >= since && !matches!(notice.kind(), NoticeKind::OverriderMoves | NoticeKind::Granted) {
            all.push(Event { time, from: String::new(), text: explain::notice(&notice, clients).to_string() });
        }
    }
    for line in reader.log_lines(robot)? {
        let (time, line) = line?;
        if time > until {
            break;
        }
        if time >= since {
            all.push(Event { time, from: line.node, text: line.text });
        }
    }
    all.sort_by_key(|event| event.time);
    let mut after = all.split_off(all.partition_point(|event| event.time <= at));
    after.truncate(AFTER.1);
    let before = all.split_off(all.len().saturating_sub(BEFORE.1));
    Ok((before, after))
}
