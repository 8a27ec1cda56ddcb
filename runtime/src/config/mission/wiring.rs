//! Does every topic that is read have its writer?

use super::{
    AgentConfig, RobotConfig,
    catalog::{AgentInfo, Catalog},
};
use crate::{
    config::{problem::Problem, source::Sources, suggest},
    topics::limits,
};

/// Nodes of a robot that are no agents: base, sonar, arbitration, recorder.
const OTHER_NODES: usize = 4;

/// A robot with what the catalogue knows of its parts.
pub(super) struct Wired<'a> {
    pub(super) robot: &'a RobotConfig,
    pub(super) agents: &'a [&'a AgentInfo],
    /// Topics of its drivers, and who writes them.
    pub(super) devices: Vec<(&'static str, &'a [String])>,
}

/// Unsatisfied topics, topics with two writers, and too many agents.
pub(super) fn check(wired: &Wired<'_>, catalog: &dyn Catalog, sources: &Sources, problems: &mut Vec<Problem>) {
    let agents: Vec<(&AgentConfig, &AgentInfo)> = wired.robot.agents.iter().zip(wired.agents.iter().copied()).collect();
    let mut told: Vec<&str> = Vec::new();
    for (index, (agent, info)) in agents.iter().enumerate() {
        for topic in info.reads.iter().filter(|topic| !written(topic, wired, &agents, catalog)) {
            if !told.contains(&topic.as_str()) {
                told.push(topic);
                let readers = agents.iter().filter(|(_, info)| info.reads.contains(topic)).map(|(agent, _)| *agent);
                problems.push(unsatisfied(topic, &readers.collect::<Vec<_>>(), wired.robot, catalog, sources));
            }
        }
        for topic in info.writes.iter().filter(|topic| !catalog.many_writers(topic)) {
            problems.extend(second_writer(topic, agent, wired, &agents[..index], catalog, sources));
        }
    }
    let most = limits::NODES - OTHER_NODES;
    if let Some((agent, _)) = agents.get(most) {
        let message = format!("the robot `{}` has {} agents; {most} is the most", wired.robot.name, agents.len());
        problems.push(Problem::new(sources, &agent.span, message, "remove an agent, or set `enabled = false`"));
    }
}

fn written(topic: &String, wired: &Wired<'_>, agents: &[(&AgentConfig, &AgentInfo)], catalog: &dyn Catalog) -> bool {
    catalog.always_written().contains(topic)
        || wired.devices.iter().any(|(_, topics)| topics.contains(topic))
        || agents.iter().any(|(_, info)| info.writes.contains(topic))
}

fn unsatisfied(topic: &str, readers: &[&AgentConfig], robot: &RobotConfig, catalog: &dyn Catalog, sources: &Sources) -> Problem {
    let writes = |info: &AgentInfo| info.writes.iter().any(|written| written == topic);
    let kinds = catalog.agent_kinds();
    let writers: Vec<&str> = kinds.iter().map(String::as_str).filter(|kind| catalog.agent(kind).is_some_and(writes)).collect();
    let asleep = robot.disabled.iter().find(|agent| catalog.agent(&agent.kind).is_some_and(writes));
    let hint = match (asleep, writers.as_slice()) {
        (Some(asleep), _) => format!("the agent `{}` writes it, but is not enabled", asleep.name),
        (None, [only]) => format!("add an agent that writes it: `[robot.agent.{only}]`"),
        (None, []) if topic.starts_with("sonar/") => "give the robot a sonar: `sonar = { driver = \"…\" }`".to_owned(),
        (None, []) => "no kind of agent writes it; it takes another driver".to_owned(),
        (None, several) => format!("add an agent of a kind that writes it: {}", suggest::list(several.iter().copied())),
    };
    let names = suggest::list(readers.iter().map(|agent| agent.name.as_str()));
    let message = match readers {
        [_] => format!("nothing on robot `{}` writes `{topic}`, which the agent {names} reads", robot.name),
        _ => format!("nothing on robot `{}` writes `{topic}`, which the agents {names} read", robot.name),
    };
    let at = readers.first().map_or(&robot.span, |agent| &agent.span);
    let problem = Problem::new(sources, at, message, hint);
    match asleep {
        Some(asleep) => problem.note(sources, &asleep.span, "this one writes it, but is not enabled"),
        None => problem.note(sources, &robot.span, "this is the robot"),
    }
}

fn second_writer(
    topic: &String,
    agent: &AgentConfig,
    wired: &Wired<'_>,
    before: &[(&AgentConfig, &AgentInfo)],
    catalog: &dyn Catalog,
    sources: &Sources,
) -> Option<Problem> {
    let hint = "remove one of the two, or set `enabled = false`";
    let message = |first: &str| {
        format!("`{topic}` has two writers on robot `{}`: {first} and the agent `{}`", wired.robot.name, agent.name)
    };
    if let Some((device, _)) = wired.devices.iter().find(|(_, topics)| topics.contains(topic)) {
        return Some(Problem::new(sources, &agent.span, message(&format!("the {device}")), hint));
    }
    if catalog.always_written().contains(topic) {
        return Some(Problem::new(sources, &agent.span, message("arbitration"), hint));
    }
    let (first, _) = before.iter().find(|(_, info)| info.writes.contains(topic))?;
    let problem = Problem::new(sources, &agent.span, message(&format!("the agent `{}`", first.name)), hint);
    Some(problem.note(sources, &first.span, "the first is here"))
}
