//! The values of a cell and how a reading changes them (Good 1992, §2.1 and §2.3.3).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The largest magnitude of a cell's confidence, and the largest weight of a reading.
pub const MAX_CONFIDENCE: f32 = 6.0;

/// The probabilities that readings assign, from certainly occupied to certainly empty.
pub mod level {
    /// Certainly occupied.
    pub const HIGH_OCCUPIED: f32 = 1.0;
    /// Probably occupied.
    pub const MEDIUM_OCCUPIED: f32 = 0.75;
    /// Rather occupied than not.
    pub const LOW_OCCUPIED: f32 = 0.62;
    /// Rather empty than not.
    pub const LOW_EMPTY: f32 = 0.38;
    /// Probably empty.
    pub const MEDIUM_EMPTY: f32 = 0.25;
    /// Certainly empty.
    pub const HIGH_EMPTY: f32 = 0.0;
}

/// Where the classes of cells begin (Good 1992, §2.1).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Thresholds {
    /// A cell is empty if its probability of being occupied is at most this (THE).
    #[schemars(range(min = 0.0, max = 0.5))]
    pub empty: f32,
    /// A cell is occupied if its probability of being occupied is at least this (THO).
    #[schemars(range(min = 0.5, max = 1.0))]
    pub occupied: f32,
    /// A path may lead through a cell if its probability of being occupied is at most this (PATH).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub path: f32,
}

impl Default for Thresholds {
    fn default() -> Self {
        Self { empty: 0.25, occupied: 0.75, path: 0.25 }
    }
}

/// What a cell is taken for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CellClass {
    /// `C` is at most the threshold of empty cells.
    Empty,
    /// `C` lies between the thresholds.
    Uncertain,
    /// `C` is at least the threshold of occupied cells.
    Occupied,
}

impl Thresholds {
    /// The class of a cell with this probability. Where the two thresholds meet, occupied wins.
    #[must_use]
    pub fn classify(&self, probability: f32) -> CellClass {
        if probability >= self.occupied {
            CellClass::Occupied
        } else if probability <= self.empty {
            CellClass::Empty
        } else {
            CellClass::Uncertain
        }
    }
}

/// The rules of a grid that do not change from reading to reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// Probability of a cell nobody has looked at.
    pub background: f32,
    /// Probability that decay assumes beyond the edge of the grid.
    pub edge_background: f32,
    /// Where the classes begin.
    pub thresholds: Thresholds,
    /// A reading of emptiness that leaves `F` at or below this, and `C` at or below [`level::MEDIUM_EMPTY`], sets `C` to
    /// exactly 0, so that something that went away leaves no ghost. The prose of Good (1992) asks for less than -3, the
    /// program used -1.
    pub residue_confidence: f32,
}

impl Default for Rules {
    fn default() -> Self {
        Self { background: 0.5, edge_background: 0.5, thresholds: Thresholds::default(), residue_confidence: -1.0 }
    }
}

/// Smallest weight of a reading: keeps the weighted mean of a cell without evidence defined.
const MIN_WEIGHT: f32 = 0.01;

/// One reading in the form in which it is applied to whole rows of cells, without branches so that the compiler can use
/// vector instructions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Update {
    /// `value · weight`
    pull: f32,
    weight: f32,
    /// What the reading adds to `F`: +1, 0 or -1.
    step: f32,
    /// The rule against residue applies at or below this `F`.
    residue: f32,
    /// Cells whose `F` is at or above this stay as they are.
    shield: f32,
}

impl Update {
    /// A reading of `value` in `[0, 1]` with a positive weight.
    pub(super) fn new(value: f32, weight: f32, rules: &Rules) -> Self {
        let value = value.clamp(0.0, 1.0);
        let weight = weight.clamp(MIN_WEIGHT, MAX_CONFIDENCE);
        let empty = value <= level::MEDIUM_EMPTY;
        let step = f32::from(i8::from(value >= level::MEDIUM_OCCUPIED) - i8::from(empty));
        let residue = if empty { rules.residue_confidence } else { f32::NEG_INFINITY };
        Self { pull: value * weight, weight, step, residue, shield: f32::INFINITY }
    }

    /// The same reading, but cells with a confidence of at least `confidence` are left alone.
    pub(super) fn sparing(self, confidence: f32) -> Self {
        Self { shield: confidence, ..self }
    }

    /// `(C, F)` after the reading.
    #[inline(always)]
    pub(super) fn of(&self, c: f32, f: f32) -> (f32, f32) {
        self.with::<true>(c, f)
    }

    /// As [`of`](Self::of), without looking at the shield unless `SPARING`.
    #[inline(always)]
    fn with<const SPARING: bool>(&self, c: f32, f: f32) -> (f32, f32) {
        let evidence = f.abs();
        let mean = (c * evidence + self.pull) / (evidence + self.weight);
        let moved = (f + self.step).clamp(-MAX_CONFIDENCE, MAX_CONFIDENCE);
        let settled = (moved <= self.residue) & (mean <= level::MEDIUM_EMPTY);
        // Rounding may overshoot by one unit in the last place.
        let mean = if mean > 1.0 { 1.0 } else { mean };
        let mean = if settled { 0.0 } else { mean };
        let spared = SPARING && f >= self.shield;
        (if spared { c } else { mean }, if spared { f } else { moved })
    }

