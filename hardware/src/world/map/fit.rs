//! Straight sides for a staircase of cell edges.

use nalgebra::{Point2, Vector2};

use super::{super::region::Ring, trace::Corner};

/// Corners of fitted sides may lie this much further from the border than the sides themselves, cells.
const CORNER_SLACK: f64 = 0.75;
/// Sides that meet at a smaller angle than this have no reliable crossing, as the sine.
const NEARLY_PARALLEL: f64 = 0.1;

/// Borders of no more unit edges than this (a block of 2 × 2 cells) are kept as they are: nothing in them is a line.
const TINY: usize = 8;
/// How many sides may be merged into one at a time.
const LOOK_AHEAD: usize = 24;
/// Sides of fewer unit edges are judged by their chord alone.
const LONG: usize = 8;

/// A line through `at` along the unit vector `along`.
#[derive(Debug, Clone, Copy)]
struct Line {
    at: Point2<f64>,
    along: Vector2<f64>,
}

/// The ring of straight sides that follows a border within `tolerance` cells; see [`Grid::rings`](super::Grid::rings).
pub(super) fn straighten(border: &[Corner], tolerance: f64) -> Ring {
    let tolerance = if border.len() <= TINY { 0.0 } else { tolerance };
    let breaks = merge(border, break_points(border, tolerance), tolerance);
    let n = breaks.len();
    let lines: Vec<Line> = (0..n).map(|i| fit(border, breaks[i], breaks[(i + 1) % n])).collect();
    let mut ring = Vec::with_capacity(n);
    for i in 0..n {
        let corner = to_point(border[breaks[i]]);
        join(lines[(i + n - 1) % n], lines[i], corner, tolerance + CORNER_SLACK, &mut ring);
    }
    ring
}

fn to_point(corner: Corner) -> Point2<f64> {
    Point2::from(corner.cast::<f64>())
}

/// Indices at which the border is cut into sides, in order (Douglas and Peucker 1973). The first two cuts are the lowest of
/// the leftmost corners and the corner farthest from it; both are corners of the convex hull.
fn break_points(border: &[Corner], tolerance: f64) -> Vec<usize> {
    let n = border.len();
    let first = (0..n).min_by_key(|i| (border[*i].x, border[*i].y)).unwrap_or(0);
    let squared = |i: &usize| {
        let d = (border[*i] - border[first]).map(i64::from);
        d.x * d.x + d.y * d.y
    };
    let second = (0..n).max_by_key(squared).unwrap_or(0);
    let mut cut = vec![false; n];
    cut[first] = true;
    cut[second] = true;
    let mut open = vec![(first, second), (second, first)];
    while let Some((from, to)) = open.pop() {
        if is_straight(border, from, to, tolerance) {
            continue;
        }
        let (a, b) = (to_point(border[from]), to_point(border[to]));
        let off = |i: usize| distance_to_segment(to_point(border[i % n]), a, b);
        let inner = from + 1..from + steps(n, from, to);
        if let Some((i, _)) = inner.map(|i| (i, off(i))).reduce(|x, y| if y.1 > x.1 { y } else { x }) {
            cut[i % n] = true;
            open.extend([(from, i % n), (i % n, to)]);
        }
    }
    (0..n).filter(|i| cut[*i]).collect()
}

/// Takes out cuts between sides that are straight as one: recursion cuts at the worst place, not at the best, and can leave a
/// ragged wall in many short pieces of which no two, but all together are straight. From each cut the longest straight side
/// wins that ends at one of the next [`LOOK_AHEAD`] cuts.
fn merge(border: &[Corner], mut breaks: Vec<usize>, tolerance: f64) -> Vec<usize> {
    let mut i = 0;
    let mut kept = 0;
    while breaks.len() > 2 && kept < breaks.len() {
        let n = breaks.len();
        i %= n;
        let straight = |ahead: &usize| is_straight(border, breaks[i], breaks[(i + ahead) % n], tolerance);
        // At least two sides must remain, and the far end of the new one is not to be taken out.
        match (2..=LOOK_AHEAD.min(n - 1)).rev().find(straight) {
            Some(ahead) => {
                let start = breaks[i];
                let inner: Vec<usize> = (1..ahead).map(|k| breaks[(i + k) % n]).collect();
                breaks.retain(|cut| !inner.contains(cut));
                i = breaks.iter().position(|cut| *cut == start).unwrap_or(0);
                kept = 0;
            }
            None => {
                kept += 1;
                i += 1;
            }
        }
    }
    breaks
}

