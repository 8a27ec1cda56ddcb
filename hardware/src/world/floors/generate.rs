//! A floor from its seed and specification, step by step.

use std::collections::BTreeMap;

use nalgebra::Point2;
use orienteer_runtime::random::Streams;
use rand::{Rng, seq::SliceRandom};

use super::{
    Corridor, CorridorEnd, Floor, FloorError, FloorSpec, Heading, MOST_LINES, Place, Truth, doorways,
    doorways::{Opening, Room, WALL},
    furniture::{self, Crate, Passage},
    grid::{Grid, Node},
    layout::{self, Layout, Run, Stretch},
    mm, rounds, sketch,
};
use crate::world::{
    geometry::Bounds,
    plan::{self, WorldPlan},
};

/// A corridor between two places, by their numbers.
#[derive(Debug, Clone, Copy)]
struct Link {
    ends: [(usize, Heading); 2],
    width: f64,
}

/// A floor while it grows.
struct Draft {
    layout: Layout,
    corridors: Vec<plan::Corridor>,
    rooms: Vec<Room>,
    places: Vec<Place>,
    links: Vec<Link>,
}

/// The floor of a checked specification, its grid grown until there are as many places as it asks for.
pub(super) fn floor(seed: u64, spec: &FloorSpec) -> Result<Floor, FloorError> {
    let Some(wanted) = spec.places else { return finish(Draft::new(seed, spec), seed, spec) };
    let mut most = 0;
    for (columns, rows) in growing(spec.most_lines()) {
        let grown = FloorSpec { columns, rows, places: None, ..spec.clone() };
        let draft = Draft::new(seed, &grown);
        most = most.max(draft.places.len());
        if draft.places.len() >= wanted as usize {
            return finish(draft, seed, &grown);
        }
    }
    Err(FloorError::TooFewPlaces { wanted, most })
}

/// Grids from two by one on, each with a column or a row more than the last.
fn growing(most: u32) -> impl Iterator<Item = (u32, u32)> {
    (1..=most.min(MOST_LINES)).flat_map(|k| [(k, k.saturating_sub(1)), (k, k)]).filter(|(columns, rows)| columns * rows >= 2)
}

impl Draft {
    fn new(seed: u64, spec: &FloorSpec) -> Self {
        let stream = |purpose: &str| Streams::new(seed).stream("floor", purpose);
        let (columns, rows) = (spec.columns as usize, spec.rows as usize);
        let grid = Grid::thinned(columns, rows, spec.loops, spec.dead_ends, &mut stream("grid"));
        let layout = Layout::new(grid, spec, &mut stream("pitch"), &mut stream("widths"));
        let corridors = layout.runs.iter().filter_map(|run| layout.corridor(run)).collect();
        let mut draft = Self { layout, corridors, rooms: Vec::new(), places: Vec::new(), links: Vec::new() };
        let crossings = draft.add_crossings();
        draft.add_doorways(&crossings, spec, seed);
        draft.number_places();
        draft
    }

    /// The places where corridors meet or end, by their nodes.
    fn add_crossings(&mut self) -> BTreeMap<Node, usize> {
        let mut numbers = BTreeMap::new();
        for node in self.layout.grid.nodes().filter(|node| self.layout.grid.is_junction(*node)) {
            let arm =
                |heading: Heading| (heading, self.layout.width(node, heading).unwrap_or(0.0), self.layout.mouth(node, heading));
            let arms: Vec<_> = self.layout.grid.arms(node).map(arm).collect();
            if let Some(place) = Place::new(self.layout.at(node), &arms, Vec::new()) {
                numbers.insert(node, self.places.len());
                self.places.push(place);
            }
        }
        numbers
    }

