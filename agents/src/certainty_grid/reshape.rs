//! Moving and enlarging the window.
//!
//! Cells lie row by row in one flat array: neighbours are found by adding 1 or the width, rows feed vector
//! instructions, and files and recordings copy them as they are. Recentring moves rows inside that array
//! and allocates nothing. Growing allocates a new array; it happens once per block of cells, so a robot that maps a building
//! pays it every few metres of new ground. Tiles behind a directory would spare that copy and charge every read for it.

use super::{CellIndex, Grid, GridError, Window};

impl Grid {
    /// Moves the window by so many columns and rows; what leaves it is forgotten, what enters is unknown. Indices keep
    /// naming the same floor. Allocates nothing.
    pub fn shift(&mut self, columns: i32, rows: i32) {
        let first = self.window.first.offset(columns, rows);
        let moved = Window { first, ..self.window };
        let kept = moved.intersection(&self.window);
        shift_rows(&mut self.probabilities, self.window, moved, kept, self.rules.background);
        shift_rows(&mut self.confidences, self.window, moved, kept, 0.0);
        self.window = moved;
    }

    /// Moves the window so that `index` lies in its middle. Allocates nothing.
    pub fn recentre(&mut self, index: CellIndex) {
        let middle = self.window.first.offset((self.window.width / 2) as i32, (self.window.height / 2) as i32);
        self.shift(index.column.saturating_sub(middle.column), index.row.saturating_sub(middle.row));
    }

    /// True if the cell is nearer than `margin` cells to an edge of the window, or outside.
    #[must_use]
    pub fn near_edge(&self, index: CellIndex, margin: usize) -> bool {
        let Window { first, width, height } = self.window;
        let near = |at: i32, first: i32, count: usize| {
            let past = i64::from(at) - i64::from(first);
            past < margin as i64 || past >= count as i64 - margin as i64
        };
        near(index.column, first.column, width) || near(index.row, first.row, height)
    }

    /// Enlarges the window, in whole blocks of `block` cells, until it contains `wanted`; does nothing if it already
    /// does. Returns whether it grew.
    ///
    /// # Errors
    /// [`GridError::Size`] if more than `limit` cells would be needed; the grid stays as it is.
    pub fn grow_to(&mut self, wanted: Window, block: usize, limit: usize) -> Result<bool, GridError> {
        let block = block.max(1);
        let missing = |cells: i64| if cells > 0 { (cells as usize).div_ceil(block).saturating_mul(block) } else { 0 };
        let old = self.window;
        let grown = |first: i32, count: usize, wanted: i32, wanted_count: usize| {
            let before = missing(i64::from(first) - i64::from(wanted));
            let after = missing(i64::from(wanted) + wanted_count as i64 - i64::from(first) - count as i64);
            (before, before.saturating_add(count).saturating_add(after))
        };
        let (left, width) = grown(old.first.column, old.width, wanted.first.column, wanted.width);
        let (below, height) = grown(old.first.row, old.height, wanted.first.row, wanted.height);
        if (width, height) == (old.width, old.height) {
            return Ok(false);
        }
        let cells = Self::checked_size(width, height, limit.min(Self::MAX_CELLS))?;
        let enlarge = |cells_before: &[f32], fill: f32| {
            let mut enlarged = vec![fill; cells];
            for (row, line) in cells_before.chunks_exact(old.width).enumerate() {
                let start = (row + below) * width + left;
                enlarged[start..start + old.width].copy_from_slice(line);
            }
            enlarged
        };
        self.probabilities = enlarge(&self.probabilities, self.rules.background);
        self.confidences = enlarge(&self.confidences, 0.0);
        self.window = Window { first: old.first.offset(-(left as i32), -(below as i32)), width, height };
        Ok(true)
    }
}

