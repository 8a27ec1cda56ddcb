//! The influence diagram that names places.
//!
//! ```text
//!             ┌──▶ (NRC)
//!   (place) ──┼──▶ (NRE)  ...     [report] ──┐
//!      │      └──▶ (WL)                      ▼
//!      └──────────────────────────────────▶ ⟨loss⟩
//! ```
//!
//! How a look ends depends on the place alone. What has been seen so far enters as evidence on the place, so that a feature can be looked
//! for again. The report costs the loss if it names the wrong place. Which feature to look for next is decided by what the diagram says a
//! look would be worth: in bits, in hypotheses ruled out, or in what the report then gains.

use orienteer_influence::{
    ChanceId, DecisionId, Diagram, Evidence, SolveError, entropy, joint, mutual_information, posterior, value_of_observing,
};

use super::{catalogue::Catalogue, sensor_model::Outcomes};

/// The diagram for one place.
#[derive(Debug, Clone)]
pub struct PlaceDiagram {
    diagram: Diagram,
    place: ChanceId,
    looks: Vec<ChanceId>,
    report: DecisionId,
}

impl PlaceDiagram {
    /// The diagram for this catalogue; `prior` is the probability of each hypothesis, `loss` what a wrong report costs.
    ///
    /// # Errors
    /// If the prior is none.
    pub fn new(
        catalogue: &Catalogue,
        outcomes: Outcomes,
        prior: &[f64],
        loss: f64,
    ) -> Result<Self, orienteer_influence::BuildError> {
        let mut build = Diagram::builder("place");
        let ids: Vec<&str> = catalogue.hypothesis.iter().map(|hypothesis| hypothesis.id.as_str()).collect();
        let place = build.chance("place", ids.iter().copied()).table(prior);
        let look = |(f, feature): (usize, &super::catalogue::Feature)| {
            let rows =
                (0..ids.len()).flat_map(|h| outcomes.probabilities(feature.kind, catalogue.standing(f, h)).iter().copied());
            let look = build.chance(format!("look for {}", feature.id), outcomes.names().iter().copied());
            look.given(place).table(rows.collect::<Vec<_>>())
        };
        let looks = catalogue.feature.iter().enumerate().map(look).collect();
        let report = build.decision("report", ids.iter().copied()).id();
        let wrong = |i: usize| if i / ids.len() == i % ids.len() { 0.0 } else { -loss };
        let losses: Vec<f64> = (0..ids.len() * ids.len()).map(wrong).collect();
        build.utility("loss").given(place).given(report).table(losses);
        Ok(Self { diagram: build.build()?, place, looks, report })
    }

    /// The diagram itself, to be saved or looked at.
    #[must_use]
    pub fn diagram(&self) -> &Diagram {
        &self.diagram
    }

    /// The probability of each hypothesis; `likelihoods` says how well each agrees with what has been seen.
    ///
    /// # Errors
    /// [`SolveError::Impossible`] if none does.
    pub fn beliefs(&self, likelihoods: &[f64]) -> Result<Vec<f64>, SolveError> {
        posterior(&self.diagram, self.place, &self.seen(likelihoods))
    }

    /// What a look can be expected to tell about the place, bits.
    ///
    /// # Errors
    /// As for [`beliefs`](Self::beliefs).
    pub fn information(&self, feature: usize, likelihoods: &[f64]) -> Result<f64, SolveError> {
        mutual_information(&self.diagram, self.place, self.looks[feature], &self.seen(likelihoods))
    }

    /// How many hypotheses a look can be expected to rule out: by how much the effective number of them, 1/Σp², falls.
    ///
    /// # Errors
    /// As for [`beliefs`](Self::beliefs).
    pub fn eliminated(&self, feature: usize, likelihoods: &[f64]) -> Result<f64, SolveError> {
        let joint = joint(&self.diagram, &[self.place.into(), self.looks[feature].into()], &self.seen(likelihoods))?;
        let outcomes = self.diagram.extent(self.looks[feature]);
        // Not normalised: (Σp)² / Σp² is the effective number all the same.
        let effective = |column: &dyn Fn(&[f64]) -> f64| {
            let (sum, squares) =
                joint.values().chunks(outcomes).map(column).fold((0.0, 0.0), |(sum, squares), p| (sum + p, squares + p * p));
            (sum, if squares > 0.0 { sum * sum / squares } else { 0.0 })
        };
        let (_, now) = effective(&|row| row.iter().sum());
        let then: f64 =
            (0..outcomes).map(|outcome| effective(&|row| row[outcome])).map(|(probability, number)| probability * number).sum();
        Ok(now - then)
    }

