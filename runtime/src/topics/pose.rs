//! Topics that say where the robot is.

use iceoryx2::prelude::ZeroCopySend;
use nalgebra::Matrix3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Payload;
use crate::{
    geometry::{Pose, Twist},
    time::Time,
};

/// Where the robot thinks it is, in the map frame. Topic `pose`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::PoseEstimate.v1")]
pub struct PoseEstimate {
    /// The time of the odometry that this estimate rests on.
    pub stamp: Time,
    /// Estimated pose, map frame, m and rad.
    pub pose: Pose,
    /// Covariance of (x, y, heading), row by row; m², m·rad, rad².
    pub covariance: [f64; 9],
    /// Path length driven since the start, m.
    pub travelled: f64,
}

impl PoseEstimate {
    /// The covariance as a matrix.
    #[must_use]
    pub fn covariance(&self) -> Matrix3<f64> {
        Matrix3::from_row_slice(&self.covariance)
    }
}

impl Payload for PoseEstimate {
    const TOPIC: &'static str = "pose";
}

/// Where a simulated robot really is. Topic `truth`; for the recording and for experiments, never for behaviours.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::Truth.v1")]
pub struct Truth {
    /// Simulated time.
    pub stamp: Time,
    /// True pose, world frame.
    pub pose: Pose,
    /// True velocity.
    pub twist: Twist,
    /// How often the robot has driven into something.
    pub collisions: u32,
    /// How often something has walked into the robot while it stood or gave way.
    pub bumped: u32,
}

impl Payload for Truth {
    const TOPIC: &'static str = "truth";
}
