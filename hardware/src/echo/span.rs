//! A wall or a disc as one beam sees it, and what hides what.

use super::{
    beam::Beam,
    grid::{Disc, Line},
};

/// A wall or a disc as one beam sees it.
///
/// Coordinates are those of the beam: `x` along its axis, `y` to the left. A direction is given by its slope `t = y / x`, the
/// tangent of its bearing, which is monotone over the beam and costs no trigonometry.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    /// The slopes between which the surface lies in the beam.
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) reflectance: f64,
    /// Item number in the grid, or number of the body plus the number of items.
    pub(super) number: u32,
    pub(super) shape: Shape,
}

#[derive(Debug, Clone, Copy)]
pub(super) enum Shape {
    /// The points with `a x + b y = d`, where `(a, b)` is the unit normal that points away from the transducer, `d ≥ 0`.
    Line { a: f64, b: f64, d: f64 },
    /// A circle.
    Circle { x: f64, y: f64, radius: f64 },
}

impl Span {
    /// False only if no part of a wall lies in the beam. Free of branches.
    pub(super) fn may_meet(line: &Line, beam: &Beam) -> bool {
        let tan = beam.tan_half;
        let (x1, y1) = beam.local(line.ax, line.ay);
        let (x2, y2) = beam.local(line.bx, line.by);
        // Not behind, and not wholly on the far side of one edge of the beam
        ((x1 > 0.0) | (x2 > 0.0)) & ((y1 <= tan * x1) | (y2 <= tan * x2)) & ((y1 >= -tan * x1) | (y2 >= -tan * x2))
    }

    /// The part of a wall that lies in the beam, if it [may](Self::may_meet); `None` if there is none.
    pub(super) fn of_line(line: &Line, beam: &Beam, number: u32) -> Option<Self> {
        let tan = beam.tan_half;
        let (x1, y1) = beam.local(line.ax, line.ay);
        let (x2, y2) = beam.local(line.bx, line.by);
        let (mut t1, mut t2) = (y1 / x1, y2 / x2);
        if x1 <= 0.0 {
            t1 = if y1 * x2 > y2 * x1 { f64::INFINITY } else { f64::NEG_INFINITY };
        } else if x2 <= 0.0 {
            t2 = if y2 * x1 > y1 * x2 { f64::INFINITY } else { f64::NEG_INFINITY };
        }
        let (low, high) = (t1.min(t2).max(-tan), t1.max(t2).min(tan));
        // False for NaN, too
        let is_seen = low <= high;
        if !is_seen {
            return None;
        }
        let (mut a, mut b) = beam.turned(line.nx, line.ny);
        let mut d = a * x1 + b * y1;
        if d < 0.0 {
            (a, b, d) = (-a, -b, -d);
        }
        Some(Self { low, high, reflectance: line.reflectance, number, shape: Shape::Line { a, b, d } })
    }

    /// The part of a disc that lies in the beam; `None` if there is none. `Err` if the transducer is inside the disc.
    pub(super) fn of_disc(disc: &Disc, beam: &Beam, number: u32) -> Result<Option<Self>, Inside> {
        let (x, y) = beam.local(disc.centre.x, disc.centre.y);
        let radius = disc.radius;
        let tan = beam.tan_half;
        let square = x * x + y * y;
        if !(radius > 0.0 && square <= (beam.max_range + radius).powi(2)) {
            return Ok(None);
        }
        let tangent = square - radius * radius;
        if tangent <= 0.0 {
            return Err(Inside);
        }
        let margin = radius * beam.sec_half;
        if y - tan * x > margin || -y - tan * x > margin {
            return Ok(None);
        }
        // Directions of the two tangents: the middle's turned by ∓asin(radius / distance)
        let m = tangent.sqrt();
        let (right, left) = ((x * m + y * radius, y * m - x * radius), (x * m - y * radius, y * m + x * radius));
        if (right.0 <= 0.0 && x <= 0.0 && y > 0.0) || (left.0 <= 0.0 && x <= 0.0 && y <= 0.0) {
            return Ok(None);
        }
        let low = if right.0 > 0.0 { right.1 / right.0 } else { f64::NEG_INFINITY }.max(-tan);
        let high = if left.0 > 0.0 { left.1 / left.0 } else { f64::INFINITY }.min(tan);
        let span = Self { low, high, reflectance: disc.reflectance, number, shape: Shape::Circle { x, y, radius } };
        Ok((low <= high).then_some(span))
    }

