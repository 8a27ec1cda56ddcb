//! Topics of the sonar: scans, firing programs, claims, decisions.

use iceoryx2::prelude::ZeroCopySend;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{ArbitrationRule, ClientId, FixedVec, HeldBack, MAX_TRANSDUCERS, Payload};
use crate::time::Time;

/// What one transducer heard.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Echo {
    /// The first echo came from this far away, metres from the transducer's face.
    Range(f32),
    /// Nothing answered within the ring's maximum range.
    Nothing,
    /// Something is nearer than the ring's minimum range.
    TooNear,
    /// This transducer has never been fired.
    NotFired,
}

impl Echo {
    /// The distance up to which the beam's axis is taken to be free: the echo's range, `max_range` if nothing answered,
    /// zero if something is too near, `None` if the transducer was not fired.
    #[must_use]
    pub fn free_distance(self, max_range: f32) -> Option<f32> {
        match self {
            Echo::Range(range) => Some(range),
            Echo::Nothing => Some(max_range),
            Echo::TooNear => Some(0.0),
            Echo::NotFired => None,
        }
    }
}

/// The newest reading of every transducer of a ring. Topic `sonar/scan`.
///
/// A scan is published when a pass of the firing program is complete. Transducers that the program leaves out keep their
/// last reading, with a growing age.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::SonarScan.v1")]
pub struct SonarScan {
    /// When the last transducer of the pass was read.
    pub stamp: Time,
    /// Counts scans from 1, so that a reader can tell distinct rings from repeated ones.
    pub seq: u64,
    /// Bit `i` is set if transducer `i` was fired in this pass.
    pub fired: u32,
    /// Metres; meaningless unless the state says so. Use [`SonarScan::echo`].
    ranges: FixedVec<f32>,
    /// See [`SonarScan::echo`].
    states: FixedVec<u8>,
    /// Seconds from the reading of each transducer to `stamp`.
    ages: FixedVec<f32>,
}

const NOT_FIRED: u8 = 0;
const RANGE: u8 = 1;
const NOTHING: u8 = 2;
const TOO_NEAR: u8 = 3;

impl SonarScan {
    /// A scan of a ring with `transducers` members, none of which has been fired.
    #[must_use]
    pub fn unfired(transducers: usize) -> Self {
        Self {
            ranges: FixedVec::filled(0.0, transducers),
            states: FixedVec::filled(NOT_FIRED, transducers),
            ages: FixedVec::filled(0.0, transducers),
            ..Self::default()
        }
    }

    /// A scan in which every transducer was fired at `stamp`: for tests and for drivers that read a whole ring at once.
    #[must_use]
    pub fn from_echoes(stamp: Time, seq: u64, echoes: &[Echo]) -> Self {
        let mut scan = Self::unfired(echoes.len());
        scan.stamp = stamp;
        scan.seq = seq;
        for (i, echo) in echoes.iter().enumerate().take(MAX_TRANSDUCERS) {
            scan.set(i, *echo, 0.0);
        }
        scan
    }

    /// Number of transducers.
    #[must_use]
    pub fn len(&self) -> usize {
        self.ranges.len()
    }

    /// True if the ring has no transducer.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What transducer `i` heard last; [`Echo::NotFired`] beyond the ring's length. A range that is not a positive number
    /// counts as [`Echo::TooNear`]: fail toward standing still.
    #[must_use]
    pub fn echo(&self, i: usize) -> Echo {
        let Some(range) = self.ranges.get(i).copied() else { return Echo::NotFired };
        match self.states.get(i).copied() {
            Some(RANGE) if range.is_finite() && range > 0.0 => Echo::Range(range),
            Some(RANGE | TOO_NEAR) => Echo::TooNear,
            Some(NOTHING) => Echo::Nothing,
            _ => Echo::NotFired,
        }
    }

