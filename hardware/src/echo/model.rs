//! How a simulated sonar hears, and errs: its parameters.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// One point of the curve of the incidence limit over range.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct IncidencePoint {
    /// Range at which the limit holds, m.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub range: f64,
    /// Greatest angle between the beam and the surface's normal at which the surface is heard, degrees; 90 for a rough
    /// surface, which is heard at any angle.
    #[schemars(range(min = 0.5, max = 90.0))]
    pub limit_deg: f64,
}

impl Default for IncidencePoint {
    fn default() -> Self {
        Self { range: 0.0, limit_deg: 30.0 }
    }
}

/// One point of the curve of the detection threshold over range.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DetectionPoint {
    /// Range at which the threshold holds, m.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub range: f64,
    /// Least reflectance that is heard from there, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub reflectance: f64,
}

impl Default for DetectionPoint {
    fn default() -> Self {
        Self { range: 0.0, reflectance: 0.0 }
    }
}

/// How a simulated sonar hears. Ranges and beam widths belong to the ring, not to this.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SonarModel {
    /// How obliquely a surface may be met and still be heard, as a curve over range: linear between its points, constant
    /// beyond them, never rising. One point: the same limit everywhere. None: surfaces are heard at any angle, which no real
    /// sonar does. (30° for Randazza 1989's robot; ±15° and less with range for MacPherson 1993's, §III.)
    #[schemars(length(max = 16))]
    pub incidence_limit: Vec<IncidencePoint>,
    /// The least reflectance heard, as a curve over range: linear between its points, constant beyond them, never falling.
    /// None: whatever reflects at all is heard up to the ring's range. (MacPherson 1993, §III, target strength.)
    #[schemars(length(max = 16))]
    pub detection: Vec<DetectionPoint>,
    /// Corners and edges of full strength are heard at any angle up to this range, m.
    #[schemars(range(min = 0.0, max = 20.0))]
    pub vertex_range: f64,
    /// Standard deviation of a range, m: the part that does not depend on range.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub noise: f64,
    /// Standard deviation of a range, m for each metre of range; added to `noise`.
    #[schemars(range(min = 0.0, max = 0.2))]
    pub noise_per_metre: f64,
    /// Ranges are cut to a multiple of this, m; 0 for none. (0.03048 is the tenth of a foot of Randazza 1989; 0.001 the counter
    /// of MacPherson 1993.)
    #[schemars(range(min = 0.0, max = 0.5))]
    pub quantum: f64,
    /// Probability that a firing reports a random range between the ring's least and greatest instead of the true one.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub spurious: f64,
    /// Probability that a firing hears nothing whatever is there.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub dropout: f64,
    /// Factor between the true and the reported range: the ratio of the assumed to the real speed of sound, and errors of the
    /// clock that counts it. (0.97–0.98 if the counts of MacPherson 1993 are read as millimetres.)
    #[schemars(range(min = 0.8, max = 1.2))]
    pub range_scale: f64,
    /// A beam that no surface answers directly may be heard after a reflection off one wall: reads too far (Good 1992,
    /// multi-bounce).
    pub second_bounce: bool,
    /// Probability that a firing takes the echo of a neighbour fired in the same slot for its own (Good 1992, cross-talk).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub cross_talk: f64,
}

impl Default for SonarModel {
    /// The model of Randazza 1989's robot with a fine quantum and no spurious readings.
    fn default() -> Self {
        Self {
            incidence_limit: vec![IncidencePoint::default()],
            detection: Vec::new(),
            vertex_range: 1.5,
            noise: 0.01,
            noise_per_metre: 0.0,
            quantum: 0.001,
            spurious: 0.0,
            dropout: 0.0,
            range_scale: 1.0,
            second_bounce: false,
            cross_talk: 0.0,
        }
    }
}

/// Why a sonar model makes no sense.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum ModelError {
    /// A number is not finite or outside the range that its documentation gives.
    #[error("`{0}` of the sonar model is out of range")]
    OutOfRange(&'static str),
    /// The points of a curve are not in order of rising range.
    #[error("the points of `{0}` of the sonar model are not in order of rising range")]
    Unordered(&'static str),
    /// The incidence limit rises, or the detection threshold falls with range: a surface would be heard from afar only.
    #[error("`{0}` of the sonar model makes surfaces easier to hear from farther away")]
    EasierFarAway(&'static str),
}

impl SonarModel {
    /// No noise and no quantum: what the geometry alone says. For tests and teaching.
    #[must_use]
    pub fn noiseless(self) -> Self {
        Self {
            noise: 0.0,
            noise_per_metre: 0.0,
            quantum: 0.0,
            spurious: 0.0,
            dropout: 0.0,
            range_scale: 1.0,
            cross_talk: 0.0,
            ..self
        }
    }

    /// The same limit of incidence at every range.
    #[must_use]
    pub fn with_incidence_limit(self, limit_deg: f64) -> Self {
        Self { incidence_limit: vec![IncidencePoint { range: 0.0, limit_deg }], ..self }
    }

    pub(super) fn check(&self) -> Result<(), ModelError> {
        let within = |name, value: f64, low: f64, high: f64| {
            if (low..=high).contains(&value) { Ok(()) } else { Err(ModelError::OutOfRange(name)) }
        };
        within("vertex_range", self.vertex_range, 0.0, 20.0)?;
        within("noise", self.noise, 0.0, 1.0)?;
        within("noise_per_metre", self.noise_per_metre, 0.0, 0.2)?;
        within("quantum", self.quantum, 0.0, 0.5)?;
        within("spurious", self.spurious, 0.0, 1.0)?;
        within("dropout", self.dropout, 0.0, 1.0)?;
        within("range_scale", self.range_scale, 0.8, 1.2)?;
        within("cross_talk", self.cross_talk, 0.0, 1.0)?;
        for point in &self.incidence_limit {
            within("incidence_limit", point.range, 0.0, 100.0)?;
            within("incidence_limit", point.limit_deg, 0.5, 90.0)?;
        }
        for point in &self.detection {
            within("detection", point.range, 0.0, 100.0)?;
            within("detection", point.reflectance, 0.0, 1.0)?;
        }
        let in_order = |name, ordered: bool| if ordered { Ok(()) } else { Err(ModelError::Unordered(name)) };
        in_order("incidence_limit", self.incidence_limit.is_sorted_by(|a, b| a.range < b.range))?;
        in_order("detection", self.detection.is_sorted_by(|a, b| a.range < b.range))?;
        let harder = |name, harder: bool| if harder { Ok(()) } else { Err(ModelError::EasierFarAway(name)) };
        harder("incidence_limit", self.incidence_limit.is_sorted_by(|a, b| a.limit_deg >= b.limit_deg))?;
        harder("detection", self.detection.is_sorted_by(|a, b| a.reflectance <= b.reflectance))
    }
}
