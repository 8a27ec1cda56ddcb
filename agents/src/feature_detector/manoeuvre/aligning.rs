//! Facing a wall, or standing along it (Randazza 1989, §4.3).

use orienteer_runtime::topics::{FeatureReason, Side};

use super::{COARSE, Ended, Manoeuvre, ONE_WALL};
use crate::{clock_ring::DIRECTIONS, feature_detector::wall_tests::abeam};

/// How many coarse steps there may be one way, and of how many fine ones, of this size, rad.
const COARSE_STEPS: i32 = 12;
const FINE: f64 = 1.0 / 180.0 * std::f64::consts::PI;
const FINE_STEPS: i32 = 25;
/// So many changes of direction end an alignment: the noise decides by then.
const THRASHES: i32 = 5;
/// Two ranges are the same within this, m: half the step in which a Denning ring counts.
const SAME: f64 = 0.016;
/// Who turned by more than this to face a wall has met something else, rad.
const SKEWED: f64 = 25.0 / 180.0 * std::f64::consts::PI;

impl Manoeuvre {
    /// Brings the robot parallel to the wall on a side, or a little off it if that is too near.
    pub async fn align_beside(&self, side: Side) -> Result<(), Ended> {
        self.align(abeam(side), false).await?;
        self.turn_off(side, &self.ring().await?).await?;
        Ok(())
    }

    /// Brings the robot perpendicular to the wall ahead.
    pub async fn align_ahead(&self) -> Result<(), Ended> {
        let turned = self.align(0, true).await?;
        if turned.abs() > SKEWED { Err(Ended::NotFound(FeatureReason::Skewed)) } else { Ok(()) }
    }

    /// Turns until the given direction hears the nearest and its neighbours hear the same: coarse steps, then fine ones. Says how
    /// far it has turned, to the left.
    async fn align(&self, middle: usize, ahead: bool) -> Result<f64, Ended> {
        let coarse = self.align_coarsely(middle, ahead).await?;
        let fine = self.align_finely(middle).await?;
        Ok(coarse + fine)
    }

    async fn align_coarsely(&self, middle: usize, ahead: bool) -> Result<f64, Ended> {
        let mut steps = [0; 2];
        loop {
            let ring = self.ring().await?;
            let off = |by: i32| ring[(middle as i32 + by).rem_euclid(DIRECTIONS as i32) as usize];
            // Where several are as near, the middle one counts.
            let nearest = [0, -1, 1, -2, 2].into_iter().fold(0, |nearest, by| if off(by) < off(nearest) { by } else { nearest });
            // Beams that are about perpendicular hear the same; what is ahead need not be nearest by more than the noise.
            if nearest == 0 || (ahead && off(0) <= off(nearest) + SAME) {
                return Ok(COARSE * f64::from(steps[0] - steps[1]));
            }
            // Nearest before the middle, clockwise: the nose goes to the left.
            let way = usize::from(nearest > 0);
            steps[way] += 1;
            if steps[way] > COARSE_STEPS {
                return Err(Ended::NotFound(FeatureReason::NotAligned));
            }
            self.turn(if way == 0 { COARSE } else { -COARSE }).await?;
        }
    }

    async fn align_finely(&self, middle: usize) -> Result<f64, Ended> {
        let (mut steps, mut thrashes, mut turned) = (0, 0, 0.0);
        let mut last = 0.0;
        loop {
            let ring = self.ring().await?;
            let before = ring[(middle + DIRECTIONS - 1) % DIRECTIONS];
            let after = ring[(middle + 1) % DIRECTIONS];
            if (after - before).abs() < SAME || (after - before).abs() > ONE_WALL {
                return Ok(turned);
            }
            // The one before is nearer: the nose goes to the left.
            let step = if after > before { FINE } else { -FINE };
            if last * step < 0.0 {
                thrashes += 1;
                if thrashes >= THRASHES {
                    return Ok(turned);
                }
            } else {
                steps += 1;
                if steps > FINE_STEPS {
                    return Err(Ended::NotFound(FeatureReason::NotAligned));
                }
            }
            self.turn(step).await?;
            (turned, last) = (turned + step, step);
        }
    }
}
