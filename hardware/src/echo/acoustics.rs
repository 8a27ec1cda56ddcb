//! A [`SonarModel`](super::SonarModel) made ready for use: what is heard at which range and angle.

use orienteer_runtime::topics::Echo;
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

use super::model::{ModelError, SonarModel};

/// The least and greatest range that a ring reports, m: see [`Ring`](orienteer_runtime::robot_model::Ring).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeGate {
    /// Anything nearer reads as too near.
    pub min: f64,
    /// At and beyond this nothing is heard.
    pub max: f64,
}

/// A [`SonarModel`] checked and worked out: which surfaces answer, and how a reading is spoilt.
#[derive(Debug, Clone, PartialEq)]
pub struct Acoustics {
    model: SonarModel,
    /// Cosine of the widest angle of incidence at any range.
    cos_limit: f64,
    /// The limit at each range (m, rad), if it depends on range.
    limits: Vec<(f64, f64)>,
    /// The least reflectance heard at each range (m, share), if any is set.
    thresholds: Vec<(f64, f64)>,
}

impl Acoustics {
    /// Checks a model.
    ///
    /// # Errors
    /// [`ModelError`] if a number is out of its range, or a curve is not in order of range or bends the wrong way.
    pub fn new(model: &SonarModel) -> Result<Self, ModelError> {
        model.check()?;
        let limits: Vec<_> = model.incidence_limit.iter().map(|p| (p.range, p.limit_deg.to_radians())).collect();
        let widest = limits.first().map_or(90.0f64.to_radians(), |first| first.1);
        Ok(Self {
            // A limit of 90° excludes nothing, rounding or not.
            cos_limit: if widest < 89.999f64.to_radians() { widest.cos() - 1e-12 } else { -1.0 },
            limits: if limits.len() > 1 { limits } else { Vec::new() },
            thresholds: model.detection.iter().map(|p| (p.range, p.reflectance)).collect(),
            model: model.clone(),
        })
    }

    /// The model as configured.
    #[must_use]
    pub fn model(&self) -> &SonarModel {
        &self.model
    }

    /// True if a surface `range` m away, met at an angle of incidence with this cosine, sends an echo that is heard.
    #[must_use]
    pub fn answers(&self, range: f64, cos_incidence: f64, reflectance: f64) -> bool {
        cos_incidence >= self.cos_limit
            && reflectance > 0.0
            && (self.limits.is_empty() || cos_incidence >= interpolate(&self.limits, range).cos() - 1e-12)
            && (self.thresholds.is_empty() || reflectance >= interpolate(&self.thresholds, range))
    }

    /// How far away a vertex of this strength (0 to 1) is heard, m.
    #[must_use]
    pub fn vertex_reach(&self, strength: f64) -> f64 {
        self.model.vertex_range * strength.min(1.0)
    }

    /// Turns the distance of the first echo (`None` if there is none) into a reading.
    ///
    /// In this order: dropout, spurious echo, scale error of the clock, Gaussian noise, truncation to the quantum, range gate.
    /// A call draws the same kinds of numbers whatever the distance, so that a small change of the world leaves most of the
    /// later noise as it was.
    pub fn measure(&self, distance: Option<f64>, gate: RangeGate, rng: &mut impl Rng) -> Echo {
        let model = &self.model;
        let luck: f64 = if model.dropout + model.spurious > 0.0 { rng.random() } else { 1.0 };
        let anywhere: f64 = if model.spurious > 0.0 { rng.random() } else { 0.0 };
        let noise: f64 = if model.noise + model.noise_per_metre > 0.0 { rng.sample(StandardNormal) } else { 0.0 };
        if luck < model.dropout {
            return Echo::Nothing;
        }
        let heard = if luck < model.dropout + model.spurious {
            gate.min + anywhere * (gate.max - gate.min)
        } else {
            let Some(distance) = distance.filter(|d| *d <= gate.max) else { return Echo::Nothing };
            if distance <= 0.0 {
                return Echo::TooNear;
            }
            distance * model.range_scale + noise * (model.noise + model.noise_per_metre * distance)
        };
        let read = if model.quantum > 0.0 { (heard / model.quantum + 1e-9).floor() * model.quantum } else { heard };
        if heard < gate.min || read <= 0.0 {
            Echo::TooNear
        } else if read >= gate.max {
            Echo::Nothing
        } else {
            Echo::Range(read as f32)
        }
    }
}

/// Piecewise linear, constant beyond both ends. `points` is not empty and in order.
fn interpolate(points: &[(f64, f64)], at: f64) -> f64 {
    let above = points.partition_point(|p| p.0 <= at);
    match (above.checked_sub(1).and_then(|i| points.get(i)), points.get(above)) {
        (Some(low), Some(high)) => low.1 + (at - low.0) / (high.0 - low.0) * (high.1 - low.1),
        (Some(end), None) | (None, Some(end)) => end.1,
        (None, None) => f64::NAN,
    }
}

#[cfg(test)]
mod tests;
