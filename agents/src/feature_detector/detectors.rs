//! The four detectors: how a robot goes round a feature to be sure of it (Randazza 1989, §4.6, with the corrections that it takes to work).
//!
//! Each reads as the manoeuvre goes. It ends with [`Ended`] as soon as a wall is missing that should be there, or is there and should not
//! be, and when the robot can't go on. The wall is kept on the side that the request says. Points are recorded in the order in which
//! a robot meets them that keeps the feature on its right.

use std::f64::consts::{FRAC_PI_2, PI};

use orienteer_runtime::{
    geometry::Pose,
    topics::{FeatureKind, FeatureReason, FeatureSearch, Side},
};

use super::manoeuvre::{Ended, Followed, Manoeuvre};

/// Goes round the feature that is searched for.
pub(super) async fn detect(manoeuvre: &Manoeuvre, search: &FeatureSearch) -> Result<(), Ended> {
    match search.kind {
        FeatureKind::Wall => wall(manoeuvre, search).await,
        FeatureKind::Convex => convex(manoeuvre, search).await,
        FeatureKind::Concave => concave(manoeuvre, search).await,
        FeatureKind::Edge => edge(manoeuvre, search).await,
    }
}

/// True if the points come in the order of the sequence; with the wall kept on the right they come the other way round.
pub(super) fn in_order(search: &FeatureSearch) -> bool {
    search.kind == FeatureKind::Wall || search.side == Side::Left
}

fn whole(followed: Followed) -> Result<(), Ended> {
    if followed.wall_ended { Err(Ended::NotFound(FeatureReason::WallTooShort)) } else { Ok(()) }
}

fn ends(followed: Followed) -> Result<(), Ended> {
    if followed.wall_ended { Ok(()) } else { Err(Ended::NotFound(FeatureReason::WallTooLong)) }
}

/// Half a length to the one side, a whole length to the other, and back to the middle.
async fn wall(m: &Manoeuvre, search: &FeatureSearch) -> Result<(), Ended> {
    let half = 0.5 * m.config.wall_length;
    m.approach(search).await?;
    let ahead = m.ring().await?[0] + m.face();
    let middle = m.mark(Pose::new(ahead, 0.0, 0.0))?.pose();
    m.turn(-FRAC_PI_2).await?;
    m.align_beside(Side::Left).await?;
    whole(m.follow(Side::Left, half).await?)?;
    m.record_beside(Side::Left).await?;
    m.record_point(middle);
    m.turn(PI).await?;
    m.align_beside(Side::Right).await?;
    whole(m.follow(Side::Right, 2.0 * half).await?)?;
    m.record_beside(Side::Right).await?;
    m.turn(PI).await?;
    m.align_beside(Side::Left).await?;
    m.go(half).await?;
    Ok(())
}

/// Past the corner, round it, along the second leg; back, and along the first.
async fn convex(m: &Manoeuvre, search: &FeatureSearch) -> Result<(), Ended> {
    let (side, other) = (search.side, search.side.other());
    // The way to the wall's side; the other way is its negative.
    let toward = side.sign() * FRAC_PI_2;
    let (clearance, overshoot, ring) = (m.config.clearance, m.config.wall_overshoot, 2.0 * m.face());
    let half = 0.5 * m.config.wall_length;
    m.approach(search).await?;
    m.turn(-toward).await?;
    m.align_beside(side).await?;
    ends(m.follow(side, half + ring + overshoot + search.error).await?)?;
    m.go(clearance - overshoot + BERTH).await?;
    let corner = m.mark(Pose::new(0.0, 0.0, -toward))?;
    m.turn(toward).await?;
    m.go(clearance + ring).await?;
    m.align_beside(side).await?;
    whole(m.follow(side, half).await?)?;
    m.record_beside(side).await?;
    m.turn(-2.0 * toward).await?;
    m.align_beside(other).await?;
    let beside = m.beside(other).await?;
    m.go(half).await?;
    m.record(m.face(), beside)?;
    m.go_to(corner, orienteer_runtime::agent::Strategy::Straight).await?;
    m.turn(-toward).await?;
    m.go(clearance + ring).await?;
    m.align_beside(other).await?;
    whole(m.follow(other, half).await?)?;
    m.record_beside(other).await?;
    m.turn(2.0 * toward).await?;
    Ok(())
}

