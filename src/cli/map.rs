//! `orienteer map`: the map, drawn again from what a recording holds.

use std::time::Instant;

use crate::{
    Registry,
    agents::mapper::{
        Config, Mapper,
        files::{self, Mode},
        picture::{self, PictureStyle},
    },
    mission::{self, Composed},
    runtime::{
        agent::RobotContext,
        config::{mission::ClockKind, validate},
        recording::Reader,
        time::Time,
        topics::{PoseEstimate, SonarScan},
    },
};

use super::{
    MapArguments, Outcome, Refusal,
    style::{self, Paint},
    table::{Align, Table},
    verify,
};

/// Draws the maps of a recording's robots.
pub fn map(arguments: &MapArguments, registry: &Registry) -> Result<Outcome, Refusal> {
    let reader = verify::open(&arguments.recording)?;
    let robots = robots(&reader, arguments.robot.as_deref())?;
    let (configs, composed) = settings(&reader, arguments, registry)?;
    let paint = Paint::stdout();
    let columns = [("map", Align::Left), ("scans", Align::Right), ("free cells", Align::Right), ("occupied cells", Align::Right)];
    let columns = columns.into_iter().chain([("free ground", Align::Right), ("drawn in", Align::Right)]);
    let mut table = Table::new(columns);
    let mut written = Vec::new();
    for robot in &robots {
        let started = Instant::now();
        let Some(context) = context(&composed, robot) else { continue };
        let config = configs.iter().find(|(name, _)| name == robot).map(|(_, config)| config.clone()).unwrap_or_default();
        let (mapper, scans) = draw(&reader, robot, config, context)?;
        // As `run` names them.
        let directory = arguments.out.join(robot);
        std::fs::create_dir_all(&directory).map_err(|error| {
            let message = format!("the output directory `{}` can't be used: {error}", directory.display());
            Refusal::failed(message, "name another directory with `--out`")
        })?;
        let stem = directory.join("map");
        let picture = directory.join("map-picture.png");
        let saved = files::save(mapper.grid(), &stem, Mode::Trinary)
            .and_then(|saved| picture::save(mapper.grid(), mapper.path(), PictureStyle::default(), &picture).map(|()| saved))
            .map_err(|error| Refusal::failed(error.to_string(), "look at the disk, or name another directory with `--out`"))?;
        let summary = &saved.summary;
        table.row([
            robot.clone(),
            scans.to_string(),
            summary.free.to_string(),
            summary.occupied.to_string(),
            format!("{:.1} m²", summary.free_area),
            format!("{:.2} s", started.elapsed().as_secs_f64()),
        ]);
        written.extend([saved.image, saved.yaml, picture]);
    }
    let mut text = table.render(paint, |_, _, cell| cell.to_owned());
    text.push_str(&format!("\n{}\n", paint.bold("written")));
    for file in written {
        text.push_str(&format!("{}\n", file.display()));
    }
    style::print(&text)?;
    Ok(Outcome::Well)
}

/// The robots to draw maps for: the one asked for, or all that know where they are and have heard something.
fn robots(reader: &Reader, asked: Option<&str>) -> Result<Vec<String>, Refusal> {
    let able = |robot: &str| -> Result<bool, Refusal> {
        let poses = reader.messages::<PoseEstimate>(robot)?.next().transpose()?;
        let scans = reader.messages::<SonarScan>(robot)?.next().transpose()?;
        Ok(poses.is_some() && scans.is_some())
    };
    let names = match asked {
        Some(name) => vec![name.to_owned()],
        None => reader.mission().robots.iter().map(|robot| robot.name.clone()).collect(),
    };
    let mut found = Vec::new();
    for name in names {
        if able(&name)? {
            found.push(name);
        }
    }
    if found.is_empty() {
        let who = asked.map_or_else(|| "no robot of the recording".to_owned(), |name| format!("`{name}`"));
        let message = format!("there is nothing to draw: {who} has both poses and sonar scans");
        let message = if asked.is_some() { message.replace(" has both", " does not have both") } else { message };
        return Err(Refusal::misused(message, "a robot needs a sonar and the agent `where-am-i`"));
    }
    Ok(found)
}

/// Each robot's settings for the mapper, if it has one, and what is known of the robots.
fn settings(
    reader: &Reader,
    arguments: &MapArguments,
    registry: &Registry,
) -> Result<(Vec<(String, Config)>, Composed), Refusal> {
    let mut loaded = verify::load(reader, registry)?;
    // Real devices are refused then. They must not be opened for a picture.
    loaded.mission.settings.clock = ClockKind::Lockstep;
    let mut configs = Vec::new();
    for robot in &loaded.mission.robots {
        if arguments.robot.as_ref().is_some_and(|name| *name != robot.name) {
            continue;
        }
        if let Some(agent) = robot.agents.iter().find(|agent| agent.kind == "mapper") {
            configs.push((robot.name.clone(), validate::read::<Config>(&agent.section, &loaded.sources)?));
        }
    }
    let composed = mission::compose(loaded, registry, reader.mission().seed)?;
    Ok((configs, composed))
}

fn context<'a>(composed: &'a Composed, robot: &str) -> Option<&'a RobotContext> {
    let plan = composed.robots.iter().find(|plan| *plan.name == *robot)?;
    plan.nodes.first().map(|node| &node.context)
}

/// Shows the mapper poses and scans as it would have seen them on the robot: step by step, poses first.
fn draw(reader: &Reader, robot: &str, config: Config, context: &RobotContext) -> Result<(Mapper, u64), Refusal> {
    let every = u64::from(config.every.max(1));
    let mut mapper = Mapper::new(config, &context.ring, context.start).map_err(|error| {
        Refusal::misused(format!("the mapper of `{robot}` can't be built: {error}"), "correct its parameters and record again")
    })?;
    let mut poses = reader.messages::<PoseEstimate>(robot)?.peekable();
    let mut heard = 0;
    for scan in reader.messages::<SonarScan>(robot)? {
        let (now, scan) = scan?;
        follow(&mut mapper, &mut poses, now)?;
        if u64::is_multiple_of(heard, every) {
            mapper.scan(&scan);
        }
        heard += 1;
    }
    follow(&mut mapper, &mut poses, Time::FAR)?;
    Ok((mapper, heard))
}

type Poses<'r> = std::iter::Peekable<crate::runtime::recording::Messages<'r, PoseEstimate>>;

/// Tells the mapper all poses up to a time.
fn follow(mapper: &mut Mapper, poses: &mut Poses<'_>, until: Time) -> Result<(), Refusal> {
    while let Some(next) = poses.next_if(|next| next.as_ref().map_or(true, |(at, _)| *at <= until)) {
        let (_, estimate) = next?;
        mapper.track(estimate.stamp, estimate.pose);
    }
    Ok(())
}
