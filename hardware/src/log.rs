//! Robots that only repeat what was recorded.
//!
//! A log of poses and sonar readings is played through the same two driver traits as any robot: [`LogBase`] reports the recorded
//! poses as odometry and ignores commands, [`LogSonar`] gives the recorded readings as scans. Both share one parsed [`SonarLog`].
//!
//! # Format
//!
//! Two text files, one line per entry, numbers separated by blanks, empty lines ignored:
//!
//! ```text
//! measurement.txt   time z1 … z8           ms, mm in steps of 10; 5110 is no echo
//! poses.txt         time x y heading       ms, mm, mm, 0.1°
//! ```
//!
//! Every time occurs in both files, and times grow.
//!
//! # Frames, as found in the data
//!
//! The log of the RoboND course (413 entries, 92.8 s, 25.0 m) does not state its conventions. In all 362 steps longer than 3 cm
//! the direction of motion agrees with the heading, counted **counter-clockwise** from x with y to the left, within 1.2° (mean
//! −0.03°); counted clockwise only 176 of them agree within 10°. So headings need no change of sign, and the robot never reverses.
//! The readings z1 … z8 look along −90, −37.5, −22.5, −7.5, 7.5, 22.5, 37.5 and 90°, also counter-clockwise (z1 to the right): so
//! mapped, 420 of the 10 cm cells that an echo shorter than 3 m hits are contradicted by other beams that pass through, with the opposite
//! sign 475.
//! Where the sonars sit on the body is not known; they are taken to be at its centre.

mod parse;
mod play;

pub use parse::{Entry, LogError, MEASUREMENTS, POSES, SONARS, SonarLog};
pub use play::{LogBase, LogSonar, platform, players, ring};

#[cfg(test)]
mod tests;
