//! Where a robot on its tour has come to, by the map and by the odometry since its last place.

use nalgebra::{Matrix2, Point2};
use orienteer_runtime::{
    geometry::Pose,
    topics::{CorridorReport, Opening},
};
use petgraph::graph::NodeIndex;

use super::{Departure, Standing, Tour};
use crate::geographer::{chart::Fix, compass::Quarter, map::Arm};

/// A place that stops the follower this far from where it should be is another one, m.
pub(super) const ELSEWHERE: f64 = 1.0;
/// A start pose that is so far from where a known corridor should end is wrong, m.
const AMISS: f64 = 0.3;
/// Two places are farther from each other than this, m.
const LEAST: f64 = 1.5;
/// Who is so far off its line, m, or its course, rad, does not look along its corridor.
const OFF_LINE: f64 = 0.35;
const OFF_COURSE: f64 = 0.4;
/// By so much the odometry may be off the course of a corridor, rad.
const DRIFT: f64 = 0.1;
/// Where a robot is that did not come straight: off by this, m, and by its drift, one standard deviation.
const ASTRAY: f64 = 0.1;
/// What is between a robot and the first place that it knows anything about: its middle may be off by this, m, one standard deviation.
const FIRST: f64 = 0.05;
/// Ends of a corridor.
pub(super) const BOTH: u32 = 2;

/// Where a stretch has led, by reckoning.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reached {
    /// The middle of the place that may be there, map frame, m; with covariance, m².
    pub at: Point2<f64>,
    pub covariance: Matrix2<f64>,
    pub facing: Quarter,
    /// How far it is from the place that was left, m, if the robot came straight along its arm.
    pub length: Option<f64>,
}

/// Which place it is that was reached.
#[derive(Debug, Clone, Copy)]
pub(super) enum Which {
    /// This one, and so far ahead of where the follower says that it begins, m; 0 as a rule.
    Known(NodeIndex, f64),
    /// One that nobody has been to.
    New,
    /// None: something has stopped the robot on a way that it knows.
    None,
    /// None that it can be.
    Lost,
}

impl Tour {
    /// Where the robot has come to; `None` if that can't be said.
    pub(super) fn reached(&self, departure: Option<&Departure>, report: &CorridorReport, middle: f64) -> Option<Reached> {
        let ahead = Pose::new(middle, 0.0, 0.0);
        let chart = self.chart.borrow();
        let (map, compass) = (&chart.map, chart.map.compass()?);
        let Some(fix) = chart.fix else {
            let facing = compass.nearest(report.pose.heading);
            let at = report.pose.then(ahead).point();
            return Some(Reached { at, covariance: Matrix2::identity() * FIRST * FIRST, facing, length: None });
        };
        let pose = fix.in_map(report.pose);
        let facing = compass.nearest(pose.heading);
        let straight = |departure: &&Departure| facing == departure.arm && is_on_line(departure.from, report.pose);
        if let Some(departure) = departure.filter(straight) {
            let length = departure.out + departure.from.distance(&report.pose) + middle;
            let (at, covariance) = map.reached(departure.place, departure.arm, length)?;
            return Some(Reached { at, covariance, facing, length: Some(length) });
        }
        let at = Pose { heading: compass.heading(facing), ..pose }.then(ahead).point();
        let astray = ASTRAY + DRIFT * fix.odometry.distance(&report.pose);
        Some(Reached { at, covariance: Matrix2::identity() * astray * astray, facing, length: None })
    }

    /// What is known of where the robot is when it stands at the start pose of a place.
    pub(super) fn fix_at(&self, standing: &Standing) -> Option<Fix> {
        let map = &self.chart.borrow().map;
        let (at, heading) = (map.place(standing.place)?.at, map.compass()?.heading(standing.facing));
        let middle = Pose::new(at.x, at.y, heading);
        Some(Fix { map: middle.then(Pose::new(-standing.middle, 0.0, 0.0)), odometry: standing.start })
    }

    /// Which place is there.
    pub(super) fn which_place(&self, departure: Option<&Departure>, reached: &Reached, opening: Opening) -> Which {
        let chart = self.chart.borrow();
        let map = &chart.map;
        let Reached { at, covariance, facing, length } = reached;
        let recognised = || map.recognise(*at, covariance);
        let (Some(length), Some(departure)) = (length, departure) else {
            return match recognised() {
                // Who came some other way knows a place again that is open on that side, or nothing.
                Some(known) => {
                    let is_closed = map.place(known).is_none_or(|place| place.arms[facing.back().index()] == Arm::Closed);
                    if is_closed && self.strange < BOTH { Which::Lost } else { Which::Known(known, 0.0) }
                }
                // If neither end is known, the corridor is a new one. What seems to be the end of one may be anything.
                None if chart.fix.is_some() && (self.strange < BOTH || opening == Opening::DeadEnd) => Which::Lost,
                None => Which::New,
            };
        };
        let known = match map.corridor((departure.place, departure.arm)) {
            Some((usual, (place, _))) if (length - usual).abs() < ELSEWHERE => {
                // The corner that the follower has found is nearer to the truth, unless it was none.
                let short = usual - length;
                return Which::Known(place, if short.abs() > AMISS { short } else { 0.0 });
            }
            // A place that it passed before without noticing, or nothing but what has stopped the robot.
            Some((usual, (place, _))) if *length < usual => match recognised() {
                Some(other) if other != place => Some(other),
                _ => return Which::None,
            },
            _ => recognised(),
        };
        match known {
            // Who has not come out of the place where it was has come to no other.
            Some(place) if place == departure.place => Which::Lost,
            Some(place) => Which::Known(place, 0.0),
            None if *length < LEAST => Which::Lost,
            None => Which::New,
        }
    }
}

/// True if a robot is about where it should be that has gone straight on from there.
pub(super) fn is_on_line(from: Pose, here: Pose) -> bool {
    let off = from.between(here);
    // The odometry may be off its course as well, after all the turns at a place.
    off.y.abs() < OFF_LINE + DRIFT * off.x.abs() && off.heading.abs() < OFF_COURSE
}
