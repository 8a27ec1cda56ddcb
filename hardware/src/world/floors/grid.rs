//! Which crossings of a grid are joined by corridors: a connected graph, made from the whole grid by taking edges away.

use std::collections::VecDeque;

use rand::{Rng, RngExt, seq::SliceRandom};

use super::Heading;

/// A crossing of the grid: column from the west, row from the south.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Node {
    pub column: usize,
    pub row: usize,
}

/// A grid of crossings, some neighbours joined.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Grid {
    pub columns: usize,
    pub rows: usize,
    /// Whether a node is joined to its neighbour in the east and in the north, row by row.
    joined: Vec<[bool; 2]>,
}

impl Grid {
    /// All neighbours joined.
    pub fn full(columns: usize, rows: usize) -> Self {
        let joined = |i: usize| [i % columns + 1 < columns, i / columns + 1 < rows];
        Self { columns, rows, joined: (0..columns * rows).map(joined).collect() }
    }

    /// A grid with edges taken away in random order, as long as it stays connected.
    ///
    /// An edge that could go stays all the same with probability `loops`, and a node may become a dead end with probability
    /// `dead_ends`. `loops` = 0 and `dead_ends` = 1 give a tree.
    pub fn thinned(columns: usize, rows: usize, loops: f64, dead_ends: f64, random: &mut impl Rng) -> Self {
        let mut grid = Self::full(columns, rows);
        let may_end: Vec<bool> = grid.joined.iter().map(|_| random.random_bool(dead_ends)).collect();
        let mut edges: Vec<(Node, Heading)> = grid.edges().collect();
        edges.shuffle(random);
        for (node, heading) in edges {
            let stays = random.random_bool(loops);
            let Some(other) = grid.neighbour(node, heading) else { continue };
            let bare = |end: Node| grid.arms(end).count() < if may_end[grid.index(end)] { 2 } else { 3 };
            if stays || bare(node) || bare(other) {
                continue;
            }
            grid.join(node, heading, false);
            if !grid.reaches(node, other) {
                grid.join(node, heading, true);
            }
        }
        grid
    }

    /// All nodes, row by row from the south.
    pub fn nodes(&self) -> impl Iterator<Item = Node> + use<> {
        let columns = self.columns;
        (0..columns * self.rows).map(move |i| Node { column: i % columns, row: i / columns })
    }

    /// All edges, from their western or southern end.
    fn edges(&self) -> impl Iterator<Item = (Node, Heading)> {
        let both = self.nodes().flat_map(|node| [Heading::East, Heading::North].map(|heading| (node, heading)));
        both.filter(|(node, heading)| self.joins(*node, *heading))
    }

    /// True if a corridor leads from the node toward this heading.
    pub fn joins(&self, node: Node, heading: Heading) -> bool {
        match heading {
            Heading::East => self.joined[self.index(node)][0],
            Heading::North => self.joined[self.index(node)][1],
            Heading::West | Heading::South => {
                self.neighbour(node, heading).is_some_and(|other| self.joins(other, heading.back()))
            }
        }
    }

    /// Where corridors lead from the node.
    pub fn arms(&self, node: Node) -> impl Iterator<Item = Heading> {
        Heading::ALL.into_iter().filter(move |heading| self.joins(node, *heading))
    }

    /// True unless a corridor just goes straight through.
    pub fn is_junction(&self, node: Node) -> bool {
        !self.arms(node).eq([Heading::East, Heading::West]) && !self.arms(node).eq([Heading::North, Heading::South])
    }

    /// The next node, joined or not.
    pub fn neighbour(&self, node: Node, heading: Heading) -> Option<Node> {
        let Node { column, row } = node;
        let (column, row) = match heading {
            Heading::East => (column + 1, row),
            Heading::North => (column, row + 1),
            Heading::West => (column.checked_sub(1)?, row),
            Heading::South => (column, row.checked_sub(1)?),
        };
        (column < self.columns && row < self.rows).then_some(Node { column, row })
    }

    fn index(&self, node: Node) -> usize {
        node.row * self.columns + node.column
    }

    /// Joins or parts a node and its neighbour in the east or north.
    fn join(&mut self, node: Node, heading: Heading, joined: bool) {
        let index = self.index(node);
        self.joined[index][usize::from(heading == Heading::North)] = joined;
    }

    /// True if corridors lead from one node to the other.
    fn reaches(&self, from: Node, to: Node) -> bool {
        let mut seen = vec![false; self.joined.len()];
        let mut next = VecDeque::from([from]);
        seen[self.index(from)] = true;
        while let Some(node) = next.pop_front() {
            if node == to {
                return true;
            }
            for other in self.arms(node).filter_map(|heading| self.neighbour(node, heading)) {
                if !std::mem::replace(&mut seen[self.index(other)], true) {
                    next.push_back(other);
                }
            }
        }
        false
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use orienteer_runtime::random::Streams;
    use proptest::prelude::*;

    use super::*;

    /// Number of parts, by merging the ends of every edge until nothing changes.
    fn parts(grid: &Grid) -> usize {
        let mut part: Vec<usize> = (0..grid.joined.len()).collect();
        for _ in 0..grid.joined.len() {
            for (node, heading) in grid.edges() {
                let (a, b) = (grid.index(node), grid.index(grid.neighbour(node, heading).unwrap()));
                let least = part[a].min(part[b]);
                (part[a], part[b]) = (least, least);
            }
        }
        part.sort_unstable();
        part.dedup();
        part.len()
    }

    proptest! {
        #[test]
        fn stays_connected(seed: u64, columns in 1..7_usize, rows in 1..7_usize, loops in 0.0..=1.0, ends in 0.0..=1.0) {
            let grid = Grid::thinned(columns, rows, loops, ends, &mut Streams::new(seed).stream("floor", "grid"));
            prop_assert_eq!(parts(&grid), 1);
        }

        #[test]
        fn without_loops_is_a_tree(seed: u64, columns in 1..7_usize, rows in 1..7_usize) {
            let grid = Grid::thinned(columns, rows, 0.0, 1.0, &mut Streams::new(seed).stream("floor", "grid"));
            prop_assert_eq!(grid.edges().count() + 1, columns * rows);
            prop_assert_eq!(parts(&grid), 1);
        }

        #[test]
        fn dead_ends_can_be_ruled_out(seed: u64, columns in 2..7_usize, rows in 2..7_usize) {
            let grid = Grid::thinned(columns, rows, 0.0, 0.0, &mut Streams::new(seed).stream("floor", "grid"));
            prop_assert!(grid.nodes().all(|node| grid.arms(node).count() >= 2));
        }

        #[test]
        fn every_arm_leads_back(seed: u64, columns in 1..7_usize, rows in 1..7_usize) {
            let grid = Grid::thinned(columns, rows, 0.3, 0.5, &mut Streams::new(seed).stream("floor", "grid"));
            for node in grid.nodes() {
                for heading in grid.arms(node) {
                    prop_assert!(grid.joins(grid.neighbour(node, heading).unwrap(), heading.back()));
                }
            }
        }
    }

    #[test]
    fn with_all_loops_nothing_goes() {
        let random = &mut Streams::new(1).stream("floor", "grid");
        assert_eq!(Grid::thinned(4, 3, 1.0, 1.0, random), Grid::full(4, 3));
    }
}
