//! What the ring has seen, kept where it was seen.
//!
//! A reading is fixed in the odometry frame, at the pose that the base had when the transducer was read, so that what the base
//! has driven since then is taken off exactly; nothing has to be guessed from the reading's age.
//!
//! A newer reading of a transducer replaces the older one, unless the base has turned in between: then the beam has left what it
//! met, and the beam that now looks there may not have been read yet. What it met is kept for a while. What slips into a gap
//! between the beams is remembered longer.

use std::cell::RefCell;

use nalgebra::{Point2, Rotation2, Vector2};
use orienteer_runtime::{
    geometry::{Pose, angle},
    recall::Recall,
    robot_model::{Ring, Transducer},
    time::Time,
    topics::{Echo, Odometry, SonarScan},
};

use super::memory::{Memory, NEAR, Sector};

/// Poses that are remembered at least, and at most: one for each control period within the age of a reading that still counts.
const POSES: std::ops::RangeInclusive<usize> = 64..=8192;
/// The sine of a turn after which a beam looks elsewhere.
const ELSEWHERE: f64 = 0.05;
/// For how long what a beam has turned away from is kept, s.
const KEPT: f64 = 0.5;
/// Readings of a transducer less than this much newer than the stored one are the same reading.
const SAME_READING: f64 = 1e-3;
/// How far two readings of one wall may disagree, m.
const RANGE_ERROR: f64 = 0.02;
/// Two readings of one thing, one after the other, differ by no more than this and what the base has driven, m.
const AGREES: f64 = 0.1;
/// Of two readings so far apart, m, the second may look past what the first has met.
const FAR: f64 = 0.03;
/// A place right beside a beam is off its rim by this, rad.
const BESIDE: f64 = 1e-3;
/// Two rays of a beam are no farther apart than this, rad; between them an arc bends by less than 0.2 % of the range.
const RAYS: f64 = 0.061;
/// Transducers whose beams point farther apart than this are no neighbours.
const NEIGHBOUR: f64 = 1.05;

/// The face of a transducer, odometry frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Face {
    pub at: Point2<f64>,
    /// Unit vector along the beam: readings are turned in every period, and a product is cheaper than an angle.
    pub axis: Vector2<f64>,
}

impl Face {
    fn distance(&self, other: &Face) -> f64 {
        (self.at - other.at).norm()
    }

    /// How far apart two beams point, rad.
    fn turned(&self, other: &Face) -> f64 {
        self.axis.perp(&other.axis).atan2(self.axis.dot(&other.axis)).abs()
    }

    /// The place at this range in a direction that is off the axis by `off` rad.
    fn place(&self, off: f64, range: f64) -> Point2<f64> {
        self.at + Rotation2::new(off) * self.axis * range
    }
}

/// The newest reading of one transducer.
#[derive(Debug, Clone, Copy)]
struct Reading {
    taken: Time,
    /// The transducer's face when it was read.
    face: Face,
    echo: Echo,
    /// The reading before it, or memory, says the same: it is not spurious.
    confirmed: bool,
}

impl Reading {
    /// Range of what was met, and whether it was too near to tell: then it is no farther than that. `None` if nothing answered.
    fn met(&self, min_range: f64) -> Option<(f64, bool)> {
        match self.echo {
            Echo::Range(range) => Some((f64::from(range), false)),
            Echo::TooNear => Some((min_range, true)),
            Echo::Nothing | Echo::NotFired => None,
        }
    }

    /// True if both met something at about the same distance.
    fn agrees(&self, other: &Reading, min_range: f64) -> bool {
        match (self.met(min_range), other.met(min_range)) {
            (Some((a, _)), Some((b, _))) => (a - b).abs() < AGREES + self.face.distance(&other.face),
            _ => false,
        }
    }
}

/// Something that may be there, in the robot frame of now: one of the places within a beam that an echo may have come from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Obstacle {
    /// The place.
    pub point: Point2<f64>,
    /// Direction of the ray that met it.
    pub ray: Vector2<f64>,
    /// It may be a wall that the ray meets at a right angle.
    pub is_wall: bool,
}

thread_local! {
    /// The beams of whoever looks, by slot: of use during one look only, so all that look on a thread share it.
    static MET: RefCell<Vec<Option<Beam>>> = const { RefCell::new(Vec::new()) };
}

