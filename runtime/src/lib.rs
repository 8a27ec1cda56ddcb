//! How Orienteer's actors live.
//!
//! This crate knows nothing of any particular behaviour or device. It gives them time ([`time`]), a common geometry
//! ([`geometry`]), named random streams ([`random`]), typed topics ([`topics`]) and a description of the robot they run on
//! ([`robot_model`]), and it decides who drives ([`arbitration`]).
#![forbid(unsafe_code)]

pub mod arbitration;
pub mod geometry;
pub mod random;
pub mod robot_model;
pub mod time;
pub mod topics;
