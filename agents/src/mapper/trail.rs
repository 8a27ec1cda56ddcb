//! What is known to be free because the robot has been there.

use nalgebra::{Point2, Vector2};

use super::TrailConfig;
use crate::certainty_grid::{Grid, level};

/// Where the robot has been: what is free beyond doubt, and the line that a picture shows.
#[derive(Debug, Clone)]
pub(super) struct Trail {
    config: TrailConfig,
    last: Option<Point2<f64>>,
    path: Vec<Point2<f32>>,
    /// Distance between two points of the path, m; doubles whenever the path is full.
    spacing: f64,
}

/// Most points of a path.
const LONGEST: usize = 8192;

impl Trail {
    pub(super) fn new(config: TrailConfig) -> Self {
        Self { config, last: None, path: Vec::with_capacity(LONGEST), spacing: 0.05 }
    }

    /// The robot is here now. Frees what it drove over since the last call, and returns how far that was, m: the length of a
    /// correction does not count.
    pub(super) fn advance(&mut self, grid: &mut Grid, here: Point2<f64>) -> f64 {
        let driven = self.last.map(|last| here - last).filter(|way| way.norm() <= self.config.longest_move);
        // While the robot stands, the ground under it stays what it is: free.
        if driven.is_some_and(|way| way.norm() < 0.02 * grid.cell_size()) {
            return 0.0;
        }
        let way = driven.unwrap_or(Vector2::zeros());
        let pieces = (way.norm() / (0.5 * grid.cell_size())).ceil().clamp(1.0, 1000.0);
        for piece in 1..=pieces as u32 {
            free_disc(grid, here - way * (1.0 - f64::from(piece) / pieces), self.config.radius);
        }
        self.last = Some(here);
        self.remember(here);
        way.norm()
    }

    /// The line the robot drove, oldest point first.
    pub(super) fn path(&self) -> &[Point2<f32>] {
        &self.path
    }

    fn remember(&mut self, here: Point2<f64>) {
        let here: Point2<f32> = here.cast();
        if self.path.last().is_some_and(|last| f64::from((here - last).norm()) < self.spacing) {
            return;
        }
        if self.path.len() == LONGEST {
            for i in 0..LONGEST / 2 {
                self.path[i] = self.path[2 * i];
            }
            self.path.truncate(LONGEST / 2);
            self.spacing *= 2.0;
        }
        self.path.push(here);
    }
}

/// Frees the cell of the centre, and all whose centre lies within the radius.
fn free_disc(grid: &mut Grid, centre: Point2<f64>, radius: f64) {
    let middle = grid.index_of(centre);
    grid.force(middle, level::HIGH_EMPTY);
    let reach = (radius / grid.cell_size()).ceil() as i32;
    for row in -reach..=reach {
        for column in -reach..=reach {
            let index = middle.offset(column, row);
            if (grid.centre_of(index) - centre).norm() <= radius {
                grid.force(index, level::HIGH_EMPTY);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::certainty_grid::{Layout, Rules};

    fn grid() -> Grid {
        Grid::new(Layout::around(Point2::origin(), 0.1, 4.0, 4.0), Rules::default()).unwrap()
    }

    #[test]
    fn everything_under_the_robot_is_free() {
        let mut grid = grid();
        let mut trail = Trail::new(TrailConfig { radius: 0.2, longest_move: 1.0 });
        assert_eq!(trail.advance(&mut grid, Point2::new(-0.5, 0.02)), 0.0);
        assert!((trail.advance(&mut grid, Point2::new(0.4, 0.02)) - 0.9).abs() < 1e-12);
        for i in 0..100 {
            let x = -0.6 + 0.011 * f64::from(i);
            for y in [-0.05, 0.02, 0.1] {
                assert_eq!(grid.confidence(grid.index_of(Point2::new(x, y))), -6.0, "{x} {y}");
            }
        }
        assert_eq!(grid.confidence(grid.index_of(Point2::new(0.0, 0.35))), 0.0);
    }

    #[test]
    fn a_correction_is_no_path() {
        let mut grid = grid();
        let mut trail = Trail::new(TrailConfig { radius: 0.0, longest_move: 0.5 });
        trail.advance(&mut grid, Point2::new(-1.0, 0.0));
        assert_eq!(trail.advance(&mut grid, Point2::new(1.0, 0.0)), 0.0);
        assert_eq!(grid.counts().free, 2);
    }

    #[test]
    fn a_long_path_is_thinned_not_cut() {
        let mut trail = Trail::new(TrailConfig::default());
        let steps = 20_000u16;
        (0..steps).for_each(|i| trail.remember(Point2::new(f64::from(i) * 0.1, 0.0)));
        assert_eq!(trail.path.capacity(), LONGEST);
        assert_eq!(trail.path()[0].x, 0.0);
        assert!(trail.path().last().unwrap().x > 1999.0);
        assert!(trail.path().len() > LONGEST / 4);
    }
}
