//! Forgetting where things are as the robot moves (Good 1992, §2.4).
//!
//! Dead reckoning drifts, so what was mapped earlier lies elsewhere by now. Decay mixes each cell with its eight neighbours:
//!
//! ```text
//! A  = Σ C·(|F|+1) / Σ (|F|+1)          over the neighbours; beyond the edge C = edge background, |F| = 0
//! C' = W·C + (1-W)·A                    W = 1 - K·(cells moved)
//! F' = F moved toward 0 by |C - A|
//! ```
//!
//! All cells change at once. Walls swell, which keeps a navigator away from them, and fade, which is why the author left decay
//! off except on short simple routes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Grid;

/// Whether and how fast the map fades.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DecayConfig {
    /// Whether the map fades at all.
    pub enabled: bool,
    /// Share of a cell that is replaced by its neighbours' mean for each cell the robot moves (K).
    #[schemars(range(min = 0.0, max = 0.3))]
    pub per_cell: f32,
    /// The longest move, in cells, that one decay accounts for.
    #[schemars(range(min = 1.0, max = 3.0))]
    pub most_cells: f64,
}

impl Default for DecayConfig {
    fn default() -> Self {
        Self { enabled: false, per_cell: 0.05, most_cells: 3.0 }
    }
}

/// Three rows of values as they were before this pass, with one cell of edge on either side.
#[derive(Debug, Clone, Default, PartialEq)]
struct Row {
    weight: Vec<f32>,
    weighted: Vec<f32>,
}

impl Row {
    fn resize(&mut self, width: usize) {
        self.weight.resize(width, 0.0);
        self.weighted.resize(width, 0.0);
    }

    fn edge(&mut self, background: f32) {
        self.weight.fill(1.0);
        self.weighted.fill(background);
    }

    fn load(&mut self, probabilities: &[f32], confidences: &[f32], background: f32) {
        self.edge(background);
        let inner = self.weight.iter_mut().zip(&mut self.weighted).skip(1);
        for ((weight, weighted), (c, f)) in inner.zip(probabilities.iter().zip(confidences)) {
            *weight = f.abs() + 1.0;
            *weighted = c * *weight;
        }
    }
}

/// Decays grids; keeps the rows it needs, so that it allocates nothing after the first use with a grid of some width.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Decay {
    above: Row,
    here: Row,
    below: Row,
}

impl Decay {
    /// Lets the whole grid fade once, with the weight `1 - fade` for what a cell held before (`fade` is K times the cells
    /// moved, and is cut to `[0, 1]`).
    pub fn apply(&mut self, grid: &mut Grid, fade: f32) {
        let fade = if fade.is_nan() { 0.0 } else { fade.clamp(0.0, 1.0) };
        let (width, height, background) = (grid.width(), grid.height(), grid.rules().edge_background);
        for row in [&mut self.above, &mut self.here, &mut self.below] {
            row.resize(width + 2);
        }
        self.below.edge(background);
        self.here.load(&grid.probabilities[..width], &grid.confidences[..width], background);
        for row in 0..height {
            let next = (row + 1) * width..(row + 2) * width;
            if row + 1 < height {
                self.above.load(&grid.probabilities[next.clone()], &grid.confidences[next], background);
            } else {
                self.above.edge(background);
            }
            let cells = row * width..(row + 1) * width;
            self.fade_row(&mut grid.probabilities[cells.clone()], &mut grid.confidences[cells], fade);
            std::mem::swap(&mut self.below, &mut self.here);
            std::mem::swap(&mut self.here, &mut self.above);
        }
    }

