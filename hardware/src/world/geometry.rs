//! What the world is made of once it is flattened: segments, corners, pillars.
//!
//! Free space lies on the **left** of every segment of a world, so `(b - a)` turned by +90° points at whoever looks at the
//! wall. At a corner the boundary therefore turns right where matter sticks out into free space (a *convex* corner: it
//! diffracts sound and answers a sonar from any angle) and left where two walls enclose free space (a *concave* corner: a
//! retro-reflector only by double reflection).

use std::f64::consts::PI;

use nalgebra::{Point2, Vector2};
use orienteer_runtime::geometry::angle;

/// How a surface treats sound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Amplitude of an echo at normal incidence as a share of that of a hard, smooth wall; `(0, 1]`. MacPherson 1993 (§2)
    /// calls it target strength and asks for more than one half at 2.3 m.
    pub reflectance: f64,
}

impl Default for Material {
    /// A hard wall.
    fn default() -> Self {
        Self { reflectance: 1.0 }
    }
}

/// A straight piece of surface, free space on the left of `a → b`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Start, m.
    pub a: Point2<f64>,
    /// End, m; never equal to `a`.
    pub b: Point2<f64>,
    /// What the surface is made of.
    pub material: Material,
}

impl Segment {
    /// A segment of hard wall.
    #[must_use]
    pub fn new(a: Point2<f64>, b: Point2<f64>) -> Self {
        Self { a, b, material: Material::default() }
    }

    /// Length, m.
    #[must_use]
    pub fn length(&self) -> f64 {
        (self.b - self.a).norm()
    }

    /// Unit normal that points into free space. Zero for a segment without length.
    #[must_use]
    pub fn normal(&self) -> Vector2<f64> {
        let along = self.b - self.a;
        Vector2::new(-along.y, along.x).try_normalize(0.0).unwrap_or_else(Vector2::zeros)
    }

    /// The point of the segment nearest to `from`.
    ///
    /// ```
    /// use nalgebra::Point2;
    /// use orienteer_hardware::world::geometry::Segment;
    /// let wall = Segment::new(Point2::new(0.0, 0.0), Point2::new(2.0, 0.0));
    /// assert_eq!(wall.nearest(Point2::new(0.5, 1.0)), Point2::new(0.5, 0.0));
    /// assert_eq!(wall.nearest(Point2::new(-3.0, 4.0)), wall.a);
    /// ```
    #[must_use]
    pub fn nearest(&self, from: Point2<f64>) -> Point2<f64> {
        let along = self.b - self.a;
        let squared = along.norm_squared();
        let t = if squared > 0.0 { ((from - self.a).dot(&along) / squared).clamp(0.0, 1.0) } else { 0.0 };
        self.a + along * t
    }
}

/// What kind of corner a vertex is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Corner {
    /// Sticks out into free space; answers sonar from any angle.
    Convex,
    /// Two walls that enclose free space.
    Concave,
    /// The free end of a surface without thickness; behaves like a sharp convex corner.
    End,
}

/// Where the boundary of solid matter changes direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex {
    /// Position, m.
    pub at: Point2<f64>,
    /// Which way it points.
    pub kind: Corner,
    /// How sharply the boundary turns here, in `[0, π]` rad: π/2 at the corner of a box, little where a polyline stands for a
    /// curve, π at an end.
    pub turn: f64,
    /// The weaker material of the two surfaces that meet here.
    pub material: Material,
}

/// A circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disc {
    /// Centre, m.
    pub center: Point2<f64>,
    /// Radius, m.
    pub radius: f64,
}

impl Disc {
    /// A disc from its centre (m) and radius (m).
    #[must_use]
    pub fn new(center: Point2<f64>, radius: f64) -> Self {
        Self { center, radius }
    }

    /// Distance from a point to the rim, m; negative inside.
    #[must_use]
    pub fn distance(&self, from: Point2<f64>) -> f64 {
        (from - self.center).norm() - self.radius
    }
}