    /// All echoes in ring order.
    pub fn echoes(&self) -> impl Iterator<Item = Echo> + '_ {
        (0..self.len()).map(|i| self.echo(i))
    }

    /// Seconds from the reading of transducer `i` to the scan's stamp.
    #[must_use]
    pub fn age(&self, i: usize) -> f32 {
        self.ages.get(i).copied().unwrap_or(0.0)
    }

    /// Makes every reading older by `seconds`; what a pass does to the readings it does not renew.
    pub fn grow_older(&mut self, seconds: f32) {
        for age in self.ages.iter_mut() {
            *age += seconds;
        }
    }

    /// Stores a reading of transducer `i`, taken `age` seconds before the scan's stamp, and marks it as fired.
    pub fn set(&mut self, i: usize, echo: Echo, age: f32) {
        let (Some(range), Some(state), Some(stored_age)) = (self.ranges.get_mut(i), self.states.get_mut(i), self.ages.get_mut(i))
        else {
            return;
        };
        (*range, *state) = match echo {
            Echo::Range(range) => (range, RANGE),
            Echo::Nothing => (0.0, NOTHING),
            Echo::TooNear => (0.0, TOO_NEAR),
            Echo::NotFired => (0.0, NOT_FIRED),
        };
        *stored_age = age;
        self.fired |= 1 << i;
    }

    /// True if transducer `i` was fired in this pass.
    #[must_use]
    pub fn is_fresh(&self, i: usize) -> bool {
        i < MAX_TRANSDUCERS && self.fired & (1 << i) != 0
    }
}

impl Payload for SonarScan {
    const TOPIC: &'static str = "sonar/scan";
    const QUEUE: usize = 16;
}

/// Which transducers fire, in what order, how often, and over how many passes its client means to average.
///
/// A pass runs through the slots; the transducers of one slot fire together. Slots follow each other at the ring's own
/// pace, passes start no sooner than `period` after each other.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::FiringProgram.v1")]
pub struct FiringProgram {
    /// A bit mask of transducers for each slot, in firing order.
    pub slots: FixedVec<u32>,
    /// Least seconds from the start of a pass to the start of the next. The safety floor may shorten it.
    pub period: f32,
    /// Number of distinct passes over whose median the client averages; 0 and 1 mean none. Scans are never averaged for it:
    /// others read the same ones.
    pub rings: u32,
}

impl FiringProgram {
    /// All transducers that the program fires at least once a pass, as a bit mask.
    #[must_use]
    pub fn transducers(&self) -> u32 {
        self.slots.iter().fold(0, |all, slot| all | slot)
    }
}

/// What one client asks of the sonar, renewed in every step while it wants it. Topic `sonar/claims`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::SonarClaim.v1")]
pub struct SonarClaim {
    /// Who asks.
    pub client: ClientId,
    /// When it asked.
    pub stamp: Time,
    /// The claim lapses at this time unless renewed.
    pub valid_until: Time,
    /// What it wants; a program without slots gives the sonar back.
    pub program: FiringProgram,
}

impl Payload for SonarClaim {
    const TOPIC: &'static str = "sonar/claims";
    const QUEUE: usize = 4;
    const MANY_WRITERS: bool = true;
}

/// What the sonar shall do. Topic `sonar/decision`, once a step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::SonarDecision.v1")]
pub struct SonarDecision {
    /// When it was decided.
    pub stamp: Time,
    /// Whose program runs; nobody means the ring's own default.
    pub holder: ClientId,
    /// The program with the safety floor worked in. A pass that has begun is finished before another program is taken up.
    pub program: FiringProgram,
    /// Transducers whose firings the safety floor has added to, as a bit mask.
    pub floor: u32,
    /// All transducers of the safety floor, as a bit mask, whoever has them fired. Neither averaging over rings nor the
    /// length of a pass must keep their readings from avoidance.
    pub reserved: u32,
    /// Since when the holder has had the sonar without a break; the stamp if nobody has it.
    pub since: Time,
    rule: u16,
    held_back: FixedVec<HeldBack>,
}

impl SonarDecision {
    /// Sets why the holder has the sonar.
    #[must_use]
    pub fn because(mut self, rule: ArbitrationRule) -> Self {
        self.rule = rule.code();
        self
    }

    /// Why the holder has the sonar.
    #[must_use]
    pub fn rule(&self) -> ArbitrationRule {
        ArbitrationRule::from_code(self.rule)
    }

    /// Names one more client that is held back; there is room for every node of a robot.
    pub fn hold_back(&mut self, entry: HeldBack) {
        self.held_back.push(entry);
    }

    /// Who is held back and why, first in line first: by priority, then by order of arrival.
    #[must_use]
    pub fn held_back(&self) -> &[HeldBack] {
        &self.held_back
    }
}

impl Payload for SonarDecision {
    const TOPIC: &'static str = "sonar/decision";
    const QUEUE: usize = 2;
}