    /// Slope, range and cosine of the angle of incidence at the point between two slopes that is nearest and met nearest to
    /// its normal. Both range and angle grow from there to both sides.
    pub(super) fn nearest(&self, low: f64, high: f64) -> (f64, f64, f64) {
        let (x, y) = match self.shape {
            Shape::Line { a, b, .. } => (a, b),
            Shape::Circle { x, y, .. } => (x, y),
        };
        let normal = if x > 0.0 { y / x } else { f64::INFINITY.copysign(y) };
        if let Shape::Line { d, .. } = self.shape
            && low <= normal
            && normal <= high
        {
            return (normal, d, 1.0);
        }
        let slope = normal.max(low).min(high);
        let (range, cos_incidence) = self.at(slope);
        (slope, range, cos_incidence)
    }

    /// The square of the greatest range within the span. It is met at one of the ends.
    pub(super) fn depth_squared(&self) -> f64 {
        let at = |t: f64| match self.shape {
            Shape::Line { a, b, d } => {
                let along = d / (a + b * t);
                along * along * (1.0 + t * t)
            }
            Shape::Circle { .. } => self.at(t).0.powi(2),
        };
        at(self.low).max(at(self.high))
    }

    /// Range at slope `t` and cosine of the angle of incidence.
    pub(super) fn at(&self, t: f64) -> (f64, f64) {
        let sec = (1.0 + t * t).sqrt();
        match self.shape {
            Shape::Line { a, b, d } => {
                let cos = (a + b * t) / sec;
                (d / cos, cos)
            }
            Shape::Circle { x, y, radius } => {
                let (along, aside) = ((x + y * t) / sec, (y - x * t) / sec);
                let depth = (radius * radius - aside * aside).max(0.0).sqrt();
                (along - depth, depth / radius)
            }
        }
    }

    /// True if the surface is nearer than `range` in the direction of slope `t`, whose secant is `sec`.
    pub(super) fn hides(&self, t: f64, sec: f64, range: f64) -> bool {
        match self.shape {
            Shape::Line { a, b, d } => d * sec < range * (a + b * t),
            Shape::Circle { .. } => self.at(t).0 < range,
        }
    }

    /// Unit normal on the transducer's side where the axis meets the surface, at `range`; in the beam's frame.
    pub(super) fn normal_ahead(&self, range: f64) -> (f64, f64) {
        match self.shape {
            Shape::Line { a, b, .. } => (-a, -b),
            Shape::Circle { x, y, radius } => ((range - x) / radius, -y / radius),
        }
    }

    /// Calls `visit` with the slopes at which this surface may pass from before to behind `other`: where they cross.
    pub(super) fn crossings(&self, other: &Span, mut visit: impl FnMut(f64)) {
        let mut point = |x: f64, y: f64| {
            if x > 0.0 {
                visit(y / x);
            }
        };
        match (self.shape, other.shape) {
            (Shape::Line { a, b, d }, Shape::Line { a: a2, b: b2, d: d2 }) => {
                // d (a2 + b2 t) = d2 (a + b t)
                let t = (d2 * a - d * a2) / (d * b2 - d2 * b);
                point(1.0, t);
            }
            (Shape::Line { a, b, d }, Shape::Circle { x, y, radius })
            | (Shape::Circle { x, y, radius }, Shape::Line { a, b, d }) => {
                let offset = d - a * x - b * y;
                let half = (radius * radius - offset * offset).sqrt();
                point(x + a * offset - b * half, y + b * offset + a * half);
                point(x + a * offset + b * half, y + b * offset - a * half);
            }
            (Shape::Circle { x, y, radius }, Shape::Circle { x: x2, y: y2, radius: radius2 }) => {
                let (dx, dy) = (x2 - x, y2 - y);
                let distance = dx.hypot(dy);
                let (a, b) = (dx / distance, dy / distance);
                let offset = (distance * distance + radius * radius - radius2 * radius2) / (2.0 * distance);
                let half = (radius * radius - offset * offset).sqrt();
                point(x + a * offset - b * half, y + b * offset + a * half);
                point(x + a * offset + b * half, y + b * offset - a * half);
            }
        }
    }
}

/// The transducer is inside a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Inside;
