//! Regions of constant depth: how far a reading is to be believed (Good 1992, §2.3.2, after Tsai).
//!
//! A region is a row of consecutive readings of one transducer that agree. For each transducer we keep their mean `μ`, variance
//! `σ²` and number `δ`. A reading `r` belongs to the region if `0.84 μ < r < 1.16 μ` and `σ² < 1000 mm²`; then
//!
//! ```text
//! σ² ← (σ²·δ + (μ - r)²) / (δ + 1)     with the old μ
//! μ  ← (μ·δ + r) / (δ + 1)
//! δ  ← δ + 1
//! ```
//!
//! up to `δ = 6`, where the statistics freeze. Otherwise a new region begins with this reading and `δ = 1`. The reading's weight
//! is `δ`. Echoes by way of several walls jump about and stay light; walls the robot drives along grow heavy.
//!
//! Silence (no echo) agrees with itself perfectly and would always reach full weight, although a wall met at a grazing angle
//! is just as silent as free ground. So its weight can be capped.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// When readings agree.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RcdConfig {
    /// A reading belongs to a region if it differs from the region's mean by less than this share of it.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub tolerance: f64,
    /// A region whose standard deviation has reached this, m, takes no more readings. (The source: a variance of 1000 mm².)
    #[schemars(range(min = 0.0, max = 1.0))]
    pub spread: f64,
    /// The longest region, and so the greatest weight of a reading.
    #[schemars(range(min = 1, max = 6))]
    pub longest: u8,
}

impl Default for RcdConfig {
    fn default() -> Self {
        Self { tolerance: 0.16, spread: 0.001_f64.sqrt(), longest: 6 }
    }
}

/// The region of constant depth of one transducer.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Region {
    mean: f64,
    variance: f64,
    count: u8,
}

impl Region {
    /// Takes a reading (m; the maximum range for silence) and returns its weight `δ`, from 1 to `config.longest`.
    pub fn take(&mut self, range: f64, config: &RcdConfig) -> u8 {
        let fits = (1.0 - config.tolerance) * self.mean < range
            && range < (1.0 + config.tolerance) * self.mean
            && self.variance < config.spread * config.spread;
        if !fits {
            *self = Self { mean: range, variance: 0.0, count: 1 };
        } else if self.count < config.longest {
            let (old, new) = (f64::from(self.count), f64::from(self.count + 1));
            self.variance = (self.variance * old + (self.mean - range).powi(2)) / new;
            self.mean = (self.mean * old + range) / new;
            self.count += 1;
        }
        self.count
    }

    /// Mean range `μ`, m; 0 before the first reading.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Variance `σ²`, m².
    #[must_use]
    pub fn variance(&self) -> f64 {
        self.variance
    }

    /// Number of readings `δ`; 0 before the first.
    #[must_use]
    pub fn count(&self) -> u8 {
        self.count
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn take(readings_mm: &[f64]) -> Vec<(f64, f64, u8)> {
        let mut region = Region::default();
        let config = RcdConfig::default();
        readings_mm
            .iter()
            .map(|mm| {
                let count = region.take(mm / 1000.0, &config);
                assert_eq!(count, region.count());
                (region.mean() * 1e3, region.variance() * 1e6, count)
            })
            .collect()
    }

    fn assert_states(got: &[(f64, f64, u8)], want: &[(f64, f64, u8)]) {
        assert_eq!(got.len(), want.len());
        for (got, want) in got.iter().zip(want) {
            let close = (got.0 - want.0).abs() < 1e-6 && (got.1 - want.1).abs() < 1e-6 && got.2 == want.2;
            assert!(close, "{got:?} instead of {want:?}");
        }
    }

    #[test]
    fn agreeing_readings_grow_a_region() {
        assert_states(&take(&[2000.0, 2030.0, 2060.0]), &[(2000.0, 0.0, 1), (2015.0, 450.0, 2), (2030.0, 975.0, 3)]);
    }

    #[test]
    fn a_wide_step_ends_the_region_one_reading_later() {
        let got = take(&[2000.0, 2100.0, 2050.0]);
        assert_states(&got, &[(2000.0, 0.0, 1), (2050.0, 5000.0, 2), (2050.0, 0.0, 1)]);
    }

    #[test]
    fn a_jump_starts_a_new_region_at_once() {
        for jump in [2000.0 * 0.839, 2000.0 * 1.161] {
            assert_states(&take(&[2000.0, jump]), &[(2000.0, 0.0, 1), (jump, 0.0, 1)]);
        }
        assert_eq!(take(&[2000.0, 2000.0 * 1.159])[1].2, 2);
    }

    #[test]
    fn a_full_region_freezes() {
        let got = take(&[1000.0, 1000.0, 1000.0, 1000.0, 1000.0, 1000.0, 1010.0, 1010.0]);
        assert_states(&got[6..], &[(1000.0, 0.0, 6), (1000.0, 0.0, 6)]);
    }
}
