//! A world for the tests: walls and round people, and a sonar that is computed ray by ray, independently of the product's own
//! echo model.
use std::f64::consts::TAU;

use nalgebra::{Point2, Vector2};
use orienteer_runtime::{
    geometry::Pose,
    robot_model::{Ring, Transducer},
    topics::{Echo, FiringProgram, FixedVec},
};

#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// Straight walls from one point to another.
    pub walls: Vec<(Point2<f64>, Point2<f64>)>,
    /// Centres and radii.
    pub people: Vec<(Point2<f64>, f64)>,
    /// A wall answers only up to this angle from its normal, rad.
    pub specular: f64,
}

impl Scene {
    /// Two walls along x, `width` apart, the x axis in their middle.
    pub fn corridor(width: f64, specular: f64) -> Self {
        let y = 0.5 * width;
        let wall = |y: f64| (Point2::new(-20.0, y), Point2::new(20.0, y));
        Self { walls: vec![wall(y), wall(-y)], people: vec![], specular }
    }

    /// Where a ray meets a wall or a person: distance and cosine of incidence.
    fn along(&self, from: Point2<f64>, ray: Vector2<f64>) -> Vec<(f64, f64)> {
        let mut hits = Vec::new();
        for (a, b) in &self.walls {
            let edge = b - a;
            let normal = Vector2::new(-edge.y, edge.x).normalize();
            let t = normal.dot(&(a - from)) / normal.dot(&ray);
            let share = (from + ray * t - a).dot(&edge) / edge.norm_squared();
            if t > 0.0 && (0.0..=1.0).contains(&share) {
                hits.push((t, normal.dot(&ray).abs()));
            }
        }
        for (centre, radius) in &self.people {
            let to = centre - from;
            let (ahead, beside) = (ray.dot(&to), ray.x * to.y - ray.y * to.x);
            if ahead > 0.0 && beside.abs() <= *radius {
                // clothes scatter: a person answers in any direction
                hits.push((ahead - (radius * radius - beside * beside).sqrt(), 1.0));
            }
        }
        hits
    }

    /// First echo in a beam: rays each quarter of a degree; what lies behind something nearer on its ray is hidden.
    pub fn echo(&self, face: Pose, half_beam: f64, max_range: f64) -> Echo {
        let count = (2.0 * half_beam / 0.0044).ceil() as usize;
        let mut nearest = f64::INFINITY;
        for i in 0..=count {
            let bearing = face.heading - half_beam + 2.0 * half_beam * i as f64 / count as f64;
            let hits = self.along(face.point(), Vector2::new(bearing.cos(), bearing.sin()));
            let first = hits.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((range, cosine)) = first
                && cosine >= self.specular.cos()
            {
                nearest = nearest.min(range);
            }
        }
        if nearest <= max_range { Echo::Range(nearest as f32) } else { Echo::Nothing }
    }

    /// Distance from a point to the nearest thing.
    pub fn clearance(&self, p: Point2<f64>) -> f64 {
        let wall = |(a, b): &(Point2<f64>, Point2<f64>)| {
            let edge = b - a;
            let share = ((p - a).dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0);
            nalgebra::distance(&p, &(a + edge * share))
        };
        let walls = self.walls.iter().map(wall).fold(f64::INFINITY, f64::min);
        self.people.iter().map(|(centre, radius)| nalgebra::distance(&p, centre) - radius).fold(walls, f64::min)
    }
}

/// `count` transducers in a circle of radius `radius`, the first ahead.
pub fn circular_ring(count: usize, radius: f64, half_beam_deg: f64) -> Ring {
    let transducers = (0..count).map(|i| {
        let bearing = TAU * i as f64 / count as f64;
        let mount = Pose::new(radius * bearing.cos(), radius * bearing.sin(), bearing);
        Transducer { mount, half_beam: half_beam_deg.to_radians() }
    });
    ring_of(transducers.collect())
}

/// The 16 sonars of a Pioneer P3-DX (ARIA's p3dx.p), mm and degrees.
pub fn pioneer_ring() -> Ring {
    let front = [(69, 136, 90), (114, 119, 50), (148, 78, 30), (166, 27, 10)];
    let rear = [(-157, 136, 90), (-203, 119, 130), (-237, 78, 150), (-255, 27, 170)];
    let both = front.iter().chain(&rear).flat_map(|(x, y, bearing)| [(*x, *y, *bearing), (*x, -*y, -*bearing)]);
    let transducers = both.map(|(x, y, bearing)| {
        let mount = Pose::new(f64::from(x) * 1e-3, f64::from(y) * 1e-3, f64::from(bearing).to_radians());
        Transducer { mount, half_beam: 15f64.to_radians() }
    });
    ring_of(transducers.collect())
}

fn ring_of(transducers: Vec<Transducer>) -> Ring {
    let all = u32::MAX >> (32 - transducers.len());
    Ring {
        name: "test".into(),
        transducers,
        min_range: 0.03,
        max_range: 5.0,
        slot_time: 0.1,
        program: FiringProgram { slots: FixedVec::filled(all, 1), period: 0.1, rings: 1 },
    }
}
