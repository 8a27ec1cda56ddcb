//! A mobile base: what it can do, what it believes it did, and what it must never do.
//!
//! Everything here is pure: it is told the time and the readings, and answers. A driver or a simulation runs it.
//!
//! ```text
//!  decision ─▶ executor ─ demand ─▶ protection ─ permitted ─▶ driver ─▶ kinematics (simulated) ─▶ odometry
//! ```
//!
//! * [`kinematics`]: synchro, differential and bicycle drives under their acceleration limits, with presets;
//! * [`odometry`]: the error of dead reckoning, systematic and random;
//! * [`executor`]: turns a motion into a twist, period by period, and reports how far it has come;
//! * [`protection`]: the last stage before the driver;
//! * [`profile`]: the braking arithmetic that the executor and the protection share.

pub mod executor;
pub mod kinematics;
pub mod odometry;
pub mod presets;
pub mod profile;
pub mod protection;
