//! The pieces that the elements of a plan are made of: polygons that overlap or touch.

use std::f64::consts::FRAC_PI_3;

use nalgebra::{Point2, Rotation2, Vector2};

use super::{
    WorldError,
    error::Element,
    plan::{Block, Door, Xy},
    region::Ring,
};

/// Doors reach this much beyond the surface they cut through, m; enough to survive rounding, too little to leave a mark.
const OVERLAP: f64 = 1e-5;
/// A door written this far off its wall still belongs to it, m.
const OFF_WALL: f64 = 0.5;
/// Sides and legs shorter than this are refused, m.
pub(super) const SHORTEST: f64 = 1e-3;
/// Free space behind a room's door must begin within this distance, m.
pub(super) const THICKEST: f64 = 1.5;

fn left(v: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-v.y, v.x)
}

/// A line drawn with a broad pen: a rectangle along each leg and a mitred (beyond 120°, bevelled) piece on the outside of
/// each bend.
pub(super) fn stroke(along: &[Xy], closed: bool, width: f64) -> Vec<Ring> {
    let half = 0.5 * width;
    let legs = legs(along, closed);
    let mut pieces: Vec<Ring> = legs.iter().map(|&(a, b)| leg_rectangle(a, b, half)).collect();
    let bends = if closed { legs.len() } else { legs.len() - 1 };
    for i in 0..bends {
        let (before, after) = (legs[i], legs[(i + 1) % legs.len()]);
        let (d1, d2) = ((before.1 - before.0).normalize(), (after.1 - after.0).normalize());
        let turn = d1.perp(&d2).atan2(d1.dot(&d2));
        // The outside of a left turn is on the right.
        let side = if turn > 0.0 { -half } else { half };
        let (n1, n2) = (left(d1) * side, left(d2) * side);
        let at = after.0;
        let mut piece = vec![at, at + n1];
        if turn.abs() <= 2.0 * FRAC_PI_3 {
            piece.push(at + (n1 + n2) / (1.0 + d1.dot(&d2)));
        }
        piece.push(at + n2);
        pieces.push(piece);
    }
    pieces
}

fn legs(along: &[Xy], closed: bool) -> Vec<(Point2<f64>, Point2<f64>)> {
    let points: Vec<Point2<f64>> = along.iter().map(|xy| xy.point()).collect();
    let mut legs: Vec<_> = points.windows(2).map(|w| (w[0], w[1])).collect();
    if let (true, Some(last), Some(first)) = (closed && points.len() > 2, points.last(), points.first())
        && (first - last).norm() > SHORTEST
    {
        legs.push((*last, *first));
    }
    legs
}

fn leg_rectangle(a: Point2<f64>, b: Point2<f64>, half: f64) -> Ring {
    let n = left((b - a).normalize()) * half;
    vec![a - n, b - n, b + n, a + n]
}

/// The ring that `corners` describe, counter-clockwise: two opposite corners of a rectangle, or a simple polygon.
pub(super) fn closed_outline(on: &Element, corners: &[Xy]) -> Result<Ring, WorldError> {
    let mut ring: Ring = match corners {
        [] | [_] => return Err(on.refuse("corners needs two opposite corners of a rectangle, or all corners of a polygon")),
        [Xy([x0, y0]), Xy([x1, y1])] => [(*x0, *y0), (*x1, *y0), (*x1, *y1), (*x0, *y1)].map(|(x, y)| Point2::new(x, y)).to_vec(),
        all => all.iter().map(|xy| xy.point()).collect(),
    };
    if ring.len() > 3 && ring.first() == ring.last() {
        ring.pop();
    }
    let sides: Vec<_> = ring.iter().copied().zip(ring.iter().copied().cycle().skip(1)).collect();
    if let Some(i) = sides.iter().position(|(a, b)| (b - a).norm() < SHORTEST) {
        return Err(on.refuse(format!("side {} of its outline has no length", i + 1)));
    }
    for (i, &(a, b)) in sides.iter().enumerate() {
        for (j, &(c, d)) in sides.iter().enumerate().skip(i + 2).filter(|(j, _)| (j + 1) % sides.len() != i) {
            if cross(a, b, c, d) {
                return Err(on.refuse(format!("sides {} and {} of its outline cross", i + 1, j + 1)));
            }
        }
    }
    let doubled: f64 = sides.iter().map(|(a, b)| a.coords.perp(&b.coords)).sum();
    if doubled.abs() < 1e-6 {
        return Err(on.refuse("its outline encloses no area"));
    }
    if doubled < 0.0 {
        ring.reverse();
    }
    Ok(ring)
}