/// Into the corner, along the second wall and back, along the first wall and back.
async fn concave(m: &Manoeuvre, search: &FeatureSearch) -> Result<(), Ended> {
    let (side, other) = (search.side, search.side.other());
    let toward = side.sign() * FRAC_PI_2;
    let leg = m.config.wall_length - m.config.clearance;
    m.approach(search).await?;
    m.turn(-toward).await?;
    m.follow_to_corner(side, leg + search.error, m.config.clearance).await?;
    m.turn(-toward).await?;
    m.align_beside(side).await?;
    whole(m.follow(side, leg).await?)?;
    m.record_beside(side).await?;
    m.turn(-2.0 * toward).await?;
    m.align_beside(other).await?;
    m.go(leg).await?;
    let ring = m.ring().await?;
    let beside = other.sign() * (ring[super::wall_tests::abeam(other)] + m.face());
    m.record(ring[0] + m.face(), beside)?;
    m.turn(toward).await?;
    m.align_beside(other).await?;
    whole(m.follow(other, leg).await?)?;
    m.record_beside(other).await?;
    m.turn(2.0 * toward).await?;
    m.align_beside(side).await?;
    m.go(leg).await?;
    m.turn(-toward).await?;
    Ok(())
}

/// Through the doorway along the wall's end, along its far side; back, and along the near side.
async fn edge(m: &Manoeuvre, search: &FeatureSearch) -> Result<(), Ended> {
    let (side, other) = (search.side, search.side.other());
    let toward = side.sign() * FRAC_PI_2;
    let config = m.config.clone();
    let (half, ring) = (0.5 * config.wall_length, 2.0 * m.face());
    let (face, beyond) = (config.clearance + m.face(), config.clearance + config.wall_overshoot);
    m.approach(search).await?;
    m.turn(-toward).await?;
    m.align_beside(side).await?;
    ends(m.follow(side, half + ring + config.wall_overshoot + search.error).await?)?;
    m.go(config.clearance - config.wall_overshoot).await?;
    m.turn(toward).await?;
    // A corner would have a wall here, beyond the thickness of the first one.
    let past = face + config.wall_thickness + PAST_THE_POST;
    m.creep(past).await?;
    if m.is_wall_beside(side).await? {
        return Err(Ended::NotFound(FeatureReason::WallBeside));
    }
    m.creep(face - BEFORE_THE_POST - past).await?;
    m.between_doorposts(side).await?;
    m.creep(beyond).await?;
    let through = m.mark(Pose::new(0.0, 0.0, -toward))?;
    m.turn(toward).await?;
    m.go(config.doorpost_distance + ring).await?;
    m.align_beside(side).await?;
    whole(m.follow(side, half).await?)?;
    m.record_beside(side).await?;
    m.turn(-2.0 * toward).await?;
    m.align_beside(other).await?;
    m.go_to(through, orienteer_runtime::agent::Strategy::Straight).await?;
    m.turn(-toward).await?;
    m.creep(config.clearance).await?;
    m.between_doorposts(other).await?;
    m.record(0.0, other.sign() * config.doorpost_distance)?;
    m.creep(beyond).await?;
    m.turn(-toward).await?;
    m.go(config.doorpost_distance + ring).await?;
    m.align_beside(other).await?;
    whole(m.follow(other, half).await?)?;
    m.record_beside(other).await?;
    m.turn(2.0 * toward).await?;
    Ok(())
}

/// By so much a corner is given a wider berth than the walls, m: the robot goes round it by dead reckoning, and its sonars hear it
/// nearer than it is.
const BERTH: f64 = 0.05;
/// Where to look for a wall behind a doorpost: so far past it, m. Nearer, the beams still hear the post.
const PAST_THE_POST: f64 = 0.18;
/// Where to begin to measure a post: so far before it, m.
const BEFORE_THE_POST: f64 = 0.14;
