//! `orienteer hardware`: a robot's base and sonar in a process of their own.

use std::time::Duration;

use crate::{
    Registry,
    mission::{self, Recording, RunOptions},
    runtime::config::mission::HardwarePlace,
};

use super::{HardwareArguments, Outcome, Refusal, style, summary::conclude};

/// Runs one robot's hardware until somebody stops it.
pub fn hardware(arguments: &HardwareArguments, registry: &Registry) -> Result<Outcome, Refusal> {
    let loaded = mission::load(&arguments.config, registry)?;
    let elsewhere = loaded.mission.robots.iter().filter(|robot| robot.hardware == HardwarePlace::Elsewhere);
    let robot = match (&arguments.robot, &elsewhere.map(|robot| &robot.name).collect::<Vec<_>>()[..]) {
        (Some(robot), _) => robot.clone(),
        (None, [robot]) => (*robot).clone(),
        (None, []) => {
            let message = "no robot of this mission has its hardware in a process of its own";
            return Err(Refusal::misused(message, "add `hardware = \"elsewhere\"` to the robot"));
        }
        (None, robots) => {
            let names = mission::several(robots);
            return Err(Refusal::misused(
                "several robots of this mission have hardware elsewhere",
                format!("say which with `--robot`: {names}"),
            ));
        }
    };
    let title = format!("hardware of `{robot}`; Ctrl-C ends it\n");
    let options = RunOptions {
        duration: arguments.duration.map(Duration::from_secs_f64),
        record: Recording::Off,
        hardware_of: Some(robot),
        // Where standard output leads nowhere, the end tells.
        ready: Some(Box::new(move || _ = style::print(&title))),
        ..RunOptions::default()
    };
    let ended = mission::run(loaded, registry, options)?;
    let fact = |name| ended.robots.first().and_then(|robot| robot.fact(name)).unwrap_or_default();
    style::print(&format!(
        "{}, driving for {:.1} s; {:.0} commands from missions, {:.0} of them in time for their step, {:.0} later\n",
        ended.time,
        fact("driving_s"),
        fact("pulses_heard"),
        fact("answered"),
        fact("pulses_heard") - fact("answered")
    ))?;
    Ok(conclude(&ended))
}
