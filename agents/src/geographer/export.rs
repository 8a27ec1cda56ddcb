//! The map of places as files.

use std::fmt::Write as _;

use serde::{Deserialize, Serialize};

use super::{Arm, Quarter, TopologicalMap};

/// The map, as `places.json` has it. Lengths in m, angles in degrees to the left of x.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PlacesFile {
    /// All places, in the order in which they were found.
    pub places: Vec<PlaceEntry>,
    /// All corridors.
    pub corridors: Vec<CorridorEntry>,
}

/// A place in `places.json`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PlaceEntry {
    /// Its name.
    pub name: String,
    /// What it is, for who comes to it in the direction `seen_deg`.
    pub kind: String,
    /// The same for people.
    pub title: String,
    /// How probable that is.
    pub belief: f64,
    /// Direction of the robot that saw it first, degrees.
    pub seen_deg: f64,
    /// Its middle.
    pub at: [f64; 2],
    /// Covariance of `at`: xx, xy, yy, m².
    pub covariance: [f64; 3],
    /// Directions in which corridors lead away, degrees.
    pub ways_deg: Vec<f64>,
    /// Directions of those of them that were not gone.
    pub left_deg: Vec<f64>,
    /// How often it was come to.
    pub visits: u32,
}

/// A corridor in `places.json`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct CorridorEntry {
    /// The place where it begins.
    pub from: String,
    /// The place where it ends.
    pub to: String,
    /// Its direction, degrees.
    pub heading_deg: f64,
    /// From middle to middle.
    pub length: f64,
}

/// The map as data.
#[must_use]
pub fn file(map: &TopologicalMap) -> PlacesFile {
    let compass = map.compass();
    let degrees = |quarter: Quarter| compass.map_or(0.0, |compass| round(compass.heading(quarter).to_degrees()));
    let places = map.places().map(|(_, place)| {
        let ways = |chosen: fn(Arm) -> bool| {
            let open = Quarter::ALL.into_iter().filter(|quarter| chosen(place.arms[quarter.index()]));
            open.map(degrees).collect()
        };
        PlaceEntry {
            name: place.name.clone(),
            kind: place.kind.clone(),
            title: place.title.clone(),
            belief: round(place.belief),
            seen_deg: degrees(place.seen),
            at: [place.at.x, place.at.y].map(round),
            covariance: [place.covariance.m11, place.covariance.m12, place.covariance.m22],
            ways_deg: ways(|arm| matches!(arm, Arm::Leads | Arm::Unexplored)),
            left_deg: ways(|arm| arm == Arm::Unexplored),
            visits: place.visits,
        }
    });
    let name = |place| map.place(place).map(|place| place.name.clone()).unwrap_or_default();
    let corridors = map.corridors().map(|corridor| CorridorEntry {
        from: name(corridor.from.0),
        to: name(corridor.to.0),
        heading_deg: degrees(corridor.from.1),
        length: round(corridor.length),
    });
    PlacesFile { places: places.collect(), corridors: corridors.collect() }
}

/// The map as JSON, see [`PlacesFile`].
///
/// # Errors
/// If a number is none.
pub fn json(map: &TopologicalMap) -> Result<String, serde_json::Error> {
    let mut text = serde_json::to_string_pretty(&file(map))?;
    text.push('\n');
    Ok(text)
}

/// A line for each place, for the summary: what it is, where, and where its corridors lead.
#[must_use]
pub fn lines(map: &TopologicalMap) -> Vec<String> {
    let PlacesFile { places, corridors } = file(map);
    let leads = |name: &str| {
        let to = corridors.iter().filter_map(|corridor| match (corridor.from == name, corridor.to == name) {
            (true, _) => Some(format!("{} {:.1} m", corridor.to, corridor.length)),
            (_, true) => Some(format!("{} {:.1} m", corridor.from, corridor.length)),
            _ => None,
        });
        to.collect::<Vec<_>>().join(", ")
    };
    let line = |place: &PlaceEntry| {
        let [x, y] = place.at;
        let sure = 100.0 * place.belief;
        format!("{}: {}, {sure:.1} % sure, at ({x:.1}, {y:.1}); to {}", place.name, place.title, leads(&place.name))
    };
    places.iter().map(line).collect()
}

/// The map for GraphViz: `neato -n places.dot` puts places where they are.
#[must_use]
pub fn dot(map: &TopologicalMap) -> String {
    /// GraphViz counts in points; so many for a metre.
    const POINTS: f64 = 24.0;
    let PlacesFile { places, corridors } = file(map);
    let mut text = String::from("graph places {\n  node [shape=box, style=rounded, fontsize=10];\n");
    for place in places {
        let [x, y] = place.at.map(|along| along * POINTS);
        let title = place.title.replace('\\', "\\\\").replace('"', "\\\"");
        let _ = writeln!(
            text,
            "  {} [label=\"{}\\n{title}\\n{:.0} %\", pos=\"{x:.0},{y:.0}\"];",
            place.name,
            place.name,
            100.0 * place.belief
        );
    }
    for CorridorEntry { from, to, length, .. } in corridors {
        let _ = writeln!(text, "  {from} -- {to} [label=\"{length:.1} m\"];");
    }
    text.push_str("}\n");
    text
}

/// To tenths of millimetres, and tenths of thousandths of degrees.
fn round(value: f64) -> f64 {
    // Adding 0 turns -0 into 0.
    (value * 1e4).round() / 1e4 + 0.0
}
