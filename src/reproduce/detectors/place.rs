//! Which features belong to which of the twelve places that Randazza (1989) names.

use crate::{
    agents::feature_detector::Whereabouts,
    hardware::world::floors::{Flank, Hypothesis},
    runtime::topics::{FeatureKind, Side},
};

/// The features that the detectors are asked for, with the listing's names for them.
pub(super) const FEATURES: [(&str, FeatureKind, Whereabouts); 13] = {
    use FeatureKind::{Concave, Convex, Edge, Wall};
    use Side::{Left, Right};
    use Whereabouts::{Ahead, Beside, Far, Near};
    [
        ("NRC", Convex, Near(Right)),
        ("NRE", Edge, Near(Right)),
        ("NLC", Convex, Near(Left)),
        ("NLE", Edge, Near(Left)),
        ("FRC", Convex, Far(Right)),
        ("FLC", Convex, Far(Left)),
        ("FRE", Edge, Far(Right)),
        ("FLE", Edge, Far(Left)),
        ("WL", Wall, Beside(Left)),
        ("WR", Wall, Beside(Right)),
        ("WA", Wall, Ahead),
        ("KL", Concave, Beside(Left)),
        ("KR", Concave, Beside(Right)),
    ]
};

/// The twelve places: all but the dead end, which the listing does not know.
pub(super) const PLACES: usize = Hypothesis::ALL.len() - 1;

/// True if that feature belongs to this place.
pub(super) fn has(place: Hypothesis, kind: FeatureKind, whereabouts: Whereabouts) -> bool {
    let view = place.view();
    let flank = |side: Side| if side == Side::Left { view.left } else { view.right };
    match (kind, whereabouts) {
        (FeatureKind::Convex, Whereabouts::Near(side)) => matches!(flank(side), Flank::Corridor | Flank::CornerThenEdge),
        (FeatureKind::Convex, Whereabouts::Far(side)) => {
            view.ahead && matches!(flank(side), Flank::Corridor | Flank::EdgeThenCorner)
        }
        (FeatureKind::Edge, Whereabouts::Near(side)) => flank(side) == Flank::EdgeThenCorner,
        (FeatureKind::Edge, Whereabouts::Far(side)) => flank(side) == Flank::CornerThenEdge,
        (FeatureKind::Wall, Whereabouts::Beside(side)) => view.ahead && flank(side) == Flank::Wall,
        (FeatureKind::Wall, Whereabouts::Ahead) => !view.ahead && view.left == Flank::Corridor && view.right == Flank::Corridor,
        (FeatureKind::Concave, Whereabouts::Beside(side)) => !view.ahead && flank(side) == Flank::Wall,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_features_is_that_of_the_listing() {
        let expected = [
            "NRC FRC WL",
            "NRC KL",
            "NRC FRE WL",
            "NRE FRC WL",
            "NLC FLC WR",
            "NLC KR",
            "NLE FLC WR",
            "NLC FLE WR",
            "NRE NLC FRC FLE",
            "NRC NLE FLC FRE",
            "NRC NLC WA",
            "NRC NLC FRC FLC",
        ];
        for (place, expected) in Hypothesis::ALL.into_iter().zip(expected) {
            let names: Vec<_> = FEATURES.iter().filter(|(_, kind, at)| has(place, *kind, *at)).map(|(name, ..)| *name).collect();
            assert_eq!(names.join(" "), expected, "{place}");
        }
    }
}
