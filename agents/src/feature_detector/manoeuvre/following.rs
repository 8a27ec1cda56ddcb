//! Going along a wall (Randazza 1989, §4.4).

use orienteer_runtime::{
    agent::Aborted,
    topics::{FeatureReason, Side},
};

use super::{Ended, Manoeuvre};
use crate::{
    clock_ring::ClockRing,
    feature_detector::wall_tests::{Beside, abeam, wall_beside},
};

/// A wall that is nearer than this beside the robot is too near, m from the sonar's face; and by how much to turn off then, rad.
const TOO_NEAR: f64 = 0.30;
const OFF: f64 = 4.0 / 180.0 * std::f64::consts::PI;
/// So often a base that is kept from going on beside a wall this near, m from the sonar's face, is steered off it.
const NEAR: f64 = 0.36;
const BLOCKED: u32 = 2;

/// How a wall was followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Followed {
    /// The wall ended before the length that was asked for.
    pub wall_ended: bool,
    /// How far it went, m.
    pub length: f64,
}

impl Manoeuvre {
    /// Follows the wall on a side for a length, or until it ends.
    pub async fn follow(&self, side: Side, length: f64) -> Result<Followed, Aborted> {
        self.undisturbed(async || self.follow_once(side, length).await).await
    }

    async fn follow_once(&self, side: Side, length: f64) -> Result<Followed, Aborted> {
        let start = self.travelled()?;
        let (mut missing, mut blocked) = (0, 0);
        let mut wall_ended = !self.is_wall_beside(side).await?;
        if !wall_ended {
            self.cruise(self.config.speed)?;
        }
        while !wall_ended && missing < self.config.tries {
            let ring = match self.ring_within(start + length).await {
                // By the wall that it follows, or by something else?
                Err(Aborted::Blocked) if blocked < BLOCKED && self.ring().await?[abeam(side)] < NEAR => {
                    blocked += 1;
                    self.steer_off(side).await?;
                    self.cruise(self.config.speed)?;
                    continue;
                }
                ring => ring?,
            };
            let Some(ring) = ring else { break };
            missing = if wall_beside(&ring, side) == Beside::Wall { 0 } else { missing + 1 };
            wall_ended = missing >= self.config.tries;
            if missing == 0 && self.turn_off(side, &ring).await? {
                self.cruise(self.config.speed)?;
            }
        }
        self.stand().await?;
        Ok(Followed { wall_ended, length: self.travelled()? - start })
    }

    /// Turns a little off a wall that is too near to be followed: so near, the beams hear the same over several degrees, and an alignment
    /// leaves the robot on its way into the wall. Says whether it did.
    pub(super) async fn turn_off(&self, side: Side, ring: &ClockRing) -> Result<bool, Aborted> {
        let near = ring[abeam(side)] < TOO_NEAR;
        if near {
            self.steer_off(side).await?;
        }
        Ok(near)
    }

    async fn steer_off(&self, side: Side) -> Result<(), Aborted> {
        self.stand().await?;
        self.turn(-side.sign() * OFF).await
    }

    /// Follows the wall on a side until there is something as near ahead as `front`.
    pub async fn follow_to_corner(&self, side: Side, longest: f64, front: f64) -> Result<(), Ended> {
        let wrong = self.undisturbed(async || self.follow_to_corner_once(side, longest, front).await).await?;
        wrong.map_or(Ok(()), |reason| Err(Ended::NotFound(reason)))
    }

    /// Says what is wrong, if anything is.
    async fn follow_to_corner_once(&self, side: Side, longest: f64, front: f64) -> Result<Option<FeatureReason>, Aborted> {
        let start = self.travelled()?;
        let mut missing = 0;
        let mut ended = (!self.is_wall_beside(side).await?).then_some(FeatureReason::NoWallBeside);
        if ended.is_none() {
            self.cruise(self.config.speed)?;
        }
        while ended.is_none() {
            let Some(ring) = self.ring_within(start + longest).await? else {
                ended = Some(FeatureReason::WallTooLong);
                break;
            };
            if ring[0] <= front {
                break;
            }
            missing = if wall_beside(&ring, side) == Beside::Wall { 0 } else { missing + 1 };
            ended = (missing >= self.config.tries).then_some(FeatureReason::WallTooShort);
        }
        self.stand().await?;
        Ok(ended)
    }
}
