//! Features of places, found in the outline of a world by their definitions (Randazza 1989), and which of them make which hypothesis.
#![allow(clippy::unwrap_used, missing_docs)]

use nalgebra::Point2;
use orienteer_hardware::world::{
    World,
    floors::{Hypothesis, HypothesisFrame},
    geometry::{Corner, Disc},
    plan::WorldPlan,
};
use orienteer_runtime::geometry::Pose;

pub fn load(plan: &WorldPlan) -> World {
    World::from_plan(plan, &|_| unreachable!()).unwrap()
}

/// The thirteen features of the hypotheses, by her abbreviations: near or far, right or left, convex corner or edge; wall left,
/// right or ahead; concave corner left or right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Feature {
    Nrc,
    Nre,
    Nlc,
    Nle,
    Frc,
    Flc,
    Fre,
    Fle,
    Wl,
    Wr,
    Wa,
    Kl,
    Kr,
}

impl Feature {
    pub const ALL: [Self; 13] = {
        use Feature::*;
        [Nrc, Nre, Nlc, Nle, Frc, Flc, Fre, Fle, Wl, Wr, Wa, Kl, Kr]
    };
}

/// Which features a hypothesis has, as her appendix A lists them.
pub fn appendix_a(hypothesis: Hypothesis) -> Vec<Feature> {
    use Feature::*;
    let mut features = match hypothesis {
        Hypothesis::H1 => vec![Nrc, Frc, Wl],
        Hypothesis::H2 => vec![Nrc, Kl],
        Hypothesis::H3 => vec![Nrc, Fre, Wl],
        Hypothesis::H4 => vec![Nre, Frc, Wl],
        Hypothesis::H5 => vec![Nlc, Flc, Wr],
        Hypothesis::H6 => vec![Nlc, Kr],
        Hypothesis::H7 => vec![Nle, Flc, Wr],
        Hypothesis::H8 => vec![Nlc, Fle, Wr],
        Hypothesis::H9 => vec![Nlc, Frc, Nre, Fle],
        Hypothesis::H10 => vec![Nle, Flc, Nrc, Fre],
        Hypothesis::H11 => vec![Nlc, Wa, Nrc],
        Hypothesis::H12 => vec![Nlc, Nrc, Frc, Flc],
        Hypothesis::DeadEnd => vec![],
    };
    features.sort_unstable();
    features
}

/// A place as it lies before a robot, cm.
pub struct Site<'a> {
    pub world: &'a World,
    pub start: Pose,
    /// Half the corridor's width.
    pub half: f64,
    /// The far line; the near one is at 8.
    pub far: f64,
    /// Thickness of an edge.
    pub wall: f64,
}

const NEAR: f64 = 8.0;

impl Site<'_> {
    /// True if the outline has what makes this feature.
    pub fn has(&self, feature: Feature) -> bool {
        use Feature::*;
        let Self { half, far, wall, .. } = *self;
        let right = if matches!(feature, Nlc | Nle | Flc | Fle | Wl | Kl) { -1.0 } else { 1.0 };
        let side = right * half;
        match feature {
            // Two walls of 50 cm each, at right angles, around matter.
            Nrc | Nlc => {
                self.convex(side, NEAR)
                    && self.surface([side, NEAR], [0.0, -50.0])
                    && self.surface([side, NEAR], [50.0 * right, 0.0])
            }
            Frc | Flc => {
                self.convex(side, far) && self.surface([side, far], [0.0, 50.0]) && self.surface([side, far], [50.0 * right, 0.0])
            }
            // The end of a thin wall, 50 cm of it on either face.
            Nre | Nle => self.edge(side, side + right * wall, NEAR, -50.0),
            Fre | Fle => self.edge(side, side + right * wall, far, 50.0),
            // 50 cm on either side of the middle, and a robot of 30 cm radius can drive along all of it, 48 cm off.
            Wl | Wr => {
                let middle = 0.5 * (NEAR + far);
                let both = [-50.0, 50.0].map(|reach| {
                    self.surface([side, middle], [0.0, reach]) && self.drives([side - right * 48.0, middle], [0.0, reach])
                });
                both == [true, true]
            }
            Wa => [-50.0, 50.0]
                .iter()
                .all(|reach| self.surface([0.0, far], [*reach, 0.0]) && self.drives([0.0, far - 48.0], [*reach, 0.0])),
            // Two walls of 100 cm each, at right angles, around free space.
            Kl | Kr => {
                self.vertex(side, far) == Some(Corner::Concave)
                    && self.surface([side, far], [0.0, -100.0])
                    && self.surface([side, far], [-100.0 * right, 0.0])
            }
        }
    }

    fn edge(&self, front: f64, back: f64, at: f64, reach: f64) -> bool {
        [front, back].iter().all(|x| self.convex(*x, at) && self.surface([*x, at], [0.0, reach]))
            && self.surface([front, at], [back - front, 0.0])
    }

    fn convex(&self, right: f64, forward: f64) -> bool {
        self.vertex(right, forward) == Some(Corner::Convex)
    }

    fn point(&self, [right, forward]: [f64; 2]) -> Point2<f64> {
        HypothesisFrame::new(self.start).point(right, forward)
    }

    fn vertex(&self, right: f64, forward: f64) -> Option<Corner> {
        let at = self.point([right, forward]);
        self.world.outline.vertices.iter().find(|vertex| (vertex.at - at).norm() < 1e-6).map(|vertex| vertex.kind)
    }

    /// True if one straight surface goes from here as far as `reach` says.
    fn surface(&self, from: [f64; 2], reach: [f64; 2]) -> bool {
        let ends = [from, [from[0] + reach[0], from[1] + reach[1]]].map(|at| self.point(at));
        self.world.outline.segments.iter().any(|segment| ends.iter().all(|end| (segment.nearest(*end) - end).norm() < 1e-6))
    }

    /// True if a robot gets from here as far as `way` says.
    fn drives(&self, from: [f64; 2], way: [f64; 2]) -> bool {
        let [a, b] = [from, [from[0] + way[0], from[1] + way[1]]].map(|at| self.point(at));
        self.world.obstacles.sweep(Disc::new(a, 0.30), b - a).is_none()
    }
}
