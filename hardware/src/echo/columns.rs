//! The walk of a beam over the cells of the grid.

use super::{
    beam::Beam,
    grid::{Cells, Frame},
};

/// Walks over the cells of a grid that a beam covers, in order of distance, one column of cells at a time.
///
/// Columns stand across the axis to which the beam is nearest (at most 45° away), so that both edges of any beam up to
/// [`MAX_HALF_BEAM`](super::MAX_HALF_BEAM) cross every column. Between the two sides of a column the edges bound the rows.
pub(super) struct Columns {
    /// Distance from the transducer before which the next column can't be met, m; infinite after the last.
    pub(super) least: f64,
    column: i32,
    step: i32,
    left: i32,
    /// Distance covered by a whole column, m, along the direction in the beam that crosses columns fastest.
    pace: f64,
    /// Offset of the far side of the column from the transducer along the major axis, cells.
    far: f64,
    across: f64,
    /// Rise of the lower and upper edge along the minor axis for each cell along the major one.
    rise: (f64, f64),
    rows: i32,
    /// True if the columns are the grid's columns, false if they are its rows.
    along_x: bool,
}

impl Columns {
    pub(super) fn new(frame: &Frame, beam: &Beam) -> Self {
        let at = ((beam.origin.x - frame.x) * frame.per_cell, (beam.origin.y - frame.y) * frame.per_cell);
        let (x, y) = (beam.axis.x, beam.axis.y);
        // (along the major axis, along the minor axis) of position, axis and cell counts
        let along_x = x.abs() >= y.abs();
        let (at, across) = if along_x { at } else { (at.1, at.0) };
        let (x, y) = if along_x { (x, y) } else { (y, x) };
        let (count, rows) = if along_x { (frame.columns, frame.rows) } else { (frame.rows, frame.columns) };

        // The edges of the beam: which of them is the left one does not matter here.
        let tan = beam.tan_half;
        let pace = ((x - tan * y).abs(), (x + tan * y).abs());
        let rise = ((y + tan * x) / pace.0, (y - tan * x) / pace.1);
        let rise = (rise.0.min(rise.1), rise.0.max(rise.1));
        // If the major axis itself lies in the beam, it is the fastest way across.
        let fastest = if rise.0 <= 0.0 && rise.1 >= 0.0 { 1.0 } else { pace.0.max(pace.1) * beam.cos_half };

        let forward = x >= 0.0;
        let (here, last) = (floor(at), count - 1);
        let (column, left) = if forward { (here.max(0), last - here.max(0)) } else { (here.min(last), here.min(last)) };
        let near_side = if forward { f64::from(column) - at } else { at - f64::from(column) - 1.0 };
        let pace = frame.cell / fastest;
        Self {
            least: if left < 0 { f64::INFINITY } else { near_side.max(0.0) * pace },
            column,
            step: if forward { 1 } else { -1 },
            left,
            pace,
            far: near_side + 1.0,
            across,
            rise,
            rows,
            along_x,
        }
    }

    /// The cells of the next column that the beam covers.
    pub(super) fn advance(&mut self) -> Cells {
        let near = (self.far - 1.0).max(0.0);
        let low = self.across + self.rise.0 * if self.rise.0 < 0.0 { self.far } else { near };
        let high = self.across + self.rise.1 * if self.rise.1 > 0.0 { self.far } else { near };
        let (low, high) = (floor(low).max(0), floor(high).min(self.rows - 1));
        let count = (high.saturating_add(1) - low).max(0) as usize;
        let first = self.column.max(0) as usize * self.rows as usize + low as usize;

        self.least = if self.left == 0 { f64::INFINITY } else { self.far * self.pace };
        self.left -= 1;
        self.column += self.step;
        self.far += 1.0;
        Cells { in_column: self.along_x, first, count }
    }
}

/// The next lower whole number. The library's is a function call on processors without an instruction for it.
fn floor(value: f64) -> i32 {
    let whole = value as i32;
    if f64::from(whole) > value { whole.saturating_sub(1) } else { whole }
}
