//! The topological map: places, and the corridors between them (Kuipers & Byun 1988).
//!
//! A place has an arm in each of four directions. An arm is closed, or a corridor that leads somewhere, or one that nobody has gone yet. A place is recognised by where it
//! is, within what the robot's reckoning may be off, and by the arm that it is entered by.

mod change;
#[cfg(test)]
mod tests;

use nalgebra::{Matrix2, Point2, Vector2};
use petgraph::{
    algo::astar,
    graph::{EdgeIndex, EdgeReference, NodeIndex, UnGraph},
    visit::{EdgeFiltered, EdgeRef},
};

pub use change::{Change, Effect};

use super::compass::{Compass, Quarter};

/// What an arm of a place is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arm {
    /// A wall, or a doorway.
    Closed,
    /// A corridor that nobody has gone yet.
    Unexplored,
    /// A corridor to another place.
    Leads,
    /// A corridor, as it was said, that could not be gone, so many times.
    GivenUp(u32),
}

/// A place.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// A, B, C and so on, in the order in which they were found.
    pub name: String,
    /// Its middle, map frame, m.
    pub at: Point2<f64>,
    /// Covariance of `at`, m².
    pub covariance: Matrix2<f64>,
    /// What it is, by its name in the catalogue, as seen by a robot that goes in the direction `seen`.
    pub kind: String,
    /// The same for people.
    pub title: String,
    /// How probable that is.
    pub belief: f64,
    /// In which direction the robot went that saw it first.
    pub seen: Quarter,
    /// By direction.
    pub arms: [Arm; 4],
    /// How often it has been come to.
    pub visits: u32,
}

/// A way out of a place: the place, and the arm.
pub type Exit = (NodeIndex, Quarter);

/// A corridor between two places.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corridor {
    /// From the middle of one place to that of the other, m.
    pub length: f64,
    /// The place that it was gone from first, and the arm.
    pub from: Exit,
    /// The place that it leads to, and the arm.
    pub to: Exit,
}

/// Legs of a way: the places to leave, each with the arm to leave by.
pub type Route = Vec<Exit>;

/// Places and corridors.
#[derive(Debug, Clone, Default)]
pub struct TopologicalMap {
    graph: UnGraph<Place, Corridor>,
    compass: Option<Compass>,
}

/// An arm that could not be gone so often is none.
const PERSISTENCE: u32 = 3;
/// A place is recognised within three standard deviations and this, m.
const GATE: f64 = 1.0;
/// Odometry: what a straight way may be off along it, a share, and across it, rad; and what stopping adds, m. Each one standard deviation.
const ALONG: f64 = 0.02;
const ACROSS: f64 = 0.02;
const STOPS: f64 = 0.05;

impl TopologicalMap {
    /// A corridor has this heading, rad. True if it is the first, and gives the floor its directions.
    pub fn set_compass(&mut self, heading: f64) -> bool {
        let is_first = self.compass.is_none();
        self.compass.get_or_insert_with(|| Compass::new(heading));
        is_first
    }

    /// The directions of the floor, once a corridor is known.
    #[must_use]
    pub fn compass(&self) -> Option<Compass> {
        self.compass
    }

    /// All places, in the order in which they were found.
    pub fn places(&self) -> impl ExactSizeIterator<Item = (NodeIndex, &Place)> {
        self.graph.node_indices().map(|node| (node, &self.graph[node]))
    }

    /// All corridors, in the order in which they were gone unless one was found to lead elsewhere.
    pub fn corridors(&self) -> impl Iterator<Item = &Corridor> {
        self.graph.edge_weights()
    }

    /// A place.
    #[must_use]
    pub fn place(&self, place: NodeIndex) -> Option<&Place> {
        self.graph.node_weight(place)
    }

    /// How many arms nobody has gone yet.
    #[must_use]
    pub fn unexplored(&self) -> usize {
        self.graph.node_weights().flat_map(|place| place.arms).filter(|arm| *arm == Arm::Unexplored).count()
    }

    /// Where a robot is that has gone so far from a place, m, in this direction; with covariance.
    #[must_use]
    pub fn reached(&self, from: NodeIndex, direction: Quarter, distance: f64) -> Option<(Point2<f64>, Matrix2<f64>)> {
        let (place, compass) = (self.graph.node_weight(from)?, self.compass?);
        let (sin, cos) = compass.heading(direction).sin_cos();
        let (along, across) = (Vector2::new(cos, sin), Vector2::new(-sin, cos));
        let spread = |unit: Vector2<f64>, deviation: f64| unit * unit.transpose() * (deviation * deviation);
        let grown = spread(along, ALONG * distance + STOPS) + spread(across, ACROSS * distance + STOPS);
        Some((place.at + along * distance, place.covariance + grown))
    }

