//! Getting to where a feature is expected, and into a doorway (Randazza 1989, §4.5).

use std::f64::consts::FRAC_PI_2;

use orienteer_runtime::{
    agent::{Aborted, PoseHandle, Strategy},
    geometry::{Pose, angle},
    topics::{FeatureReason, FeatureSearch, Side},
};

use super::{Ended, Manoeuvre, ONE_WALL};
use crate::feature_detector::wall_tests::{Beside, abeam, wall_beside};

/// Who is kept from coming nearer than this to where it should stand first is near enough, m.
const NEARLY_THERE: f64 = 0.10;

impl Manoeuvre {
    /// Brings the robot, which stands before a doorway, to the middle of its thickness, and to the right distance from the post on
    /// that side.
    pub async fn between_doorposts(&self, side: Side) -> Result<(), Ended> {
        let config = &self.config;
        let mut steps = 0;
        while self.ring().await?[abeam(side)] > config.doorpost {
            if steps == config.doorpost_steps {
                return Err(Ended::NotFound(FeatureReason::NoWallBeside));
            }
            steps += 1;
            self.creep(0.05).await?;
        }
        self.cruise(config.creep_speed)?;
        let end = self.travelled()? + 2.0 * config.wall_thickness + config.wall_overshoot;
        let mut passed = false;
        while let Some(ring) = self.ring_within(end).await? {
            passed = ring[abeam(side)] > config.doorpost;
            if passed {
                break;
            }
        }
        self.stand().await?;
        if !passed {
            return Err(Ended::NotFound(FeatureReason::WallTooLong));
        }
        self.creep(-(0.5 * config.wall_thickness + config.wall_overshoot)).await?;
        self.turn(side.sign() * FRAC_PI_2).await?;
        self.close_up(config.doorpost_distance).await?;
        self.turn(-side.sign() * FRAC_PI_2).await?;
        Ok(())
    }

    /// Drives to a pose. Where the base can't go on just before it, that will do.
    async fn reach(&self, at: Pose, strategy: Strategy) -> Result<(), Aborted> {
        match self.go_to(PoseHandle::at(at), strategy).await {
            Err(Aborted::Blocked) if self.pose()?.distance(&at) < NEARLY_THERE => {
                self.turn(angle::turn(self.pose()?.heading, at.heading)).await
            }
            ended => ended,
        }
    }

    /// What all detectors begin with: goes to where the feature is expected, faces its wall, and comes near.
    pub async fn approach(&self, search: &FeatureSearch) -> Result<(), Ended> {
        // Whichever side has one wall all along tells how the robot really stands; the way to the place turns with it.
        let before = self.pose()?;
        let ring = self.ring().await?;
        let whole = |side: Side| {
            let (before, after) = (ring[abeam(side) - 1], ring[abeam(side) + 1]);
            wall_beside(&ring, side) == Beside::Wall && (before - after).abs() < 0.5 * ONE_WALL
        };
        if let Some(side) = [Side::Right, Side::Left].into_iter().find(|side| whole(*side)) {
            self.align_beside(side).await?;
        }
        let strategy = if search.forward_first { Strategy::ForwardFirst } else { Strategy::Straight };
        let at = self.pose()?.then(before.between(search.at));
        self.reach(at, strategy).await?;
        if !self.is_wall_ahead().await? {
            return Err(Ended::NotFound(FeatureReason::NoWallAhead));
        }
        self.align_ahead().await?;
        self.close_up(self.config.clearance).await?;
        Ok(())
    }
}
