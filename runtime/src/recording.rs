//! Recordings: one MCAP file per mission, the same bytes for the same configuration and seed.
//!
//! [MCAP](https://mcap.dev/spec) is a container for time-stamped messages that Foxglove and Lichtblick open as it is. A
//! [`Track`] beside each robot encodes what the robot's topics carry; once a step the tracks hand their [`Entries`] over, in the
//! robots' order, to the one [`Recorder`], which writes the file on a thread of its own. A [`Reader`] opens what was written,
//! also when the file is cut off.
//!
//! ```
//! use orienteer_runtime::{geometry::Pose, recording::*, time::Time, topics::PoseEstimate};
//! use std::time::Duration;
//!
//! let mission = Mission { seed: 7, robots: vec![RobotInfo::new("ann", ["avoidance", "corridor"])], ..Mission::default() };
//! let mut recorder = Recorder::start(Sink::Memory, &mission, ChunkLimits::default())?;
//! let mut track = Track::new(0, "ann", None);
//! for step in 1..=20 {
//!     let now = Time::START + Duration::from_millis(50) * step;
//!     track.begin(now);
//!     track.record(&PoseEstimate { stamp: now, pose: Pose::new(f64::from(step), 0.0, 0.0), ..Default::default() });
//!     recorder.append(track.entries());
//! }
//! let summary = recorder.finish()?;
//!
//! let reader = Reader::from_bytes(summary.memory.unwrap_or_default())?;
//! assert_eq!(reader.mission().seed, 7);
//! let last = reader.latest::<PoseEstimate>("ann", Time::from_secs_f64(0.52))?;
//! assert_eq!(last.map(|(at, sample)| (at, sample.pose.x)), Some((Time::from_secs_f64(0.5), 10.0)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What is inside
//!
//! | where | what |
//! |---|---|
//! | metadata `orienteer` | `layout`, `version`, `seed`, `duration_ns`, `control_period_ns`, `sources`, `robots` (JSON: names, and each robot's clients in the order of [`ClientId`](crate::topics::ClientId)) |
//! | attachments | the configuration's source files, byte by byte |
//! | channels | see below; channel metadata `type` is the payload's versioned type name |
//!
//! | topic | schema | from |
//! |---|---|---|
//! | `/<robot>/<payload's topic>` | `orienteer/<Payload>`, ROS 1 message (JSON for payloads of your own that hold more than numbers) | every payload given to [`Track::record`], bit by bit |
//! | `/<robot>/sonar/laser` | `foxglove.LaserScan`, frame `<robot>/base` | [`SonarScan`](crate::topics::SonarScan) of a ring whose transducers stand evenly on a circle |
//! | `/<robot>/sonar/points` | `foxglove.PointCloud`, frame `<robot>/base` | [`SonarScan`](crate::topics::SonarScan) of any other ring |
//! | `/<robot>/pose/view` | `foxglove.PoseInFrame`, frame `map` | [`PoseEstimate`](crate::topics::PoseEstimate) |
//! | `/<robot>/pose/transform` | `foxglove.FrameTransform`, `map` to `<robot>/base` | [`PoseEstimate`](crate::topics::PoseEstimate) |
//! | `/<robot>/truth/view` | `foxglove.PoseInFrame`, frame `map` (which starts as the world's frame) | [`Truth`](crate::topics::Truth) |
//! | `/<robot>/<name>` | `foxglove.Grid`, frame `map` | [`Track::record_grid`] |
//! | `/<robot>/log` | `foxglove.Log` | [`Track::log`] |
//!
//! # Why the bytes are the same every time
//!
//! Log times are simulated times; the order of messages is the order of steps, robots and [`Track::record`] calls; chunks
//! close by content and log time alone; nothing else (host, wall time, threads) enters the file. Field comments are part of the
//! message definitions, so editing a payload's documentation changes the bytes, though not what they can be read as.
//!
//! # What survives
//!
//! Chunks are written and handed to the operating system as they close, so a killed process loses at most the chunk that was
//! open and what was on its way to it; [`ChunkLimits`] bounds both in bytes and in time. The summary at the end is for
//! fast seeking only.

mod compare;
mod definition;
mod entries;
mod file;
mod grid;
mod messages;
mod mission;
mod packed;
mod payload;
mod reader;
mod record;
mod recorder;
mod scan;
mod track;
mod unpacked;
mod views;

pub use compare::Difference;
pub use entries::Entries;
pub use file::{ChunkLimits, RecordError, RecordingSummary, Sink, may_be_replaced};
pub use grid::GridImage;
pub use messages::{LogLine, Messages};
pub use mission::{LAYOUT, Mission, RobotInfo, Source};
pub use reader::{Ending, ReadError, Reader};
pub use recorder::Recorder;
pub(crate) use recorder::complete_all;
pub use track::Track;

/// Hex digits of a SHA-256 sum.
fn hex(digest: &[u8]) -> String {
    digest.iter().fold(String::with_capacity(2 * digest.len()), |text, byte| text + &format!("{byte:02x}"))
}