/// A beam that met something, in the robot frame of now.
#[derive(Debug, Clone, Copy)]
struct Beam {
    /// The transducer's face when it was read.
    face: Point2<f64>,
    /// The beam's axis.
    axis: Vector2<f64>,
    /// Half the beam's opening, rad.
    half: f64,
    /// Distance from the face, m.
    range: f64,
    /// The reading said "too near": the thing is somewhere between the face and `range`.
    too_near: bool,
}

/// The memory of a ring.
#[derive(Debug, Clone)]
pub struct Sight {
    transducers: Vec<Transducer>,
    /// Where their beams point, unit vectors of the robot frame.
    axes: Vec<Vector2<f64>>,
    neighbours: Vec<[Option<usize>; 2]>,
    min_range: f64,
    readings: Vec<Option<Reading>>,
    /// What the beams met before they turned away.
    kept: Vec<Option<Reading>>,
    memory: Memory,
    poses: Vec<(Time, Pose)>,
    newest: usize,
    known: usize,
}

impl Sight {
    /// A ring that has not seen anything yet; readings older than `max_age` s do not count, and poses come once a `period`.
    #[must_use]
    pub fn new(ring: &Ring, max_age: f64, period: f64) -> Self {
        let poses = (max_age / period).ceil().clamp(*POSES.start() as f64, *POSES.end() as f64) as usize;
        let transducers = ring.transducers.clone();
        let neighbours = (0..transducers.len()).map(|i| neighbours(&transducers, i)).collect();
        let axes = transducers.iter().map(|transducer| Rotation2::new(transducer.mount.heading) * Vector2::x()).collect();
        Self {
            neighbours,
            axes,
            min_range: ring.min_range,
            readings: vec![None; transducers.len()],
            kept: vec![None; transducers.len()],
            memory: Memory::new(),
            transducers,
            poses: vec![(Time::START, Pose::default()); poses],
            newest: 0,
            known: 0,
        }
    }

    /// True if there is no transducer.
    pub fn is_empty(&self) -> bool {
        self.transducers.is_empty()
    }

    /// Remembers where the base was.
    pub fn pass(&mut self, odometry: &Odometry) {
        let newest = self.poses[self.newest].0;
        if self.known > 0 && odometry.stamp <= newest {
            return;
        }
        self.newest = (self.newest + 1) % self.poses.len();
        self.known = (self.known + 1).min(self.poses.len());
        self.poses[self.newest] = (odometry.stamp, odometry.pose);
    }

    /// Where the base was at a time; `None` if that is forgotten. Before the first pose that came it stood there, and after the
    /// last one it is still there.
    fn pose_at(&self, time: Time) -> Option<Pose> {
        let mut later = self.poses[self.newest];
        for back in 0..self.known {
            let earlier = self.poses[(self.newest + self.poses.len() - back) % self.poses.len()];
            if earlier.0 <= time {
                let span = later.0.secs_since(earlier.0);
                return Some(if span > 0.0 {
                    earlier.1.interpolate(later.1, (time.secs_since(earlier.0) / span).min(1.0))
                } else {
                    earlier.1
                });
            }
            later = earlier;
        }
        (self.known < self.poses.len()).then_some(later.1)
    }

    /// Takes in what is new in a scan.
    pub fn take(&mut self, scan: &SonarScan) {
        // Transducers that fired together were read at the same pose, and most rings have one kind of beam.
        let mut poses = Recall::<Time, Option<(Pose, Rotation2<f64>)>, 4>::default();
        let mut slopes = Recall::<u64, f64, 2>::default();
        for i in 0..self.transducers.len().min(scan.len()) {
            let age = f64::from(scan.age(i));
            let echo = scan.echo(i);
            if echo == Echo::NotFired || !(0.0..60.0).contains(&age) {
                continue;
            }
            let taken = scan.stamp - std::time::Duration::from_secs_f64(age);
            let is_new = self.readings[i].is_none_or(|old| taken.secs_since(old.taken) > SAME_READING);
            if is_new {
                let pose = || self.pose_at(taken).map(|pose| (pose, Rotation2::new(pose.heading)));
                // Nobody knows where a reading was taken that is older than all poses.
                let Some((pose, turn)) = poses.get(taken, pose) else { continue };
                let Transducer { mount, half_beam, .. } = self.transducers[i];
                let face = Face { at: pose.point() + turn * mount.point().coords, axis: turn * self.axes[i] };
                let slope = slopes.get(half_beam.to_bits(), || half_beam.tan());
                self.renew(i, Reading { taken, face, echo, confirmed: false }, slope);
            }
        }
    }

