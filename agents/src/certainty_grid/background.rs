//! The value of ground nobody has looked at (Good 1992, §2.1).

use super::{CellIndex, Grid, Window, level};

/// Difference from the background below which a cell with little evidence counts as unknown.
const NEAR_BACKGROUND: f32 = 0.1;

/// What a survey of the surroundings found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Survey {
    /// The new background: mean probability around the robot.
    pub background: f32,
    /// True if the background now counts as occupied or as empty, so that the map will look walled up or wide open.
    pub extreme: bool,
}

impl Grid {
    /// True if nothing is known of the cell: `C` differs from the background by less than 0.1 and `F` lies between -1 and 1.
    #[must_use]
    pub fn is_unknown(&self, index: CellIndex) -> bool {
        is_unknown(self.probability(index), self.confidence(index), self.rules.background)
    }

    /// Changes the background, inside for cells to come and beyond the edge for decay. Cells keep their values.
    pub fn set_background(&mut self, background: f32) {
        let background = background.clamp(0.0, 1.0);
        self.rules.background = background;
        self.rules.edge_background = background;
    }

    /// Takes the mean probability of the cells at most `reach` columns and rows from `centre` as the background. Cells about
    /// which little is known, with a probability between medium empty and medium occupied or at the old background,
    /// become unknown. The caller has scanned around before and let the map decay a little. (The source: seven decays of 0.1;
    /// a reach of three eighths of the sonars' range.)
    pub fn survey_background(&mut self, centre: CellIndex, reach: u32) -> Survey {
        let reach = reach.min(1 << 15) as i32;
        let side = 2 * reach as usize + 1;
        let around = Window { first: centre.offset(-reach, -reach), width: side, height: side };
        let seen = around.intersection(&self.window);
        let old = self.rules.background;
        let (mut sum, mut count) = (0.0f64, 0u32);
        for row in 0..seen.height as i32 {
            for column in 0..seen.width as i32 {
                sum += f64::from(self.probability(seen.first.offset(column, row)));
                count += 1;
            }
        }
        let background = if count == 0 { old } else { (sum / f64::from(count)) as f32 };
        for (c, f) in self.probabilities.iter_mut().zip(&mut self.confidences) {
            if *c == old || (*c > level::MEDIUM_EMPTY && *c < level::MEDIUM_OCCUPIED) {
                (*c, *f) = (background, 0.0);
            }
        }
        self.set_background(background);
        let thresholds = self.rules.thresholds;
        Survey { background, extreme: background >= thresholds.occupied || background <= thresholds.empty }
    }
}

pub(super) fn is_unknown(probability: f32, confidence: f32, background: f32) -> bool {
    (probability - background).abs() < NEAR_BACKGROUND && confidence.abs() <= 1.0
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use nalgebra::Point2;

    use super::*;
    use crate::certainty_grid::{Layout, Rules};

    #[test]
    fn a_survey_takes_the_mean_around_the_robot() {
        let layout = Layout { cell: 0.2, width: 9, height: 9, origin: Point2::origin() };
        let mut grid = Grid::new(layout, Rules::default()).unwrap();
        grid.restore(CellIndex::new(4, 4), 0.0, -6.0);
        grid.restore(CellIndex::new(4, 5), 0.4, -2.0);
        grid.restore(CellIndex::new(8, 8), 1.0, 3.0);
        let survey = grid.survey_background(CellIndex::new(4, 4), 1);
        let want = (7.0 * 0.5 + 0.4) / 9.0;
        assert!((survey.background - want).abs() < 1e-6 && !survey.extreme);
        assert_eq!(grid.rules().background, survey.background);
        assert_eq!(grid.rules().edge_background, survey.background);
        // vague cells follow, clear ones stay
        assert_eq!((grid.probability(CellIndex::new(4, 5)), grid.confidence(CellIndex::new(4, 5))), (survey.background, 0.0));
        assert_eq!(grid.probability(CellIndex::new(0, 8)), survey.background);
        assert_eq!(grid.probability(CellIndex::new(4, 4)), 0.0);
        assert_eq!(grid.probability(CellIndex::new(8, 8)), 1.0);
        assert!(grid.is_unknown(CellIndex::new(0, 0)) && !grid.is_unknown(CellIndex::new(4, 4)));
    }

    #[test]
    fn a_survey_beyond_the_grid_changes_nothing() {
        let layout = Layout { cell: 0.2, width: 3, height: 3, origin: Point2::origin() };
        let mut grid = Grid::new(layout, Rules::default()).unwrap();
        let survey = grid.survey_background(CellIndex::new(i32::MAX, -500), u32::MAX);
        assert_eq!(survey, Survey { background: 0.5, extreme: false });
    }
}
