//! The certainty grid of Good (1992): what sonar readings say about free and occupied ground.
//!
//! Every cell `(x, y)` carries two numbers:
//!
//! * `C` in `[0, 1]`, the probability that something stands in the cell, and
//! * `F` in `[-6, 6]`, a signed count of evidence: positive for "occupied", negative for "empty" (Good 1992, §2.3.3).
//!
//! A reading of value `v` and weight `δ` moves `C` to the weighted mean `(C·|F| + v·δ) / (|F| + δ)` and `F` by one. So a cell
//! nobody has looked at takes the first reading as it is, and a firmly known one needs twelve contrary readings to change
//! its mind entirely. The weight of a reading is the length of its *region of constant depth* ([`rcd`]): readings that
//! repeat themselves count for more than those that jump.
//!
//! The parts, each of them pure and free of allocations once warm:
//!
//! | part | idea |
//! |---|---|
//! | [`Grid`] | storage, geometry, the update rule; [`Grid::recentre`] and [`Grid::grow_to`] move or enlarge the window |
//! | [`sector`] | which cells lie in a beam: rows of cells, exactly |
//! | [`marking`] | draws one reading: an empty cone and the arc of the object |
//! | [`rcd`] | how far a reading is to be believed |
//! | [`pairs`] | fuses two transducers that look the same way from side by side |
//! | [`decay`] | forgets where things are as the robot moves |
//! | [`occupancy`] | the map as others want it: classes, counts, bytes |
//!
//! Cells are addressed by [`CellIndex`], which counts from the lower left corner that the grid had when it was made. An index
//! keeps naming the same piece of floor while the window moves, so nobody has to translate goals after a recentring, as
//! the original had to. `x` grows to the right, `y` upward, and a cell owns its lower and left edges.

mod background;
pub mod decay;
mod grid;
pub mod marking;
pub mod occupancy;
pub mod pairs;
mod ray;
pub mod rcd;
mod reshape;
pub mod sector;
mod update;

pub use background::Survey;
pub use grid::{Grid, GridError, Layout, Window};
pub use occupancy::Occupancy;
pub use update::{CellClass, MAX_CONFIDENCE, Rules, Thresholds, level};

/// A cell by its column and row, counted from the lower left corner of the grid as it was made; may be negative or lie
/// outside the present window.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CellIndex {
    /// Column, growing with x.
    pub column: i32,
    /// Row, growing with y.
    pub row: i32,
}

impl CellIndex {
    /// The cell in this column and row.
    #[must_use]
    pub const fn new(column: i32, row: i32) -> Self {
        Self { column, row }
    }

    /// The cell so many columns and rows further on.
    #[must_use]
    pub const fn offset(self, columns: i32, rows: i32) -> Self {
        Self::new(self.column.saturating_add(columns), self.row.saturating_add(rows))
    }
}