    fn fade_row(&self, probabilities: &mut [f32], confidences: &mut [f32], fade: f32) {
        let around = |above: &[f32], here: &[f32], below: &[f32]| {
            let column = |i: usize| above[i] + here[i] + below[i];
            column(0) + column(2) + above[1] + below[1]
        };
        let weights = self.above.weight.windows(3).zip(self.here.weight.windows(3)).zip(self.below.weight.windows(3));
        let weighted = self.above.weighted.windows(3).zip(self.here.weighted.windows(3)).zip(self.below.weighted.windows(3));
        let cells = probabilities.iter_mut().zip(confidences);
        for ((c, f), (((wa, wh), wb), ((sa, sh), sb))) in cells.zip(weights.zip(weighted)) {
            let mean = around(sa, sh, sb) / around(wa, wh, wb);
            let faded = (f.abs() - (*c - mean).abs()).max(0.0);
            *f = faded.copysign(*f);
            *c = ((1.0 - fade) * *c + fade * mean).clamp(0.0, 1.0);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use nalgebra::Point2;
    use proptest::prelude::*;

    use super::*;
    use crate::certainty_grid::{CellIndex, Layout, Rules};

    fn grid(width: usize, height: usize, cell: impl Fn(i32, i32) -> (f32, f32)) -> Grid {
        let layout = Layout { cell: 0.2, width, height, origin: Point2::origin() };
        let mut grid = Grid::new(layout, Rules::default()).unwrap();
        for row in 0..height as i32 {
            for column in 0..width as i32 {
                let (c, f) = cell(column, row);
                grid.restore(CellIndex::new(column, row), c, f);
            }
        }
        grid
    }

    /// `C` and `F` of the middle cell after so many decays; the grid is so large that its edge does not reach the middle.
    fn after(cycles: usize, fade: f32, cell: impl Fn(i32, i32) -> (f32, f32)) -> (f32, f32) {
        let size = 2 * cycles + 5;
        let mut grid = grid(size, size, cell);
        let mut decay = Decay::default();
        for _ in 0..cycles {
            decay.apply(&mut grid, fade);
        }
        let middle = CellIndex::new((size / 2) as i32 / 2 * 2, (size / 2) as i32 / 2 * 2);
        (grid.probability(middle), grid.confidence(middle))
    }

    #[test]
    fn a_checkerboard_fades_to_grey() {
        let board = |x: i32, y: i32| if (x + y) % 2 == 0 { (1.0, 6.0) } else { (0.0, -6.0) };
        let table = [
            (5, 0.05, 0.8869, 3.738),
            (10, 0.05, 0.7994, 1.987),
            (14, 0.05, 0.7438, 0.877),
            (15, 0.05, 0.7316, 0.633),
            (20, 0.05, 0.6792, 0.0),
            (5, 0.1, 0.7952, 3.952),
            (10, 0.1, 0.6743, 2.743),
            (14, 0.1, 0.6144, 2.144),
            (15, 0.1, 0.6029, 2.029),
            (20, 0.1, 0.5608, 1.608),
        ];
        for (cycles, fade, c, f) in table {
            let got = after(cycles, fade, board);
            assert!((got.0 - c).abs() < 1e-4 && (got.1 - f).abs() < 1e-3, "{cycles} at {fade}: {got:?}");
        }
    }

    #[test]
    fn a_thin_wall_fades_away() {
        let wall = |cycles: usize, fade| {
            let middle = (2 * cycles as i32 + 5) / 2 / 2 * 2;
            after(cycles, fade, move |x, _| if x == middle { (1.0, 6.0) } else { (0.0, -6.0) }).0
        };
        assert!((wall(1, 0.05) - 0.9625).abs() < 1e-4);
        assert!((wall(5, 0.05) - 0.8267).abs() < 1e-4);
        assert!(wall(7, 0.05) >= 0.75 && wall(8, 0.05) < 0.75);
        assert!(wall(17, 0.05) >= 0.5 && wall(18, 0.05) < 0.5);
        assert!(wall(3, 0.1) >= 0.75 && wall(4, 0.1) < 0.75);
        assert!(wall(9, 0.1) >= 0.5 && wall(10, 0.1) < 0.5);
    }

    #[test]
    fn a_lone_cell_sinks_into_the_background() {
        for (cycles, want) in [(1, 0.975), (5, 0.8921), (10, 0.8170), (15, 0.7625), (20, 0.7216)] {
            let middle = (2 * cycles as i32 + 5) / 2 / 2 * 2;
            let got = after(cycles, 0.05, move |x, y| if (x, y) == (middle, middle) { (1.0, 6.0) } else { (0.5, 0.0) }).0;
            assert!((got - want).abs() < 1e-4, "{cycles}: {got}");
        }
    }

    /// The definition, cell by cell, into a copy.
    fn naive(grid: &Grid, fade: f32) -> Grid {
        let mut faded = grid.clone();
        for row in 0..grid.height() as i32 {
            for column in 0..grid.width() as i32 {
                let (mut sum, mut weights) = (0.0, 0.0);
                for (dx, dy) in [(1, 0), (-1, 0), (0, -1), (0, 1), (1, 1), (-1, -1), (1, -1), (-1, 1)] {
                    let neighbour = CellIndex::new(column + dx, row + dy);
                    let inside = grid.contains(neighbour);
                    let c = if inside { grid.probability(neighbour) } else { grid.rules().edge_background };
                    let weight = grid.confidence(neighbour).abs() + 1.0;
                    sum += f64::from(c * weight);
                    weights += f64::from(weight);
                }
                let index = CellIndex::new(column, row);
                let (c, f) = (grid.probability(index), grid.confidence(index));
                let mean = (sum / weights) as f32;
                let magnitude = (f.abs() - (c - mean).abs()).max(0.0);
                faded.restore(index, c * (1.0 - fade) + mean * fade, if f < 0.0 { -magnitude } else { magnitude });
            }
        }
        faded
    }

    proptest! {
        #[test]
        fn agrees_with_the_definition(
            width in 1usize..9, height in 1usize..9, fade in 0.0..0.3f32,
            cells in prop::collection::vec((0.0..=1.0f32, -6.0..=6.0f32), 64),
        ) {
            let mut fast = grid(width, height, |x, y| cells[(y * 8 + x) as usize]);
            let slow = naive(&fast, fade);
            Decay::default().apply(&mut fast, fade);
            for (a, b) in fast.probabilities().iter().zip(slow.probabilities()) {
                prop_assert!((a - b).abs() < 1e-5 && (0.0..=1.0).contains(a));
            }
            for (a, b) in fast.confidences().iter().zip(slow.confidences()) {
                prop_assert!((a - b).abs() < 1e-4 && a.abs() <= 6.0);
            }
        }
    }
}
