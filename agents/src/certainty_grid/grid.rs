//! The grid itself: cells, frames, and the window that is kept when the robot leaves it.

use nalgebra::Point2;
use thiserror::Error;

use super::{CellClass, CellIndex, MAX_CONFIDENCE, Rules, update::Update};

/// Size and place of a grid as it is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layout {
    /// Edge of a cell, m.
    pub cell: f64,
    /// Columns of cells.
    pub width: usize,
    /// Rows of cells.
    pub height: usize,
    /// Lower left corner, map frame, m.
    pub origin: Point2<f64>,
}

impl Layout {
    /// The layout of a grid of `width` × `height` metres whose middle lies within a cell of `centre`. The corner lies on a
    /// multiple of the cell's edge, so that grids of one cell size fit onto each other.
    #[must_use]
    pub fn around(centre: Point2<f64>, cell: f64, width: f64, height: f64) -> Self {
        let cells = |length: f64| (length / cell).round().max(1.0) as usize;
        let (columns, rows) = (cells(width), cells(height));
        let corner = |middle: f64, cells: usize| ((middle / cell).floor() - (cells / 2) as f64) * cell;
        Self { cell, width: columns, height: rows, origin: Point2::new(corner(centre.x, columns), corner(centre.y, rows)) }
    }
}

/// Why a grid can't be made or enlarged.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum GridError {
    /// The edge of a cell or the place of the grid is not a usable number.
    #[error("a grid needs a positive cell size and a finite origin")]
    Geometry,
    /// There would be no cells, or more than fit.
    #[error("a grid of {width} x {height} cells: at least 1 x 1 and at most {limit} cells are possible")]
    Size {
        /// Columns asked for.
        width: usize,
        /// Rows asked for.
        height: usize,
        /// Most cells there can be.
        limit: usize,
    },
}

/// A rectangle of cells: from `first`, so many columns and rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// The cell at the lower left.
    pub first: CellIndex,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Window {
    /// True if the cell lies inside.
    #[must_use]
    pub fn contains(&self, index: CellIndex) -> bool {
        let inside = |at: i32, first: i32, count: usize| {
            let past = i64::from(at) - i64::from(first);
            past >= 0 && past < count as i64
        };
        inside(index.column, self.first.column, self.width) && inside(index.row, self.first.row, self.height)
    }

    /// The cell at the upper right; the one at the lower left if the window is empty.
    #[must_use]
    pub fn last(&self) -> CellIndex {
        self.first.offset(self.width.saturating_sub(1) as i32, self.height.saturating_sub(1) as i32)
    }

    /// The part that both windows share; may be empty.
    #[must_use]
    pub fn intersection(&self, other: &Window) -> Window {
        let overlap = |a: i32, na: usize, b: i32, nb: usize| {
            let start = a.max(b);
            let end = (i64::from(a) + na as i64).min(i64::from(b) + nb as i64);
            (start, (end - i64::from(start)).max(0) as usize)
        };
        let (column, width) = overlap(self.first.column, self.width, other.first.column, other.width);
        let (row, height) = overlap(self.first.row, self.height, other.first.row, other.height);
        Window { first: CellIndex::new(column, row), width, height }
    }
}

/// A rectangular window of cells over the plane. See the [module](super) for the meaning of the values.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    pub(super) cell: f64,
    /// Lower left corner of cell (0, 0); never moves.
    pub(super) anchor: Point2<f64>,
    pub(super) window: Window,
    pub(super) rules: Rules,
    /// `C`, row by row from the lowest.
    pub(super) probabilities: Vec<f32>,
    /// `F`, in the same order. Apart from `C`, because decay, classes and files read one of the two alone.
    pub(super) confidences: Vec<f32>,
}

impl Grid {
    /// The most cells a grid may have: 2²⁶, 512 MiB.
    pub const MAX_CELLS: usize = 1 << 26;

    /// A grid of which nothing is known.
    ///
    /// # Errors
    /// [`GridError`] if the cell size is not a positive number, the origin is not finite, or the size is not between 1 cell and
    /// [`Grid::MAX_CELLS`].
    pub fn new(layout: Layout, rules: Rules) -> Result<Self, GridError> {
        let Layout { cell, width, height, origin } = layout;
        if !(cell.is_finite() && cell > 0.0 && origin.x.is_finite() && origin.y.is_finite()) {
            return Err(GridError::Geometry);
        }
        let cells = Self::checked_size(width, height, Self::MAX_CELLS)?;
        Ok(Self {
            cell,
            anchor: origin,
            window: Window { first: CellIndex::default(), width, height },
            rules,
            probabilities: vec![rules.background; cells],
            confidences: vec![0.0; cells],
        })
    }

