//! What there is to look for, and the kinds of places at which it is found.
//!
//! The twelve kinds of Randazza (1989, appendix A) are built in. A file of one's own adds to them, or replaces some by their `id`, so
//! that a new kind of junction takes five lines and no code:
//!
//! ```
//! use orienteer_agents::place_classifier::Catalogue;
//!
//! let mut catalogue = Catalogue::corridors();
//! catalogue.extend(toml::from_str(r#"
//!     [[hypothesis]]
//!     id = "dead-end"
//!     title = "dead end"
//!     features = ["KL", "KR"]
//! "#)?);
//! assert_eq!(catalogue.check(), Ok(()));
//! assert_eq!(catalogue.hypothesis.len(), 13);
//! # Ok::<(), toml::de::Error>(())
//! ```

use orienteer_runtime::{
    config::suggest,
    topics::{FeatureKind, MAX_TRANSDUCERS, Opening, Side, Way},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::places::{Spot, Whereabouts};

/// Features and hypotheses, as a file has them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Catalogue {
    /// What can be looked for.
    pub feature: Vec<Feature>,
    /// Kinds of places.
    pub hypothesis: Vec<Hypothesis>,
}

/// Something that can be looked for about a place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Feature {
    /// Its name, which hypotheses refer to.
    #[schemars(length(min = 1, max = 60))]
    pub id: String,
    /// What it is.
    pub kind: FeatureKind,
    /// Where it is expected: `near-left`, `near-right`, `far-left` or `far-right` for convex corners and edges, `left`, `right` or
    /// `ahead` for walls, `left` or `right` for concave corners.
    #[serde(rename = "where")]
    #[schemars(with = "Spot")]
    pub whereabouts: Whereabouts,
}

/// A kind of place.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Hypothesis {
    /// Its name, as reports have it.
    #[schemars(length(min = 1, max = 60))]
    pub id: String,
    /// What people call it; its `id` unless it has one.
    #[serde(default)]
    pub title: String,
    /// What is there.
    #[serde(default)]
    pub features: Vec<String>,
    /// What can't be looked for there, since the way to it leads through a wall.
    #[serde(default)]
    pub blocked: Vec<String>,
    /// Where corridors lead on.
    #[serde(default)]
    pub ways: Vec<Way>,
    /// How much more often such a place is met than others.
    #[serde(default = "one")]
    #[schemars(range(min = 0.000001, max = 1000000.0))]
    pub weight: f64,
}

fn one() -> f64 {
    1.0
}

/// The most features and the most hypotheses.
pub const MOST: usize = MAX_TRANSDUCERS;

/// What is wrong with a catalogue.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{message}")]
pub struct CatalogueError {
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub hint: String,
    /// The `id` of the feature or hypothesis that it is about, and which of the two; `None` for the whole.
    pub about: Option<(Table, String)>,
}

/// A table of a catalogue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Table {
    /// `[[feature]]`
    Feature,
    /// `[[hypothesis]]`
    Hypothesis,
}

/// How a feature stands to a kind of place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// It is there.
    Present,
    /// It can't be looked for.
    Blocked,
    /// It is not there.
    Absent,
}

impl Hypothesis {
    /// What people call it.
    #[must_use]
    pub fn name(&self) -> &str {
        if self.title.is_empty() { &self.id } else { &self.title }
    }
}

impl Catalogue {
    /// The corridors of Randazza (1989), appendix A.
    #[must_use]
    pub fn corridors() -> Self {
        // A test reads it.
        toml::from_str(include_str!("corridors.toml")).unwrap_or_default()
    }

    /// Adds what another one has. What has the same `id` is replaced, and stays at its place.
    pub fn extend(&mut self, more: Self) {
        for feature in more.feature {
            match self.feature.iter_mut().find(|known| known.id == feature.id) {
                Some(known) => *known = feature,
                None => self.feature.push(feature),
            }
        }
        for hypothesis in more.hypothesis {
            match self.hypothesis.iter_mut().find(|known| known.id == hypothesis.id) {
                Some(known) => *known = hypothesis,
                None => self.hypothesis.push(hypothesis),
            }
        }
    }

    /// The number of a feature.
    #[must_use]
    pub fn feature_by_id(&self, id: &str) -> Option<usize> {
        self.feature.iter().position(|feature| feature.id == id)
    }

    /// How a feature stands to a kind of place, both by their numbers. What is not known is absent.
    #[must_use]
    pub fn standing(&self, feature: usize, hypothesis: usize) -> Standing {
        let (Some(feature), Some(hypothesis)) = (self.feature.get(feature), self.hypothesis.get(hypothesis)) else {
            return Standing::Absent;
        };
        if hypothesis.features.contains(&feature.id) {
            Standing::Present
        } else if hypothesis.blocked.contains(&feature.id) {
            Standing::Blocked
        } else {
            Standing::Absent
        }
    }

    /// What the corridor follower says on arrival at such a place: which sides have corners or edges.
    #[must_use]
    pub fn opening(&self, hypothesis: usize) -> Opening {
        let is_open = |side: Side| {
            self.feature.iter().enumerate().any(|(number, feature)| {
                let beside = matches!(feature.whereabouts, Whereabouts::Near(at) | Whereabouts::Far(at) if at == side);
                beside && self.standing(number, hypothesis) == Standing::Present
            })
        };
        match (is_open(Side::Left), is_open(Side::Right)) {
            (true, true) => Opening::Both,
            (true, false) => Opening::Left,
            (false, true) => Opening::Right,
            (false, false) => Opening::DeadEnd,
        }
    }