    /// By how much a look can be expected to make the report better, in the units of the loss (the value of sample information).
    ///
    /// # Errors
    /// As for [`beliefs`](Self::beliefs).
    pub fn worth(&self, feature: usize, likelihoods: &[f64]) -> Result<f64, SolveError> {
        value_of_observing(&self.diagram, &[self.looks[feature]], self.report, &self.seen(likelihoods))
    }

    fn seen(&self, likelihoods: &[f64]) -> Evidence {
        Evidence::none().likelihood(self.place, likelihoods)
    }
}

/// How much there is left to find out, bits.
#[must_use]
pub fn doubt(beliefs: &[f64]) -> f64 {
    entropy(beliefs)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const LOSS: f64 = 20_000.0;

    fn uniform(outcomes: Outcomes) -> (Catalogue, PlaceDiagram) {
        let catalogue = Catalogue::corridors();
        let prior = vec![1.0 / 12.0; 12];
        let diagram = PlaceDiagram::new(&catalogue, outcomes, &prior, LOSS).unwrap();
        (catalogue, diagram)
    }

    /// What a first look is worth, feature by feature: bits and hypotheses if outcomes are certain, bits if they are not.
    #[test]
    fn first_looks_are_worth_what_was_worked_out() {
        let table = [
            ("NRC", 1.000, 6.00, 0.8888),
            ("NLC", 1.000, 6.00, 0.8888),
            ("FRC", 0.918, 5.33, 0.8173),
            ("FLC", 0.918, 5.33, 0.8173),
            ("WL", 0.811, 4.50, 0.7193),
            ("WR", 0.811, 4.50, 0.7193),
            ("NRE", 0.650, 3.33, 0.5580),
            ("NLE", 0.650, 3.33, 0.5580),
            ("FRE", 0.650, 3.33, 0.5580),
            ("FLE", 0.650, 3.33, 0.5580),
            ("WA", 0.414, 1.83, 0.3534),
            ("KL", 0.414, 1.83, 0.3534),
            ("KR", 0.414, 1.83, 0.3534),
        ];
        let (catalogue, certain) = uniform(Outcomes::Certain);
        let (_, probable) = uniform(Outcomes::TwoValued);
        let nothing = [1.0; 12];
        for (id, bits, eliminated, probable_bits) in table {
            let feature = catalogue.feature_by_id(id).unwrap();
            assert!((certain.information(feature, &nothing).unwrap() - bits).abs() < 5e-4, "{id}");
            assert!((certain.eliminated(feature, &nothing).unwrap() - eliminated).abs() < 5e-3, "{id}");
            assert!((probable.information(feature, &nothing).unwrap() - probable_bits).abs() < 5e-5, "{id}");
        }
    }

    /// With nothing known every look that splits the hypotheses makes the report better by as much: the price alone decides.
    #[test]
    fn cheap_looks_tell_as_much_as_dear_ones_at_the_start() {
        let (catalogue, certain) = uniform(Outcomes::Certain);
        let (_, probable) = uniform(Outcomes::TwoValued);
        for (f, feature) in catalogue.feature.iter().enumerate() {
            assert!((certain.worth(f, &[1.0; 12]).unwrap() - LOSS / 12.0).abs() < 1e-6, "{}", feature.id);
            let expected = if feature.kind == orienteer_runtime::topics::FeatureKind::Edge { 1600.0 } else { 1616.7 };
            assert!((probable.worth(f, &[1.0; 12]).unwrap() - expected).abs() < 0.05, "{}", feature.id);
        }
    }
}