    /// Doorways beside the corridors that have room for them, and the corridors between all places.
    fn add_doorways(&mut self, crossings: &BTreeMap<Node, usize>, spec: &FloorSpec, seed: u64) {
        let mut random = Streams::new(seed).stream("floor", "doorways");
        let mut taken: Vec<Bounds> = self.corridors.iter().filter_map(layout::ground).collect();
        for Stretch { heading, ends: [first, last], width } in self.layout.stretches().collect::<Vec<_>>() {
            let (Some(&start), Some(&end)) = (crossings.get(&first), crossings.get(&last)) else { continue };
            let origin = self.layout.at(first);
            let length = (self.layout.at(last) - origin).norm();
            let mouths = (self.layout.mouth(first, heading), length - self.layout.mouth(last, heading));
            let mut numbers = vec![start];
            for along in doorways::along(mouths.0, mouths.1, spec, &mut random) {
                let at = origin + heading.vector() * along;
                let opening = Opening { at, corridor: width, width: spec.door_width, thickness: WALL };
                let Some(rooms) = opening.draw(heading, &taken, &mut random) else { continue };
                let mouth = 0.5 * spec.door_width;
                let arms =
                    if heading == Heading::East { [Heading::East, Heading::West] } else { [Heading::North, Heading::South] };
                let doorways = rooms.iter().map(|room| room.doorway).collect();
                let Some(place) = Place::new(at, &arms.map(|arm| (arm, width, mouth)), doorways) else { continue };
                numbers.push(self.places.len());
                self.places.push(place);
                taken.extend(rooms.iter().map(|room| room.ground));
                self.rooms.extend(rooms);
            }
            numbers.push(end);
            self.links.extend(numbers.windows(2).map(|w| Link { ends: [(w[0], heading), (w[1], heading.back())], width }));
        }
    }

    /// Numbers the places as one reads: from the north-west, row by row.
    fn number_places(&mut self) {
        let mut order: Vec<usize> = (0..self.places.len()).collect();
        let [x, y] = [0, 1].map(|axis| self.places.iter().map(|place| place.at[axis]).collect::<Vec<_>>());
        order.sort_by(|a, b| y[*b].total_cmp(&y[*a]).then(x[*a].total_cmp(&x[*b])));
        let mut number = vec![0; order.len()];
        for (new, old) in order.iter().enumerate() {
            number[*old] = new;
        }
        self.places = order.iter().map(|old| self.places[*old].clone()).collect();
        for (i, place) in self.places.iter_mut().enumerate() {
            place.name = format!("p{}", i + 1);
        }
        for (end, _) in self.links.iter_mut().flat_map(|link| &mut link.ends) {
            *end = number[*end];
        }
        self.links.sort_by_key(|link| link.ends.map(|(number, _)| number));
    }

    /// The corridors, called after the places at their ends.
    fn named_corridors(&self) -> Vec<plan::Corridor> {
        let called = |node: Option<&Node>| {
            let at = node.map(|node| self.layout.at(*node));
            self.places.iter().find(|place| Some(place.point()) == at).map_or("?", |place| &place.name)
        };
        let named = |(corridor, run): (&plan::Corridor, &Run)| {
            let name = format!("{} to {}", called(run.nodes.first()), called(run.nodes.last()));
            plan::Corridor { name: Some(name), ..corridor.clone() }
        };
        self.corridors.iter().zip(&self.layout.runs).map(named).collect()
    }

    /// The rooms, called after the places at which they open.
    fn named_rooms(&self) -> Vec<plan::Room> {
        let named = |room: &Room| {
            let place = self.places.iter().find(|place| place.doorways.contains(&room.doorway));
            plan::Room { name: place.map(|place| format!("room at {}", place.name)), ..room.plan() }
        };
        self.rooms.iter().map(named).collect()
    }

    /// The corridor of a link between the mouths of its places.
    fn passage(&self, link: &Link) -> Passage {
        let [(a, heading), (b, back)] = link.ends;
        let mouth = |place: &Place, arm: Heading| place.arm(arm).map_or(0.0, |arm| arm.mouth);
        let [first, last] = [&self.places[a], &self.places[b]];
        let from = first.point() + heading.vector() * mouth(first, heading);
        let to = last.point() + back.vector() * mouth(last, back);
        Passage { from, heading, length: (to - from).norm(), width: link.width }
    }

