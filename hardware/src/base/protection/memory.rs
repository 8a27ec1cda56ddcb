//! What has slipped out of sight.
//!
//! The beams of a ring leave gaps: the sonars of Huey's stand 8 cm from its centre with beams of ±12° every 22.5°, so that within
//! a metre a door post or a table leg may stand where no beam looks. It was seen before it got there. What a beam has met near the
//! body, and looks at no longer because the base has moved on, is therefore remembered where it was, until
//!
//! * a beam looks there again, whether it meets the thing or looks through its place (but not if it meets something nearer);
//! * it is farther away than a metre and a half;
//! * twelve seconds are over: people do not stay where they were.
//!
//! An echo may come from anywhere on an arc across its beam. Most of the arc stays within the beam as it moves on; only what
//! leaves it is remembered. A reading that the one before does not confirm may be spurious, and is not remembered unless the ring is
//! so slow, or the base so fast, that there could be no second one.

use nalgebra::Point2;
use orienteer_runtime::time::Time;

use super::sight::Face;

/// Places farther from the centre of the base than this are not worth remembering, m: there beams leave no gaps.
pub const NEAR: f64 = 1.5;
/// For how long a place is remembered, s. People do not stay where they were: with 30 s, 2 % of those who had stepped aside for
/// somebody did not resume their way. A behaviour that is held by what it does not see had better turn before this is over, as
/// patrol does; the corridor follower, which has people to wait for, does not.
const LASTING: f64 = 12.0;
/// Two distances of one thing differ by no more than this, m.
const SAME: f64 = 0.05;
/// Places closer together than this are one, m: half a degree at arm's length.
const APART: f64 = 0.005;
/// How many places are remembered; the oldest goes first.
const MOST: usize = 128;

/// Places that were met and are not looked at any more.
#[derive(Debug, Clone)]
pub(super) struct Memory {
    spots: Vec<Spot>,
}

/// A place in the odometry frame.
#[derive(Debug, Clone, Copy)]
struct Spot {
    at: Point2<f64>,
    seen: Time,
}

/// The sector in which a transducer looks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sector {
    pub face: Face,
    /// Tangent of the angle to each side.
    pub slope: f64,
}

impl Sector {
    /// True if a place lies within the sector.
    pub fn covers(&self, at: Point2<f64>) -> bool {
        let (ahead, beside) = self.local(at);
        // Without branches: most places lie outside, and there are many of them.
        (ahead > 0.0) & (beside.abs() <= self.slope * ahead)
    }

    /// Distance of a place from the face, if it lies within the sector.
    pub fn distance(&self, at: Point2<f64>) -> Option<f64> {
        let (ahead, beside) = self.local(at);
        self.covers(at).then(|| ahead.hypot(beside))
    }

    fn local(&self, at: Point2<f64>) -> (f64, f64) {
        let offset = at - self.face.at;
        (self.face.axis.dot(&offset), self.face.axis.perp(&offset))
    }
}

impl Memory {
    pub fn new() -> Self {
        Self { spots: Vec::with_capacity(MOST) }
    }

    /// This beam has met something at `range` from its face, and nothing before that: what is nearer is not there, and what is
    /// there needs no memory. True if something that was remembered has been met again.
    pub fn look_again(&mut self, beam: &Sector, range: f64) -> bool {
        if !self.spots.iter().fold(false, |any, spot| any | beam.covers(spot.at)) {
            return false;
        }
        let mut met = false;
        self.spots.retain(|spot| {
            let Some(beyond) = beam.distance(spot.at).map(|distance| distance - range) else { return true };
            met |= beyond.abs() <= SAME;
            beyond > SAME
        });
        met
    }

    /// Something was met here.
    pub fn remember(&mut self, at: Point2<f64>, seen: Time) {
        if let Some(spot) = self.spots.iter_mut().find(|spot| (spot.at - at).norm_squared() < APART * APART) {
            spot.seen = seen;
            return;
        }
        if self.spots.len() == MOST {
            let oldest = (0..MOST).min_by_key(|i| self.spots[*i].seen).unwrap_or(0);
            self.spots.swap_remove(oldest);
        }
        self.spots.push(Spot { at, seen });
    }

    /// Forgets what is old or far from the base.
    pub fn forget(&mut self, now: Time, centre: Point2<f64>) {
        self.spots.retain(|spot| now.secs_since(spot.seen) <= LASTING && (spot.at - centre).norm_squared() <= NEAR * NEAR);
    }

    /// All places, odometry frame.
    pub fn places(&self) -> impl Iterator<Item = Point2<f64>> + '_ {
        self.spots.iter().map(|spot| spot.at)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn at(seconds: u64) -> Time {
        Time::START + Duration::from_secs(seconds)
    }

    fn sector(heading: f64) -> Sector {
        let axis = nalgebra::Vector2::new(heading.cos(), heading.sin());
        Sector { face: Face { at: Point2::new(0.1, 0.0), axis }, slope: 0.3f64.tan() }
    }

    #[test]
    fn a_place_is_forgotten_when_it_is_looked_at_or_old_or_far() {
        let mut memory = Memory::new();
        let place = Point2::new(0.5, 0.1);
        let ahead = sector(0.0);
        let count = |memory: &Memory| memory.places().count();
        memory.remember(place, at(1));
        assert!(!memory.look_again(&sector(0.6), 2.0));
        assert!(!memory.look_again(&ahead, 0.3));
        assert_eq!(count(&memory), 1, "one beam looks elsewhere, the other meets something before the place");
        assert!(memory.look_again(&ahead, 0.4) && count(&memory) == 0);
        memory.remember(place, at(1));
        assert!(!memory.look_again(&ahead, 2.0) && count(&memory) == 0);
        memory.remember(place, at(1));
        memory.forget(at(13), Point2::origin());
        assert_eq!(count(&memory), 1);
        memory.forget(at(14), Point2::origin());
        assert_eq!(count(&memory), 0);
        memory.remember(place, at(14));
        memory.forget(at(14), Point2::new(-1.1, 0.0));
        assert_eq!(count(&memory), 0);
    }

    #[test]
    fn places_close_together_are_one_and_the_oldest_goes_first() {
        let mut memory = Memory::new();
        (0..2 * MOST as u64).for_each(|i| memory.remember(Point2::new(0.001 * i as f64, 0.0), at(i)));
        assert!(memory.places().count() < 60);
        (0..2 * MOST as u64).for_each(|i| memory.remember(Point2::new(0.1 * i as f64, 1.0), at(1000 + i)));
        assert_eq!(memory.places().count(), MOST);
        assert!(memory.places().all(|place| place.x > 0.1 * MOST as f64 - 0.15));
    }
}
