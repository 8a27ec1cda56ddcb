//! Arbitration of the sonar.
//!
//! The firing program of the highest priority runs; of equals, that of the first asker. An asker that is held back need not
//! do anything: its program runs when it is first in line. Into whatever program runs, the [`SafetyFloor`] is worked,
//! so that the transducers which avoidance lives by are fired often enough, whoever has the sonar. If nobody asks, the ring's
//! own program runs, with the floor as well.

mod floor;

pub use floor::{FloorError, SafetyFloor};

use crate::{
    arbitration::{Clients, Standing, rank, rule},
    robot_model::Ring,
    time::Time,
    topics::{ClientId, FiringProgram, FixedVec, HeldBack, MAX_TRANSDUCERS, SonarClaim, SonarDecision},
};

/// What the arbiter remembers of one client.
#[derive(Debug, Clone, Default)]
struct Record {
    priority: u8,
    /// The newest claim heard, its program made valid.
    claim: SonarClaim,
    /// The client wants the sonar.
    asking: bool,
    /// Number of the decision that first saw it asking.
    arrival: u64,
    /// It has had the sonar since it began to ask.
    granted: bool,
}

impl Record {
    /// Brings the record in line with the newest claim and the time.
    fn settle(&mut self, now: Time, decision: u64) {
        let asks = !self.claim.program.slots.is_empty() && now < self.claim.valid_until;
        if asks && !self.asking {
            (self.arrival, self.granted) = (decision, false);
        }
        self.asking = asks;
    }
}

/// A program with the floor worked in; remembered, because programs seldom change.
#[derive(Debug, Clone, Copy)]
struct Merged {
    from: FiringProgram,
    program: FiringProgram,
    added: u32,
}

/// Decides which firing program runs.
///
/// ```
/// # use orienteer_runtime::{robot_model::Ring, time::Time, topics::{ClientId, FiringProgram, FixedVec, SonarClaim}};
/// # use orienteer_runtime::arbitration::{Clients, sonar::{SafetyFloor, SonarArbiter}};
/// # let mut program = FiringProgram::default();
/// # (0..4).for_each(|i| { program.slots.push(1 << i); });
/// # let transducer = orienteer_runtime::robot_model::Transducer { mount: Default::default(), half_beam: 0.2 };
/// # let ring = Ring {
/// #     name: "four".into(), transducers: vec![transducer; 4], min_range: 0.2, max_range: 7.0, slot_time: 0.05, program };
/// // A ring of four; transducer 0 looks ahead and is to be fired every 0.2 s.
/// let floor = SafetyFloor::new(&ring, 0b0001, 0.2)?;
/// let clients: Clients = [("mapper", 3)].into_iter().collect();
/// let mut arbiter = SonarArbiter::new(&clients, &ring, floor);
///
/// // The mapper wants to look to the right only.
/// let mut right = FiringProgram::default();
/// right.slots.push(0b1000);
/// arbiter.claim(&SonarClaim { client: ClientId(0), stamp: Time::START, valid_until: Time::FAR, program: right });
///
/// let decision = arbiter.decide(Time::START);
/// assert_eq!(decision.holder, ClientId(0));
/// assert_eq!(decision.program.slots[..], [0b0001, 0b1000]);
/// assert_eq!(decision.floor, 0b0001);
/// # Ok::<(), orienteer_runtime::arbitration::sonar::FloorError>(())
/// ```
#[derive(Debug, Clone)]
pub struct SonarArbiter {
    records: Vec<Record>,
    decisions: u64,
    /// Who had the sonar after the last decision, and since when.
    held: Option<(ClientId, Time)>,
    /// The line at the last decision; kept for its memory.
    line: Vec<Standing>,
    own_program: FiringProgram,
    members: u32,
    floor: SafetyFloor,
    merged: Option<Merged>,
}

impl SonarArbiter {
    /// An arbiter between these clients over one ring. `floor` must have been made for the same ring.
    #[must_use]
    pub fn new(clients: &Clients, ring: &Ring, floor: SafetyFloor) -> Self {
        let records: Vec<Record> =
            clients.iter().map(|(_, client)| Record { priority: client.priority, ..Record::default() }).collect();
        let members = members(ring);
        Self {
            line: Vec::with_capacity(records.len()),
            records,
            decisions: 0,
            held: None,
            own_program: valid(&ring.program, members),
            members,
            floor,
            merged: None,
        }
    }

    /// Takes in a claim. One by a client that is not in the table is ignored, so is one that is older than another by the
    /// same client. Of the program, transducers that the ring lacks are cut, then slots that fire nothing are dropped; a
    /// period that is not a positive number becomes zero.
    pub fn claim(&mut self, claim: &SonarClaim) {
        let Some(record) = self.records.get_mut(usize::from(claim.client.0)) else { return };
        if claim.stamp >= record.claim.stamp {
            record.claim = SonarClaim { program: valid(&claim.program, self.members), ..*claim };
        }
    }

    /// Decides whose program runs from `now` on. Call it once a step, after the step's claims.
    pub fn decide(&mut self, now: Time) -> SonarDecision {
        self.decisions += 1;
        self.line.clear();
        for (record, client) in self.records.iter_mut().zip((0..ClientId::NONE.0).map(ClientId)) {
            record.settle(now, self.decisions);
            if record.asking {
                let Record { priority, arrival, granted, .. } = *record;
                self.line.push(Standing { client, priority, arrival, granted });
            }
        }
        rank(&mut self.line);
        let wanted = self.hold(now);
        let merged = self.merge(&wanted);
        let mut decision = SonarDecision::default().because(rule(&self.line, 0));
        decision.stamp = now;
        (decision.holder, decision.since) = self.held.unwrap_or((ClientId::NONE, now));
        (decision.program, decision.floor, decision.reserved) = (merged.program, merged.added, self.floor.transducers());
        for place in 1..self.line.len() {
            decision.hold_back(HeldBack::new(self.line[place].client, rule(&self.line, place)));
        }
        decision
    }

    /// Gives the sonar to the first in line. Returns the program it wants, or the ring's own if there is nobody.
    fn hold(&mut self, now: Time) -> FiringProgram {
        let first = self.line.first().map(|first| first.client);
        let record = first.and_then(|client| self.records.get_mut(usize::from(client.0)));
        let (Some(client), Some(record)) = (first, record) else {
            self.held = None;
            return self.own_program;
        };
        let since = self.held.filter(|(holder, _)| *holder == client).map_or(now, |(_, since)| since);
        record.granted = true;
        self.held = Some((client, since));
        record.claim.program
    }

    fn merge(&mut self, wanted: &FiringProgram) -> Merged {
        if let Some(merged) = self.merged.filter(|merged| merged.from == *wanted) {
            return merged;
        }
        let (program, added) = self.floor.merge(wanted);
        *self.merged.insert(Merged { from: *wanted, program, added })
    }
}

/// The transducers of a ring as a bit mask.
fn members(ring: &Ring) -> u32 {
    let beyond = MAX_TRANSDUCERS.saturating_sub(ring.transducers.len()) as u32;
    u32::MAX.checked_shr(beyond).unwrap_or(0)
}

/// The part of a program that a ring with these members can execute.
fn valid(program: &FiringProgram, members: u32) -> FiringProgram {
    let mut slots = FixedVec::default();
    for slot in program.slots.iter().map(|slot| slot & members).filter(|slot| *slot != 0) {
        slots.push(slot);
    }
    let period = if program.period.is_finite() { program.period.max(0.0) } else { 0.0 };
    FiringProgram { slots, period, rings: program.rings }
}
