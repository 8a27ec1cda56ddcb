//! From a grid of crossings to corridors in metres.

use nalgebra::Point2;
use rand::{Rng, RngExt, seq::IndexedRandom};

use super::{
    FloorSpec, Heading, Width,
    grid::{Grid, Node},
    mm,
};
use crate::world::{
    geometry::Bounds,
    plan::{self, Xy},
};

/// A straight corridor through all crossings that it joins without a break.
#[derive(Debug, Clone)]
pub(super) struct Run {
    /// East or north.
    pub heading: Heading,
    /// The crossings on its way, two at least.
    pub nodes: Vec<Node>,
    /// From wall to wall, m.
    pub width: f64,
}

/// A piece of a run between two crossings that are places.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretch {
    /// East or north.
    pub heading: Heading,
    /// Where it begins and ends.
    pub ends: [Node; 2],
    /// From wall to wall, m.
    pub width: f64,
}

/// A grid with measures.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub grid: Grid,
    /// Where the columns are, from the west, m.
    pub x: Vec<f64>,
    /// Where the rows are, from the south, m.
    pub y: Vec<f64>,
    pub runs: Vec<Run>,
}

impl Layout {
    /// Gives the grid its measures: the lines from `pitches`, the corridors from `widths`.
    pub fn new(grid: Grid, spec: &FloorSpec, pitches: &mut impl Rng, widths: &mut impl Rng) -> Self {
        let x = lines(grid.columns, spec, pitches);
        let y = lines(grid.rows, spec, pitches);
        let mut runs = Vec::new();
        for heading in [Heading::East, Heading::North] {
            for first in grid.nodes().filter(|node| grid.joins(*node, heading) && !grid.joins(*node, heading.back())) {
                let next = |node: &Node| grid.neighbour(*node, heading).filter(|_| grid.joins(*node, heading));
                let nodes = std::iter::successors(Some(first), next).collect();
                runs.push(Run { heading, nodes, width: draw_width(&spec.corridor_width, widths) });
            }
        }
        Self { grid, x, y, runs }
    }

    /// Where the centre lines through a node meet.
    pub fn at(&self, node: Node) -> Point2<f64> {
        Point2::new(self.x[node.column], self.y[node.row])
    }

    /// Width of the corridor through the node along this heading, if there is one, m.
    pub fn width(&self, node: Node, heading: Heading) -> Option<f64> {
        let along = |run: &&Run| run.heading == heading || run.heading == heading.back();
        self.runs.iter().filter(along).find(|run| run.nodes.contains(&node)).map(|run| run.width)
    }

    /// How far from the node the free space of its middle reaches along this heading, m: to the walls of the corridor across,
    /// or to the end wall of a dead end.
    pub fn mouth(&self, node: Node, heading: Heading) -> f64 {
        0.5 * self.width(node, heading.left()).or_else(|| self.width(node, heading)).unwrap_or(0.0)
    }

    /// The pieces of all runs between crossings that are places.
    pub fn stretches(&self) -> impl Iterator<Item = Stretch> {
        self.runs.iter().flat_map(|run| {
            let stops: Vec<Node> = run.nodes.iter().copied().filter(|node| self.grid.is_junction(*node)).collect();
            let piece = |ends: &[Node]| Stretch { heading: run.heading, ends: [ends[0], ends[1]], width: run.width };
            stops.windows(2).map(piece).collect::<Vec<_>>()
        })
    }

    /// The run as a corridor of a world: it reaches to the far wall of those it meets, so that corners are square.
    pub fn corridor(&self, run: &Run) -> Option<plan::Corridor> {
        let (&first, &last) = (run.nodes.first()?, run.nodes.last()?);
        let along = run.heading.vector();
        let from = self.at(first) - along * self.mouth(first, run.heading);
        let to = self.at(last) + along * self.mouth(last, run.heading);
        Some(corridor(from, to, run.width))
    }
}

