//! `orienteer check` and `orienteer schema`.

use std::fmt::Write as _;

use super::{
    CheckArguments, Outcome, Refusal, SchemaArguments,
    style::{self, Paint},
    table::{Align, Table},
};
use crate::{
    Registry,
    hardware::world::plan::WorldPlan,
    mission::{self, Composed, Remark},
    runtime::{
        config::{self, mission::RobotConfig, validate},
        robot::RobotPlan,
        time::Time,
    },
};

/// Checks a configuration: all that `run` does before anything moves.
pub fn check(arguments: &CheckArguments, registry: &Registry) -> Result<Outcome, Refusal> {
    let (remarks, text) = examine(arguments, registry)?;
    if arguments.json {
        style::print_json(&serde_json::json!({ "ok": true, "problems": [], "remarks": remarks }))?;
    } else {
        style::print(&text)?;
    }
    Ok(Outcome::Well)
}

fn examine(arguments: &CheckArguments, registry: &Registry) -> Result<(Vec<Remark>, String), Refusal> {
    let mut loaded = mission::load(&arguments.config, registry)?;
    // The very mission may be running under its name.
    loaded.mission.settings.run = None;
    let configs = loaded.mission.robots.clone();
    let world = loaded.mission.world.as_ref().map(|world| world.path.clone());
    let seed = loaded.mission.settings.seed;
    let composed = mission::compose(loaded, registry, seed)?;
    let path = arguments.config.display();
    let text = describe(&path.to_string(), world.as_deref(), &configs, &composed);
    Ok((composed.remarks, text))
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
        table.row([mission::several(&names)].into_iter().chain(make));
    }
    text += &table.render(paint, |_, _, cell| cell.to_owned());
    for remark in &composed.remarks {
        let line = style::wrap(&format!("remark: {remark}"), 2);
        let _ = writeln!(text, "\n{}", line.replacen("remark", &paint.bad("remark"), 1));
    }
    text
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

/// Prints the schema of missions or worlds.
pub fn schema(arguments: &SchemaArguments, registry: &Registry) -> Result<Outcome, Refusal> {
    if arguments.of == "world" {
        style::print_json(&validate::schema_of::<WorldPlan>())?;
    } else {
        style::print_json(&config::mission::schema(registry))?;
    }
    Ok(Outcome::Well)
}
