//! The safety floor: how often some transducers are fired, whoever has the sonar.
//!
//! # The rule
//!
//! Let a slot take `s` seconds and let the floor ask that each of its transducers is fired at least every `D` seconds. Then
//! the *budget* is `K = ⌊D / s⌋` slots from one firing to the next. The floor's transducers are fired in `m` slots of their
//! own: grouped as in the ring's own program, which knows what may be fired together.
//!
//! 1. A program that fires every floor transducer often enough is left alone.
//! 2. Otherwise its period is cut to `D`: with idle time between passes, no order of slots could help.
//! 3. The `m` floor slots are inserted at the start and after every `K − m` of its slots. They come first, so that a ring
//!    whose program is changed in the middle of a pass fires them soonest.
//! 4. Of what was inserted, whatever turns out not to be needed is taken out again, slot by slot from the last, then
//!    transducer by transducer.
//! 5. If that is more than the 32 slots which a program may have, nothing is inserted; instead, the floor's transducers are
//!    fired *together with* the program's own: the `n` slots are divided into `⌈n / K⌉` blocks of nearly equal length, and
//!    floor slot `j` joins slot `j` of each block (counted round if the block is shorter). This may cost cross-talk, never
//!    safety.
//!
//! # Why the bound holds
//!
//! Inserting: from one firing of a floor transducer to the next there are at most `K − m` slots of the program and `m` of the
//! floor, so `K s ≤ D`. This goes for the step from one pass to the next, too, unless the ring then waits for the period.
//! It waits only if the pass is shorter than `D` (the period was cut), hence no longer than `K` slots; so the floor slots
//! stand in it once, and fire once every `D`. Joining: equal places of successive blocks are one block's length apart, at
//! most `K`. Taking out is checked case by case.
//!
//! The bound is for a program that runs on. A ring that finishes its pass before it takes up another program has fired every
//! floor transducer less than `D` before that, and does so again within `D` after: the gap across a change is below `2 D`,
//! and no client can make it longer by changing its program all the time.

use thiserror::Error;

use crate::{
    arbitration::sonar::members,
    robot_model::Ring,
    topics::{FiringProgram, FixedVec, MAX_TRANSDUCERS},
};

/// Gaps may be longer than the floor's period by this much, s: programs carry their period in single precision.
const TOLERANCE: f64 = 1e-6;

/// Above this many slots, it is not worth looking which of them could be taken out again.
const MAX_WORK: usize = 4 * MAX_TRANSDUCERS;

/// Why a ring can't keep a floor.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FloorError {
    /// The floor names transducers that are not there.
    #[error("the safety floor names transducers {0:?}, which the ring does not have")]
    NoSuchTransducers(Vec<usize>),
    /// The period is not a positive number.
    #[error("a safety floor can't have a period of {0} s")]
    BadPeriod(f64),
    /// The ring's slot time is not a positive number.
    #[error("a ring with a slot time of {0} s can't keep a safety floor")]
    BadSlotTime(f64),
    /// The floor's own slots and one for everybody else take longer than its period.
    #[error("the safety floor's transducers can't be fired every {period} s: the ring needs {least:.3} s")]
    TooOften {
        /// What was asked, s.
        period: f64,
        /// What the ring could keep, s.
        least: f64,
    },
}

/// One slot under construction.
#[derive(Debug, Clone, Copy)]
struct Slot {
    /// What the program wants fired.
    own: u32,
    /// What the floor has put in.
    added: u32,
}

/// Transducers that must be fired at least every so often. See the source of this module for the rule and the proof.
#[derive(Debug, Clone)]
pub struct SafetyFloor {
    /// The floor's transducers, grouped as they may be fired together.
    slots: Vec<u32>,
    transducers: u32,
    period: f64,
    slot_time: f64,
    /// Slots from one firing to the next, at most.
    budget: usize,
    /// The program under construction; kept for its memory.
    work: Vec<Slot>,
}

impl SafetyFloor {
    /// No floor at all: every program runs as it is.
    #[must_use]
    pub fn none() -> Self {
        Self { slots: Vec::new(), transducers: 0, period: f64::MAX, slot_time: 1.0, budget: usize::MAX, work: Vec::new() }
    }

    /// A floor under a ring: each of `transducers` (a bit mask) is fired at least every `period` seconds.
    ///
    /// # Errors
    /// If the ring could not keep the floor and still serve anybody else.
    pub fn new(ring: &Ring, transducers: u32, period: f64) -> Result<Self, FloorError> {
        let unknown = transducers & !members(ring);
        if unknown != 0 {
            return Err(FloorError::NoSuchTransducers(bits(unknown).collect()));
        }
        if transducers == 0 {
            return Ok(Self::none());
        }
        if !(period.is_finite() && period > 0.0) {
            return Err(FloorError::BadPeriod(period));
        }
        if !(ring.slot_time.is_finite() && ring.slot_time > 0.0) {
            return Err(FloorError::BadSlotTime(ring.slot_time));
        }
        let slots = group(transducers, &ring.program);
        let budget = (period / ring.slot_time + 1e-9).floor() as usize;
        if budget <= slots.len() {
            return Err(FloorError::TooOften { period, least: (slots.len() + 1) as f64 * ring.slot_time });
        }
        Ok(Self { slots, transducers, period, slot_time: ring.slot_time, budget, work: Vec::with_capacity(MAX_WORK) })
    }

