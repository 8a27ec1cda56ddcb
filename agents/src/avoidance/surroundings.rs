//! What comes nearer by itself, told from what the robot's own motion brings nearer.

use std::{collections::VecDeque, sync::Arc};

use nalgebra::Vector2;
use orienteer_runtime::{
    geometry::{Pose, angle},
    recall::Recall,
    robot_model::Ring,
    time::Time,
    topics::{Echo, Odometry, SonarScan},
};

use super::track::{Reading, Track};

/// What each transducer has heard lately, freed of the robot's own motion.
///
/// An echo says how far, not where within the beam. While the robot moves by `d` in direction `δ`, a thing at rest, a point or
/// a wall, at bearing `φ` gets nearer by `d cos(δ − φ)`, and `φ` may be anywhere within the half beam `h` of the axis `b`. So
/// nothing at rest gets nearer by more than
///
/// ```text
/// d · cos( max(0, |δ − b| − h − tilt) )
/// ```
///
/// where `tilt` allows for walls that answer at the rim of the beam; and when the beam turns by `a`, a wall at distance `r` that
/// answers at its rim by no more than `r · tan 30° · a`. This most is added back to the readings. What then still
/// gets nearer moves by itself, at no less than the slope of a line fitted to the sum. The price is that a thing beside the
/// robot's course must come a little faster to be noticed: by 0.3 of the robot's speed at a right angle.
#[derive(Debug)]
pub struct Surroundings {
    ring: Arc<Ring>,
    radius: f64,
    tracks: Vec<Track>,
    /// For each transducer, how far before the robot's centre its face stands along its beam, m, and the cosine of its bearing.
    faces: Vec<(f64, f64)>,
    /// Where the robot was, oldest first, for as long as it takes a scan to be complete.
    poses: VecDeque<(Time, Pose)>,
    /// Speed along the heading, m/s.
    speed: f64,
    /// A transducer that has said nothing for longer than this, s, is silent: nobody knows what is there.
    patience: f64,
}

/// Something that a transducer hears.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Threat {
    /// Where it is, rad from the heading.
    pub bearing: f64,
    /// Distance from the robot's centre, m.
    pub distance: f64,
    /// Distance from the body, m.
    pub clearance: f64,
    /// How fast it comes nearer by itself, at least, m/s.
    pub approach: f64,
    /// How fast the gap shrinks, own motion included, m/s.
    pub closing: f64,
    /// How much nearer it has come by itself within the history, m.
    pub came: f64,
    /// It has been coming evenly, as somebody who walks does, and not in a step, as when a beam meets something else.
    pub steady: bool,
}

/// Walls that answer at the rim of a beam may lie this much farther off its axis, rad.
const TILT: f64 = 0.1;
/// Beams that point less than this apart may hear the same wall, rad.
const BESIDE: f64 = 0.5;
/// A thing that approaches more slowly than this stands, m/s.
const STANDS: f64 = 0.06;
/// On top of two passes of the ring's own program: the safety floor has every transducer fire twice a second, s.
const SILENT: f64 = 0.5;
/// 1 / cos 30° and some for the transducers standing apart on the ring.
const RIM: f64 = 1.3;

impl Surroundings {
    /// Nothing heard yet, by this ring on a body of this radius (m).
    #[must_use]
    pub fn new(ring: Arc<Ring>, radius: f64) -> Self {
        let tracks = vec![Track::default(); ring.transducers.len()];
        let face = |mount: &Pose| (mount.x * mount.heading.cos() + mount.y * mount.heading.sin(), mount.heading.cos());
        let faces = ring.transducers.iter().map(|transducer| face(&transducer.mount)).collect();
        let patience = SILENT + 2.0 * ring.pass_time();
        Self { ring, radius, tracks, faces, poses: VecDeque::new(), speed: 0.0, patience }
    }

    /// Follows the robot's own motion.
    pub fn moved(&mut self, odometry: &Odometry) {
        // One pose that is no number would stay in the history for good.
        if !odometry.pose.is_sound() || !odometry.twist.is_finite() {
            return;
        }
        if self.poses.back().is_none_or(|(stamp, _)| odometry.stamp > *stamp) {
            let over = |(stamp, _): &(Time, Pose)| odometry.stamp.secs_since(*stamp) > self.patience;
            while self.poses.get(1).is_some_and(over) {
                self.poses.pop_front();
            }
            self.poses.push_back((odometry.stamp, odometry.pose));
        }
        self.speed = odometry.twist.linear;
    }