    /// The known place that is there, if there is one. Of several the nearest.
    #[must_use]
    pub fn recognise(&self, at: Point2<f64>, covariance: &Matrix2<f64>) -> Option<NodeIndex> {
        let distance = |place: &Place| (place.at - at).norm();
        let gate = |place: &Place| {
            // Larger than any deviation of the two together.
            let deviation = (place.covariance + covariance).trace().max(0.0).sqrt();
            distance(place) < (GATE + 3.0 * deviation).min(2.0)
        };
        let near = self.places().filter(|(_, place)| gate(place));
        near.min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b))).map(|(place, _)| place)
    }

    /// Adds a place, and gives it a name.
    pub fn add(&mut self, mut place: Place) -> NodeIndex {
        place.name = name(self.graph.node_count());
        self.graph.add_node(place)
    }

    /// A place is something else than it was thought to be. Arms that were gone, or tried, stay what they turned out to be. True if other arms are ways now.
    pub fn rename(&mut self, place: NodeIndex, to: Place) -> bool {
        let Some(place) = self.graph.node_weight_mut(place) else { return false };
        let before = place.arms;
        (place.kind, place.title, place.belief, place.seen) = (to.kind, to.title, to.belief, to.seen);
        for (arm, new) in place.arms.iter_mut().zip(to.arms) {
            if matches!(arm, Arm::Closed | Arm::Unexplored) {
                *arm = new;
            }
        }
        place.arms != before
    }

    /// A known place was come to again, and was there: both estimates together are better than either.
    pub fn seen_again(&mut self, place: NodeIndex, at: Point2<f64>, covariance: &Matrix2<f64>) {
        let Some(place) = self.graph.node_weight_mut(place) else { return };
        place.visits += 1;
        let Some(inverse) = (place.covariance + covariance).try_inverse() else { return };
        let gain = place.covariance * inverse;
        place.at += gain * (at - place.at);
        let updated = (Matrix2::identity() - gain) * place.covariance;
        place.covariance = 0.5 * (updated + updated.transpose());
    }

    /// An arm could not be gone. True unless it is known to be a corridor, or none.
    pub fn give_up(&mut self, place: NodeIndex, direction: Quarter) -> bool {
        let Some(place) = self.graph.node_weight_mut(place) else { return false };
        let arm = &mut place.arms[direction.index()];
        *arm = match *arm {
            Arm::Unexplored => Arm::GivenUp(1),
            Arm::GivenUp(times) => Arm::GivenUp(times + 1),
            Arm::Closed | Arm::Leads => return false,
        };
        true
    }

    /// An arm turned out to be something else.
    pub fn set_arm(&mut self, place: NodeIndex, direction: Quarter, arm: Arm) {
        if let Some(place) = self.graph.node_weight_mut(place) {
            place.arms[direction.index()] = arm;
        }
    }

    /// A corridor was gone from one place to another. One that is known already gets a better length. True if it was not known.
    pub fn join(&mut self, from: Exit, to: Exit, length: f64) -> bool {
        if let Some(known) = self.edge_at(from)
            && let Some(corridor) = self.graph.edge_weight_mut(known)
            && (corridor.from.0 == to.0 || corridor.to.0 == to.0)
        {
            corridor.length = 0.5 * (corridor.length + length);
            return false;
        }
        if self.is_place_between(from.0, to.0) {
            return false;
        }
        self.cut(from);
        self.cut(to);
        self.graph.add_edge(from.0, to.0, Corridor { length, from, to });
        self.set_arm(from.0, from.1, Arm::Leads);
        self.set_arm(to.0, to.1, Arm::Leads);
        true
    }

    /// True if a place is known on the straight way from one place to another: somebody came between, and the robot passed it without noticing.
    fn is_place_between(&self, from: NodeIndex, to: NodeIndex) -> bool {
        let (Some(start), Some(end)) = (self.place(from), self.place(to)) else { return false };
        let way = end.at - start.at;
        let is_between = |place: &Place| {
            let off = place.at - start.at;
            let along = off.dot(&way) / way.norm();
            (GATE..way.norm() - GATE).contains(&along) && (off.norm_squared() - along * along).max(0.0).sqrt() < GATE
        };
        self.places().any(|(_, place)| is_between(place))
    }

    /// The corridor that was thought to be there leads elsewhere: what is at its ends has to be explored again.
    fn cut(&mut self, exit: Exit) {
        let Some(edge) = self.edge_at(exit) else { return };
        if let Some(corridor) = self.graph.remove_edge(edge) {
            self.set_arm(corridor.from.0, corridor.from.1, Arm::Unexplored);
            self.set_arm(corridor.to.0, corridor.to.1, Arm::Unexplored);
        }
    }

    fn edge_at(&self, exit: Exit) -> Option<EdgeIndex> {
        let ends_there = |edge: &EdgeReference<'_, Corridor>| edge.weight().from == exit || edge.weight().to == exit;
        self.graph.edges(exit.0).find(ends_there).map(|edge| edge.id())
    }

    /// The corridor behind an arm: its length, and the place and arm at its other end.
    #[must_use]
    pub fn corridor(&self, exit: Exit) -> Option<(f64, Exit)> {
        let corridor = self.graph.edge_weight(self.edge_at(exit)?)?;
        let other = if corridor.from == exit { corridor.to } else { corridor.from };
        Some((corridor.length, other))
    }

    /// The shortest way from a place to an arm that nobody has gone yet; the last leg is that arm. A robot that stands there facing in a direction goes
    /// straight on rather than right, right rather than left, and back last. When none is left, those that could not be gone are tried again.
    ///
    /// Others may keep the robot from arms and corridors: only those that are `free` and `passable` are gone.
    #[must_use]
    pub fn nearest_unexplored(
        &self,
        from: NodeIndex,
        facing: Quarter,
        free: impl Fn(Exit) -> bool,
        passable: impl Fn(&Corridor) -> bool,
    ) -> Option<Route> {
        let graph = EdgeFiltered::from_fn(&self.graph, |edge: EdgeReference<'_, Corridor>| passable(edge.weight()));
        let way = |(goal, arm): Exit| {
            let (distance, nodes) = astar(&graph, from, |node| node == goal, |edge| edge.weight().length, |_| 0.0)?;
            let bias = if goal == from { turning(facing, arm) } else { 0.0 };
            Some((distance + bias, nodes, (goal, arm)))
        };
        let nearest = |wanted: fn(Arm) -> bool| {
            let ways = self.arms(wanted).filter(|exit| free(*exit)).filter_map(way);
            ways.min_by(|a, b| a.0.total_cmp(&b.0))
        };
        let unexplored = nearest(|arm| arm == Arm::Unexplored);
        let (_, nodes, last) = unexplored.or_else(|| nearest(|arm| matches!(arm, Arm::GivenUp(times) if times < PERSISTENCE)))?;
        let mut route: Route = nodes.windows(2).filter_map(|two| self.leg(two[0], two[1])).collect();
        route.push(last);
        Some(route)
    }

    fn arms(&self, wanted: fn(Arm) -> bool) -> impl Iterator<Item = Exit> {
        let of = move |(node, place): (NodeIndex, &Place)| {
            let arms = place.arms;
            Quarter::ALL.into_iter().filter(move |arm| wanted(arms[arm.index()])).map(move |arm| (node, arm))
        };
        self.places().flat_map(of)
    }

    /// By which arm to leave a place for its neighbour: the shortest corridor, if there are several.
    fn leg(&self, from: NodeIndex, to: NodeIndex) -> Option<Exit> {
        let corridors = self.graph.edges_connecting(from, to).map(|edge| *edge.weight());
        let shortest = corridors.min_by(|a, b| a.length.total_cmp(&b.length))?;
        Some(if shortest.from.0 == from { shortest.from } else { shortest.to })
    }

    /// The corridors at a place.
    pub fn at(&self, place: NodeIndex) -> impl Iterator<Item = &Corridor> {
        self.graph.edges(place).map(|edge| edge.id()).filter_map(|edge| self.graph.edge_weight(edge))
    }
}

/// By how much a turn is disliked, as if it were so far to drive, m.
fn turning(facing: Quarter, arm: Quarter) -> f64 {
    use orienteer_runtime::topics::Way;
    match facing.way_to(arm) {
        Some(Way::Ahead) => 0.0,
        Some(Way::Right) => 0.1,
        Some(Way::Left) => 0.2,
        None => 0.3,
    }
}

/// A to Z, AA to AZ and so on.
fn name(mut number: usize) -> String {
    let mut letters = Vec::new();
    loop {
        letters.push(b'A' + (number % 26) as u8);
        number /= 26;
        if number == 0 {
            break;
        }
        number -= 1;
    }
    letters.reverse();
    String::from_utf8_lossy(&letters).into_owned()
}