    /// Who walks through a link: round the floor through it, or to and fro where no way leads round.
    fn walker(&self, through: usize, passages: &[Passage], crates: &[Option<Crate>], random: &mut impl Rng) -> plan::Person {
        let along = |link: usize| furniture::way_along(&passages[link], crates[link].as_ref());
        let Some(round) = self.round(through, random) else {
            return furniture::walker(&along(through), plan::Loop::BackAndForth, random);
        };
        let mut path = Vec::new();
        for (place, link) in round {
            path.push(self.places[place].point());
            // Past a box there is one way; elsewhere it is straight.
            if crates[link].is_some() {
                let mut past = along(link);
                if self.links[link].ends[0].0 != place {
                    past.reverse();
                }
                path.extend(past);
            }
        }
        furniture::walker(&path, plan::Loop::Round, random)
    }

    /// The places and links of a way round through a link, if there is one.
    fn round(&self, through: usize, random: &mut impl Rng) -> Option<Vec<(usize, usize)>> {
        let ends: Vec<[usize; 2]> = self.links.iter().map(|link| link.ends.map(|(place, _)| place)).collect();
        rounds::round(through, &ends, random)
    }

    /// The corridor of a link as the ground truth has it.
    fn corridor(&self, link: &Link) -> Corridor {
        let [from, to] = link.ends.map(|(place, arm)| CorridorEnd { place: self.places[place].name.clone(), arm });
        let [a, b]: [Point2<f64>; 2] = link.ends.map(|(place, _)| self.places[place].point());
        Corridor { from, to, length: mm((b - a).norm()), width: mm(link.width) }
    }
}

/// Puts furniture and people into a draft, and says what has come of it.
fn finish(draft: Draft, seed: u64, spec: &FloorSpec) -> Result<Floor, FloorError> {
    let count = draft.links.len();
    if spec.people as usize > count {
        return Err(FloorError::Crowded { people: spec.people, corridors: count });
    }
    let stream = |purpose: &str| Streams::new(seed).stream("floor", purpose);
    let passages: Vec<Passage> = draft.links.iter().map(|link| draft.passage(link)).collect();
    let (mut boxes, mut people) = (stream("boxes"), stream("people"));
    let crates: Vec<Option<Crate>> = passages.iter().map(|passage| Crate::draw(passage, spec, &mut boxes)).collect();
    let mut order: Vec<usize> = (0..count).collect();
    order.shuffle(&mut people);
    // Whoever walks to and fro shuts itself up behind a robot.
    order.sort_by_key(|link| draft.round(*link, &mut stream("rounds")).is_none());
    let walked = order.into_iter().take(spec.people as usize);
    let name = format!("floor {seed}");
    let place = |place: &Place| plan::Place {
        name: place.name.clone(),
        at: plan::Xy(place.at),
        heading_deg: place.arms.first().map_or(0.0, |arm| arm.heading.degrees()),
    };
    let plan = WorldPlan {
        name: name.clone(),
        corridor: draft.named_corridors(),
        room: draft.named_rooms(),
        boxes: passages.iter().zip(&crates).filter_map(|(passage, it)| it.map(|it| it.plan(passage))).collect(),
        person: walked.map(|link| draft.walker(link, &passages, &crates, &mut people)).collect(),
        place: draft.places.iter().map(place).collect(),
        ..WorldPlan::default()
    };
    let corridors = draft.links.iter().map(|link| draft.corridor(link)).collect();
    let sketch = sketch::draw(&draft.layout, &draft.places);
    Ok(Floor { plan, truth: Truth { name, seed, spec: spec.clone(), places: draft.places, corridors }, sketch })
}
