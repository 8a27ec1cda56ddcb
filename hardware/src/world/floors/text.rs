//! Worlds as text: what a person would have written, not every key that there is.

use std::{collections::BTreeSet, fmt::Write as _};

use super::{Arm, Corridor, Floor, Hypothesis, JunctionWorld, Perturbation, Place};
use crate::world::plan::{self, Block, Person, Room, WorldPlan, Xy};

/// The file of a floor.
pub(super) fn floor(floor: &Floor) -> String {
    let truth = &floor.truth;
    let mut text = format!("# A floor of {} places, made from seed {}.\n#\n", truth.places.len(), truth.seed);
    for line in floor.sketch.lines() {
        comment(&mut text, line);
    }
    if !floor.sketch.is_empty() {
        text += "#\n";
    }
    text += "# Places, and what each is for a robot that comes from there:\n#\n";
    for place in &truth.places {
        comment(&mut text, &told(place));
    }
    text += "#\n# There is:\n#\n";
    let met: BTreeSet<Hypothesis> = truth.places.iter().flat_map(|place| place.arms.iter().map(|arm| arm.meets)).collect();
    for hypothesis in met.into_iter().filter(|it| *it != Hypothesis::DeadEnd) {
        comment(&mut text, &format!("{hypothesis} {}", hypothesis.title()));
    }
    text += "#\n# Corridors from place to place:\n#\n";
    for Corridor { from, to, length, width } in &truth.corridors {
        comment(
            &mut text,
            &format!("{} {} - {} {}: {length} m, {width} m wide", from.place, from.arm.name(), to.place, to.arm.name()),
        );
    }
    text += "#\n# Its specification:\n#\n";
    for line in toml::to_string(&truth.spec).unwrap_or_default().lines() {
        comment(&mut text, line);
    }
    text + &world(&floor.plan)
}

/// The file of a world with a single place.
pub(super) fn junction(junction: &JunctionWorld) -> String {
    let Perturbation { corridor, opening, wall, length } = junction.perturbation;
    let mut text =
        format!("# {}: {}, for a robot that comes from the south.\n#\n", junction.hypothesis, junction.hypothesis.title());
    text += "# The robot explores it from the place `start`, in the middle of the corridor and 0.08 m before the near line.\n";
    if junction.perturbation != Perturbation::NONE {
        let _ = writeln!(
            text,
            "# Perturbed: corridor x {corridor:.4}, opening x {opening:.4}, wall x {wall:.4}, lengths x {length:.4}."
        );
    }
    text + &world(&junction.plan)
}

fn comment(text: &mut String, line: &str) {
    let _ = writeln!(text, "{}", format!("#   {line}").trim_end());
}

fn told(place: &Place) -> String {
    let arm = |arm: &Arm| format!("{} {}", arm.heading.name(), arm.meets);
    let arms: Vec<String> = place.arms.iter().map(arm).collect();
    format!("{} at [{}, {}]: {}", place.name, place.at[0], place.at[1], arms.join(", "))
}

/// The tables of a plan, of those kinds that floors have.
fn world(plan: &WorldPlan) -> String {
    let mut text = format!("\nname = {}\n", quoted(&plan.name));
    section(&mut text, "corridors", &plan.corridor, corridor);
    section(&mut text, "rooms", &plan.room, room);
    section(&mut text, "boxes", &plan.boxes, block);
    section(&mut text, "people", &plan.person, person);
    section(&mut text, "places", &plan.place, place);
    text
}

fn section<T>(text: &mut String, title: &str, elements: &[T], write: fn(&T) -> String) {
    if !elements.is_empty() {
        let _ = write!(text, "\n# ---- {title}\n");
        text.extend(elements.iter().map(|element| format!("\n{}", write(element))));
    }
}

fn corridor(it: &plan::Corridor) -> String {
    format!("[[corridor]]\n{}along = {}\nwidth = {:?}\n", name(it.name.as_deref()), points(&it.along), it.width)
}

fn room(it: &Room) -> String {
    let door = |door: &plan::Door| format!("{{ at = {}, width = {:?} }}", point(&door.at), door.width);
    let doors: Vec<String> = it.doors.iter().map(door).collect();
    format!("[[room]]\n{}corners = {}\ndoors = [{}]\n", name(it.name.as_deref()), points(&it.corners), doors.join(", "))
}

fn block(it: &Block) -> String {
    format!("[[box]]\n{}center = {}\nsize = {}\n", name(it.name.as_deref()), point(&it.center), point(&Xy(it.size)))
}

fn person(it: &Person) -> String {
    let mut text = format!("[[person]]\n{}path = {}\n", name(it.name.as_deref()), points(&it.path));
    let Person { speed, speed_variation, pause, start, patience, .. } = it;
    let _ = write!(text, "speed = {speed:?}\nspeed_variation = {speed_variation:?}\npause = {pause:?}\nstart = {start:?}\n");
    if it.looping == plan::Loop::Round {
        text += "loop = \"round\"\n";
    }
    if let Some(patience) = patience {
        let _ = writeln!(text, "patience = {patience:?}");
    }
    text
}

fn place(it: &plan::Place) -> String {
    format!("[[place]]\nname = {}\nat = {}\nheading_deg = {}\n", quoted(&it.name), point(&it.at), it.heading_deg)
}

fn name(name: Option<&str>) -> String {
    name.map(|name| format!("name = {}\n", quoted(name))).unwrap_or_default()
}

fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

fn points(all: &[Xy]) -> String {
    format!("[{}]", all.iter().map(point).collect::<Vec<_>>().join(", "))
}

fn point(Xy([x, y]): &Xy) -> String {
    format!("[{x:?}, {y:?}]")
}
