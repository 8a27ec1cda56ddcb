//! Orienteer: mobile robots that find their way by sonar, as actors.
//!
//! This is the whole framework behind one name: [`runtime`] is how actors live, [`hardware`] what robots are made of,
//! [`agents`] what they do. [`mission`] turns a configuration into a running fleet; [`Registry`] holds what a configuration may
//! name, and is the place to add agents and drivers of your own; [`cli::main`] makes a program of it, with all commands.
//!
//! ```no_run
//! use orienteer::{Registry, mission::{self, RunOptions}};
//!
//! let registry = Registry::standard();
//! let mission = mission::load("configs/office-floor.toml", &registry).map_err(|problems| problems.to_string())?;
//! let outcome = mission::run(mission, &registry, RunOptions::default()).map_err(|error| error.to_string())?;
//! println!("{} robots, {}", outcome.robots.len(), outcome.time);
//! # Ok::<(), String>(())
//! ```
#![forbid(unsafe_code)]

pub mod cli;
pub mod emulate;
pub mod mission;
mod registry;
pub mod reproduce;

pub use orienteer_agents as agents;
pub use orienteer_hardware as hardware;
pub use orienteer_runtime as runtime;
pub use registry::Registry;
