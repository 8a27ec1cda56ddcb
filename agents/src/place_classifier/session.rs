//! Naming one place: what to look for next, what it told, and when it is enough.

use std::sync::Arc;

use orienteer_influence::SolveError;
use orienteer_runtime::topics::Opening;

use super::{
    PlaceClassifierConfig,
    catalogue::Catalogue,
    diagram::PlaceDiagram,
    lookahead::Lookahead,
    selection::{Offer, Selection},
    sensor_model::{Ending, Outcomes},
};

/// The looks at one place.
///
/// ```
/// use orienteer_agents::place_classifier::{Ending, Next, PlaceClassifierConfig, Session};
/// use orienteer_runtime::topics::Opening;
///
/// let config = PlaceClassifierConfig::default();
/// let costs: Vec<f64> = config.catalogue.feature.iter().map(|feature| config.costs.of(feature.kind)).collect();
/// let mut session = Session::new(&config, Opening::Right)?;
/// while let Next::Look(feature) = session.next(&costs)? {
///     // At a T with its branch to the right.
///     let there = ["NRC", "FRC", "WL"].contains(&config.catalogue.feature[feature].id.as_str());
///     session.observe(feature, if there { Ending::Found } else { Ending::NotFound });
/// }
/// let Next::Report(verdict) = session.next(&costs)? else { unreachable!() };
/// assert_eq!(verdict.hypothesis, Some(0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Session {
    catalogue: Arc<Catalogue>,
    rules: Rules,
    diagram: PlaceDiagram,
    /// How well each hypothesis agrees with what was seen; the best one is 1.
    likelihoods: Vec<f64>,
    /// How often each feature has been looked for.
    uses: Vec<u32>,
    /// How often somebody came between; and how each look for a feature would have ended otherwise, so many times in a row.
    interrupted: u32,
    seemed: Vec<(Ending, u32)>,
    /// Where the robot could not go on.
    blocked: Vec<bool>,
}

#[derive(Debug, Clone, Copy)]
struct Rules {
    selection: Selection,
    outcomes: Outcomes,
    loss: f64,
    content: f64,
    least_gain: f64,
    repeats: u32,
    looks: u32,
    interruptions: u32,
    horizon: u32,
}

/// What to do now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Next {
    /// Look for this feature, by its number in the catalogue.
    Look(usize),
    /// It is enough, or no look would tell more.
    Report(Verdict),
}

/// What the place is thought to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    /// The most probable hypothesis, by its number in the catalogue; `None` if all are ruled out.
    pub hypothesis: Option<usize>,
    /// Its probability.
    pub belief: f64,
    /// True if that is as much as was asked for.
    pub sure: bool,
}

/// What seems so often to be is.
const INSISTS: u32 = 3;
/// With so many hypotheses or fewer, plans are made to the end if outcomes are certain.
const FEW: usize = 16;

impl Session {
    /// Nothing was looked for yet; `opening` is what was seen on arrival, [`Opening::Lost`] if nothing was.
    ///
    /// # Errors
    /// If the catalogue or the rules make no diagram.
    pub fn new(config: &PlaceClassifierConfig, opening: Opening) -> Result<Self, orienteer_influence::BuildError> {
        let catalogue = config.catalogue.clone();
        let prior = prior(&catalogue, if config.hint { opening } else { Opening::Lost }, config.elsewhere);
        let diagram = PlaceDiagram::new(&catalogue, config.outcomes, &prior, config.loss)?;
        let rules = Rules {
            selection: config.selection,
            outcomes: config.outcomes,
            loss: config.loss,
            content: config.content,
            least_gain: config.least_gain,
            repeats: config.repeats,
            looks: config.looks,
            interruptions: config.interruptions,
            horizon: config.horizon,
        };
        let (features, hypotheses) = (catalogue.feature.len(), catalogue.hypothesis.len());
        Ok(Self {
            catalogue,
            rules,
            diagram,
            likelihoods: vec![1.0; hypotheses],
            uses: vec![0; features],
            interrupted: 0,
            seemed: vec![(Ending::Interrupted, 0); features],
            blocked: vec![false; features],
        })
    }

    /// The influence diagram behind it.
    #[must_use]
    pub fn diagram(&self) -> &PlaceDiagram {
        &self.diagram
    }

    /// How many looks were taken.
    #[must_use]
    pub fn looks(&self) -> u32 {
        self.uses.iter().sum()
    }

    /// The probability of each hypothesis; all 0 if every one is ruled out.
    #[must_use]
    pub fn beliefs(&self) -> Vec<f64> {
        self.diagram.beliefs(&self.likelihoods).unwrap_or_else(|_| vec![0.0; self.likelihoods.len()])
    }

    /// Somebody came between when a feature was looked for; if nobody had, the look would have ended so. Whoever walks by is not there each time: the same ending for the
    /// third time in a row is believed.
    pub fn interrupt(&mut self, feature: usize, seemed: Ending) {
        let Some((before, times)) = self.seemed.get_mut(feature) else { return };
        *times = if *before == seemed { *times + 1 } else { 1 };
        *before = seemed;
        let insists = *times >= INSISTS && seemed != Ending::Interrupted;
        if insists {
            *times = 0;
        }
        self.take(feature, if insists { seemed } else { Ending::Interrupted });
    }