    pub(super) fn checked_size(width: usize, height: usize, limit: usize) -> Result<usize, GridError> {
        width
            .checked_mul(height)
            .filter(|cells| (1..=limit).contains(cells) && i32::try_from(width.max(height)).is_ok())
            .ok_or(GridError::Size { width, height, limit })
    }

    /// Edge of a cell, m.
    #[must_use]
    pub fn cell_size(&self) -> f64 {
        self.cell
    }

    /// Columns of the present window.
    #[must_use]
    pub fn width(&self) -> usize {
        self.window.width
    }

    /// Rows of the present window.
    #[must_use]
    pub fn height(&self) -> usize {
        self.window.height
    }

    /// The present window.
    #[must_use]
    pub fn window(&self) -> Window {
        self.window
    }

    /// Lower left corner of the present window, map frame, m.
    #[must_use]
    pub fn origin(&self) -> Point2<f64> {
        self.corner_of(self.window.first)
    }

    /// The rules by which cells change.
    #[must_use]
    pub fn rules(&self) -> &Rules {
        &self.rules
    }

    /// The cell in which a point lies, be it inside the window or not. Coordinates that are not finite, or beyond 2³¹ cells,
    /// give a cell at the end of the range.
    #[must_use]
    pub fn index_of(&self, point: Point2<f64>) -> CellIndex {
        let at = |value: f64, anchor: f64| ((value - anchor) / self.cell).floor() as i32;
        CellIndex::new(at(point.x, self.anchor.x), at(point.y, self.anchor.y))
    }

    /// Lower left corner of a cell, m.
    #[must_use]
    pub fn corner_of(&self, index: CellIndex) -> Point2<f64> {
        let at = |count: i32, anchor: f64| anchor + f64::from(count) * self.cell;
        Point2::new(at(index.column, self.anchor.x), at(index.row, self.anchor.y))
    }

    /// Middle of a cell, m.
    #[must_use]
    pub fn centre_of(&self, index: CellIndex) -> Point2<f64> {
        let corner = self.corner_of(index);
        Point2::new(corner.x + 0.5 * self.cell, corner.y + 0.5 * self.cell)
    }

    /// True if the cell lies in the present window.
    #[must_use]
    pub fn contains(&self, index: CellIndex) -> bool {
        self.window.contains(index)
    }

    /// Where a cell lies in [`Grid::probabilities`] and [`Grid::confidences`]; `None` outside the window.
    #[must_use]
    pub fn slot(&self, index: CellIndex) -> Option<usize> {
        self.contains(index).then(|| {
            let column = (index.column - self.window.first.column) as usize;
            let row = (index.row - self.window.first.row) as usize;
            row * self.window.width + column
        })
    }

    /// `C` of a cell; the background outside the window.
    #[must_use]
    pub fn probability(&self, index: CellIndex) -> f32 {
        self.slot(index).map_or(self.rules.background, |slot| self.probabilities[slot])
    }

    /// `F` of a cell; 0 outside the window.
    #[must_use]
    pub fn confidence(&self, index: CellIndex) -> f32 {
        self.slot(index).map_or(0.0, |slot| self.confidences[slot])
    }

    /// The class of a cell.
    #[must_use]
    pub fn class(&self, index: CellIndex) -> CellClass {
        self.rules.thresholds.classify(self.probability(index))
    }

    /// True if a path may lead through the cell: `C` is at most [`Thresholds::path`](super::Thresholds::path).
    #[must_use]
    pub fn is_path(&self, index: CellIndex) -> bool {
        self.probability(index) <= self.rules.thresholds.path
    }

    /// All `C`, row by row from the lowest, each row from the left.
    #[must_use]
    pub fn probabilities(&self) -> &[f32] {
        &self.probabilities
    }

    /// All `F`, in the same order.
    #[must_use]
    pub fn confidences(&self) -> &[f32] {
        &self.confidences
    }

    /// A reading that gives the cell the value `value` (a probability, see [`level`](super::level)) with a weight of 1 to 6.
    /// Outside the window nothing happens.
    ///
    /// ```
    /// use orienteer_agents::certainty_grid::{CellIndex, Grid, Layout, Rules, level};
    /// use nalgebra::Point2;
    /// let layout = Layout { cell: 0.2, width: 10, height: 10, origin: Point2::new(0.0, 0.0) };
    /// let mut grid = Grid::new(layout, Rules::default())?;
    /// let cell = grid.index_of(Point2::new(0.5, 0.1));
    /// assert_eq!(cell, CellIndex::new(2, 0));
    /// grid.observe(cell, level::HIGH_OCCUPIED, 1.0);
    /// assert_eq!((grid.probability(cell), grid.confidence(cell)), (1.0, 1.0));
    /// # Ok::<(), orienteer_agents::certainty_grid::GridError>(())
    /// ```
    pub fn observe(&mut self, index: CellIndex, value: f32, weight: f32) {
        if let Some(slot) = self.slot(index) {
            let update = Update::new(value, weight, &self.rules);
            let (c, f) = update.of(self.probabilities[slot], self.confidences[slot]);
            (self.probabilities[slot], self.confidences[slot]) = (c, f);
        }
    }

