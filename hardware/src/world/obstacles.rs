//! How near is solid matter, and where does a moving body touch it?
//!
//! Surfaces lie in a uniform grid, each in every cell it passes through, so that a query looks at its neighbourhood only. All
//! answers are exact: those of a plain loop over every surface. Nothing allocates after [`Obstacles::new`].
//!
//! A sweep asks for the first share `t` of a motion `p(t) = p + t·d` at which the distance to a surface falls to the body's
//! radius `r`. For a segment that is where the ray enters the stadium of half width `r` around it: one crossing with a line
//! moved out by `r`, two circles about the ends. A fast body therefore can't pass through a thin wall between two steps.

use nalgebra::{Point2, Vector2};

use super::geometry::{Bounds, Disc, Outline, Segment};

/// Smallest side of a cell, m. Larger worlds get larger cells.
const CELL: f64 = 0.5;
/// Most cells of a grid.
const MOST_CELLS: f64 = 250_000.0;
/// Bodies nearer than this touch, m.
const SKIN: f64 = 1e-9;

/// The nearest surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// The point of the surface that is nearest.
    pub at: Point2<f64>,
    /// How far it is, m; 0 inside a pillar.
    pub distance: f64,
}

/// Where a moving body first touches something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impact {
    /// How much of the motion is done by then, in `[0, 1]`.
    pub share: f64,
    /// The point that is touched.
    pub at: Point2<f64>,
    /// Unit vector from there toward the body's centre.
    pub normal: Vector2<f64>,
}

#[derive(Debug, Clone, Copy)]
enum Surface {
    Flat(Segment),
    Round(Disc),
}

/// The static world for bodies.
#[derive(Debug, Clone)]
pub struct Obstacles {
    surfaces: Vec<Surface>,
    cell: f64,
    origin: Point2<f64>,
    columns: i64,
    rows: i64,
    /// Where the list of each cell begins in `members`, row by row, and where the last one ends.
    starts: Vec<u32>,
    /// Indices into `surfaces`.
    members: Vec<u32>,
}

/// A rectangle of cells, both ends included.
#[derive(Debug, Clone, Copy)]
struct Cells {
    columns: (i64, i64),
    rows: (i64, i64),
}

impl Obstacles {
    /// Arranges the surfaces of an outline.
    #[must_use]
    pub fn new(outline: &Outline) -> Self {
        let flat = outline.segments.iter().copied().map(Surface::Flat);
        let round = outline.pillars.iter().map(|p| Surface::Round(p.disc));
        let surfaces: Vec<Surface> = flat.chain(round).collect();
        let size = outline.bounds.size();
        let cell = CELL.max((size.x * size.y / MOST_CELLS).sqrt()).max(size.max() / MOST_CELLS);
        let count = |length: f64| (length / cell).floor() as i64 + 1;
        let mut grid = Self {
            surfaces,
            cell,
            origin: outline.bounds.min,
            columns: count(size.x),
            rows: count(size.y),
            starts: Vec::new(),
            members: Vec::new(),
        };
        grid.fill();
        grid
    }

    /// Counts the members of each cell, then puts them where the counts say.
    fn fill(&mut self) {
        let mut counts = vec![0_u32; (self.columns * self.rows) as usize + 1];
        self.each_membership(|cell, _| counts[cell + 1] += 1);
        for i in 1..counts.len() {
            counts[i] += counts[i - 1];
        }
        let mut members = vec![0; counts.last().copied().unwrap_or(0) as usize];
        let mut next = counts.clone();
        self.each_membership(|cell, surface| {
            members[next[cell] as usize] = surface;
            next[cell] += 1;
        });
        self.starts = counts;
        self.members = members;
    }

    fn each_membership(&self, mut visit: impl FnMut(usize, u32)) {
        for (i, surface) in self.surfaces.iter().enumerate() {
            let cells = self.cells(&surface.bounds().grown(SKIN));
            for row in cells.rows.0..=cells.rows.1 {
                for column in cells.columns.0..=cells.columns.1 {
                    if surface.enters(&self.square(column, row)) {
                        visit((row * self.columns + column) as usize, i as u32);
                    }
                }
            }
        }
    }

    fn square(&self, column: i64, row: i64) -> Bounds {
        let min = self.origin + Vector2::new(column as f64, row as f64) * self.cell;
        Bounds { min, max: min + Vector2::new(self.cell, self.cell) }.grown(SKIN)
    }

    /// The cells of the grid that a rectangle touches; empty ranges if it lies outside.
    fn cells(&self, bounds: &Bounds) -> Cells {
        let index = |v: f64, from: f64| ((v - from) / self.cell).floor() as i64;
        Cells {
            columns: (index(bounds.min.x, self.origin.x).max(0), index(bounds.max.x, self.origin.x).min(self.columns - 1)),
            rows: (index(bounds.min.y, self.origin.y).max(0), index(bounds.max.y, self.origin.y).min(self.rows - 1)),
        }
    }