/// A straight corridor, hard walls.
pub(super) fn corridor(from: Point2<f64>, to: Point2<f64>, width: f64) -> plan::Corridor {
    plan::Corridor { name: None, along: vec![xy(from), xy(to)], width: mm(width), closed: false, reflectance: 1.0 }
}

/// A position in whole millimetres.
pub(super) fn xy(point: Point2<f64>) -> Xy {
    Xy([mm(point.x), mm(point.y)])
}

/// The ground that a straight corridor takes.
pub(super) fn ground(corridor: &plan::Corridor) -> Option<Bounds> {
    let ends = Bounds::around(corridor.along.iter().map(|xy| xy.point()))?;
    let half = 0.5 * corridor.width;
    let size = ends.size();
    let mut ground = ends;
    let across = if size.x > size.y { 1 } else { 0 };
    ground.min[across] -= half;
    ground.max[across] += half;
    Some(ground)
}

/// Where so many lines are, the first at 0.
fn lines(count: usize, spec: &FloorSpec, random: &mut impl Rng) -> Vec<f64> {
    let least = spec.widest() + spec.gap;
    let mut at = vec![0.0];
    while at.len() < count {
        let step = cm(spec.pitch + random.random_range(-spec.jitter..=spec.jitter)).max(least);
        at.push(mm(at[at.len() - 1] + step));
    }
    at
}

fn draw_width(choices: &[Width], random: &mut impl Rng) -> f64 {
    let [from, to] = choices.choose(random).map_or([0.0, 0.0], |width| width.range());
    // Half a width is a coordinate, and those shall be short.
    let width = if from < to { (2.0 * cm(0.5 * random.random_range(from..=to))).clamp(from, to) } else { from };
    2.0 * mm(0.5 * width)
}

/// Rounds to whole centimetres.
pub(super) fn cm(length: f64) -> f64 {
    (100.0 * length).round() / 100.0
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use orienteer_runtime::random::Streams;
    use proptest::prelude::*;

    use super::*;

    fn layout(seed: u64, spec: &FloorSpec) -> Layout {
        let streams = Streams::new(seed);
        let grid = Grid::thinned(4, 4, 0.2, 0.5, &mut streams.stream("floor", "grid"));
        Layout::new(grid, spec, &mut streams.stream("floor", "pitch"), &mut streams.stream("floor", "widths"))
    }

    proptest! {
        #[test]
        fn runs_have_every_edge_once(seed: u64) {
            let layout = layout(seed, &FloorSpec::default());
            let mut left: Vec<(Node, Heading)> = Vec::new();
            for node in layout.grid.nodes() {
                let forward = layout.grid.arms(node).filter(|heading| [Heading::East, Heading::North].contains(heading));
                left.extend(forward.map(|heading| (node, heading)));
            }
            for run in &layout.runs {
                for node in &run.nodes[..run.nodes.len() - 1] {
                    let at = left.iter().position(|edge| *edge == (*node, run.heading));
                    prop_assert!(at.is_some());
                    left.remove(at.unwrap());
                }
            }
            prop_assert!(left.is_empty());
        }

        #[test]
        fn lines_keep_their_distance_and_widths_are_from_the_list(seed: u64) {
            let corridor_width = vec![Width::Exactly(1.13), Width::Between([1.5, 2.1])];
            let spec = FloorSpec { corridor_width, pitch: 10.0, jitter: 1.9, ..FloorSpec::default() };
            let layout = layout(seed, &spec);
            for line in [&layout.x, &layout.y] {
                prop_assert!(line.windows(2).all(|w| (8.1 - 1e-9..=11.9 + 0.006).contains(&(w[1] - w[0]))), "{line:?}");
            }
            let listed = |width: f64| (width - 1.13).abs() < 0.0011 || (1.5..=2.1).contains(&width);
            prop_assert!(layout.runs.iter().all(|run| listed(run.width)));
        }
    }
}
