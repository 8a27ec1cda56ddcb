//! A simulated ring that fires by its program.

use std::{cell::RefCell, time::Duration};

use nalgebra::{Point2, Vector2};
use orienteer_runtime::{
    geometry::Pose,
    robot_model::{Ring, Transducer},
    time::Time,
    topics::{FiringProgram, MAX_TRANSDUCERS, SonarScan},
};
use rand::{Rng, RngExt};
use thiserror::Error;

use super::{
    acoustics::{Acoustics, RangeGate},
    beam::{Beam, MAX_HALF_BEAM},
    bounce::second_bounce,
    cone::{Scratch, cone, first_surface},
    grid::{Disc, SegmentGrid},
    model::{ModelError, SonarModel},
};

/// The shortest time between two slots that a ring may have, s.
const MIN_SLOT_TIME: f64 = 1e-4;

thread_local! {
    /// Only one pinger at a time searches on a thread. Each with a scratch of its own, a swarm would fill the caches with memory
    /// that nobody looks at again before the next step.
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// Why a ring can't be simulated.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum PingerError {
    /// The sonar model makes no sense.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// More transducers than a scan can hold.
    #[error("the ring has {0} transducers, a scan holds at most {MAX_TRANSDUCERS}")]
    TooMany(usize),
    /// A transducer's beam is not between 0 and 40° to each side, or its mount is not finite.
    #[error("transducer {0} has a half beam outside 0 to 40 degrees, or a mount that is not a number")]
    Transducer(usize),
    /// Not `0 ≤ min_range < max_range`.
    #[error("the ring's ranges {min} to {max} m are not in order")]
    Ranges {
        /// The ring's least range, m.
        min: f64,
        /// The ring's greatest range, m.
        max: f64,
    },
    /// Slots follow each other in less than 0.1 ms.
    #[error("the ring's slot time of {0} s is shorter than 0.0001 s")]
    SlotTime(f64),
}

/// Runs a simulated ring through its firing program.
///
/// # Timing
///
/// The transducers of a slot fire together, slots follow each other at the ring's slot time, and a pass starts at the
/// program's period after the last, or a slot time after its last slot if that is later. The first slot fires one slot time
/// after the start. A scan carries the time of its last slot and is handed over by the call of [`poll`](Pinger::poll) whose
/// interval contains that; a pass may begin in one call and end in another. A reading is taken to be instantaneous: the robot
/// does not move while the sound is under way (58 ms for an echo from 10 m; at 0.3 m/s that is 2 cm).
///
/// A new program takes effect with the next pass. Averaging over rings is left to the reader of the scans.
///
/// The calls draw the same random numbers however the time is cut into intervals.
#[derive(Debug, Clone)]
pub struct Pinger {
    ring: Ring,
    acoustics: Acoustics,
    /// Each transducer's mount as (position, unit axis) in the robot frame, and its beam at the origin.
    mounts: Vec<(Pose, Beam)>,
    gate: RangeGate,
    program: FiringProgram,
    wanted: FiringProgram,
    /// The slot that fires next.
    slot: usize,
    /// When the last slot fired, or the start.
    last: Time,
    /// When the running or last pass fired its first slot.
    pass_start: Option<Time>,
    slot_time: Duration,
    scan: SonarScan,
    /// A scan is complete with every slot, not only with the last of a pass.
    every_slot: bool,
    /// Bodies farther than this from the robot's centre are not heard, m.
    reach: f64,
    /// The bodies near enough to be heard in this slot.
    near: Vec<Disc>,
}

impl Pinger {
    /// A ring that starts at `start` with its own program.
    ///
    /// # Errors
    /// [`PingerError`] if the ring or the model makes no sense.
    pub fn new(ring: Ring, model: &SonarModel, start: Time) -> Result<Self, PingerError> {
        check(&ring)?;
        let mounted = |t: &Transducer| (t.mount, Beam::new(t.mount, t.half_beam, ring.max_range));
        Ok(Self {
            acoustics: Acoustics::new(model)?,
            mounts: ring.transducers.iter().map(mounted).collect(),
            gate: RangeGate { min: ring.min_range, max: ring.max_range },
            program: ring.program,
            wanted: ring.program,
            slot: 0,
            last: start,
            pass_start: None,
            slot_time: Duration::from_secs_f64(ring.slot_time),
            scan: SonarScan::unfired(ring.transducers.len()),
            every_slot: false,
            reach: ring.transducers.iter().map(|t| t.mount.x.hypot(t.mount.y)).fold(0.0, f64::max) + ring.max_range,
            near: Vec::with_capacity(16),
            ring,
        })
    }