    fn members(&self, column: i64, row: i64) -> impl Iterator<Item = &Surface> {
        let cell = (row * self.columns + column) as usize;
        let range = self.starts[cell] as usize..self.starts[cell + 1] as usize;
        self.members[range].iter().map(|i| &self.surfaces[*i as usize])
    }

    /// The surface point nearest to `from`, if any is within `reach` (m).
    ///
    /// Cells are visited in square rings about `from`; the search ends when what it has found is nearer than the next ring.
    #[must_use]
    pub fn nearest(&self, from: Point2<f64>, reach: f64) -> Option<Contact> {
        let sound = reach >= 0.0 && from.coords.iter().all(|v| v.is_finite());
        if !sound {
            return None;
        }
        let within = self.cells(&Bounds { min: from, max: from }.grown(reach + SKIN));
        if within.columns.0 > within.columns.1 || within.rows.0 > within.rows.1 {
            return None;
        }
        let offset = (from - self.origin) / self.cell;
        let (column, row) = (offset.x.floor() as i64, offset.y.floor() as i64);
        let inset = [offset.x - offset.x.floor(), offset.y - offset.y.floor()];
        let to_rim = inset.into_iter().map(|f| f.min(1.0 - f)).fold(1.0, f64::min);
        let last = [within.columns.0 - column, within.columns.1 - column, within.rows.0 - row, within.rows.1 - row];
        let last = last.into_iter().map(i64::abs).max().unwrap_or(0);

        let mut best: Option<Contact> = None;
        for ring in self.first_ring(&within, column, row)..=last {
            let inner = (ring as f64 - 1.0 + to_rim) * self.cell;
            if best.is_some_and(|b| b.distance < inner) {
                break;
            }
            self.visit_ring(&within, column, row, ring, |surface| {
                let found = surface.nearest(from);
                if found.distance <= reach && best.is_none_or(|b| found.distance < b.distance) {
                    best = Some(found);
                }
            });
        }
        best
    }

    /// The smallest ring about a cell, which may lie outside the grid, that reaches into `within`.
    fn first_ring(&self, within: &Cells, column: i64, row: i64) -> i64 {
        let gap = |v: i64, (low, high): (i64, i64)| (low - v).max(v - high).max(0);
        gap(column, within.columns).max(gap(row, within.rows))
    }

    fn visit_ring(&self, within: &Cells, column: i64, row: i64, ring: i64, mut visit: impl FnMut(&Surface)) {
        for y in (row - ring).max(within.rows.0)..=(row + ring).min(within.rows.1) {
            let edge = (y - row).abs() == ring;
            let stride = if edge || ring == 0 { 1 } else { 2 * ring };
            let mut x = column - ring;
            if edge {
                x = x.max(within.columns.0);
            }
            while x <= (column + ring).min(within.columns.1) {
                if x >= within.columns.0 {
                    self.members(x, y).for_each(&mut visit);
                }
                x += stride;
            }
        }
    }

    /// True if the disc and a surface share more than a touch. A disc that lies wholly inside matter overlaps no surface.
    #[must_use]
    pub fn overlaps(&self, disc: Disc) -> bool {
        self.nearest(disc.center, disc.radius).is_some_and(|contact| contact.distance < disc.radius - SKIN)
    }

    /// The first touch of a disc that moves in a straight line by `by` (m); `None` if it gets there freely.
    ///
    /// A disc that touches or overlaps a surface at the start is stopped at once if it moves toward it, and may slide along
    /// it or leave it.
    #[must_use]
    pub fn sweep(&self, disc: Disc, by: Vector2<f64>) -> Option<Impact> {
        let ends = [disc.center, disc.center + by];
        if !ends.iter().all(|p| p.coords.iter().all(|v| v.is_finite())) {
            return None;
        }
        let cells = self.cells(&Bounds::around(ends)?.grown(disc.radius + SKIN));
        let mut first: Option<Impact> = None;
        for row in cells.rows.0..=cells.rows.1 {
            for column in cells.columns.0..=cells.columns.1 {
                for surface in self.members(column, row) {
                    if let Some(hit) = surface.sweep(disc, by)
                        && first.is_none_or(|f| hit.share < f.share)
                    {
                        first = Some(hit);
                    }
                }
            }
        }
        first
    }
}

impl Surface {
    fn bounds(&self) -> Bounds {
        match self {
            Self::Flat(s) => Bounds { min: s.a.inf(&s.b), max: s.a.sup(&s.b) },
            Self::Round(d) => Bounds { min: d.center, max: d.center }.grown(d.radius),
        }
    }

