//! Walking along a ray from cell to cell (Amanatides and Woo, 1987).

use nalgebra::Vector2;
use orienteer_runtime::geometry::Pose;

use super::{CellIndex, Grid};

/// Distance at which a ray first enters a cell that is occupied with at least this confidence, if that is less than `limit`, m.
/// A ray that begins outside the window meets nothing.
pub(super) fn first_wall(grid: &Grid, face: &Pose, limit: f64, confidence: f32) -> Option<f64> {
    let Walk { index, step, mut next, per_cell } = Walk::along(grid, face)?;
    let mut slot = grid.slot(index)?;
    let (first, last, width) = (grid.window.first, grid.window.last(), grid.window.width);
    // How many columns and rows there still are in front, and how far apart their cells lie in memory.
    let ahead = |at: i32, first: i32, last: i32, step: i32| if step > 0 { last - at } else { at - first };
    let mut columns = ahead(index.column, first.column, last.column, step.0);
    let mut rows = ahead(index.row, first.row, last.row, step.1);
    let by_column = step.0 as isize as usize;
    let by_row = if step.1 > 0 { width } else { width.wrapping_neg() };
    let occupied = grid.rules.thresholds.occupied;
    let mut entered = 0.0;
    while entered < limit {
        if *grid.confidences.get(slot)? >= confidence && *grid.probabilities.get(slot)? >= occupied {
            return Some(entered);
        }
        if next.x < next.y {
            entered = next.x;
            next.x += per_cell.x;
            columns -= 1;
            slot = slot.wrapping_add(by_column);
        } else {
            entered = next.y;
            next.y += per_cell.y;
            rows -= 1;
            slot = slot.wrapping_add(by_row);
        }
        if columns < 0 || rows < 0 {
            return None;
        }
    }
    None
}

/// A walk at its beginning.
struct Walk {
    index: CellIndex,
    step: (i32, i32),
    /// Distance along the ray to the next column and to the next row.
    next: Vector2<f64>,
    /// Distance along the ray from column to column and from row to row.
    per_cell: Vector2<f64>,
}

impl Walk {
    /// `None` if a number is not finite.
    fn along(grid: &Grid, face: &Pose) -> Option<Self> {
        let direction = face.direction();
        if !(direction.x.is_finite() && direction.y.is_finite() && face.x.is_finite() && face.y.is_finite()) {
            return None;
        }
        let cell = grid.cell_size();
        let index = grid.index_of(face.point());
        let past = face.point() - grid.corner_of(index);
        let first = |past: f64, d: f64| if d > 0.0 { (cell - past) / d } else { -past / d };
        let toward = |past: f64, d: f64| if d == 0.0 { f64::INFINITY } else { first(past, d).max(0.0) };
        Some(Self {
            index,
            step: (if direction.x < 0.0 { -1 } else { 1 }, if direction.y < 0.0 { -1 } else { 1 }),
            next: Vector2::new(toward(past.x, direction.x), toward(past.y, direction.y)),
            per_cell: Vector2::new(cell / direction.x.abs(), cell / direction.y.abs()),
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::f64::consts::PI;

    use nalgebra::Point2;
    use proptest::prelude::*;

    use super::*;
    use crate::certainty_grid::{Layout, Rules};

    proptest! {
        #[test]
        fn finds_the_wall_that_small_steps_find(
            walls in prop::collection::vec((-20i32..20, -20i32..20), 0..80), x in -1.5..1.5f64, y in -1.5..1.5f64, heading in -PI..PI,
        ) {
            let mut grid = Grid::new(Layout::around(Point2::origin(), 0.1, 4.0, 4.0), Rules::default()).unwrap();
            for (column, row) in walls {
                grid.force(CellIndex::new(column + 20, row + 20), 1.0);
            }
            let face = Pose::new(x, y, heading);
            let found = first_wall(&grid, &face, 4.0, 6.0);
            let tiny = 1e-4;
            let stepped = (0..40_000).map(|i| f64::from(i) * tiny).find(|s| {
                grid.confidence(grid.index_of(face.point() + *s * face.direction())) == 6.0
            });
            match (found, stepped) {
                (Some(found), Some(stepped)) => {
                    // A cell whose corner is cut for less than a step may be missed by the steps.
                    prop_assert!(found <= stepped + 1e-9);
                    if found < stepped - 2.0 * tiny {
                        let corner = grid.index_of(face.point() + (found + 1e-9) * face.direction());
                        prop_assert_eq!(grid.confidence(corner), 6.0);
                    }
                }
                (None, Some(stepped)) => prop_assert!(stepped > 4.0 - 1e-9),
                (Some(found), None) => {
                    let corner = grid.index_of(face.point() + (found + 1e-9) * face.direction());
                    prop_assert_eq!(grid.confidence(corner), 6.0);
                }
                (None, None) => {}
            }
        }
    }

    #[test]
    fn an_axis_along_the_cells_works() {
        let mut grid = Grid::new(Layout::around(Point2::origin(), 0.1, 4.0, 4.0), Rules::default()).unwrap();
        grid.force(grid.index_of(Point2::new(1.05, 0.0)), 1.0);
        let found = first_wall(&grid, &Pose::new(0.0, 0.0, 0.0), 4.0, 3.0).unwrap();
        assert!((found - 1.0).abs() < 1e-9);
        assert_eq!(first_wall(&grid, &Pose::new(0.0, 0.0, 0.0), 0.9, 3.0), None);
        let lost = Pose { x: f64::NAN, y: 0.0, heading: 0.0 };
        assert_eq!(first_wall(&grid, &lost, 4.0, 3.0), None);
    }
}