    /// Hands a scan over with every slot, as rings do that tell what they have heard at once.
    #[must_use]
    pub fn telling_every_slot(mut self) -> Self {
        self.every_slot = true;
        self
    }

    /// The ring that is simulated.
    #[must_use]
    pub fn ring(&self) -> &Ring {
        &self.ring
    }

    /// Asks for another program from the next pass on. A program without slots is the ring's own.
    pub fn set_program(&mut self, program: &FiringProgram) {
        self.wanted = if program.slots.is_empty() { self.ring.program } else { *program };
    }

    /// Fires every slot due in the interval `(from, to]` and appends the scans that are completed to `out`.
    ///
    /// `pose_at` gives the robot's true pose at any time of the interval; `bodies` are the other moving bodies. If `from` is
    /// later than the end of the last interval, what would have fired between is left out.
    #[expect(clippy::too_many_arguments, reason = "an interval, a world and where to put the result")]
    pub fn poll(
        &mut self,
        from: Time,
        to: Time,
        pose_at: impl Fn(Time) -> Pose,
        world: &SegmentGrid,
        bodies: &[Disc],
        rng: &mut impl Rng,
        out: &mut Vec<SonarScan>,
    ) {
        SCRATCH.with_borrow_mut(|scratch| {
            while let Some(now) = self.next_after(from).filter(|next| *next <= to) {
                self.fire(now, pose_at(now), world, bodies, rng, scratch);
                if self.slot == 0 || self.every_slot {
                    out.push(self.scan);
                }
            }
        });
    }

    /// When the next slot fires if nobody looks before `from`; `None` if no program has a slot.
    fn next_after(&mut self, from: Time) -> Option<Time> {
        if self.slot == 0 {
            self.program = self.wanted;
        }
        if self.program.slots.is_empty() {
            return None;
        }
        let mut next = self.last + self.slot_time;
        if let Some(start) = self.pass_start.filter(|_| self.slot == 0) {
            next = next.max(start + period(&self.program));
        }
        if next <= from {
            // Keep to the beat of the slots.
            let beat = self.slot_time.as_nanos().max(1) as u64;
            let beats = (from.as_nanos() - self.last.as_nanos()) / beat + 1;
            next = Time::from_nanos(self.last.as_nanos().saturating_add(beats.saturating_mul(beat)));
        }
        Some(next)
    }

    /// Fires the slot that is due; afterwards `self.slot` is 0 if the pass is complete.
    fn fire(&mut self, now: Time, robot: Pose, world: &SegmentGrid, bodies: &[Disc], rng: &mut impl Rng, scratch: &mut Scratch) {
        if self.slot == 0 {
            self.pass_start = Some(now);
        }
        if self.slot == 0 || self.every_slot {
            self.scan.fired = 0;
        }
        self.scan.grow_older(now.secs_since(self.last) as f32);
        self.last = now;

        let mask = self.program.slots.get(self.slot).copied().unwrap_or(0);
        self.near.clear();
        let in_reach = |body: &&Disc| (body.centre - robot.point()).norm() <= self.reach + body.radius;
        self.near.extend(bodies.iter().filter(in_reach));
        let distances = self.listen(mask, robot, world, rng, scratch);
        for (i, distance) in distances.iter().enumerate().take(self.mounts.len()).filter(|(i, _)| mask & (1 << i) != 0) {
            self.scan.set(i, self.acoustics.measure(*distance, self.gate, rng), 0.0);
        }

        self.slot = (self.slot + 1) % self.program.slots.len();
        if self.slot == 0 || self.every_slot {
            self.scan.stamp = now;
            self.scan.seq += 1;
        }
    }

