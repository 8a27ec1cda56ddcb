//! How Orienteer's actors live.
//!
//! This crate knows nothing of any particular behaviour or device. From the ground up:
//!
//! | layer | modules |
//! |---|---|
//! | common terms | [`geometry`], [`time`], [`random`], [`recall`], [`robot_model`], [`topics`] |
//! | between actors | [`link`] carries topics, [`arbitration`] decides who has the base and the sonar |
//! | one actor | [`agent`]: what a behaviour is; [`agents`]: the kinds that there are; [`host`]: the actor that runs one |
//! | many actors | [`robot`] steps its nodes, [`fleet`] its robots, [`clock`] says when |
//! | around them | [`config`] says what there is, [`recording`] keeps what happened |
#![deny(unsafe_code)]

pub mod agent;
pub mod agents;
pub mod arbitration;
pub mod clock;
pub mod config;
pub mod descriptors;
pub mod fleet;
pub mod geometry;
pub mod host;
pub mod link;
pub mod random;
pub mod recall;
pub mod recording;
pub mod robot;
pub mod robot_model;
pub mod time;
pub mod topics;
