//! Exploring floors: does a robot find every place and every corridor, and nothing else?
//!
//! Floors have 10 to 40 places, dead ends and doorways among them, and corridors of Randazza's width (1989). The robot starts in the
//! middle of a corridor and knows nothing. It stands still for who comes near: in corridors in which nobody gets past a robot, one that steps aside is driven about
//! by people who would turn back otherwise. Several robots start in corridors far from each other.

use std::collections::BTreeSet;

use nalgebra::Point2;

use super::{Effort, Row, Suite, SuiteError, in_parallel};
use crate::{
    Registry,
    agents::geographer::export::{PlaceEntry, PlacesFile},
    hardware::world::{
        floors::{Corridor, Floor, FloorSpec, Heading, Place, Truth},
        people::People,
    },
    mission::{self, Recording, RunOptions},
    runtime::{geometry::angle, random::Streams, robot::RobotReport},
};

pub(super) const SUITE: Suite = Suite {
    name: "geographer",
    help: "explores floors of 10 to 40 places: one robot, three robots, one robot among people",
    run,
};

/// Seeds from here on were not looked at while the geographer was made.
const FIRST_SEED: u64 = 5001;
/// A place that was found is that one if it is no farther off, m.
const SAME: f64 = 1.5;
/// Nobody is nearer to a robot when it begins, m.
const ROOM: f64 = 5.0;
/// No floor takes longer, s.
const LONGEST: f64 = 30_000.0;

/// What was found on a floor.
#[derive(Debug, Clone, Default)]
struct Explored {
    places: usize,
    missed: usize,
    phantoms: usize,
    corridors: usize,
    corridors_missed: usize,
    corridors_phantom: usize,
    named_right: usize,
    collisions: u32,
    ended: bool,
    /// Seconds until it ended.
    took: f64,
    /// How far places are off, m, sum.
    off: f64,
    /// Robots whose map is not that of the first.
    other_maps: usize,
}

fn run(effort: &Effort) -> Result<Vec<Row>, SuiteError> {
    let floors = effort.seeds(30);
    let alone = explored(effort, "floors", floors, Party { robots: 1, people: 0 })?;
    let three = explored(effort, "floors, three robots", floors, Party { robots: 3, people: 0 })?;
    let among_people = explored(effort, "floors with people", floors, Party { robots: 1, people: 3 })?;
    let share = |of: &[Explored]| 100.0 * mean(of, |floor| floor.took) / mean(&alone, |floor| floor.took);
    let mut rows = rows_of("one robot", &alone);
    rows.extend(rows_of("three robots", &three));
    let other_maps = three.iter().map(|floor| floor.other_maps).sum::<usize>();
    rows.push(Row::exactly("three robots: robots with another map than the first", 0.0, other_maps as f64, ""));
    rows.push(Row::at_most("three robots: time, as a share of one robot's", 45.0, share(&three), "%"));
    rows.extend(rows_of("one robot, three people", &among_people));
    rows.push(Row::information("one robot, three people: time, as a share of that without", share(&among_people), "%"));
    Ok(rows)
}

/// Who is on a floor.
#[derive(Debug, Clone, Copy)]
struct Party {
    robots: usize,
    people: u32,
}

fn explored(effort: &Effort, what: &str, floors: u64, party: Party) -> Result<Vec<Explored>, SuiteError> {
    in_parallel(effort, what, floors, |number| explore(FIRST_SEED + number, party))
}

