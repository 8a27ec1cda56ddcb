//! Poses, twists and angles in the plane.
//!
//! One convention holds everywhere inside Orienteer: right-handed frames, `x` forward, `y` to the left, headings
//! counter-clockwise from `x`, metres, radians and seconds. Sources that count clockwise or in centimetres are converted
//! where they enter.
//!
//! * [`Pose`] is an element of SE(2), the transformation group of MacPherson (1993), §3: [`Pose::then`] composes,
//!   [`Pose::inverse`] inverts, [`Pose::between`] gives one pose as seen from another.
//! * [`Twist`] is a body velocity; [`Pose::after`] moves along the circular arc that a constant twist describes.
//! * [`angle`] wraps angles.

pub mod angle;
mod pose;
mod twist;

pub use pose::Pose;
pub use twist::{Limits, Twist};