    /// True if part of the surface may lie in the square: exact for segments.
    fn enters(&self, square: &Bounds) -> bool {
        let Self::Flat(s) = self else { return true };
        let along = s.b - s.a;
        let side = |x: f64, y: f64| along.perp(&(Point2::new(x, y) - s.a));
        let (min, max) = (square.min, square.max);
        let sides = [side(min.x, min.y), side(max.x, min.y), side(max.x, max.y), side(min.x, max.y)];
        sides.iter().any(|v| *v >= 0.0) && sides.iter().any(|v| *v <= 0.0)
    }

    fn nearest(&self, from: Point2<f64>) -> Contact {
        match self {
            Self::Flat(s) => {
                let at = s.nearest(from);
                Contact { at, distance: (from - at).norm() }
            }
            Self::Round(d) => {
                let out = (from - d.center).try_normalize(0.0).unwrap_or_else(Vector2::x);
                Contact { at: d.center + out * d.radius, distance: d.distance(from).max(0.0) }
            }
        }
    }

    fn sweep(&self, body: Disc, by: Vector2<f64>) -> Option<Impact> {
        match self {
            Self::Flat(s) => sweep_segment(body, by, s),
            Self::Round(d) => sweep_disc(body, by, *d),
        }
    }
}

/// The first touch of a disc that moves by `by` with a disc that stands. For robots and people; the rules at the start are
/// those of [`Obstacles::sweep`].
///
/// ```
/// use nalgebra::{Point2, Vector2};
/// use orienteer_hardware::world::{geometry::Disc, obstacles::sweep_disc};
/// let robot = Disc::new(Point2::new(0.0, 0.0), 0.5);
/// let person = Disc::new(Point2::new(4.0, 0.0), 0.5);
/// let hit = sweep_disc(robot, Vector2::new(6.0, 0.0), person).unwrap();
/// assert_eq!(hit.share, 0.5);
/// assert!(sweep_disc(robot, Vector2::new(-6.0, 0.0), person).is_none());
/// ```
#[must_use]
pub fn sweep_disc(body: Disc, by: Vector2<f64>, standing: Disc) -> Option<Impact> {
    let from = body.center - standing.center;
    if from.norm() <= body.radius + standing.radius + SKIN {
        let normal = from.try_normalize(0.0).unwrap_or_else(Vector2::x);
        return pressing(by, normal).then(|| Impact { share: 0.0, at: standing.center + normal * standing.radius, normal });
    }
    let share = enter_circle(body.center, by, standing.center, body.radius + standing.radius)?;
    let normal = (body.center + by * share - standing.center).try_normalize(0.0)?;
    Some(Impact { share, at: standing.center + normal * standing.radius, normal })
}

/// True if a motion goes against a surface with this normal, by more than rounding can feign.
fn pressing(by: Vector2<f64>, normal: Vector2<f64>) -> bool {
    by.dot(&normal) < -SKIN * by.norm()
}

fn sweep_segment(body: Disc, by: Vector2<f64>, wall: &Segment) -> Option<Impact> {
    let at = wall.nearest(body.center);
    let from = body.center - at;
    if from.norm() <= body.radius + SKIN {
        let normal = from.try_normalize(0.0).unwrap_or_else(|| wall.normal());
        return pressing(by, normal).then_some(Impact { share: 0.0, at, normal });
    }
    let share = [
        enter_strip(body, by, wall),
        enter_circle(body.center, by, wall.a, body.radius),
        enter_circle(body.center, by, wall.b, body.radius),
    ];
    let share = share.into_iter().flatten().reduce(f64::min)?;
    let center = body.center + by * share;
    let at = wall.nearest(center);
    Some(Impact { share, at, normal: (center - at).try_normalize(0.0)? })
}

/// When the foot of the perpendicular lies on the segment and the distance has fallen to the radius.
fn enter_strip(body: Disc, by: Vector2<f64>, wall: &Segment) -> Option<f64> {
    let along = wall.b - wall.a;
    let length = along.norm();
    let along = along.try_normalize(0.0)?;
    let height = along.perp(&(body.center - wall.a));
    let speed = along.perp(&by) * height.signum();
    if speed >= 0.0 {
        return None;
    }
    let share = (body.radius - height.abs()) / speed;
    let foot = along.dot(&(body.center + by * share - wall.a));
    ((0.0..=1.0).contains(&share) && (0.0..=length).contains(&foot)).then_some(share)
}

/// When a point outside a circle first gets onto it: the smaller root of `|p + t·d − c|² = r²`.
fn enter_circle(from: Point2<f64>, by: Vector2<f64>, center: Point2<f64>, radius: f64) -> Option<f64> {
    let out = from - center;
    let (a, half_b, c) = (by.norm_squared(), out.dot(&by), out.norm_squared() - radius * radius);
    let discriminant = half_b * half_b - a * c;
    if half_b >= 0.0 || discriminant < 0.0 {
        return None;
    }
    // c / (−b/2 + √…) keeps its digits where −b/2 − √… would cancel.
    let share = c / (-half_b + discriminant.sqrt());
    (0.0..=1.0).contains(&share).then_some(share)
}

#[cfg(test)]
mod tests;