/// How many unit steps lead from corner `from` to corner `to` of a border of `n`.
fn steps(n: usize, from: usize, to: usize) -> usize {
    if to > from { to - from } else { to + n - from }
}

/// True if a straight side can stand for the border between two corners: if no corner on the way is more than `tolerance`
/// from the chord or, for sides long enough to tell a line from a bend, from the line that fits best. The corners of a
/// digitised straight line lie within `(sin φ + cos φ) / 2 ≤ 0.71` cells of it, but up to twice that from a chord.
fn is_straight(border: &[Corner], from: usize, to: usize, tolerance: f64) -> bool {
    let n = border.len();
    let edges = steps(n, from, to);
    let (a, b) = (to_point(border[from]), to_point(border[to]));
    let corners = || (from..=from + edges).map(|i| to_point(border[i % n]));
    if corners().all(|p| distance_to_segment(p, a, b) <= tolerance) {
        return true;
    }
    if edges < LONG {
        return false;
    }
    let line = fit(border, from, to);
    corners().all(|p| line.along.perp(&(p - line.at)).abs() <= tolerance)
}

fn distance_to_segment(p: Point2<f64>, a: Point2<f64>, b: Point2<f64>) -> f64 {
    let along = b - a;
    let squared = along.norm_squared();
    let t = if squared > 0.0 { ((p - a).dot(&along) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (p - (a + along * t)).norm()
}

/// The total-least-squares line through the middles of the unit edges from corner `from` to corner `to`: through their
/// centroid, along the eigenvector of the larger eigenvalue of the scatter matrix, `tan 2φ = 2 Sxy / (Sxx - Syy)`.
fn fit(border: &[Corner], from: usize, to: usize) -> Line {
    let n = border.len();
    let edges = steps(n, from, to);
    let middles = || (from..from + edges).map(|i| nalgebra::center(&to_point(border[i % n]), &to_point(border[(i + 1) % n])));
    let chord = to_point(border[to]) - to_point(border[from]);
    let at = Point2::from(middles().map(|p| p.coords).sum::<Vector2<f64>>() / edges as f64);
    let along = chord.normalize();
    if edges < 3 {
        return Line { at: to_point(border[from]), along };
    }
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for d in middles().map(|p| p - at) {
        xx += d.x * d.x;
        xy += d.x * d.y;
        yy += d.y * d.y;
    }
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    // Exactly along an axis where all middles are: sin(π/2) is 1, but cos(π/2) is not 0.
    let fitted = if xy == 0.0 { along.map(f64::round) } else { Vector2::new(angle.cos(), angle.sin()) };
    let fitted = if fitted.dot(&along) < 0.0 { -fitted } else { fitted };
    // A short side that turns far away from its chord was no line.
    Line { at, along: if fitted.dot(&along) > 0.8 { fitted } else { along } }
}

/// Adds the corner between two neighbouring sides: the crossing of their lines if that is near the border's own corner. Sides
/// that run on in nearly one direction meet half-way between the feet of that corner on both; where a side runs back beside
/// the other, at the end of a thin wall, both feet are corners.
fn join(before: Line, after: Line, corner: Point2<f64>, reach: f64, ring: &mut Ring) {
    let sine = before.along.perp(&after.along);
    if sine.abs() > NEARLY_PARALLEL {
        let t = (after.at - before.at).perp(&after.along) / sine;
        let crossing = before.at + before.along * t;
        if (crossing - corner).norm() <= reach {
            ring.push(crossing);
            return;
        }
    }
    let foot = |line: Line| line.at + line.along * line.along.dot(&(corner - line.at));
    if before.along.dot(&after.along) < 0.0 {
        ring.extend([foot(before), foot(after)]);
    } else {
        ring.push(nalgebra::center(&foot(before), &foot(after)));
    }
}
