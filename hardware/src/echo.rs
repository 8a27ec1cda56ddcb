//! What a sonar hears: the echo model of the simulated world.
//!
//! # The idea
//!
//! At 40–50 kHz a wall is a mirror. A transducer floods a cone with sound and reports the *nearest surface that sends some of
//! it back*: a wall answers only where the beam meets it within a few degrees of its normal, and a slanted wall in front
//! hides what lies behind without being heard itself (Good 1992, "false empty"; MacPherson 1993, §III: ±15° of the normal).
//! Edges and corners scatter, so they answer at any angle, but only from close by.
//!
//! Let `r(θ)` be the distance to the first surface in direction `θ` and `φ(θ)` the angle of incidence there. The range is
//!
//! ```text
//! min { r(θ) : |θ| ≤ half beam,  r(θ) ≤ max range,  φ(θ) ≤ limit(r(θ)),  reflectance ≥ threshold(r(θ)) }
//! ```
//!
//! together with the distances of visible vertices within their own range. Bundles of rays approximate this minimum from
//! above; [`cone`] computes it exactly and is faster.
//!
//! # Parts
//!
//! * [`SegmentGrid`] holds the static world: walls, vertices and pillars in a uniform grid of lists.
//! * [`cone`] asks what one transducer hears, noise aside; [`first_surface`] what a thin ray meets.
//! * [`SonarModel`] says what answers and how a reading is spoilt; [`Acoustics`] is the same, checked and ready for use.
//! * [`Pinger`] runs a ring through its firing program and produces [`SonarScan`](orienteer_runtime::topics::SonarScan)s.
//!
//! Everything is a pure function of its arguments; once warm nothing allocates.

mod acoustics;
mod beam;
mod bounce;
mod columns;
mod cone;
mod grid;
mod model;
#[cfg(test)]
mod oracle;
mod pinger;
mod span;

pub use acoustics::{Acoustics, RangeGate};
pub use beam::{Answer, Beam, Contact, MAX_HALF_BEAM, Source};
pub use bounce::second_bounce;
pub use cone::{Scratch, cone, first_surface};
pub use grid::{Disc, GridError, PERSON_REFLECTANCE, SegmentGrid, Vertex, Wall};
pub use model::{DetectionPoint, IncidencePoint, ModelError, SonarModel};
pub use pinger::{Pinger, PingerError};