/// A round pillar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pillar {
    /// Its cross-section.
    pub disc: Disc,
    /// What its surface is made of.
    pub material: Material,
}

/// An axis-parallel rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Corner with the smallest coordinates, m.
    pub min: Point2<f64>,
    /// Corner with the largest coordinates, m.
    pub max: Point2<f64>,
}

impl Bounds {
    /// The smallest rectangle that contains all points; `None` without any.
    pub fn around(points: impl IntoIterator<Item = Point2<f64>>) -> Option<Self> {
        points.into_iter().map(|p| Self { min: p, max: p }).reduce(|a, b| a.union(&b))
    }

    /// The smallest rectangle that contains both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.inf(&other.min), max: self.max.sup(&other.max) }
    }

    /// The rectangle grown by `margin` (m) on every side.
    #[must_use]
    pub fn grown(&self, margin: f64) -> Self {
        let by = Vector2::new(margin, margin);
        Self { min: self.min - by, max: self.max + by }
    }

    /// Width and height, m.
    #[must_use]
    pub fn size(&self) -> Vector2<f64> {
        self.max - self.min
    }

    /// True if the point is inside or on the rim.
    #[must_use]
    pub fn contains(&self, point: Point2<f64>) -> bool {
        self.min.x <= point.x && point.x <= self.max.x && self.min.y <= point.y && point.y <= self.max.y
    }
}

/// The static world as sonar and bodies meet it.
///
/// No segment lies inside solid matter, with one exception: a pillar is kept as the exact circle it is, so where one stands
/// in a wall, hidden pieces of both remain. They can't be seen or touched from free space.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// All flat surfaces, ring after ring.
    pub segments: Vec<Segment>,
    /// All corners.
    pub vertices: Vec<Vertex>,
    /// All round pillars.
    pub pillars: Vec<Pillar>,
    /// The smallest rectangle around everything above; the origin alone in an empty world.
    pub bounds: Bounds,
    /// True if everything far away is solid, as in a world carved out of matter.
    pub enclosed: bool,
}

impl Outline {
    /// An outline from closed rings, each with free space on its left, and pillars. `material` is asked for the material at
    /// the middle of each segment. Repeated points are skipped; a ring of less than two distinct points is ignored.
    pub fn from_rings(
        rings: &[Vec<Point2<f64>>],
        pillars: Vec<Pillar>,
        enclosed: bool,
        mut material: impl FnMut(Point2<f64>, Point2<f64>) -> Material,
    ) -> Self {
        let mut segments = Vec::new();
        let mut vertices = Vec::new();
        for ring in rings {
            let first = segments.len();
            let next = ring.iter().cycle().skip(1);
            let sides = ring.iter().zip(next).filter(|(a, b)| a != b);
            segments.extend(sides.map(|(&a, &b)| Segment { a, b, material: material(a, b) }));
            let sides = &segments[first..];
            for (i, after) in sides.iter().enumerate() {
                let before = &sides[(i + sides.len() - 1) % sides.len()];
                vertices.push(corner(before, after));
            }
        }
        Self::assemble(segments, vertices, pillars, enclosed)
    }

    /// An outline of thin walls that can be seen from both sides, each an open polyline. Its ends are [`Corner::End`]; every
    /// bend sticks out to one side, so it counts as [`Corner::Convex`].
    #[must_use]
    pub fn from_polylines(lines: &[Vec<Point2<f64>>]) -> Self {
        let mut segments = Vec::new();
        let mut vertices = Vec::new();
        for line in lines {
            let first = segments.len();
            segments.extend(line.windows(2).filter(|w| w[0] != w[1]).map(|w| Segment::new(w[0], w[1])));
            let sides = &segments[first..];
            let end = |at| Vertex { at, kind: Corner::End, turn: PI, material: Material::default() };
            if let (Some(start), Some(stop)) = (sides.first(), sides.last()) {
                vertices.extend([end(start.a), end(stop.b)]);
            }
            vertices.extend(sides.windows(2).map(|w| Vertex { kind: Corner::Convex, ..corner(&w[0], &w[1]) }));
        }
        Self::assemble(segments, vertices, Vec::new(), false)
    }