    /// True if it ended because somebody came between too often.
    #[must_use]
    pub fn is_interrupted(&self) -> bool {
        self.interrupted >= self.rules.interruptions
    }

    /// The same, to be gone on with: nobody has come between lately.
    #[must_use]
    pub fn rested(&self) -> Self {
        Self { interrupted: 0, ..self.clone() }
    }

    /// A look for a feature ended so, and nobody came between.
    pub fn observe(&mut self, feature: usize, ending: Ending) {
        if let Some(seemed) = self.seemed.get_mut(feature) {
            *seemed = (Ending::Interrupted, 0);
        }
        self.take(feature, ending);
    }

    /// Draws the conclusions from how a look ended.
    fn take(&mut self, feature: usize, ending: Ending) {
        let Some(known) = self.catalogue.feature.get(feature) else { return };
        if ending == Ending::Interrupted {
            self.interrupted += 1;
            return;
        }
        self.uses[feature] += 1;
        // Who is blocked again is so by the same thing.
        if ending == Ending::Blocked && std::mem::replace(&mut self.blocked[feature], true) {
            return;
        }
        let Some(number) = self.rules.outcomes.number(ending) else { return };
        for (h, likelihood) in self.likelihoods.iter_mut().enumerate() {
            *likelihood *= self.rules.outcomes.probabilities(known.kind, self.catalogue.standing(feature, h))[number];
        }
        let most = self.likelihoods.iter().copied().fold(0.0, f64::max);
        if most > 0.0 {
            self.likelihoods.iter_mut().for_each(|likelihood| *likelihood /= most);
        }
    }

    /// What to do now; `costs` has what each look would cost.
    ///
    /// # Errors
    /// If the diagram can't be solved.
    pub fn next(&self, costs: &[f64]) -> Result<Next, SolveError> {
        let beliefs = self.beliefs();
        let most = beliefs.iter().copied().fold(0.0, f64::max);
        // Of equals the first one.
        let best = beliefs.iter().position(|belief| *belief == most).filter(|_| most > 0.0);
        let verdict = Verdict { hypothesis: best, belief: most, sure: most >= self.rules.content };
        let enough = self.looks() >= self.rules.looks || self.is_interrupted();
        if verdict.sure || best.is_none() || enough {
            return Ok(Next::Report(verdict));
        }
        let choice = match self.rules.selection {
            Selection::Expectimax => self.plan(&beliefs, costs),
            _ => self.weigh(costs)?,
        };
        Ok(choice.map_or(Next::Report(verdict), Next::Look))
    }

    /// The look with the highest score; `None` if none tells anything.
    fn weigh(&self, costs: &[f64]) -> Result<Option<usize>, SolveError> {
        let mut best: Option<(f64, f64, usize)> = None;
        for (feature, cost) in costs.iter().copied().enumerate() {
            if self.uses.get(feature).is_none_or(|uses| *uses >= self.rules.repeats) {
                continue;
            }
            let information = self.diagram.information(feature, &self.likelihoods)?;
            if information <= self.rules.least_gain {
                continue;
            }
            let offer = Offer { diagram: &self.diagram, feature, likelihoods: &self.likelihoods, information, cost };
            let Some(score) = offer.score(self.rules.selection)? else { continue };
            if self.rules.selection == Selection::Evsi && score <= 0.0 {
                continue;
            }
            let better =
                best.is_none_or(|(highest, price, _)| score > highest + EQUAL || (score > highest - EQUAL && cost < price));
            if better {
                best = Some((score, cost, feature));
            }
        }
        Ok(best.map(|(.., feature)| feature))
    }

    fn plan(&self, beliefs: &[f64], costs: &[f64]) -> Option<usize> {
        let rules = &self.rules;
        let to_the_end = rules.outcomes == Outcomes::Certain && self.catalogue.hypothesis.len() <= FEW;
        let depth = if to_the_end { u32::MAX } else { rules.horizon.min(rules.looks.saturating_sub(self.looks())) };
        let mut lookahead = Lookahead::new(&self.catalogue, rules.outcomes, costs.to_vec(), rules.loss, rules.repeats);
        lookahead.best(beliefs, &self.uses, depth).first
    }
}

/// Scores that differ by less are equal.
const EQUAL: f64 = 1e-9;

/// The probability of each hypothesis on arrival: by their weights, those that do not open as was seen share `elsewhere`.
fn prior(catalogue: &Catalogue, opening: Opening, elsewhere: f64) -> Vec<f64> {
    let opens_so = |h: usize| opening == Opening::Lost || catalogue.opening(h) == opening;
    let weights: Vec<(bool, f64)> =
        catalogue.hypothesis.iter().enumerate().map(|(h, hypothesis)| (opens_so(h), hypothesis.weight)).collect();
    let sum = |so: bool| weights.iter().filter(|(opens, _)| *opens == so).map(|(_, weight)| weight).sum::<f64>();
    let (inside, outside) = (sum(true), sum(false));
    // Where none opens so, or all do, nothing was learned.
    if inside == 0.0 || outside == 0.0 {
        return weights.iter().map(|(_, weight)| weight / (inside + outside)).collect();
    }
    let share =
        |(opens, weight): &(bool, f64)| if *opens { (1.0 - elsewhere) * weight / inside } else { elsewhere * weight / outside };
    weights.iter().map(share).collect()
}

#[cfg(test)]
mod tests;
