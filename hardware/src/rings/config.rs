//! A ring that is written out in a mission.

use orienteer_runtime::{
    geometry::Pose,
    robot_model::{Ring, Transducer},
    topics::{FiringProgram, FixedVec, MAX_TRANSDUCERS},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// One transducer of a [`RingConfig`].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TransducerConfig {
    /// Where its face is, m forward of the robot's centre.
    #[schemars(range(min = -5.0, max = 5.0))]
    pub x: f64,
    /// Where its face is, m to the left of the robot's centre.
    #[schemars(range(min = -5.0, max = 5.0))]
    pub y: f64,
    /// Where its beam points, degrees counter-clockwise from forward.
    #[schemars(range(min = -360.0, max = 360.0))]
    pub bearing_deg: f64,
    /// Half its beam's opening angle, degrees, if it differs from the ring's.
    #[schemars(range(min = 0.1, max = 40.0))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub half_beam_deg: Option<f64>,
}

/// A sonar ring as a user describes it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RingConfig {
    /// Anything nearer to the face of a transducer than this reads as too near, m.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub min_range: f64,
    /// Nothing beyond this is heard, m from the face of a transducer.
    #[schemars(range(min = 0.1, max = 100.0))]
    pub max_range: f64,
    /// Half the opening angle of every beam that does not bring its own, degrees.
    #[schemars(range(min = 0.1, max = 40.0))]
    pub half_beam_deg: f64,
    /// Seconds from one slot of the firing program to the next. Sound needs 5.9 ms for each metre there and back.
    #[schemars(range(min = 0.0001, max = 10.0))]
    pub slot_time: f64,
    /// Least seconds from the start of a pass to the start of the next.
    #[schemars(range(min = 0.0, max = 60.0))]
    pub period: f64,
    /// Which transducers (from 0) fire together, slot by slot. Empty: one after the other, in order.
    #[schemars(length(max = 32))]
    pub slots: Vec<Vec<usize>>,
    /// The transducers, in the order of scans.
    #[schemars(length(max = 32))]
    pub transducer: Vec<TransducerConfig>,
}

impl Default for RingConfig {
    /// The figures of the common electrostatic ranging unit, and no transducer.
    fn default() -> Self {
        Self {
            min_range: 0.1,
            max_range: 6.0,
            half_beam_deg: 15.0,
            slot_time: 0.04,
            period: 0.0,
            slots: Vec::new(),
            transducer: Vec::new(),
        }
    }
}

/// Why a [`RingConfig`] is no ring.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RingError {
    /// No transducer at all.
    #[error("ring `{0}` has no transducer")]
    Empty(String),
    /// More than a scan can hold.
    #[error("ring `{name}` has {count} {what}, at most {MAX_TRANSDUCERS} are possible")]
    TooMany {
        /// The ring.
        name: String,
        /// How many there are.
        count: usize,
        /// `transducers` or `slots`.
        what: &'static str,
    },
    /// A slot names a transducer that does not exist.
    #[error("slot {slot} of ring `{name}` fires transducer {transducer}, but the ring has only 0 to {last}")]
    NoSuchTransducer {
        /// The ring.
        name: String,
        /// The slot, from 0.
        slot: usize,
        /// What it names.
        transducer: usize,
        /// The ring's last transducer.
        last: usize,
    },
    /// A number is not finite or out of its documented range.
    #[error("`{field}` of ring `{name}` is out of range")]
    OutOfRange {
        /// The ring.
        name: String,
        /// The key.
        field: &'static str,
    },
}

impl RingConfig {
    /// The ring of that name.
    ///
    /// # Errors
    /// [`RingError`] says what does not fit together.
    pub fn ring(&self, name: &str) -> Result<Ring, RingError> {
        self.check(name)?;
        let transducers = self.transducer.iter().map(|t| Transducer {
            mount: Pose::new(t.x, t.y, t.bearing_deg.to_radians()),
            half_beam: t.half_beam_deg.unwrap_or(self.half_beam_deg).to_radians(),
        });
        Ok(Ring {
            name: name.to_owned(),
            transducers: transducers.collect(),
            min_range: self.min_range,
            max_range: self.max_range,
            slot_time: self.slot_time,
            program: FiringProgram { slots: self.masks(), period: self.period as f32, rings: 1 },
        })
    }

    fn masks(&self) -> FixedVec<u32> {
        let count = if self.slots.is_empty() { self.transducer.len() } else { self.slots.len() };
        let mut masks = FixedVec::filled(0, count);
        for (i, mask) in masks.iter_mut().enumerate() {
            *mask = match self.slots.get(i) {
                Some(slot) => slot.iter().fold(0, |mask, transducer| mask | 1 << transducer),
                None => 1 << i,
            };
        }
        masks
    }

    fn check(&self, name: &str) -> Result<(), RingError> {
        let name = || name.to_owned();
        let count = self.transducer.len();
        if count == 0 {
            return Err(RingError::Empty(name()));
        }
        for (what, count) in [("transducers", count), ("slots", self.slots.len())] {
            if count > MAX_TRANSDUCERS {
                return Err(RingError::TooMany { name: name(), count, what });
            }
        }
        for (slot, members) in self.slots.iter().enumerate() {
            if let Some(&transducer) = members.iter().find(|t| **t >= count) {
                return Err(RingError::NoSuchTransducer { name: name(), slot, transducer, last: count - 1 });
            }
        }
        let within = |field, value: f64, low: f64, high: f64| {
            if (low..=high).contains(&value) { Ok(()) } else { Err(RingError::OutOfRange { name: name(), field }) }
        };
        within("min_range", self.min_range, 0.0, 5.0)?;
        within("max_range", self.max_range, 0.1_f64.max(self.min_range + 1e-3), 100.0)?;
        within("half_beam_deg", self.half_beam_deg, 0.1, 40.0)?;
        within("slot_time", self.slot_time, 0.0001, 10.0)?;
        within("period", self.period, 0.0, 60.0)?;
        for transducer in &self.transducer {
            within("x", transducer.x, -5.0, 5.0)?;
            within("y", transducer.y, -5.0, 5.0)?;
            within("bearing_deg", transducer.bearing_deg, -360.0, 360.0)?;
            within("half_beam_deg", transducer.half_beam_deg.unwrap_or(1.0), 0.1, 40.0)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