    /// Checks that names are known and differ, that features can be where they are said to be, and that no two kinds of places look alike.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check(&self) -> Result<(), CatalogueError> {
        let count = |what: &str, number: usize| {
            let message =
                if number == 0 { format!("there is no {what}") } else { format!("{number} of [[{what}]] are too many") };
            let wrong = number == 0 || number > MOST;
            if wrong { Err(CatalogueError { message, hint: format!("1 to {MOST} are possible"), about: None }) } else { Ok(()) }
        };
        count("feature", self.feature.len())?;
        count("hypothesis", self.hypothesis.len())?;
        self.check_features()?;
        (0..self.hypothesis.len()).try_for_each(|number| self.check_hypothesis(number))
    }

    fn check_features(&self) -> Result<(), CatalogueError> {
        for (number, feature) in self.feature.iter().enumerate() {
            let refuse = |message: String, hint: &str| {
                Err(CatalogueError { message, hint: hint.to_owned(), about: Some((Table::Feature, feature.id.clone())) })
            };
            if self.feature_by_id(&feature.id) != Some(number) {
                return refuse(format!("the feature `{}` is there twice", feature.id), "give one of them another `id`");
            }
            if !feature.whereabouts.may_hold(feature.kind) {
                let hint = "convex corners and edges are near or far, walls beside or ahead, concave corners beside";
                return refuse(format!("the feature `{}` can't be there", feature.id), hint);
            }
        }
        Ok(())
    }

    fn check_hypothesis(&self, number: usize) -> Result<(), CatalogueError> {
        let Some(hypothesis) = self.hypothesis.get(number) else { return Ok(()) };
        let refuse = |message: String, hint: String| {
            Err(CatalogueError { message, hint, about: Some((Table::Hypothesis, hypothesis.id.clone())) })
        };
        let id = &hypothesis.id;
        for name in hypothesis.features.iter().chain(&hypothesis.blocked) {
            if self.feature_by_id(name).is_none() {
                let hint = suggest::hint(name, "there are", self.feature.iter().map(|feature| feature.id.as_str()));
                return refuse(format!("`{id}` names the feature `{name}`, which there is not"), hint);
            }
        }
        if let Some(both) = hypothesis.features.iter().find(|name| hypothesis.blocked.contains(name)) {
            return refuse(
                format!("`{both}` is said to be at `{id}` and to be blocked there"),
                "take it out of one of the two".into(),
            );
        }
        for (other, earlier) in self.hypothesis.iter().enumerate().take(number) {
            if earlier.id == *id {
                return refuse(format!("the hypothesis `{id}` is there twice"), "give one of them another `id`".into());
            }
            let alike = (0..self.feature.len()).all(|f| {
                let is_there = |hypothesis| self.standing(f, hypothesis) == Standing::Present;
                is_there(number) == is_there(other)
            });
            if alike {
                let hint = "give one of them a feature that the other has not".into();
                return refuse(format!("`{id}` and `{}` have the same features", earlier.id), hint);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_corridors_are_those_of_the_listing() {
        let catalogue = Catalogue::corridors();
        assert_eq!(catalogue.check(), Ok(()));
        assert_eq!((catalogue.feature.len(), catalogue.hypothesis.len()), (13, 12));
        let all: Vec<(usize, usize)> = (0..13).flat_map(|f| (0..12).map(move |h| (f, h))).collect();
        let count = |standing| all.iter().filter(|(f, h)| catalogue.standing(*f, *h) == standing).count();
        assert_eq!([Standing::Present, Standing::Blocked, Standing::Absent].map(count), [37, 18, 101]);
    }

    /// The hint of open sides leaves a third of them.
    #[test]
    fn sides_open_in_groups_of_four() {
        let catalogue = Catalogue::corridors();
        let expected = [Opening::Right, Opening::Left, Opening::Both];
        for number in 0..12 {
            assert_eq!(catalogue.opening(number), expected[number / 4], "{}", catalogue.hypothesis[number].id);
        }
    }

    #[test]
    fn kinds_of_ones_own_are_added() {
        let mut catalogue = Catalogue::corridors();
        catalogue.extend(toml::from_str(include_str!("../../../configs/places/more.toml")).unwrap());
        assert_eq!(catalogue.check(), Ok(()));
        let names: Vec<&str> = catalogue.hypothesis.iter().skip(12).map(|hypothesis| hypothesis.id.as_str()).collect();
        assert_eq!(names, ["dead-end", "room"]);
        assert_eq!((catalogue.opening(12), catalogue.opening(13)), (Opening::DeadEnd, Opening::Both));
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        let refused = |change: fn(&mut Catalogue)| {
            let mut catalogue = Catalogue::corridors();
            change(&mut catalogue);
            catalogue.check().unwrap_err().message
        };
        assert!(refused(|c| c.hypothesis.clear()).contains("no hypothesis"));
        assert!(refused(|c| c.hypothesis[1].id = "H1".into()).contains("twice"));
        assert!(refused(|c| c.feature[1].id = "NRC".into()).contains("twice"));
        assert!(refused(|c| c.feature[0].kind = FeatureKind::Wall).contains("can't be there"));
        assert!(refused(|c| c.hypothesis[3].features = c.hypothesis[2].features.clone()).contains("same features"));
        assert!(refused(|c| c.hypothesis[0].blocked.push("WL".into())).contains("blocked"));
        assert!(refused(|c| c.hypothesis[0].features.push("NRX".into())).contains("NRX"));
    }
}