    /// Sets a cell beyond doubt: `C` to `value`, `F` to the extreme on that side. For ground the robot has driven over and
    /// for edits by hand. Outside the window nothing happens.
    pub fn force(&mut self, index: CellIndex, value: f32) {
        if let Some(slot) = self.slot(index) {
            self.probabilities[slot] = value.clamp(0.0, 1.0);
            self.confidences[slot] = if value < 0.5 { -MAX_CONFIDENCE } else { MAX_CONFIDENCE };
        }
    }

    /// Stores `C` and `F` of a cell as they are, cut to their ranges: for loading a map. Outside the window nothing happens.
    pub fn restore(&mut self, index: CellIndex, probability: f32, confidence: f32) {
        if let Some(slot) = self.slot(index) {
            self.probabilities[slot] = probability.clamp(0.0, 1.0);
            self.confidences[slot] = confidence.clamp(-MAX_CONFIDENCE, MAX_CONFIDENCE);
        }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.probabilities.fill(self.rules.background);
        self.confidences.fill(0.0);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn layout() -> Layout {
        Layout { cell: 0.2, width: 100, height: 60, origin: Point2::new(-3.0, 1.0) }
    }

    #[test]
    fn points_and_cells_agree() {
        let grid = Grid::new(layout(), Rules::default()).unwrap();
        for index in [CellIndex::new(0, 0), CellIndex::new(99, 59), CellIndex::new(-7, 200)] {
            assert_eq!(grid.index_of(grid.centre_of(index)), index);
        }
        assert_eq!(grid.index_of(Point2::new(-3.0, 1.0)), CellIndex::new(0, 0));
        assert_eq!(grid.slot(CellIndex::new(3, 2)), Some(203));
        assert_eq!(grid.slot(CellIndex::new(100, 0)), None);
        assert_eq!(grid.slot(CellIndex::new(0, -1)), None);
    }

    #[test]
    fn outside_the_window_nothing_is_known_and_nothing_happens() {
        let mut grid = Grid::new(layout(), Rules::default()).unwrap();
        let before = grid.clone();
        for index in [CellIndex::new(i32::MIN, i32::MAX), CellIndex::new(0, 60), grid.index_of(Point2::new(f64::NAN, 1e300))] {
            assert!(!grid.contains(index) || index.column == 0);
            if !grid.contains(index) {
                grid.observe(index, 1.0, 1.0);
                grid.force(index, 0.0);
                assert_eq!((grid.probability(index), grid.confidence(index)), (0.5, 0.0));
            }
        }
        assert_eq!(grid, before);
    }

    #[test]
    fn a_forced_write_is_beyond_doubt() {
        let mut grid = Grid::new(layout(), Rules::default()).unwrap();
        let cell = CellIndex::new(4, 4);
        grid.force(cell, 0.0);
        assert_eq!((grid.probability(cell), grid.confidence(cell), grid.class(cell)), (0.0, -6.0, CellClass::Empty));
        assert!(grid.is_path(cell));
        grid.force(cell, 1.0);
        assert_eq!((grid.probability(cell), grid.confidence(cell), grid.class(cell)), (1.0, 6.0, CellClass::Occupied));
    }

    #[test]
    fn absurd_layouts_are_refused() {
        let with = |change: fn(&mut Layout)| {
            let mut layout = layout();
            change(&mut layout);
            Grid::new(layout, Rules::default()).unwrap_err()
        };
        assert_eq!(with(|l| l.cell = 0.0), GridError::Geometry);
        assert_eq!(with(|l| l.cell = f64::NAN), GridError::Geometry);
        assert_eq!(with(|l| l.origin.x = f64::INFINITY), GridError::Geometry);
        assert!(matches!(with(|l| l.width = 0), GridError::Size { .. }));
        assert!(matches!(with(|l| (l.width, l.height) = (usize::MAX, 2)), GridError::Size { .. }));
    }

    #[test]
    fn a_layout_around_a_point_keeps_to_multiples_of_the_cell() {
        let layout = Layout::around(Point2::new(1.23, -4.56), 0.25, 10.0, 5.0);
        assert_eq!((layout.width, layout.height), (40, 20));
        assert_eq!(layout.origin, Point2::new(-4.0, -7.25));
    }
}
