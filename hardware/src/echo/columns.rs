use std::ops::Range;

use super::{beam::Beam, grid::SegmentGrid};

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
    rise: [f64; 2],
    rows: i32,
    /// Index distance from row to row and from column to column.
    strides: [usize; 2],
}

impl Columns {
    pub(super) fn new(grid: &SegmentGrid, beam: &Beam) -> Self {
        let frame = &grid.frame;
        let at = [(beam.origin.x - frame.x) / frame.cell, (beam.origin.y - frame.y) / frame.cell];
        let counts = [frame.columns, frame.rows];
        let strides = [1, frame.columns as usize];
        let axis = [beam.axis.x, beam.axis.y];
        let (major, minor) = if axis[0].abs() >= axis[1].abs() { (0, 1) } else { (1, 0) };

        let forward = axis[major] >= 0.0;
        let edge = |side: f64| {
            let edge = [axis[0] - side * axis[1], axis[1] + side * axis[0]];
            (edge[minor] / edge[major].abs(), edge[major].abs())
        };
        let ((rise_right, pace_right), (rise_left, pace_left)) = (edge(-beam.tan_half), edge(beam.tan_half));
        let rise = if rise_right <= rise_left { [rise_right, rise_left] } else { [rise_left, rise_right] };
        // If the major axis itself lies in the beam, it is the fastest way across.
        let fastest = if rise[0] <= 0.0 && rise[1] >= 0.0 { 1.0 } else { pace_right.max(pace_left) / beam.sec_half };

        let here = at[major].floor() as i32;
        let last = counts[major] - 1;
        let (column, left) = if forward { (here.max(0), last - here.max(0)) } else { (here.min(last), here.min(last)) };
        let near_side = if forward { f64::from(column) - at[major] } else { at[major] - f64::from(column) - 1.0 };
        let pace = frame.cell / fastest;
        Self {
            least: if left < 0 { f64::INFINITY } else { near_side.max(0.0) * pace },
            column,
            step: if forward { 1 } else { -1 },
            left,
            pace,
            far: near_side + 1.0,
            across: at[minor],
            rise,
            rows: counts[minor],
            strides: [strides[minor], strides[major]],
        }
    }

    /// The cells of the next column as (first index, index step, how many), and moves on.
    pub(super) fn advance(&mut self) -> (usize, usize, Range<i32>) {
        let near = (self.far - 1.0).max(0.0);
        let at = |rise: f64, farther: bool| self.across + rise * if farther { self.far } else { near };
        let low = at(self.rise[0], self.rise[0] < 0.0).floor() as i32;
        let high = at(self.rise[1], self.rise[1] > 0.0).floor() as i32;
        let rows = low.max(0)..high.min(self.rows - 1).saturating_add(1);
        let base = self.column.max(0) as usize * self.strides[1];

        self.least = if self.left == 0 { f64::INFINITY } else { self.far * self.pace };
        self.left -= 1;
        self.column += self.step;
        self.far += 1.0;
        (base, self.strides[0], rows)
    }
}