fn cross(a: Point2<f64>, b: Point2<f64>, c: Point2<f64>, d: Point2<f64>) -> bool {
    let side = |p: Point2<f64>, q: Point2<f64>, r: Point2<f64>| (q - p).perp(&(r - p));
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

/// A rectangle at an angle.
pub(super) fn block(of: &Block) -> Ring {
    let turn = quarter_exact(of.rotation_deg);
    let [w, h] = of.size.map(|v| 0.5 * v);
    [(-w, -h), (w, -h), (w, h), (-w, h)].map(|(x, y)| of.center.point() + turn * Vector2::new(x, y)).to_vec()
}

/// A rotation by degrees that is exact for quarter turns.
fn quarter_exact(degrees: f64) -> Rotation2<f64> {
    let quarters = (degrees / 90.0).round();
    let rest = Rotation2::new((degrees - 90.0 * quarters).to_radians());
    let quarter = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][quarters.rem_euclid(4.0) as usize % 4];
    let basis = nalgebra::Matrix2::new(quarter.0, -quarter.1, quarter.1, quarter.0);
    Rotation2::from_matrix_unchecked(basis) * rest
}

/// The opening of a door through a wall drawn by [`stroke`].
pub(super) fn door_through_wall(
    on: &Element,
    along: &[Xy],
    closed: bool,
    thickness: f64,
    door: &Door,
) -> Result<Ring, WorldError> {
    let (a, b, middle) = place_door(on, &legs(along, closed), door)?;
    let d = (b - a).normalize() * (0.5 * door.width);
    Ok(leg_rectangle(middle - d, middle + d, 0.5 * thickness + OVERLAP))
}

/// The opening of a door from the room `ring` (counter-clockwise) to the nearest of the other free pieces behind its wall.
pub(super) fn door_of_room(on: &Element, ring: &Ring, door: &Door, others: &[&Ring]) -> Result<Ring, WorldError> {
    let sides: Vec<_> = ring.iter().copied().zip(ring.iter().copied().cycle().skip(1)).collect();
    let (a, b, middle) = place_door(on, &sides, door)?;
    let along = (b - a).normalize();
    let outward = -left(along);
    let d = along * (0.5 * door.width);
    let inset = along * OVERLAP;
    let mut depth: f64 = 0.0;
    for from in [middle - d + inset, middle, middle + d - inset] {
        let reached = first_free(from, outward, others).ok_or_else(|| {
            on.refuse(format!("{} leads nowhere: there is no free space within {THICKEST} m behind the wall", describe(door)))
        })?;
        depth = depth.max(reached);
    }
    let (inner, outer) = (-outward * OVERLAP, outward * (depth + OVERLAP));
    Ok(vec![middle - d + inner, middle - d + outer, middle + d + outer, middle + d + inner])
}

/// How far from `from` along the unit vector `direction` the first of the pieces begins.
fn first_free(from: Point2<f64>, direction: Vector2<f64>, pieces: &[&Ring]) -> Option<f64> {
    let mut marks = vec![0.0];
    for piece in pieces {
        for (a, b) in piece.iter().zip(piece.iter().cycle().skip(1)) {
            let side = b - a;
            let across = direction.perp(&side);
            let (t, s) = ((a - from).perp(&side) / across, (a - from).perp(&direction) / across);
            if across != 0.0 && (-1e-9..=THICKEST).contains(&t) && (-1e-9..=1.0 + 1e-9).contains(&s) {
                marks.push(t.max(0.0));
            }
        }
    }
    marks.sort_by(f64::total_cmp);
    marks.into_iter().find(|t| pieces.iter().any(|piece| inside(piece, from + direction * (t + OVERLAP))))
}

/// True if the point is inside the simple ring.
pub(super) fn inside(ring: &Ring, p: Point2<f64>) -> bool {
    let sides = ring.iter().zip(ring.iter().cycle().skip(1));
    sides.filter(|(a, b)| (a.y <= p.y) != (b.y <= p.y) && a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) > p.x).count() % 2 == 1
}

fn describe(door: &Door) -> String {
    format!("the door at [{}, {}]", door.at.0[0], door.at.0[1])
}

/// The side nearest to the door, and the point on it where its middle is.
type DoorPlace = (Point2<f64>, Point2<f64>, Point2<f64>);

fn place_door(on: &Element, sides: &[(Point2<f64>, Point2<f64>)], door: &Door) -> Result<DoorPlace, WorldError> {
    let at = door.at.point();
    let foot = |&(a, b): &(Point2<f64>, Point2<f64>)| {
        let along = b - a;
        a + along * ((at - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0)
    };
    let nearest = sides.iter().min_by(|p, q| (foot(p) - at).norm().total_cmp(&(foot(q) - at).norm()));
    let Some(side @ &(a, b)) = nearest else { return Err(on.refuse("has no side to put a door into")) };
    let middle = foot(side);
    let off = (middle - at).norm();
    if off > OFF_WALL {
        return Err(on.refuse(format!("{} is {off:.2} m away from its nearest wall", describe(door))));
    }
    let room = (middle - a).norm().min((middle - b).norm());
    if 0.5 * door.width > room + 1e-6 {
        let over = 0.5 * door.width - room;
        return Err(on.refuse(format!("{} is {} m wide and sticks out {over:.2} m past a corner", describe(door), door.width)));
    }
    Ok((a, b, middle))
}