    /// Takes the scans of a step, oldest first.
    pub fn heard(&mut self, scans: &[SonarScan]) {
        for scan in scans {
            self.take(scan);
        }
        let fresh = |i: usize| scans.iter().any(|scan| scan.is_fresh(i));
        for (_, track) in self.tracks.iter_mut().enumerate().filter(|(i, _)| fresh(*i)) {
            track.refit();
        }
    }

    fn take(&mut self, scan: &SonarScan) {
        // Transducers that fired together were at the same place, and went the same way there.
        let mut poses = Recall::<u64, Pose, 4>::default();
        let mut courses = Recall::<(u64, u64), f64, 4>::default();
        for i in (0..self.ring.transducers.len()).filter(|i| scan.is_fresh(*i)) {
            let transducer = self.ring.transducers[i];
            let time = scan.stamp.as_secs_f64() - f64::from(scan.age(i));
            let pose = poses.get(time.to_bits(), || self.pose_at(time));
            let axis = angle::wrap(pose.heading + transducer.mount.heading);
            let Some(range) = scan.echo(i).free_distance(self.ring.max_range as f32).map(f64::from) else { continue };
            let heard = scan.echo(i) != Echo::Nothing;
            let reading = Reading { time, range, heard, at: pose.point(), axis };
            let course = |by: Vector2<f64>| courses.get((by.x.to_bits(), by.y.to_bits()), || by.y.atan2(by.x));
            self.tracks[i].push(reading, transducer.half_beam + TILT, course);
        }
    }

    /// Where the robot was at a time; before all that is known, where it was first, and after that, where it was last.
    fn pose_at(&self, time: f64) -> Pose {
        let mut after: Option<(Time, Pose)> = None;
        for (stamp, pose) in self.poses.iter().rev().copied() {
            let Some((later, end)) = after.replace((stamp, pose)) else { continue };
            if stamp.as_secs_f64() <= time {
                let share = (time - stamp.as_secs_f64()) / later.secs_since(stamp).max(1e-6);
                return pose.interpolate(end, share.clamp(0.0, 1.0));
            }
        }
        after.map_or_else(Pose::default, |(_, pose)| pose)
    }

    /// True if a transducer has not said anything for too long.
    fn is_silent(&self, track: &Track) -> bool {
        self.poses.back().is_some_and(|(now, _)| now.as_secs_f64() - track.taken() > self.patience)
    }

    /// Everything within hearing, one entry for each transducer that hears something.
    pub fn all(&self) -> impl Iterator<Item = Threat> + '_ {
        self.ring.transducers.iter().zip(&self.tracks).enumerate().filter_map(|(i, (transducer, track))| {
            let range = track.range().filter(|_| !self.is_silent(track))?;
            let (bearing, (reach, forward)) = (transducer.mount.heading, self.faces[i]);
            let trend = track.trend();
            let distance = range + reach;
            let closing = trend.approach + self.speed * forward;
            let clearance = (distance - self.radius).max(0.0);
            let (approach, came) = (trend.approach, trend.came);
            let steady = trend.steady && !self.is_rim_of_wall(i, range);
            Some(Threat { bearing, distance, clearance, approach, closing, came, steady })
        })
    }

    /// True if what transducer `i` hears may be a wall at the rim of its beam, because a beam beside it hears one that stands.
    ///
    /// A wall heard by one beam at distance `d` is heard by the next at up to `d / cos 30°`; beyond that angle of incidence
    /// walls usually give no echo. That second echo slides along the wall as the robot drives and turns.
    fn is_rim_of_wall(&self, i: usize, range: f64) -> bool {
        let axis = |i: usize| self.ring.transducers[i].mount.heading;
        (0..self.tracks.len()).filter(|j| *j != i && angle::turn(axis(i), axis(*j)).abs() < BESIDE).any(|j| {
            let stands = self.tracks[j].trend().approach < STANDS;
            self.tracks[j].range().is_some_and(|wall| stands && wall < range + 0.02 && range < RIM * wall + 0.03)
        })
    }

    /// How far the body could go toward `bearing` (rad from the heading) before it touches something, m; at most `limit`, and
    /// nothing where the transducer that looks that way is silent.
    #[must_use]
    pub fn free_toward(&self, bearing: f64, margin: f64, limit: f64) -> f64 {
        if self.ring.nearest_to(bearing).is_some_and(|nearest| self.is_silent(&self.tracks[nearest])) {
            return 0.0;
        }
        let swath = self.radius + margin;
        self.all()
            .filter_map(|thing| {
                let (sin, cos) = (thing.bearing - bearing).sin_cos();
                let (ahead, beside) = (thing.distance * cos, thing.distance * sin);
                (ahead > 0.0 && beside.abs() < swath).then(|| ahead - (swath * swath - beside * beside).sqrt())
            })
            .fold(limit, f64::min)
            .max(0.0)
    }
}