    /// The distances that the transducers of a slot hear, noise aside.
    fn listen(
        &self,
        mask: u32,
        robot: Pose,
        world: &SegmentGrid,
        rng: &mut impl Rng,
        scratch: &mut Scratch,
    ) -> [Option<f64>; MAX_TRANSDUCERS] {
        let mut heard_at = [None; MAX_TRANSDUCERS];
        let mut distances = [None; MAX_TRANSDUCERS];
        let (direction, model) = (robot.direction(), self.acoustics.model());
        for (i, (mount, beam)) in self.mounts.iter().enumerate().filter(|(i, _)| mask & (1 << i) != 0) {
            let beam = carried(robot, direction, *mount, beam);
            let answer = cone(world, &self.near, &beam, &self.acoustics, scratch);
            distances[i] = answer.map(|answer| answer.range);
            if answer.is_none() && model.second_bounce {
                distances[i] = second_bounce(world, &self.near, &beam, &self.acoustics, scratch);
            }
            if model.cross_talk > 0.0 {
                heard_at[i] = answer.map(|answer| (answer.range, answer.at(&beam)));
            }
        }
        if model.cross_talk > 0.0 {
            self.hear_neighbours(mask, robot, world, &heard_at, &mut distances, rng, scratch);
        }
        distances
    }

    /// Cross-talk: with the model's probability a transducer takes the nearest point that answers another one of its slot,
    /// if that point is in its own beam and in sight, for its own echo. The sound then runs from the other transducer to the
    /// point and from there to this one; half of that path is heard if it is shorter than the own echo.
    #[expect(clippy::too_many_arguments, reason = "what was heard, what may be heard instead, and where to look")]
    fn hear_neighbours(
        &self,
        mask: u32,
        robot: Pose,
        world: &SegmentGrid,
        heard_at: &[Option<(f64, Point2<f64>)>; MAX_TRANSDUCERS],
        distances: &mut [Option<f64>; MAX_TRANSDUCERS],
        rng: &mut impl Rng,
        scratch: &mut Scratch,
    ) {
        let direction = robot.direction();
        for (i, (mount, beam)) in self.mounts.iter().enumerate().filter(|(i, _)| mask & (1 << i) != 0) {
            if rng.random::<f64>() >= self.acoustics.model().cross_talk {
                continue;
            }
            let beam = carried(robot, direction, *mount, beam);
            for (_, other) in heard_at.iter().enumerate().filter(|(j, _)| *j != i) {
                let Some((range, at)) = other else { continue };
                let way = at - beam.origin;
                let length = way.norm();
                let path = 0.5 * (range + length);
                let in_beam = way.dot(&beam.axis) * beam.sec_half >= length && path <= self.gate.max && length > 0.0;
                if !in_beam || distances[i].is_some_and(|own| own <= path) {
                    continue;
                }
                let sight = Beam { max_range: length - 1e-6, ..beam.moved(beam.origin, way / length) };
                if first_surface(world, &self.near, &sight, None, scratch).is_none() {
                    distances[i] = Some(path);
                }
            }
        }
    }
}

/// The beam of a transducer when its robot is at `robot`, whose heading is the unit vector `direction`.
fn carried(robot: Pose, direction: Vector2<f64>, mount: Pose, beam: &Beam) -> Beam {
    let turned = |x: f64, y: f64| Vector2::new(x * direction.x - y * direction.y, x * direction.y + y * direction.x);
    beam.moved(robot.point() + turned(mount.x, mount.y), turned(beam.axis.x, beam.axis.y))
}

/// A period in whole microseconds: payloads carry it as `f32`, whose digits beyond that mean nothing.
fn period(program: &FiringProgram) -> Duration {
    Duration::from_micros((f64::from(program.period) * 1e6).round() as u64)
}

fn check(ring: &Ring) -> Result<(), PingerError> {
    if ring.transducers.len() > MAX_TRANSDUCERS {
        return Err(PingerError::TooMany(ring.transducers.len()));
    }
    if let Some(i) =
        ring.transducers.iter().position(|t| !(t.half_beam > 0.0 && t.half_beam <= MAX_HALF_BEAM && t.mount.is_sound()))
    {
        return Err(PingerError::Transducer(i));
    }
    if !(ring.min_range >= 0.0 && ring.min_range < ring.max_range && ring.max_range.is_finite()) {
        return Err(PingerError::Ranges { min: ring.min_range, max: ring.max_range });
    }
    if !(ring.slot_time >= MIN_SLOT_TIME && ring.slot_time.is_finite()) {
        return Err(PingerError::SlotTime(ring.slot_time));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