/// Moves the `kept` part of `cells` from its place in window `old` to its place in window `new`, which has the same size, and
/// fills the rest.
fn shift_rows(cells: &mut [f32], old: Window, new: Window, kept: Window, fill: f32) {
    if kept.width == 0 || kept.height == 0 {
        cells.fill(fill);
        return;
    }
    let width = old.width;
    let place = |window: Window| {
        let column = (i64::from(kept.first.column) - i64::from(window.first.column)) as usize;
        let row = (i64::from(kept.first.row) - i64::from(window.first.row)) as usize;
        (row, column)
    };
    let (old_row, old_column) = place(old);
    let (new_row, new_column) = place(new);
    let mut move_row = |i: usize| {
        let from = (old_row + i) * width + old_column;
        let start = (new_row + i) * width;
        cells.copy_within(from..from + kept.width, start + new_column);
        cells[start..start + new_column].fill(fill);
        cells[start + new_column + kept.width..start + width].fill(fill);
    };
    // Rows must not be overwritten before they have been moved.
    if new_row <= old_row {
        (0..kept.height).for_each(&mut move_row);
    } else {
        (0..kept.height).rev().for_each(&mut move_row);
    }
    cells[..new_row * width].fill(fill);
    cells[(new_row + kept.height) * width..].fill(fill);
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use nalgebra::Point2;
    use proptest::prelude::*;

    use super::*;
    use crate::certainty_grid::{Layout, Rules};

    fn numbered(width: usize, height: usize) -> Grid {
        let layout = Layout { cell: 0.1, width, height, origin: Point2::new(-1.0, 2.0) };
        let mut grid = Grid::new(layout, Rules::default()).unwrap();
        for slot in 0..width * height {
            grid.probabilities[slot] = slot as f32 / 1e4;
            grid.confidences[slot] = (slot % 7) as f32;
        }
        grid
    }

    /// Every cell of the new window holds what the same floor held before, or the background.
    fn assert_same_floor(before: &Grid, after: &Grid) {
        let Window { first, width, height } = after.window();
        for row in 0..height as i32 {
            for column in 0..width as i32 {
                let index = first.offset(column, row);
                assert_eq!(after.probability(index), before.probability(index), "{index:?}");
                assert_eq!(after.confidence(index), before.confidence(index), "{index:?}");
                assert_eq!(after.centre_of(index), before.centre_of(index));
            }
        }
    }

    proptest! {
        #[test]
        fn shifting_is_renaming(width in 1usize..12, height in 1usize..12, columns in -14i32..14, rows in -14i32..14) {
            let before = numbered(width, height);
            let mut after = before.clone();
            after.shift(columns, rows);
            prop_assert_eq!(after.window().first, before.window().first.offset(columns, rows));
            assert_same_floor(&before, &after);
        }

        #[test]
        fn growing_keeps_every_cell(
            width in 1usize..12, height in 1usize..12, column in -30i32..30, row in -30i32..30, w in 0usize..20, h in 0usize..20, block in 1usize..9,
        ) {
            let before = numbered(width, height);
            let mut after = before.clone();
            let wanted = Window { first: CellIndex::new(column, row), width: w, height: h };
            let grew = after.grow_to(wanted, block, 1 << 20).unwrap();
            prop_assert_eq!(grew, after.window() != before.window());
            prop_assert_eq!((after.width() - width) % block, 0);
            prop_assert_eq!((after.height() - height) % block, 0);
            if w > 0 && h > 0 {
                prop_assert!(after.contains(wanted.first) && after.contains(wanted.last()));
            }
            prop_assert!(after.contains(before.window().first) && after.contains(before.window().last()));
            assert_same_floor(&before, &after);
        }
    }

    #[test]
    fn recentring_puts_a_cell_in_the_middle() {
        let mut grid = numbered(10, 8);
        grid.recentre(CellIndex::new(40, -3));
        assert_eq!(grid.window().first, CellIndex::new(35, -7));
        assert!(!grid.near_edge(CellIndex::new(40, -3), 3));
        assert!(grid.near_edge(CellIndex::new(37, -3), 3));
        assert!(grid.near_edge(CellIndex::new(400, -3), 0));
    }

    #[test]
    fn growth_has_a_limit() {
        let mut grid = numbered(10, 8);
        let before = grid.clone();
        let far = Window { first: CellIndex::new(i32::MAX - 1, 0), width: 1, height: 1 };
        assert!(matches!(grid.grow_to(far, 16, 1 << 20), Err(GridError::Size { .. })));
        assert_eq!(grid, before);
    }
}
