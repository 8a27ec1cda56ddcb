//! What robots are made of.
//!
//! | layer | modules |
//! |---|---|
//! | devices as nodes | [`nodes`]: base and sonar, each over a driver |
//! | what every driver has to do | [`conformance`](mod@conformance): as tests |
//! | devices elsewhere | [`remote`]: base and sonar in a process of their own |
//! | drivers | [`driver`]: what one is; [`sim`]: simulated; [`log`]: played from a recorded log; [`fault`]: one that fails on purpose |
//! | real devices | [`arcos`]: a session with a Pioneer; [`oi`]: one with a Create; [`wire`]: the languages of real devices, as bytes and packets; [`line`](mod@line): serial ports and network connections |
//! | other ends | [`emulator`]: simulated robots that speak those languages |
//! | bases | [`base`]: kinematics, odometry, motions, protection |
//! | sonars | [`rings`]: where transducers sit; [`echo`]: what they hear |
//! | surroundings | [`world`]: walls, doors, people |
#![forbid(unsafe_code)]

pub mod arcos;
pub mod base;
pub mod conformance;
pub mod driver;
pub mod drivers;
pub mod echo;
pub mod emulator;
pub mod fault;
pub mod line;
pub mod log;
pub mod nodes;
pub mod oi;
pub mod remote;
pub mod rings;
pub mod sim;
pub mod wire;
pub mod world;