    /// Applies the reading to a row of cells.
    #[inline(always)]
    pub(super) fn apply(&self, probabilities: &mut [f32], confidences: &mut [f32]) {
        if self.shield > MAX_CONFIDENCE {
            self.apply_with::<false>(probabilities, confidences);
        } else {
            self.apply_with::<true>(probabilities, confidences);
        }
    }

    // Not inlined, so that the compiler knows the two slices to be apart and need not check it for every row.
    #[inline(never)]
    fn apply_with<const SPARING: bool>(&self, probabilities: &mut [f32], confidences: &mut [f32]) {
        for (c, f) in probabilities.iter_mut().zip(confidences) {
            (*c, *f) = self.with::<SPARING>(*c, *f);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn run(start: (f32, f32), readings: &[(f32, f32)]) -> Vec<(f32, f32)> {
        let rules = Rules::default();
        let mut cell = start;
        readings
            .iter()
            .map(|(value, weight)| {
                cell = Update::new(*value, *weight, &rules).of(cell.0, cell.1);
                cell
            })
            .collect()
    }

    fn assert_sequence(got: &[(f32, f32)], want: &[(usize, f32, f32)]) {
        for (reading, c, f) in want {
            let (gc, gf) = got[reading - 1];
            assert!((gc - c).abs() < 6e-5 && gf == *f, "reading {reading}: {gc}, {gf} instead of {c}, {f}");
        }
    }

    #[test]
    fn an_empty_cell_fills_up_with_readings_of_weight_one() {
        let got = run((0.0, -6.0), &[(1.0, 1.0); 12]);
        let table =
            [(1, 0.1429, -5.0), (2, 0.2857, -4.0), (3, 0.4286, -3.0), (4, 0.5714, -2.0), (5, 0.7143, -1.0), (6, 0.8571, 0.0)];
        assert_sequence(&got, &table);
        assert_eq!((got[6], got[11]), ((1.0, 1.0), (1.0, 6.0)));
    }

    #[test]
    fn an_empty_cell_fills_up_faster_with_growing_weight() {
        let readings: Vec<_> = (1..=12u8).map(|weight| (1.0, f32::from(weight.min(6)))).collect();
        let got = run((0.0, -6.0), &readings);
        let table =
            [(1, 0.1429, -5.0), (2, 0.3878, -4.0), (3, 0.6501, -3.0), (4, 0.8501, -2.0), (5, 0.9572, -1.0), (6, 0.9939, 0.0)];
        assert_sequence(&got, &table);
        assert_eq!((got[6], got[11]), ((1.0, 1.0), (1.0, 6.0)));
    }

    #[test]
    fn an_occupied_cell_empties_without_residue() {
        let got = run((1.0, 6.0), &[(0.0, 1.0); 12]);
        let table = [(1, 0.8571, 5.0), (2, 0.7143, 4.0), (3, 0.5714, 3.0), (4, 0.4286, 2.0), (5, 0.2857, 1.0), (6, 0.1429, 0.0)];
        assert_sequence(&got, &table);
        assert_eq!((got[6], got[11]), ((0.0, -1.0), (0.0, -6.0)));
    }

    #[test]
    fn an_unknown_cell_takes_the_first_reading() {
        assert_eq!(run((0.5, 0.0), &[(1.0, 1.0)]), [(1.0, 1.0)]);
        let medium = run((0.5, 0.0), &[(level::MEDIUM_OCCUPIED, 1.0)]);
        assert_eq!(medium, [(0.75, 1.0)]);
        assert_eq!(Thresholds::default().classify(medium[0].0), CellClass::Occupied);
    }

    #[test]
    fn a_vague_reading_moves_the_probability_alone() {
        assert_eq!(run((1.0, 3.0), &[(0.5, 1.0)]), [(0.875, 3.0)]);
    }

    #[test]
    fn a_spared_cell_stays() {
        let update = Update::new(0.0, 6.0, &Rules::default()).sparing(3.0);
        assert_eq!(update.of(1.0, 3.0), (1.0, 3.0));
        assert_ne!(update.of(1.0, 2.0), (1.0, 2.0));
    }

    proptest! {
        #[test]
        fn values_stay_in_their_ranges(
            readings in prop::collection::vec((0.0..=1.0f32, 0.0..=8.0f32), 1..60),
            c in 0.0..=1.0f32, f in -6.0..=6.0f32,
        ) {
            for (c, f) in run((c, f), &readings) {
                prop_assert!((0.0..=1.0).contains(&c) && (-6.0..=6.0).contains(&f), "{c} {f}");
            }
        }
    }
}
