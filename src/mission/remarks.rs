//! What is allowed, but better known before anything moves.

use std::{collections::BTreeSet, fmt, time::Duration};

use orienteer_hardware::{base::protection::ProtectionConfig, drivers::OpenBase, rings::widest_gap};
use orienteer_runtime::{config::Location, descriptors, robot::RobotPlan, robot_model::Ring};
use serde::Serialize;

/// Something about robots that is allowed, but that a person should know before they move.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Remark {
    /// The robots' names.
    pub robots: Vec<String>,
    /// What to know, in one line.
    pub text: String,
    /// Where the configuration says what this is about, if it is one place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub location: Option<Location>,
}

impl Remark {
    /// Remembers it of one more robot.
    pub(super) fn note(remarks: &mut Vec<Self>, robot: &str, location: Option<&Location>, text: String) {
        match remarks.iter_mut().find(|remark| remark.text == text && remark.location.as_ref() == location) {
            Some(remark) => remark.robots.push(robot.to_owned()),
            None => remarks.push(Self { robots: vec![robot.to_owned()], text, location: location.cloned() }),
        }
    }
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(location) = &self.location {
            write!(f, "{location}: ")?;
        }
        write!(f, "{}: {}", several(&self.robots), self.text)
    }
}

/// A few names, or the first and the last of many.
#[must_use]
pub fn several<S: AsRef<str>>(names: &[S]) -> String {
    match names {
        [first, _, .., last] if names.len() > 3 => format!("{} ... {} ({})", first.as_ref(), last.as_ref(), names.len()),
        names => names.iter().map(AsRef::as_ref).collect::<Vec<_>>().join(", "),
    }
}

/// A topic in shared memory takes so many open files.
const OF_A_TOPIC: usize = 12;

/// What a person should know who wants more links in shared memory than there can be.
pub(super) fn of_descriptors(robots: &[RobotPlan]) -> Option<String> {
    let topics = |robot: &RobotPlan| {
        let ports = robot.nodes.iter().flat_map(|node| node.wiring.read_ports().iter().chain(node.wiring.write_ports()));
        ports.map(|port| port.topic).collect::<BTreeSet<_>>().len()
    };
    let (needed, most) = (OF_A_TOPIC * robots.iter().map(topics).sum::<usize>(), descriptors::most());
    (needed as u64 > most).then(|| {
        format!("links in shared memory take about {needed} open files, and this process may have {most}: say `mission.links = \"direct\"`")
    })
}

/// Narrower than this, m, is less than anybody's leg.
const LEG: f64 = 0.05;

/// Shares of a platform's top speed at which it is looked ahead.
const SPEEDS: [f64; 3] = [0.25, 0.5, 1.0];

/// What a person should know of how a robot sees where it goes.
pub(super) fn of_sight(base: &OpenBase, ring: &Ring, period: Duration) -> Option<String> {
    let platform = base.driver.platform();
    let protection = ProtectionConfig { period: period.as_secs_f64(), ..base.protection.clone() };
    if !protection.sonar_required {
        return None;
    }
    if ring.transducers.is_empty() {
        return Some(format!(
            "without a sonar `{}` stands: give the robot one, or say `protection.sonar_required = false` if it is to drive blind",
            platform.name
        ));
    }
    // Beams spread: what they cover ahead of a fast robot, they may leave open ahead of a slow one.
    let gaps = SPEEDS.map(|share| {
        let stop = protection.stopping_distance(platform, share * platform.limits.linear);
        (widest_gap(ring, platform.radius, stop), stop)
    });
    let (gap, stop) = gaps.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
    (gap > LEG).then(|| {
        format!(
            "no beam of `{}` looks at {:.0} cm of the way, {:.0} cm in front of `{}`: who steps in from the side there can be run into",
            ring.name,
            100.0 * gap,
            100.0 * stop,
            platform.name
        )
    })
}

/// What a driver says of its base or ring and can't be true.
pub(super) fn flaw(base: &OpenBase, ring: &Ring) -> Option<String> {
    let ring = Some(ring).filter(|ring| !ring.transducers.is_empty());
    base.driver.platform().flaw().or_else(|| base.protection.flaw()).or_else(|| ring?.flaw())
}
