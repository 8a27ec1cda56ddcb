//! A second opinion on what a transducer hears: very many rays, and a loop over everything for each.

use nalgebra::{Point2, Vector2};
use orienteer_runtime::geometry::Pose;

use super::RandomWorld;

/// Rays in a fan.
pub const RAYS: usize = 4001;

/// A transducer as a fan of rays, for a model with one limit of incidence and surfaces that are all hard.
pub struct Fan {
    pub pose: Pose,
    pub half_beam: f64,
    pub max_range: f64,
    /// Greatest angle of incidence that is heard, rad.
    pub limit: f64,
    /// How far away corners are heard at any angle, m.
    pub vertex_range: f64,
}

/// What a ray meets.
pub struct Hit {
    pub range: f64,
    /// Sine of the angle of incidence.
    pub slant: f64,
}

impl Fan {
    /// The nearest thing that answers any ray.
    pub fn nearest(&self, world: &RandomWorld) -> Option<f64> {
        let from = self.pose.point();
        let rays = (0..RAYS).filter_map(|i| {
            let off = self.half_beam * (2.0 * i as f64 / (RAYS - 1) as f64 - 1.0);
            let (sin, cos) = (self.pose.heading + off).sin_cos();
            let hit = first(world, from, Vector2::new(cos, sin))?;
            (hit.range <= self.max_range && hit.slant <= self.limit.sin()).then_some(hit.range)
        });
        let corners = world.vertices.iter().filter_map(|vertex| {
            let way = vertex.at - from;
            let (range, bearing) = (way.norm(), way.y.atan2(way.x) - self.pose.heading);
            let in_beam = bearing.sin().atan2(bearing.cos()).abs() <= self.half_beam;
            let heard = in_beam && range <= self.vertex_range.min(self.max_range);
            (heard && !world.hides(from, vertex.at)).then_some(range)
        });
        rays.chain(corners).min_by(f64::total_cmp)
    }
}

/// The first surface along a unit vector.
pub fn first(world: &RandomWorld, from: Point2<f64>, direction: Vector2<f64>) -> Option<Hit> {
    let mut nearest = Hit { range: f64::INFINITY, slant: 0.0 };
    for wall in &world.walls {
        let (along, to) = (wall.b - wall.a, wall.a - from);
        // from + range · direction = a + share · along
        let turn = direction.perp(&along);
        let (range, share) = (to.perp(&along) / turn, to.perp(&direction) / turn);
        if range >= 0.0 && range < nearest.range && (0.0..=1.0).contains(&share) {
            nearest = Hit { range, slant: (direction.dot(&along) / along.norm()).abs() };
        }
    }
    for disc in &world.pillars {
        let to = disc.centre - from;
        let (ahead, aside) = (to.dot(&direction), to.perp(&direction));
        let depth = disc.radius * disc.radius - aside * aside;
        if to.norm() <= disc.radius {
            return Some(Hit { range: 0.0, slant: 0.0 });
        }
        if depth >= 0.0 && ahead > 0.0 && ahead - depth.sqrt() < nearest.range {
            nearest = Hit { range: ahead - depth.sqrt(), slant: (aside / disc.radius).abs() };
        }
    }
    nearest.range.is_finite().then_some(nearest)
}

/// From a point to the nearest point of a segment.
pub fn distance(from: Point2<f64>, a: Point2<f64>, b: Point2<f64>) -> f64 {
    let along = b - a;
    let share = ((from - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
    (a + along * share - from).norm()
}