fn rows_of(name: &str, floors: &[Explored]) -> Vec<Row> {
    let sum = |figure: fn(&Explored) -> usize| floors.iter().map(figure).sum::<usize>() as f64;
    let places = sum(|floor| floor.places);
    let found = places - sum(|floor| floor.missed);
    let ended = floors.iter().filter(|floor| floor.ended).count() as f64;
    let collisions: u32 = floors.iter().map(|floor| floor.collisions).sum();
    let off: f64 = floors.iter().map(|floor| floor.off).sum();
    vec![
        Row::information(format!("{name}: floors"), floors.len() as f64, ""),
        Row::information(format!("{name}: places"), places, ""),
        Row::exactly(format!("{name}: places missed"), 0.0, sum(|floor| floor.missed), ""),
        Row::exactly(format!("{name}: places that are none"), 0.0, sum(|floor| floor.phantoms), ""),
        Row::information(format!("{name}: corridors"), sum(|floor| floor.corridors), ""),
        Row::exactly(format!("{name}: corridors missed"), 0.0, sum(|floor| floor.corridors_missed), ""),
        Row::exactly(format!("{name}: corridors that are none"), 0.0, sum(|floor| floor.corridors_phantom), ""),
        Row::at_least(format!("{name}: named right"), 99.0, 100.0 * sum(|floor| floor.named_right) / found.max(1.0), "%"),
        Row::information(format!("{name}: places off by, mean"), 100.0 * off / found.max(1.0), "cm"),
        Row::exactly(format!("{name}: collisions"), 0.0, f64::from(collisions), ""),
        Row::exactly(format!("{name}: ended by itself"), floors.len() as f64, ended, ""),
        Row::information(format!("{name}: time per place, mean"), mean(floors, |floor| floor.took / floor.places as f64), "s"),
    ]
}

fn mean(floors: &[Explored], figure: impl Fn(&Explored) -> f64) -> f64 {
    floors.iter().map(figure).sum::<f64>() / floors.len().max(1) as f64
}

/// Explores one floor.
fn explore(seed: u64, party: Party) -> Result<Explored, SuiteError> {
    let spec = FloorSpec { places: Some(10 + (seed % 31) as u32), people: party.people, ..FloorSpec::default() };
    let floor = Floor::generate(seed, &spec).map_err(SuiteError::from_display)?;
    let files = [("tour.toml".to_owned(), mission(&floor, seed, party.robots)), ("floor.toml".to_owned(), floor.text())];
    let files = files.map(|(name, text)| (name, text.into_bytes()));
    let registry = Registry::standard();
    let loaded = mission::load_files(files, "tour.toml", &registry).map_err(SuiteError::from_display)?;
    let options = RunOptions { threads: Some(1), record: Recording::Off, ..RunOptions::default() };
    let outcome = mission::run(loaded, &registry, options).map_err(SuiteError::from_display)?;
    let maps = outcome.robots.iter().map(map_of).collect::<Result<Vec<_>, _>>()?;
    let map = maps.first().ok_or_else(|| SuiteError("the mission had no robot".into()))?;
    let ended: Vec<Option<f64>> = outcome.robots.iter().map(|robot| robot.fact("explored_s")).collect();
    let explored = Explored {
        collisions: outcome.robots.iter().map(|robot| robot.fact("collisions").unwrap_or_default() as u32).sum(),
        ended: ended.iter().all(Option::is_some),
        took: ended.iter().map(|at| at.unwrap_or(LONGEST)).fold(0.0, f64::max),
        other_maps: maps.iter().filter(|other| *other != map).count(),
        ..compare(map, &floor.truth)
    };
    tracing::debug!(seed, ?party, ?explored, "floor explored");
    Ok(explored)
}

/// The map that a robot's geographer has left.
fn map_of(robot: &RobotReport) -> Result<PlacesFile, SuiteError> {
    let file = robot.nodes.iter().flat_map(|node| &node.finish.files).find(|file| file.name == "places.json");
    let file = file.ok_or_else(|| SuiteError("the geographer left no map".into()))?;
    serde_json::from_slice(&file.bytes).map_err(SuiteError::from_display)
}

