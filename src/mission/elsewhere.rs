//! Hardware that has a process of its own: which robot's, under which name, and what stands in for it.

use orienteer_hardware::remote::{Presence, RemoteBase, RemoteHardware, RemoteSonar, run_of};
use orienteer_runtime::{
    agent::{Phase, RobotContext, Wiring},
    clock::Epoch,
    config::{
        Mission, Problem, Problems, Sources,
        mission::{ClockKind, HardwarePlace, MissionKeys, RobotConfig},
        suggest,
    },
    host::{Factory, NodePlan},
    topics::{ClientId, Fingerprint},
};

use super::compose::{BASE, SONAR, once};

/// The robot of this name, if its hardware is elsewhere.
pub(super) fn find<'a>(mission: &'a Mission, robot: &str, sources: &Sources) -> Result<&'a RobotConfig, Problems> {
    let Some(config) = mission.robots.iter().find(|config| config.name == robot) else {
        let hint = suggest::hint(robot, "its robots are", mission.robots.iter().map(|robot| robot.name.as_str()));
        return Err(Problem::nowhere(format!("the mission has no robot `{robot}`"), hint).into());
    };
    if config.hardware == HardwarePlace::Here {
        let message = format!("the hardware of `{robot}` belongs to the mission's own process");
        let hint = "add `hardware = \"elsewhere\"` to the robot";
        return Err(Problem::new(sources, &config.span, message, hint).into());
    }
    Ok(config)
}

/// The name of the run that the hardware owns.
pub(super) fn run(settings: &MissionKeys, config: &RobotConfig, sources: &Sources) -> Result<String, Problems> {
    if settings.clock != ClockKind::Wall {
        let message =
            format!("the hardware of `{}` has a process of its own, but the mission does not run on real time", config.name);
        let hint = "set `clock = \"wall\"` in `[mission]`, and give no `speed`";
        return Err(Problem::new(sources, &config.span, message, hint).into());
    }
    let name = settings.run.as_ref().unwrap_or(&settings.name);
    let run = run_of(name, &config.name);
    let fits = run.len() <= 64 && run.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"-_.".contains(&byte));
    if fits {
        return Ok(run);
    }
    let message = format!(
        "the name `{run}`, under which mission and hardware meet, is too long or has other characters than letters, digits, `-`, `_` and `.`"
    );
    Err(Problem::new(sources, &config.span, message, "give the mission a short `run = \"…\"`").into())
}

/// The nodes that stand in for base and sonar.
pub(super) fn stand_ins(hardware: RemoteHardware, of_node: impl Fn(u16) -> RobotContext) -> Vec<NodePlan> {
    let (base, sonar) = (of_node(BASE), of_node(SONAR));
    let (period, has_line, of_sonar) = (base.period, hardware.has_line, hardware.clone());
    vec![
        plan(
            base,
            vec![Phase::Sense, Phase::Act],
            RemoteBase::wiring(has_line),
            once(move || Ok(RemoteBase::new(hardware, period))),
        ),
        plan(sonar, vec![Phase::Sense], RemoteSonar::wiring(), once(move || Ok(RemoteSonar::new(of_sonar)))),
    ]
}

/// The node beside base and sonar that says that they live.
pub(super) fn presence(context: &RobotContext, epoch: &Epoch, fingerprint: Fingerprint) -> NodePlan {
    let context = RobotContext { node: "presence".into(), client: ClientId::NONE, ..context.clone() };
    let epoch = epoch.clone();
    plan(
        context,
        vec![Phase::Sense, Phase::Act],
        Presence::wiring(),
        Box::new(move |_| Ok(Box::new(Presence::new(epoch.clone(), fingerprint)))),
    )
}

fn plan(context: RobotContext, phases: Vec<Phase>, wiring: Wiring, factory: Factory) -> NodePlan {
    let deadline = context.period;
    NodePlan { context, phases, wiring, claims: false, deadline, factory }
}
