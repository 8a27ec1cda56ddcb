//! What naming places takes if every look ends as it should: the figures by which rules are compared.

use orienteer_runtime::topics::Opening;

use super::{
    Ending, PlaceClassifierConfig, Standing,
    session::{Next, Session},
};

/// What naming each place of a catalogue once takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Taken {
    /// Looks, mean over the places.
    pub looks: f64,
    /// Looks, at the place that takes most.
    pub most_looks: u32,
    /// Costs, mean over the places.
    pub cost: f64,
    /// Costs, at the place that takes most.
    pub most_cost: f64,
    /// Share of places that are named right.
    pub right: f64,
}

/// Names each place of the catalogue once. Looks cost `costs`, and are chosen as if they cost `priced`; with `hinted`, the follower has told which
/// sides are open.
///
/// # Errors
/// If the catalogue or the rules make no diagram, or it can't be solved.
pub fn rehearse(
    config: &PlaceClassifierConfig,
    hinted: bool,
    costs: &[f64],
    priced: &[f64],
) -> Result<Taken, Box<dyn std::error::Error + Send + Sync>> {
    let catalogue = &config.catalogue;
    let count = catalogue.hypothesis.len();
    let mut taken = Taken { looks: 0.0, most_looks: 0, cost: 0.0, most_cost: 0.0, right: 0.0 };
    for truth in 0..count {
        let opening = if hinted { catalogue.opening(truth) } else { Opening::Lost };
        let mut session = Session::new(config, opening)?;
        let mut cost = 0.0;
        let verdict = loop {
            let feature = match session.next(priced)? {
                Next::Report(verdict) => break verdict,
                Next::Look(feature) => feature,
            };
            cost += costs.get(feature).copied().unwrap_or_default();
            let there = catalogue.standing(feature, truth) == Standing::Present;
            session.observe(feature, if there { Ending::Found } else { Ending::NotFound });
        };
        taken.looks += f64::from(session.looks()) / count as f64;
        taken.most_looks = taken.most_looks.max(session.looks());
        taken.cost += cost / count as f64;
        taken.most_cost = taken.most_cost.max(cost);
        taken.right += f64::from(u8::from(verdict.hypothesis == Some(truth))) / count as f64;
    }
    Ok(taken)
}
