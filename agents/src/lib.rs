//! What robots do.
//!
//! One folder per behaviour, the pure algorithm beside the agent that runs it. Agents never import each other; what several
//! of them need has a place of its own.
//!
//! | agent | kind | what it does |
//! |---|---|---|
//! | [`where_am_i`] | `where-am-i` | dead reckoning with covariance |
//! | [`avoidance`] | `avoidance` | slows down for what comes near, steps aside for what keeps coming |
//! | [`corridor_follower`] | `corridor-follower` | keeps to the middle of a corridor up to its next opening |
//! | [`patrol`] | `patrol` | sends the follower on from place to place |
//! | [`wander`] | `wander` | straight on until it touches something, turns away, and on |
//! | [`feature_detector`] | `feature-detector` | goes round walls, corners and wall ends to be sure of them |
//! | [`place_classifier`] | `place-classifier` | names the place that a robot has come to, by an influence diagram |
//! | [`geographer`] | `geographer` | explores a floor place by place, and draws its map |
//! | [`mapper`] | `mapper` | draws a certainty grid |
//!
//! Shared, and free of any agent: [`certainty_grid`], [`places`] (how they are laid out), [`clock_ring`] (what
//! sixteen sonars hear), [`crumbs`] (the way back).
#![forbid(unsafe_code)]

pub mod avoidance;
pub mod certainty_grid;
pub mod clock_ring;
pub mod corridor_follower;
pub mod crumbs;
pub mod feature_detector;
pub mod geographer;
pub mod mapper;
pub mod patrol;
pub mod place_classifier;
pub mod places;
pub mod wander;
pub mod where_am_i;

pub use avoidance::Avoidance;
pub use corridor_follower::CorridorFollower;
pub use feature_detector::FeatureDetector;
pub use geographer::Geographer;
pub use mapper::MapperAgent;
pub use patrol::Patrol;
pub use place_classifier::PlaceClassifier;
pub use wander::Wander;
pub use where_am_i::WhereAmI;