    /// Takes a new reading in place of an old one, of a beam with this tangent of its half angle.
    fn renew(&mut self, i: usize, mut new: Reading, slope: f64) {
        let half = self.transducers[i].half_beam;
        let beam = Sector { face: new.face, slope };
        new.confirmed = match new.echo {
            Echo::Range(range) => self.memory.look_again(&beam, f64::from(range)),
            Echo::Nothing => self.memory.look_again(&beam, f64::INFINITY),
            Echo::TooNear | Echo::NotFired => false,
        };
        if let Some(old) = self.readings[i] {
            new.confirmed |= new.agrees(&old, self.min_range);
            // A slow ring may have had no chance of a second look.
            if old.confirmed || old.face.distance(&new.face) > FAR {
                self.remember(&old, half, &beam);
            }
            let (along, across) = (old.face.axis.dot(&new.face.axis), old.face.axis.perp(&new.face.axis));
            let turned = along < 0.0 || across.abs() > ELSEWHERE;
            if turned && old.met(self.min_range).is_some() {
                self.kept[i] = Some(old);
            }
        }
        self.readings[i] = Some(new);
    }

    /// Remembers what the old beam may have met and the new one does not look at.
    fn remember(&mut self, old: &Reading, half: f64, beam: &Sector) {
        let Some((range, _)) = old.met(self.min_range).filter(|(range, _)| *range <= NEAR) else { return };
        let halves = (half / RAYS).ceil().max(1.0);
        // Rays farther inside the old beam than this are in the new one too: seen from anywhere less than half the range away,
        // what has moved aside by a share of the range has turned by no more than twice that share.
        let share = old.face.distance(&beam.face) / range;
        let inside = if share < 0.5 { half - old.face.turned(&beam.face) - 2.0 * share - 1e-6 } else { 0.0 };
        for n in 0..=2 * halves as usize {
            let off = half * (n as f64 / halves - 1.0);
            if off.abs() < inside {
                continue;
            }
            let place = old.face.place(off, range);
            if !beam.covers(place) {
                self.memory.remember(place, old.taken);
                // It may also be right beside the new beam. The gap there can be narrower than what the beam has moved by.
                let range = nalgebra::distance(&place, &beam.face.at);
                self.memory.remember(beam.face.place((half + BESIDE).copysign(off), range), old.taken);
            }
        }
    }

    /// How well the ring looks along a bearing of the robot frame: `None` if no beam points within `half_angle` of it, else the age
    /// in seconds of the oldest of these beams' readings (infinite for a beam that was never read).
    pub fn age_towards(&self, now: Time, bearing: f64, half_angle: f64) -> Option<f64> {
        let mut oldest = None;
        for (transducer, reading) in self.transducers.iter().zip(&self.readings) {
            if angle::turn(bearing, transducer.mount.heading).abs() <= half_angle {
                let age = reading.map_or(f64::INFINITY, |reading| now.secs_since(reading.taken));
                oldest = Some(oldest.unwrap_or(0.0f64).max(age));
            }
        }
        oldest
    }

