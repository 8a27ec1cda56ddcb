//! A second opinion on the arbitration of the base.
//!
//! `protocol` decides the same histories as [`BaseArbiter`] in another way: it turns claims into the messages of
//! the protocol as Randazza (1989) words it (begin, end, warning of an override), and replays them with an owner, a stack of
//! overridden owners, and a first-in first-out queue for each priority. `properties` watches the arbiter from outside for
//! what must hold in any case, and asks it again about altered histories. [`check_histories`] compares on random ones.

mod history;
mod properties;
mod protocol;

use std::{
    fmt::{self, Display, Formatter},
    ops::{AddAssign, Range},
};

use crate::{
    arbitration::base::BaseArbiter,
    random::Streams,
    topics::{BaseDecision, BaseNotice, ClientId, NoticeKind},
};

pub use history::{History, Step};

/// What an arbiter answers in one step.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The decision.
    pub decision: BaseDecision,
    /// The notices of the step, in an order of their own.
    pub notices: Vec<BaseNotice>,
}

impl Outcome {
    fn new(decision: BaseDecision, mut notices: Vec<BaseNotice>) -> Self {
        notices.sort_by_key(|notice| (notice.client, notice.kind() as u8, notice.transaction));
        Self { decision, notices }
    }
}

/// How much was compared, and how often each thing happened in it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Stats {
    /// Histories compared.
    pub histories: u64,
    /// Decisions in them.
    pub decisions: u64,
    /// Claims in them.
    pub claims: u64,
    /// Decisions with a limit in force.
    pub limited: u64,
    /// Grants, those after an override included.
    pub granted: u64,
    /// Overrides.
    pub overridden: u64,
    /// Commands of an overrider forwarded to one who hangs on.
    pub overrider_moves: u64,
    /// Waits that ended without a grant, and repeated answers.
    pub busy: u64,
    /// Lapsed transactions, and repeated answers.
    pub lapsed: u64,
    /// Owners that hung on and got the base back.
    pub regained: u64,
}

impl Stats {
    fn count(&mut self, history: &History, outcomes: &[Outcome]) {
        self.histories += 1;
        self.claims += history.steps.iter().map(|step| step.claims.len() as u64).sum::<u64>();
        let mut overridden = vec![0; history.priorities.len()];
        for Outcome { decision, notices } in outcomes {
            self.decisions += 1;
            self.limited += u64::from(decision.limited_by != ClientId::NONE);
            for notice in notices {
                let last = &mut overridden[usize::from(notice.client.0)];
                match notice.kind() {
                    NoticeKind::Granted => {
                        self.granted += 1;
                        self.regained += u64::from(*last == notice.transaction);
                    }
                    NoticeKind::Overridden => {
                        self.overridden += 1;
                        *last = notice.transaction;
                    }
                    NoticeKind::OverriderMoves => self.overrider_moves += 1,
                    NoticeKind::Busy => self.busy += 1,
                    NoticeKind::Lapsed => self.lapsed += 1,
                }
            }
        }
    }
}

impl AddAssign for Stats {
    fn add_assign(&mut self, other: Self) {
        self.histories += other.histories;
        self.decisions += other.decisions;
        self.claims += other.claims;
        self.limited += other.limited;
        self.granted += other.granted;
        self.overridden += other.overridden;
        self.overrider_moves += other.overrider_moves;
        self.busy += other.busy;
        self.lapsed += other.lapsed;
        self.regained += other.regained;
    }
}

/// What is checked on each history.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Property {
    /// The arbiter answers as the protocol does.
    Protocol,
    /// Only the holder of a live claim moves the base, and as it says.
    Holder,
    /// A limit never raises a speed.
    Limits,
    /// Every overridden owner is told exactly once, and nobody else.
    ToldOnce,
    /// Every wait in the queue ends.
    WaitsEnd,
    /// Only the newest claim of a client counts.
    LostClaims,
    /// A lower priority never alters the output while a higher transaction is held.
    LowerPriority,
}

/// Something that is not as it should be.
#[derive(Debug)]
struct Breach {
    property: Property,
    what: String,
}

/// A history in which something is wrong, as short as it could be made.
#[derive(Debug, Clone)]
pub struct Counterexample {
    /// Seed and number of the history from which it was found.
    pub found: (u64, u64),
    /// What it breaks.
    pub property: Property,
    /// What is wrong.
    pub what: String,
    /// The history.
    pub history: History,
}

impl Display for Counterexample {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        writeln!(f, "history {} of seed {}: {}", self.found.1, self.found.0, self.what)?;
        writeln!(f, "priorities {:?}", self.history.priorities)?;
        for Step { now, claims } in &self.history.steps {
            for claim in claims {
                writeln!(f, "  {claim:?}")?;
            }
            writeln!(f, "decide at {now}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Counterexample {}

/// Compares the arbiter with its oracle on `n` random histories, and checks its properties on them.
///
/// # Errors
/// The first history on which anything is wrong, shortened.
pub fn check_histories(seed: u64, n: u64) -> Result<Stats, Box<Counterexample>> {
    check_range(seed, 0..n)
}

/// [`check_histories`] for some of the histories of a seed: they do not depend on each other, so ranges can be shared out
/// among threads.
///
/// # Errors
/// As [`check_histories`].
pub fn check_range(seed: u64, range: Range<u64>) -> Result<Stats, Box<Counterexample>> {
    let streams = Streams::new(seed);
    let mut stats = Stats::default();
    for number in range {
        let history = History::random(&mut streams.stream("arbitration", &number.to_string()));
        match check(&history) {
            Ok(outcomes) => stats.count(&history, &outcomes),
            Err(breach) => return Err(Box::new(shorten(history, breach, (seed, number)))),
        }
    }
    Ok(stats)
}

/// Everything that is to be checked on one history. Returns the arbiter's answers.
fn check(history: &History) -> Result<Vec<Outcome>, Breach> {
    let outcomes = run(history);
    let expected = protocol::replay(history);
    for (step, (outcome, expected)) in outcomes.iter().zip(&expected).enumerate() {
        if outcome != expected {
            let what = format!("step {step}: the arbiter says {outcome:#?}\nthe protocol says {expected:#?}");
            return Err(Breach { property: Property::Protocol, what });
        }
    }
    properties::watch(history, &outcomes)?;
    properties::lost_claims_cost_nothing(history, &outcomes)?;
    properties::lower_priorities_alter_nothing(history, &outcomes)?;
    Ok(outcomes)
}

/// What the arbiter answers to a history.
fn run(history: &History) -> Vec<Outcome> {
    let mut arbiter = BaseArbiter::new(&history.clients());
    let answer = |step: &Step| {
        step.claims.iter().for_each(|claim| arbiter.claim(claim));
        let mut notices = Vec::new();
        let decision = arbiter.decide(step.now, &mut notices);
        Outcome::new(decision, notices)
    };
    history.steps.iter().map(answer).collect()
}

/// Leaves out steps and claims for as long as something stays wrong.
fn shorten(mut history: History, mut breach: Breach, found: (u64, u64)) -> Counterexample {
    loop {
        let shorter = history.shorter().find_map(|candidate| check(&candidate).err().map(|breach| (candidate, breach)));
        let Some(shorter) = shorter else { break };
        (history, breach) = shorter;
    }
    Counterexample { found, property: breach.property, what: breach.what, history }
}