    fn assemble(segments: Vec<Segment>, vertices: Vec<Vertex>, pillars: Vec<Pillar>, enclosed: bool) -> Self {
        let ends = segments.iter().flat_map(|s| [s.a, s.b]);
        let rims = pillars.iter().flat_map(|p| {
            let r = Vector2::new(p.disc.radius, p.disc.radius);
            [p.disc.center - r, p.disc.center + r]
        });
        let origin = Bounds { min: Point2::origin(), max: Point2::origin() };
        let bounds = Bounds::around(ends.chain(rims)).unwrap_or(origin);
        Self { segments, vertices, pillars, bounds, enclosed }
    }

    /// True if the point lies in free space, by counting how often a ray from it crosses the outline. Only for outlines of
    /// closed rings. Costs one look at each segment: for checking plans, not for control loops.
    #[must_use]
    pub fn is_free(&self, point: Point2<f64>) -> bool {
        let crossings = self.segments.iter().filter(|s| crosses_ray(s, point)).count();
        let solid = (crossings % 2 == 1) != self.enclosed;
        !solid && self.pillars.iter().all(|p| p.disc.distance(point) > 0.0)
    }
}

/// True if the ray from `origin` along +x crosses the segment, the upper end point not counted.
fn crosses_ray(segment: &Segment, origin: Point2<f64>) -> bool {
    let (a, b) = (segment.a, segment.b);
    (a.y <= origin.y) != (b.y <= origin.y) && a.x + (origin.y - a.y) / (b.y - a.y) * (b.x - a.x) > origin.x
}

fn corner(before: &Segment, after: &Segment) -> Vertex {
    let heading = |s: &Segment| (s.b.y - s.a.y).atan2(s.b.x - s.a.x);
    let turn = angle::turn(heading(before), heading(after));
    let kind = if turn > 0.0 && turn < PI { Corner::Concave } else { Corner::Convex };
    let material = if before.material.reflectance < after.material.reflectance { before.material } else { after.material };
    Vertex { at: after.a, kind, turn: turn.abs(), material }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Vec<Point2<f64>> {
        [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(|(x, y)| Point2::new(x, y)).to_vec()
    }

    fn hard(_: Point2<f64>, _: Point2<f64>) -> Material {
        Material::default()
    }

    #[test]
    fn a_room_has_concave_corners_and_a_box_convex_ones() {
        let room = Outline::from_rings(&[square()], vec![], true, hard);
        assert!(room.vertices.iter().all(|v| v.kind == Corner::Concave && (v.turn - PI / 2.0).abs() < 1e-12));
        assert!(room.is_free(Point2::new(1.0, 1.0)) && !room.is_free(Point2::new(3.0, 1.0)));
        assert_eq!(room.segments[0].normal(), Vector2::new(0.0, 1.0));

        let mut ring = square();
        ring.reverse();
        let block = Outline::from_rings(&[ring], vec![], false, hard);
        assert!(block.vertices.iter().all(|v| v.kind == Corner::Convex));
        assert!(!block.is_free(Point2::new(1.0, 1.0)) && block.is_free(Point2::new(3.0, 1.0)));
    }

    #[test]
    fn a_thin_wall_has_two_ends() {
        let line = vec![Point2::new(0.0, 0.0), Point2::new(1.0, 0.0), Point2::new(1.0, 1.0)];
        let wall = Outline::from_polylines(&[line]);
        let kinds: Vec<Corner> = wall.vertices.iter().map(|v| v.kind).collect();
        assert_eq!(kinds, [Corner::End, Corner::End, Corner::Convex]);
    }
}