    /// For each slot, the beam that met something no longer than `max_age` ago, as seen from `pose` (odometry frame). First come
    /// the newest readings of all transducers, then what they kept.
    fn beams(&self, now: Time, pose: Pose, max_age: f64) -> impl Iterator<Item = Option<Beam>> + '_ {
        let back = Rotation2::new(-pose.heading);
        let count = self.transducers.len();
        self.readings.iter().chain(&self.kept).enumerate().map(move |(slot, reading)| {
            let oldest = if slot < count { max_age } else { KEPT };
            let reading = reading.as_ref().filter(|reading| now.secs_since(reading.taken) <= oldest)?;
            let (range, too_near) = reading.met(self.min_range)?;
            Some(Beam {
                face: (back * (reading.face.at - pose.point())).into(),
                axis: back * reading.face.axis,
                half: self.transducers[slot % count].half_beam,
                range,
                too_near,
            })
        })
    }

    /// Where the beams' axes met something, as seen from `pose` (odometry frame).
    pub fn points(&self, now: Time, pose: Pose, max_age: f64) -> impl Iterator<Item = Point2<f64>> + '_ {
        self.beams(now, pose, max_age).flatten().map(|beam| beam.face + beam.axis * beam.range)
    }

    /// Replaces `obstacles` by all that may be there within `reach` of a body of radius `body` that stands at `pose` (odometry
    /// frame), by readings no older than `max_age`.
    pub fn look(&mut self, now: Time, pose: Pose, max_age: f64, body: f64, reach: f64, obstacles: &mut Vec<Obstacle>) {
        obstacles.clear();
        MET.with_borrow_mut(|met| {
            met.clear();
            met.extend(self.beams(now, pose, max_age));
            self.look_along(met, body, reach, obstacles);
        });
        self.recall(now, pose, body + reach, obstacles);
    }

    fn look_along(&self, met: &[Option<Beam>], body: f64, reach: f64, obstacles: &mut Vec<Obstacle>) {
        let count = self.transducers.len();
        for (slot, beam) in met.iter().enumerate() {
            let Some(beam) = beam else { continue };
            // No place in the beam, and no wall through it, is nearer to the centre than this.
            if !beam.too_near && beam.range - beam.face.coords.norm() > body + reach {
                continue;
            }
            // What was kept is compared with what its neighbours kept, as they looked about there at that time.
            let row = slot - slot % count;
            let beside = self.neighbours[slot % count].map(|neighbour| neighbour.and_then(|j| met[row + j]));
            let halves = (beam.half / RAYS).ceil().max(1.0);
            let step = Rotation2::new(beam.half / halves);
            let mut ray = Rotation2::new(-beam.half) * beam.axis;
            for _ in 0..=2 * halves as usize {
                let point = beam.face + ray * beam.range;
                let distance = ray.dot(&point.coords);
                let is_wall = distance <= body + reach && may_be_wall(&beside, ray, distance);
                if is_wall || point.coords.norm_squared() <= (body + reach) * (body + reach) {
                    obstacles.push(Obstacle { point, ray, is_wall });
                }
                if beam.too_near {
                    // It may be anywhere between the face and here, so also where it touches.
                    let leaves = leaves_disc(beam.face, ray, 0.999 * body).clamp(0.0, beam.range);
                    obstacles.push(Obstacle { point: beam.face + ray * leaves, ray, is_wall: false });
                }
                ray = step * ray;
            }
        }
    }

    /// Adds what is remembered within `reach` of the centre.
    fn recall(&mut self, now: Time, pose: Pose, reach: f64, obstacles: &mut Vec<Obstacle>) {
        self.memory.forget(now, pose.point());
        let back = Rotation2::new(-pose.heading);
        let near = self.memory.places().map(|place| place - pose.point()).filter(|offset| offset.norm() <= reach);
        obstacles.extend(near.map(|offset| Obstacle { point: (back * offset).into(), ray: Vector2::x(), is_wall: false }));
    }
}

impl Beam {
    /// The range at which this beam would meet the wall of all points `p` with `normal · p = distance`: where the ray that comes
    /// nearest to the normal hits it.
    fn range_of_wall(&self, normal: Vector2<f64>, distance: f64) -> f64 {
        let (cos, sin) = (self.axis.dot(&normal), self.axis.perp(&normal).abs());
        let (sin_half, cos_half) = self.half.sin_cos();
        // cos(max(0, angle − half)): the incidence of that ray
        let incidence = if cos >= cos_half { 1.0 } else { cos * cos_half + sin * sin_half };
        if incidence <= 0.0 { f64::INFINITY } else { (distance - normal.dot(&self.face.coords)) / incidence }
    }
}

/// How far along a ray from `face` it leaves the disc of this radius about the origin, m: negative if that lies behind the face. A
/// ray that misses the disc is taken where it comes nearest.
fn leaves_disc(face: Point2<f64>, ray: Vector2<f64>, radius: f64) -> f64 {
    let (along, across) = (face.coords.dot(&ray), face.coords.perp(&ray));
    (radius * radius - across * across).max(0.0).sqrt() - along
}

/// True if the neighbouring beams allow that a beam looks straight at that wall: each of them that meets anything must not meet it
/// before it could meet the wall. Something else that stands nearer counts for itself.
fn may_be_wall(beside: &[Option<Beam>; 2], normal: Vector2<f64>, distance: f64) -> bool {
    let nearer = |beam: &Beam| beam.range < beam.range_of_wall(normal, distance) - RANGE_ERROR;
    !beside.iter().flatten().any(nearer)
}

/// The transducers that point next to `i` on either side.
fn neighbours(transducers: &[Transducer], i: usize) -> [Option<usize>; 2] {
    let own = transducers[i].mount.heading;
    [1.0, -1.0].map(|side| {
        let off = |j: &usize| side * angle::turn(own, transducers[*j].mount.heading);
        (0..transducers.len()).filter(|j| off(j) > 1e-6 && off(j) <= NEIGHBOUR).min_by(|a, b| off(a).total_cmp(&off(b)))
    })
}
