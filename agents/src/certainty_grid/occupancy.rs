//! The map as others want it: three classes, counts and areas, one byte per cell.

use super::{CellClass, CellIndex, Grid, Window, background::is_unknown};

/// What a finished map says about a cell. Unlike [`CellClass`], which serves a navigator, it tells ground nobody has looked at
/// from ground that is known to be free even where the background is low.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Occupancy {
    /// Known to be free.
    Free,
    /// Known to be occupied.
    Occupied,
    /// Never looked at, or the readings contradict each other.
    Unknown,
}

/// How many cells there are of each kind.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Free cells.
    pub free: usize,
    /// Occupied cells.
    pub occupied: usize,
    /// The others.
    pub unknown: usize,
}

/// The byte of [`Grid::occupancy_bytes`] for cells of which nothing is known; -1 as a signed byte.
pub const UNKNOWN_BYTE: u8 = 255;

impl Grid {
    /// What the map says about a cell; unknown outside the window.
    #[must_use]
    pub fn occupancy(&self, index: CellIndex) -> Occupancy {
        self.slot(index).map_or(Occupancy::Unknown, |slot| self.occupancy_at(slot))
    }

    pub(super) fn occupancy_at(&self, slot: usize) -> Occupancy {
        let (c, f) = (self.probabilities[slot], self.confidences[slot]);
        match self.rules.thresholds.classify(c) {
            _ if is_unknown(c, f, self.rules.background) => Occupancy::Unknown,
            CellClass::Empty => Occupancy::Free,
            CellClass::Occupied => Occupancy::Occupied,
            CellClass::Uncertain => Occupancy::Unknown,
        }
    }

    /// Counts the cells of each kind.
    #[must_use]
    pub fn counts(&self) -> Counts {
        let mut counts = Counts::default();
        for slot in 0..self.probabilities.len() {
            match self.occupancy_at(slot) {
                Occupancy::Free => counts.free += 1,
                Occupancy::Occupied => counts.occupied += 1,
                Occupancy::Unknown => counts.unknown += 1,
            }
        }
        counts
    }

    /// Area of one cell, m².
    #[must_use]
    pub fn cell_area(&self) -> f64 {
        self.cell * self.cell
    }

    /// The smallest window that holds every cell of which anything is known, with so many cells of margin, cut to the
    /// grid; `None` if nothing is known.
    #[must_use]
    pub fn known_window(&self, margin: usize) -> Option<Window> {
        let width = self.window.width;
        let known = |slot: usize| !is_unknown(self.probabilities[slot], self.confidences[slot], self.rules.background);
        let (mut left, mut right, mut rows) = (usize::MAX, 0, None);
        for row in 0..self.window.height {
            let mut line = (row * width..(row + 1) * width).filter(|slot| known(*slot)).map(|slot| slot - row * width);
            if let Some(first) = line.next() {
                left = left.min(first);
                right = right.max(line.next_back().unwrap_or(first));
                rows = Some((rows.map_or(row, |(lowest, _)| lowest), row));
            }
        }
        let (lowest, highest) = rows?;
        let cut = |low: usize, high: usize, count: usize| {
            let start = low.saturating_sub(margin);
            (start, (high + 1 + margin).min(count) - start)
        };
        let (column, width) = cut(left, right, width);
        let (row, height) = cut(lowest, highest, self.window.height);
        Some(Window { first: self.window.first.offset(column as i32, row as i32), width, height })
    }

    /// The whole window as bytes: 0 (free) to 100 (occupied), [`UNKNOWN_BYTE`] where nothing is known; row by row from the lowest,
    /// each from the left. This is what Foxglove's `Grid` takes as one `uint8` field with a cell stride of 1, and, read as signed
    /// bytes, ROS' `OccupancyGrid`. `bytes` is emptied first and keeps its memory.
    pub fn occupancy_bytes(&self, bytes: &mut Vec<u8>) {
        bytes.clear();
        let background = self.rules.background;
        bytes.extend(
            self.probabilities
                .iter()
                .zip(&self.confidences)
                .map(|(c, f)| if is_unknown(*c, *f, background) { UNKNOWN_BYTE } else { (c * 100.0).round() as u8 }),
        );
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use nalgebra::Point2;

    use super::*;
    use crate::certainty_grid::{Layout, Rules};

    fn grid() -> Grid {
        let layout = Layout { cell: 0.2, width: 5, height: 4, origin: Point2::origin() };
        let mut grid = Grid::new(layout, Rules::default()).unwrap();
        grid.restore(CellIndex::new(1, 1), 0.0, -6.0);
        grid.restore(CellIndex::new(2, 1), 1.0, 2.0);
        grid.restore(CellIndex::new(2, 2), 0.55, 4.0);
        grid.restore(CellIndex::new(3, 2), 0.25, -1.0);
        grid
    }

    #[test]
    fn cells_are_counted_by_class() {
        let grid = grid();
        assert_eq!(grid.counts(), Counts { free: 2, occupied: 1, unknown: 17 });
        assert_eq!(grid.occupancy(CellIndex::new(2, 2)), Occupancy::Unknown);
        assert_eq!(grid.occupancy(CellIndex::new(-1, 0)), Occupancy::Unknown);
    }

    #[test]
    fn ground_nobody_has_seen_is_unknown_at_any_background() {
        let rules = Rules { background: 0.1, ..Rules::default() };
        let grid = Grid::new(Layout { cell: 0.2, width: 2, height: 2, origin: Point2::origin() }, rules).unwrap();
        assert_eq!(grid.counts().unknown, 4);
        assert_eq!(grid.class(CellIndex::new(0, 0)), CellClass::Empty);
    }

    #[test]
    fn bytes_run_from_the_lowest_row() {
        let mut bytes = vec![7; 3];
        grid().occupancy_bytes(&mut bytes);
        let u = UNKNOWN_BYTE;
        assert_eq!(bytes, [u, u, u, u, u, u, 0, 100, u, u, u, u, 55, 25, u, u, u, u, u, u]);
    }

    #[test]
    fn the_known_window_is_tight() {
        let window = grid().known_window(0).unwrap();
        assert_eq!((window.first, window.width, window.height), (CellIndex::new(1, 1), 3, 2));
        let window = grid().known_window(1).unwrap();
        assert_eq!((window.first, window.width, window.height), (CellIndex::new(0, 0), 5, 4));
        let mut blank = grid();
        blank.clear();
        assert_eq!(blank.known_window(3), None);
    }
}
