//! Which feature to look for next.

use orienteer_influence::SolveError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// By what the next look is chosen. Of equals the cheaper one is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Selection {
    /// The most hypotheses ruled out.
    Eliminate,
    /// The most hypotheses ruled out for what it costs (Randazza 1989, §4.3).
    EliminatePerCost,
    /// The most bits of information for what they cost.
    GainPerCost,
    /// The most bits of information: the fewest looks.
    InfoGain,
    /// The most by which the report becomes better, less what the look costs: the influence diagram, one look ahead.
    Evsi,
    /// The best plan, several looks ahead.
    Expectimax,
    /// The cheapest look that tells anything.
    Cheapest,
}

impl Selection {
    /// All rules, for tables.
    pub const ALL: [Self; 7] = [
        Self::GainPerCost,
        Self::EliminatePerCost,
        Self::InfoGain,
        Self::Eliminate,
        Self::Evsi,
        Self::Expectimax,
        Self::Cheapest,
    ];
}

/// What a look offers.
pub(super) struct Offer<'d> {
    pub diagram: &'d super::diagram::PlaceDiagram,
    pub feature: usize,
    pub likelihoods: &'d [f64],
    /// What it tells, bits.
    pub information: f64,
    /// What it costs.
    pub cost: f64,
}

impl Offer<'_> {
    /// The more, the better; `None` for a rule that does not weigh looks one by one.
    pub fn score(&self, selection: Selection) -> Result<Option<f64>, SolveError> {
        let &Self { diagram, feature, likelihoods, information, cost } = self;
        Ok(Some(match selection {
            Selection::Eliminate => diagram.eliminated(feature, likelihoods)?,
            Selection::EliminatePerCost => diagram.eliminated(feature, likelihoods)? / cost,
            Selection::GainPerCost => information / cost,
            Selection::InfoGain => information,
            Selection::Evsi => diagram.worth(feature, likelihoods)? - cost,
            Selection::Cheapest => -cost,
            Selection::Expectimax => return Ok(None),
        }))
    }
}
