//! Sonar rings by name, and rings of your own.
//!
//! A [`NamedRing`] is where the transducers are, when they fire, and how they hear
//! ([`SonarModel`](crate::echo::SonarModel)). Indices are those of the ring's source, so that programs and tables of that source
//! can be used as they stand; frames are ours (x forward, y to the left, counter-clockwise).
//!
//! | name | robot | transducers | source |
//! |---|---|---|---|
//! | `denning-16` | Huey, a Denning base | 16, clockwise from the front | Randazza 1989 |
//! | `luey-8-square` | Luey | 4 parallel pairs | Good 1992 |
//! | `luey-8-front` | Luey | 3 parallel pairs, 2 at ±45° | Good 1992 |
//! | `yamabico-12` | Yamabico-11 | 12 in 3 groups | MacPherson 1993 |
//! | `wheelchair-6` | a powered wheelchair | 6, two of them crossed | Shanley 1994 |
//! | `p3dx-16` | Pioneer 3-DX | 8 in front, 8 behind | ARIA, `p3dx.p` |
//! | `amigobot-8` | AmigoBot | 6 in front, 2 behind | ARIA, `amigo.p` |
//! | `robond-8` | an indoor log | 8, all in the middle | RoboND occupancy grid mapping |
//!
//! A ring of your own is a [`RingConfig`]:
//!
//! ```
//! use orienteer_hardware::rings::RingConfig;
//!
//! let config: RingConfig = toml::from_str("
//!     max_range = 4.0
//!     half_beam_deg = 15.0
//!     [[transducer]]
//!     x = 0.1
//!     bearing_deg = 0.0
//!     [[transducer]]
//!     y = 0.1
//!     bearing_deg = 90.0
//! ")?;
//! let ring = config.ring("bumper")?;
//! assert_eq!(ring.transducers.len(), 2);
//! assert_eq!(ring.program.slots[..], [0b01, 0b10]); // one after the other unless told otherwise
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod config;
mod cover;
mod named;

pub use config::{RingConfig, RingError, TransducerConfig};
pub use cover::widest_gap;
pub(crate) use named::robond_8;
pub use named::{NamedRing, all, find};
