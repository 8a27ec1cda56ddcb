//! `orienteer check` and `orienteer schema`.

use std::fmt::Write as _;

use orienteer::{
    Registry,
    mission::{self, Composed},
    runtime::{
        config::{self, Problems, mission::RobotConfig},
        robot::RobotPlan,
        time::Time,
    },
};
use serde::Serialize;

use super::{
    CheckArguments, Outcome, Refusal,
    style::{self, Paint},
    table::{Align, Table},
};

#[derive(Serialize)]
struct Answer<'a> {
    ok: bool,
    problems: Option<&'a Problems>,
}

/// Checks a configuration: all that `run` does before anything moves.
pub fn check(arguments: &CheckArguments) -> Result<Outcome, Refusal> {
    let found = examine(arguments);
    if arguments.json {
        return match found {
            Ok(_) => {
                style::print_json(&serde_json::json!({ "ok": true, "problems": [] }));
                Ok(Outcome::Well)
            }
            Err(refusal) => {
                style::print_json(&Answer { ok: false, problems: Some(refusal.problems()) });
                Ok(refusal.outcome())
            }
        };
    }
    style::print(&found?);
    Ok(Outcome::Well)
}

fn examine(arguments: &CheckArguments) -> Result<String, Refusal> {
    let registry = Registry::standard();
    let mut loaded = mission::load(&arguments.config, &registry)?;
    // The very mission may be running under its name.
    loaded.mission.settings.run = None;
    let configs = loaded.mission.robots.clone();
    let world = loaded.mission.world.as_ref().map(|world| world.path.clone());
    let seed = loaded.mission.settings.seed;
    let composed = mission::compose(loaded, &registry, seed)?;
    let path = arguments.config.display();
    Ok(describe(&path.to_string(), world.as_deref(), &configs, &composed))
}

fn describe(path: &str, world: Option<&str>, configs: &[RobotConfig], composed: &Composed) -> String {
    let paint = Paint::stdout();
    let settings = &composed.settings;
    let mut text = format!("{path} is {}\n\n", paint.good("sound"));
    let duration = style::time(Time::from_secs_f64(settings.duration));
    // Writing to a string can't fail.
    let _ = writeln!(text, "mission  {}, {duration} at {} Hz, seed {}", settings.name, settings.control_rate_hz, settings.seed);
    let _ = writeln!(text, "world    {}\n", world.unwrap_or("none"));
    let mut table =
        Table::new([("robot", Align::Left), ("base", Align::Left), ("sonar", Align::Left), ("agents (priority)", Align::Wrap)]);
    let mut rows: Vec<(Vec<&str>, [String; 3])> = Vec::new();
    for (config, plan) in configs.iter().zip(&composed.robots) {
        let make = make(config, plan);
        match rows.last_mut() {
            Some((names, same)) if *same == make => names.push(&config.name),
            _ => rows.push((vec![&config.name], make)),
        }
    }
    for (names, make) in rows {
        let name = match names.as_slice() {
            [first, _, .., last] if names.len() > 3 => format!("{first} ... {last} ({})", names.len()),
            names => names.join(", "),
        };
        table.row([name].into_iter().chain(make));
    }
    text + &table.render(paint, |_, _, cell| cell.to_owned())
}

/// What a robot is made of: base, sonar, agents.
fn make(config: &RobotConfig, plan: &RobotPlan) -> [String; 3] {
    let context = plan.nodes.first().map(|node| &node.context);
    let named = |driver: &str, name: Option<&str>| match name {
        Some(name) if name != driver => format!("{name} ({driver})"),
        _ => driver.to_owned(),
    };
    let base = named(&config.base.name, context.map(|context| context.platform.name.as_str()));
    let ring = context.map(|context| context.ring.name.as_str());
    let sonar = config.sonar.as_ref().map_or_else(|| "none".to_owned(), |sonar| named(&sonar.name, ring));
    let claims = |kind: &str| plan.nodes.iter().any(|node| node.claims && *node.context.node == *kind);
    let agents = config
        .agents
        .iter()
        .map(|agent| if claims(&agent.name) { format!("{} ({})", agent.name, agent.priority) } else { agent.name.clone() });
    [base, sonar, agents.collect::<Vec<_>>().join(", ")]
}

/// Prints the schema of configurations.
pub fn schema() -> Result<Outcome, Refusal> {
    style::print_json(&config::mission::schema(&Registry::standard()));
    Ok(Outcome::Well)
}