    /// A floor under all transducers of a ring: each is fired at least every `period` seconds. A ring that needs more than
    /// half of that for them alone fires them as often as it can with half its time.
    ///
    /// # Errors
    /// If the period or the ring's slot time is not a positive number.
    pub fn under_all(ring: &Ring, period: f64) -> Result<Self, FloorError> {
        let all = members(ring);
        let own = group(all, &ring.program).len() as f64 * ring.slot_time;
        Self::new(ring, all, if own.is_finite() { period.max(2.0 * own) } else { period })
    }

    /// The transducers concerned, as a bit mask.
    #[must_use]
    pub fn transducers(&self) -> u32 {
        self.transducers
    }

    /// Seconds within which each of them is fired.
    #[must_use]
    pub fn period(&self) -> f64 {
        self.period
    }

    /// A program that keeps the floor and is otherwise as near to `program` as the rule allows, and the transducers that
    /// had to be added (a bit mask). The program must be valid for the ring that the floor was made for.
    pub fn merge(&mut self, program: &FiringProgram) -> (FiringProgram, u32) {
        let mut work = std::mem::take(&mut self.work);
        work.clear();
        work.extend(program.slots.iter().map(|own| Slot { own: *own, added: 0 }));
        let mut period = program.period;
        if !self.kept_by(&work, period) {
            period = period.min(self.period as f32);
            self.insert(&mut work, program);
            if work.len() <= MAX_WORK {
                self.thin_out(&mut work, period);
            }
            if work.len() > MAX_TRANSDUCERS {
                self.join(&mut work, program);
                self.thin_out(&mut work, period);
            }
        }
        let mut slots = FixedVec::default();
        let mut added = 0;
        for slot in &work {
            slots.push(slot.own | slot.added);
            added |= slot.added;
        }
        self.work = work;
        (FiringProgram { slots, period, rings: program.rings }, added)
    }

    /// Rule 3.
    fn insert(&self, work: &mut Vec<Slot>, program: &FiringProgram) {
        work.clear();
        let room = self.budget - self.slots.len();
        let floor = || self.slots.iter().map(|added| Slot { own: 0, added: *added });
        for chunk in program.slots.chunks(room) {
            work.extend(floor());
            work.extend(chunk.iter().map(|own| Slot { own: *own, added: 0 }));
        }
        if program.slots.is_empty() {
            work.extend(floor());
        }
    }

    /// Rule 5.
    fn join(&self, work: &mut Vec<Slot>, program: &FiringProgram) {
        work.clear();
        work.extend(program.slots.iter().map(|own| Slot { own: *own, added: 0 }));
        let blocks = work.len().div_ceil(self.budget);
        let shortest = work.len() / blocks.max(1);
        for start in (0..blocks).map(|block| block * program.slots.len() / blocks) {
            for (j, group) in self.slots.iter().enumerate() {
                let slot = &mut work[start + j % shortest];
                slot.added |= group & !slot.own;
            }
        }
    }

    /// Rule 4.
    fn thin_out(&self, work: &mut Vec<Slot>, period: f32) {
        // A slot less makes the pass shorter, so that another may become superfluous that was not before.
        while self.drop_superfluous(work, period) {}
        for i in 0..work.len() {
            for bit in bits(work[i].added) {
                let before = work[i].added;
                work[i].added &= !(1 << bit);
                if longest_gap(work, bit, period, self.slot_time) > self.period + TOLERANCE {
                    work[i].added = before;
                }
            }
        }
    }

    /// Takes out inserted slots without which the floor is kept as well. Returns whether there were any.
    fn drop_superfluous(&self, work: &mut Vec<Slot>, period: f32) -> bool {
        let before = work.len();
        for i in (0..work.len()).rev() {
            let slot = work[i];
            if slot.own == 0 {
                work.remove(i);
                if !self.kept_by(work, period) {
                    work.insert(i, slot);
                }
            }
        }
        work.len() < before
    }

    fn kept_by(&self, slots: &[Slot], period: f32) -> bool {
        bits(self.transducers).all(|bit| longest_gap(slots, bit, period, self.slot_time) <= self.period + TOLERANCE)
    }
}

/// Longest time from one firing of a transducer to the next while a program runs on, s; infinite if it is never fired.
fn longest_gap(slots: &[Slot], transducer: usize, period: f32, slot_time: f64) -> f64 {
    let mut firings = (0..slots.len()).filter(|i| (slots[*i].own | slots[*i].added) & (1 << transducer) != 0);
    let Some(first) = firings.next() else { return f64::INFINITY };
    let (mut last, mut within) = (first, 0);
    for i in firings {
        within = within.max(i - last);
        last = i;
    }
    let pass = f64::from(period).max(slots.len() as f64 * slot_time);
    (within as f64 * slot_time).max(pass - (last - first) as f64 * slot_time)
}

/// The floor's transducers in slots: those that the ring's own program fires together, then each of the others alone.
fn group(transducers: u32, own: &FiringProgram) -> Vec<u32> {
    let mut left = transducers;
    let mut slots = Vec::new();
    for slot in own.slots.iter() {
        slots.push(slot & left);
        left &= !slot;
    }
    slots.extend(bits(left).map(|bit| 1 << bit));
    slots.retain(|slot| *slot != 0);
    slots
}

/// The places of the bits that are set.
fn bits(mask: u32) -> impl Iterator<Item = usize> {
    (0..MAX_TRANSDUCERS).filter(move |bit| mask & (1 << bit) != 0)
}
