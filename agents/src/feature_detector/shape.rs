//! Do three points make such a feature? (Randazza 1989 records them and asks no more; §4.7 of the specification fixes the angles.)

use nalgebra::Vector2;
use orienteer_runtime::{geometry::Pose, topics::FeatureKind};

/// An angle may be off by this, rad.
const ANGLE: f64 = 20.0 / 180.0 * std::f64::consts::PI;
/// How thick a wall that ends may be, m.
const THICKNESS: std::ops::Range<f64> = 0.04..0.24;

/// True if the points, in the order in which a robot meets them, have the shape of that feature: a straight line, a right angle, or two
/// parallel legs a wall's thickness apart.
#[must_use]
pub fn is_such_a_feature(kind: FeatureKind, points: &[Pose]) -> bool {
    let [a, b, c] = points else { return false };
    let (u, w) = (a.point() - b.point(), c.point() - b.point());
    let between = u.angle(&w);
    match kind {
        FeatureKind::Wall => std::f64::consts::PI - between < ANGLE,
        FeatureKind::Convex | FeatureKind::Concave => (between - std::f64::consts::FRAC_PI_2).abs() < ANGLE,
        FeatureKind::Edge => {
            let along = (u.normalize() + w.normalize()).normalize();
            between < ANGLE && THICKNESS.contains(&across(&along, &(a.point() - c.point())))
        }
    }
}

/// How far a vector leads off a direction, m.
fn across(along: &Vector2<f64>, vector: &Vector2<f64>) -> f64 {
    along.perp(vector).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(points: [(f64, f64); 3]) -> [Pose; 3] {
        points.map(|(x, y)| Pose::new(x, y, 0.0))
    }

    #[test]
    fn each_shape_is_its_own() {
        let shapes = [
            (FeatureKind::Wall, points([(-0.5, 0.02), (0.0, 0.0), (0.5, 0.05)])),
            (FeatureKind::Convex, points([(-0.6, 0.0), (0.0, 0.0), (0.03, 0.6)])),
            (FeatureKind::Edge, points([(0.6, 0.14), (0.0, 0.07), (0.6, 0.0)])),
        ];
        for (kind, points) in &shapes {
            for (other, _) in &shapes {
                assert_eq!(is_such_a_feature(*other, points), kind == other, "{kind:?} as {other:?}");
            }
        }
        assert!(is_such_a_feature(FeatureKind::Concave, &shapes[1].1), "the angle does not tell inside from outside");
    }

    #[test]
    fn what_is_no_three_points_or_one_place_is_nothing() {
        for kind in [FeatureKind::Wall, FeatureKind::Convex, FeatureKind::Edge] {
            assert!(!is_such_a_feature(kind, &[]));
            assert!(!is_such_a_feature(kind, &points([(1.0, 1.0); 3])));
        }
    }
}
