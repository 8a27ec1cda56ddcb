//! What a look costs: centimetres driven plus degrees turned (Randazza 1989, §4.3).

use orienteer_runtime::topics::FeatureKind;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What going round a feature costs, by its kind: cm driven plus degrees turned, when it is found. The way to it comes on top.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Costs {
    /// A wall.
    #[schemars(range(min = 1.0, max = 100000.0))]
    pub wall: f64,
    /// A convex corner.
    #[schemars(range(min = 1.0, max = 100000.0))]
    pub convex: f64,
    /// A concave corner.
    #[schemars(range(min = 1.0, max = 100000.0))]
    pub concave: f64,
    /// A wall's edge.
    #[schemars(range(min = 1.0, max = 100000.0))]
    pub edge: f64,
}

impl Default for Costs {
    fn default() -> Self {
        Self { wall: 680.0, convex: 1076.0, concave: 1050.0, edge: 2000.0 }
    }
}

impl Costs {
    /// That of one kind.
    #[must_use]
    pub fn of(&self, kind: FeatureKind) -> f64 {
        match kind {
            FeatureKind::Wall => self.wall,
            FeatureKind::Convex => self.convex,
            FeatureKind::Concave => self.concave,
            FeatureKind::Edge => self.edge,
        }
    }
}

/// Costs that are learned from what looks did cost: after so many successes their mean takes the place of what was given.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnedCosts {
    given: Costs,
    seen: [Mean; 4],
}

#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Mean {
    sum: f64,
    count: u32,
}

/// So many successes make a mean.
const ENOUGH: u32 = 5;

impl LearnedCosts {
    /// Nothing is learned yet.
    #[must_use]
    pub fn new(given: Costs) -> Self {
        Self { given, seen: Default::default() }
    }

    /// A look for a feature of this kind found it and cost this, the way to it not counted.
    pub fn learn(&mut self, kind: FeatureKind, cost: f64) {
        let mean = &mut self.seen[kind as usize];
        mean.sum += cost;
        mean.count += 1;
    }

    /// What a look for a feature of this kind will cost, the way to it not counted.
    #[must_use]
    pub fn of(&self, kind: FeatureKind) -> f64 {
        let Mean { sum, count } = self.seen[kind as usize];
        if count < ENOUGH { self.given.of(kind) } else { sum / f64::from(count) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_successes_make_a_mean() {
        let mut costs = LearnedCosts::new(Costs::default());
        for cost in [800.0, 810.0, 820.0, 830.0] {
            costs.learn(FeatureKind::Wall, cost);
        }
        assert_eq!(costs.of(FeatureKind::Wall), 680.0);
        costs.learn(FeatureKind::Wall, 840.0);
        assert_eq!(costs.of(FeatureKind::Wall), 820.0);
        assert_eq!(costs.of(FeatureKind::Edge), 2000.0);
    }
}
