//! The simulated world of a mission, and where in its files something is wrong.

use std::{cell::RefCell, io, path::Path, sync::Arc};

use orienteer_hardware::{
    sim::Arena,
    world::{World, WorldError, plan::WorldPlan},
};
use orienteer_runtime::{
    config::{
        Problem, Problems, Section, Sources, Span,
        document::Data,
        mission::{WorldConfig, WorldKind},
        suggest, validate,
    },
    geometry::Pose,
    random::Streams,
};

/// Reads the world of a mission and makes it ready to move.
///
/// # Errors
/// Whatever is wrong with its file or a map that it names, at its place.
pub(crate) fn open_world(config: &WorldConfig, sources: &mut Sources, streams: Streams) -> Result<Arc<Arena>, Problems> {
    let (section, plan, at): (_, WorldPlan, _) = match config.kind {
        WorldKind::File => {
            let section = Section::parse(sources, config.source)?;
            let plan = validate::read(&section, sources)?;
            (Some(section), plan, sources.start_of(config.source))
        }
        WorldKind::Map => (None, map_world(config), config.span.clone()),
    };
    let shared = RefCell::new(sources);
    let read = |path: &Path| -> io::Result<Vec<u8>> {
        let mut sources = shared.borrow_mut();
        let source = sources.read_for(&path.to_string_lossy(), &at).map_err(|problem| io::Error::other(problem.to_string()))?;
        Ok(sources.bytes(source).to_vec())
    };
    let world = World::from_plan(&plan, &read);
    let sources = shared.into_inner();
    let world = world.map_err(|error| {
        let place = section.as_ref().and_then(|section| place_of(&error, section));
        let place = place.unwrap_or_else(|| config.span.clone());
        in_map(&error, &place, sources)
            .unwrap_or_else(|| refuse(sources, config, &place, format!("the world does not work out: {error}"), hint_for(&error)))
    })?;
    let far = "bring its walls nearer to the origin";
    Ok(Arena::new(world, streams).map_err(|error| refuse(sources, config, &config.span, error.to_string(), far))?)
}

/// A place of the world by its name; otherwise what is wrong and a hint.
pub(crate) fn find_place(arena: Option<&Arena>, name: &str) -> Result<Pose, (String, String)> {
    let places = arena.map_or(&[][..], |arena| &arena.world().places);
    if let Some(place) = places.iter().find(|place| place.name == name) {
        return Ok(place.pose);
    }
    let names = places.iter().map(|place| place.name.as_str());
    let hint = if places.is_empty() { "the world names no places".to_owned() } else { suggest::hint(name, "there are", names) };
    Err((format!("there is no place `{name}` in the world"), hint))
}

fn refuse(sources: &Sources, config: &WorldConfig, at: &Span, message: String, hint: &str) -> Problem {
    let problem = Problem::new(sources, at, message, hint);
    if *at == config.span { problem } else { problem.note(sources, &config.span, "the mission names this world here") }
}

/// What is wrong inside the file of a map that is named at `named`.
fn in_map(error: &WorldError, named: &Span, sources: &mut Sources) -> Option<Problem> {
    let WorldError::Map { path, reason, .. } = error else { return None };
    let place = reason.place()?;
    let file = sources.read_for(&path.to_string_lossy(), named).ok()?;
    let start = sources.start_of(file).start;
    let hint =
        "a map has `image`, `resolution`, `origin`, `occupied_thresh` and `free_thresh`, as the ROS map server writes them";
    let problem = Problem::new(sources, &(start + place.start..start + place.end), reason.to_string(), hint);
    Some(problem.note(sources, named, "the map is named here"))
}

/// Where the element of a world file stands that an error is about; the very key, if the error begins with its name.
fn place_of(error: &WorldError, file: &Section) -> Option<Span> {
    let element = error.element()?;
    let value = file.table().get(element.table)?;
    let (table, span) = match (value.get_ref(), element.index) {
        (Data::List(tables), Some(index)) => {
            let table = tables.get(index)?;
            (table.get_ref().as_table()?, table.span())
        }
        (Data::Table(table), None) => (table, value.span()),
        _ => return None,
    };
    let key = match error {
        WorldError::Element { problem, .. } => problem.split(' ').next().and_then(|word| table.get(word)),
        _ => table.get("file"),
    };
    Some(key.map_or(span, |value| value.span()))
}

fn hint_for(error: &WorldError) -> &'static str {
    match error.element().map(|element| element.table) {
        Some("place") => "give the place another name, or move it into free space",
        Some("person") => "move the waypoints away from walls and furniture by more than the person's radius",
        Some("room" | "wall") => "correct its outline; a door stands on a wall, away from corners, with free space behind it",
        Some("corridor" | "polygon" | "box" | "disc") => "correct its numbers; they are in metres and degrees",
        Some("map" | "image") => "name a map that can be read, relative to the world's file",
        _ => "correct the world's file",
    }
}

/// A world that is nothing but a map.
fn map_world(config: &WorldConfig) -> WorldPlan {
    WorldPlan {
        name: config.path.clone(),
        map: Some(orienteer_hardware::world::plan::RosMap::of(&config.path)),
        ..WorldPlan::default()
    }
}
