//! Looking several looks ahead: the exact value of the best plan (expectimax).

use std::collections::BTreeMap;

use super::{catalogue::Catalogue, sensor_model::Outcomes};

/// Plans looks ahead.
#[derive(Debug)]
pub struct Lookahead<'c> {
    catalogue: &'c Catalogue,
    outcomes: Outcomes,
    costs: Vec<f64>,
    loss: f64,
    repeats: u32,
    /// Values of sets of hypotheses, where outcomes are certain: what was looked for before does not matter then.
    known: BTreeMap<u64, Plan>,
}

/// The best that can be done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// What is to be expected of it: minus costs and loss.
    pub value: f64,
    /// What to look for first; `None` to report now.
    pub first: Option<usize>,
}

impl<'c> Lookahead<'c> {
    /// With what each look costs, what a wrong report costs, and how often a feature may be looked for.
    #[must_use]
    pub fn new(catalogue: &'c Catalogue, outcomes: Outcomes, costs: Vec<f64>, loss: f64, repeats: u32) -> Self {
        Self { catalogue, outcomes, costs, loss, repeats, known: BTreeMap::new() }
    }

    /// The best plan of up to `depth` looks; `uses` says how often each feature has been looked for.
    pub fn best(&mut self, beliefs: &[f64], uses: &[u32], depth: u32) -> Plan {
        let mut uses = uses.to_vec();
        self.plan(beliefs, &mut uses, depth)
    }

    fn plan(&mut self, beliefs: &[f64], uses: &mut [u32], depth: u32) -> Plan {
        let report = -self.loss * (1.0 - beliefs.iter().copied().fold(0.0, f64::max));
        let mut best = Plan { value: report, first: None };
        if depth == 0 || report >= 0.0 {
            return best;
        }
        let set = self.set(beliefs);
        if let Some(known) = set.and_then(|set| self.known.get(&set)) {
            return *known;
        }
        for feature in 0..self.costs.len() {
            // Dearer than the best plan even if it told all.
            if uses[feature] >= self.repeats || -self.costs[feature] <= best.value {
                continue;
            }
            uses[feature] += 1;
            let value = self.after(feature, beliefs, uses, depth - 1);
            uses[feature] -= 1;
            if value.is_some_and(|value| value > best.value) {
                best = Plan { value: value.unwrap_or_default(), first: Some(feature) };
            }
        }
        set.map(|set| self.known.insert(set, best));
        best
    }

    /// What is to be expected after a look; `None` if it tells nothing.
    fn after(&mut self, feature: usize, beliefs: &[f64], uses: &mut [u32], depth: u32) -> Option<f64> {
        let kind = self.catalogue.feature.get(feature)?.kind;
        let mut value = -self.costs[feature];
        for outcome in 0..self.outcomes.names().len() {
            let likelihood = |h: usize| self.outcomes.probabilities(kind, self.catalogue.standing(feature, h))[outcome];
            let mut then: Vec<f64> = beliefs.iter().enumerate().map(|(h, p)| p * likelihood(h)).collect();
            let probability: f64 = then.iter().sum();
            if probability >= 1.0 - 1e-12 {
                return None;
            }
            if probability > 0.0 {
                then.iter_mut().for_each(|p| *p /= probability);
                value += probability * self.plan(&then, uses, depth).value;
            }
        }
        Some(value)
    }

    /// The hypotheses that are left, if certain outcomes have ruled the others out.
    fn set(&self, beliefs: &[f64]) -> Option<u64> {
        let certain = self.outcomes == Outcomes::Certain;
        certain.then(|| beliefs.iter().enumerate().filter(|(_, p)| **p > 0.0).fold(0, |set, (h, _)| set | 1 << h))
    }
}