/// Robots in the middle of corridors in which nobody is when they begin: of those as many, and as far apart in the floor's list, as there are robots.
fn mission(floor: &Floor, seed: u64, robots: usize) -> String {
    let middle = |corridor: &Corridor| {
        let at = |end: &str| floor.truth.place(end).map(Place::point);
        let (from, to) = (at(&corridor.from.place)?, at(&corridor.to.place)?);
        Some((nalgebra::center(&from, &to), corridor.from.arm.radians().to_degrees()))
    };
    let people = People::new(&floor.plan.person, &Streams::new(seed));
    let is_free = |at: &Point2<f64>| people.bodies().iter().all(|body| (body.disc.center - at).norm() > ROOM);
    let starts: Vec<_> = floor.truth.corridors.iter().filter_map(middle).filter(|(at, _)| is_free(at)).collect();
    let start = |number: usize| starts.get(number * starts.len() / robots).copied().unwrap_or((Point2::origin(), 0.0));
    let head = format!("[mission]\nduration = {LONGEST}\nseed = {seed}\nlinks = \"direct\"\n\n[world]\nfile = \"floor.toml\"\n");
    (0..robots).fold(head, |text, number| text + &robot(number, start(number)))
}

fn robot(number: usize, (at, heading): (Point2<f64>, f64)) -> String {
    format!(
        r#"
[[robot]]
name = "huey-{number}"
base = {{ driver = "sim", platform = "b12-huey" }}
sonar = {{ driver = "sim", ring = "denning-16" }}
start = {{ x = {:?}, y = {:?}, heading_deg = {heading:?} }}

[robot.agent.where-am-i]

[robot.agent.avoidance]
most_steps = 0

[robot.agent.corridor-follower]
cruise_speed = 0.3

[robot.agent.feature-detector]

[robot.agent.place-classifier]

[robot.agent.geographer]
"#,
        at.x, at.y
    )
}

/// Holds a map against the truth.
fn compare(map: &PlacesFile, truth: &Truth) -> Explored {
    let off = |entry: &PlaceEntry, place: usize| (Point2::from(entry.at) - truth.places[place].point()).norm();
    let nearest = |entry: &PlaceEntry| {
        let nearest = (0..truth.places.len()).min_by(|a, b| off(entry, *a).total_cmp(&off(entry, *b)));
        nearest.filter(|place| off(entry, *place) < SAME)
    };
    // Which true place each that was found is; none for the second one at the same place.
    let mut taken = BTreeSet::new();
    let is: Vec<Option<usize>> = map.places.iter().map(|entry| nearest(entry).filter(|place| taken.insert(*place))).collect();
    let right = map.places.iter().zip(&is).filter(|(entry, place)| {
        let seen = place.and_then(|place| truth.places[place].seen_from(from_direction(entry.seen_deg)));
        seen.is_some_and(|hypothesis| hypothesis.id() == entry.kind)
    });
    let number = |name: &str| map.places.iter().position(|entry| entry.name == name).and_then(|found| is[found]);
    let pair = |a: usize, b: usize| (a.min(b), a.max(b));
    let found: Vec<Option<(usize, usize)>> =
        map.corridors.iter().map(|corridor| Some(pair(number(&corridor.from)?, number(&corridor.to)?))).collect();
    let true_number = |name: &str| truth.places.iter().position(|place| place.name == name);
    let true_ones: BTreeSet<(usize, usize)> = truth
        .corridors
        .iter()
        .filter_map(|corridor| Some(pair(true_number(&corridor.from.place)?, true_number(&corridor.to.place)?)))
        .collect();
    let known: BTreeSet<(usize, usize)> = found.iter().flatten().copied().collect();
    Explored {
        places: truth.places.len(),
        missed: truth.places.len() - taken.len(),
        phantoms: is.iter().filter(|place| place.is_none()).count(),
        corridors: true_ones.len(),
        corridors_missed: true_ones.difference(&known).count(),
        corridors_phantom: found.iter().filter(|corridor| corridor.is_none_or(|pair| !true_ones.contains(&pair))).count(),
        named_right: right.count(),
        off: map.places.iter().zip(&is).filter_map(|(entry, place)| place.map(|place| off(entry, place))).sum(),
        ..Explored::default()
    }
}

/// From which side a robot came that went in this direction, degrees.
fn from_direction(deg: f64) -> Heading {
    let back = deg.to_radians() + std::f64::consts::PI;
    let off = |heading: &Heading| angle::turn(heading.radians(), back).abs();
    let all = [Heading::East, Heading::North, Heading::West, Heading::South];
    all.into_iter().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(Heading::East)
}
