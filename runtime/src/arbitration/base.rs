//! Arbitration of the base.
//!
//! Source: the low-level controller of Randazza (1989), §3. It leaves open what happens between equals and how long a client
//! waits; the rules here are ours: preemption is strict, equals wait in order of arrival, a wait has a deadline.
//!
//! # Life of a transaction
//!
//! ```text
//!          new number          first in line            higher priority comes
//!  (none) ───────────▶ waiting ─────────────▶ holding ─────────────────────────▶ hanging on
//!    ▲                    │  wait_until         │  ▲                                  │
//!    │                    ▼                     │  └──── first in line again ─────────┤
//!    │                  busy                    │                                     │
//!    └── another number, or 0 ◀─────────────────┴──────── surrender ──────────────────┘
//!        valid_until passes: lapsed, from anywhere
//! ```
//!
//! * The deadline ends a *wait*, so it does not concern a client that was granted and overridden: it hangs on until the
//!   overrider yields, or until it gives up itself. Of the source's two choices, surrender and hang on, the second would
//!   otherwise turn into the first behind the client's back.
//! * A deadline is looked at when a decision is made: the first decision at or after it either grants or ends the wait. A
//!   deadline of *now* is thus one try.
//! * A holder that sends a new number has let go and asks again: it goes behind the equals that wait.
//! * The newest claim counts in everything, so a client may move its own deadline.
//!
//! Limits are apart from all this. Every live claim's limits are in force, whoever has the base; a bound that makes no sense
//! (NaN, negative) is zero.

use crate::{
    arbitration::{Clients, Standing, rank, rule},
    geometry::Limits,
    time::Time,
    topics::{BaseClaim, BaseDecision, BaseNotice, ClientId, HeldBack, Motion, NoticeKind},
};

/// What the arbiter remembers of one client.
#[derive(Debug, Clone, Default)]
struct Record {
    priority: u8,
    /// The newest claim heard.
    claim: BaseClaim,
    /// The claim was heard since the last decision.
    fresh: bool,
    /// The claim has not lapsed.
    live: bool,
    /// The open transaction; 0 for none.
    transaction: u32,
    /// Number of the decision that first saw the open transaction.
    arrival: u64,
    /// The open transaction has been granted.
    granted: bool,
    /// The number of a transaction that ended without the client's doing, and how, until the client sends another.
    over: Option<(u32, NoticeKind)>,
}

impl Record {
    /// Brings the transaction in line with the newest claim and the time. Returns what there is to tell: number and kind.
    fn settle(&mut self, now: Time, decision: u64) -> Option<(u32, NoticeKind)> {
        let fresh = std::mem::take(&mut self.fresh);
        if !self.live {
            return None;
        }
        let claimed = self.claim.transaction;
        if let Some(over) = self.over.filter(|(number, _)| *number == claimed) {
            self.live = now < self.claim.valid_until;
            return fresh.then_some(over);
        }
        self.over = None;
        if claimed != self.transaction {
            (self.transaction, self.arrival, self.granted) = (claimed, decision, false);
        }
        if now < self.claim.valid_until {
            return None;
        }
        self.live = false;
        self.end(NoticeKind::Lapsed)
    }

    /// Ends the open transaction, if any, without the client's doing.
    fn end(&mut self, how: NoticeKind) -> Option<(u32, NoticeKind)> {
        let number = std::mem::take(&mut self.transaction);
        if number == 0 {
            return None;
        }
        self.over = Some((number, how));
        self.over
    }

    fn standing(&self, client: ClientId) -> Option<Standing> {
        let Record { priority, arrival, granted, .. } = *self;
        (self.transaction != 0).then_some(Standing { client, priority, arrival, granted })
    }
}

/// Who had the base after the last decision, and what it commanded.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Held {
    client: ClientId,
    transaction: u32,
    motion: Motion,
    since: Time,
}

/// Decides who has the base.
///
/// ```
/// use orienteer_runtime::arbitration::{Clients, base::BaseArbiter};
/// use orienteer_runtime::geometry::Twist;
/// use orienteer_runtime::time::Time;
/// use orienteer_runtime::topics::{BaseClaim, ArbitrationRule, ClientId, Motion};
///
/// let clients: Clients = [("follower", 5), ("avoidance", 10)].into_iter().collect();
/// let mut arbiter = BaseArbiter::new(&clients);
/// let mut notices = Vec::new();
/// let ahead = BaseClaim {
///     client: ClientId(0),
///     transaction: 1,
///     valid_until: Time::from_secs_f64(0.2),
///     wait_until: Time::FAR,
///     motion: Motion::velocity(Twist::new(0.3, 0.0)),
///     ..BaseClaim::default()
/// };
/// arbiter.claim(&ahead);
/// let decision = arbiter.decide(Time::from_secs_f64(0.05), &mut notices);
/// assert_eq!((decision.holder, decision.rule()), (ClientId(0), ArbitrationRule::OnlyClaim));
/// ```
#[derive(Debug, Clone)]
pub struct BaseArbiter {
    records: Vec<Record>,
    decisions: u64,
    held: Option<Held>,
    /// The line at the last decision; kept for its memory.
    line: Vec<Standing>,
}

impl BaseArbiter {
    /// An arbiter between these clients.
    #[must_use]
    pub fn new(clients: &Clients) -> Self {
        let records: Vec<Record> =
            clients.iter().map(|(_, client)| Record { priority: client.priority, ..Record::default() }).collect();
        Self { decisions: 0, held: None, line: Vec::with_capacity(records.len()), records }
    }

    /// Takes in a claim. One by a client that is not in the table is ignored, so is one that is older than another by the
    /// same client. A motion that holds anything but finite numbers becomes [`Motion::STOP`].
    pub fn claim(&mut self, claim: &BaseClaim) {
        let Some(record) = self.records.get_mut(usize::from(claim.client.0)) else { return };
        if claim.stamp < record.claim.stamp {
            return;
        }
        record.claim = BaseClaim { motion: claim.motion.within(Limits::NONE), ..*claim };
        (record.fresh, record.live) = (true, true);
    }

    /// Decides who has the base from `now` on, and appends what the clients are to be told to `notices`. Call it once a
    /// step, after the step's claims.
    pub fn decide(&mut self, now: Time, notices: &mut Vec<BaseNotice>) -> BaseDecision {
        self.decisions += 1;
        self.settle(now, notices);
        self.line.clear();
        self.line.extend(self.records.iter().zip(ids()).filter_map(|(record, client)| record.standing(client)));
        rank(&mut self.line);
        let before = self.held;
        let first = self.line.first().map(|first| first.client);
        self.held = first.and_then(|client| self.hold(client, now));
        let decision = self.decision(now);
        self.tell_handover(now, before, notices);
        self.tell_those_who_hang_on(now, before, notices);
        self.end_waits(now, notices);
        decision
    }

    fn settle(&mut self, now: Time, notices: &mut Vec<BaseNotice>) {
        for (record, client) in self.records.iter_mut().zip(ids()) {
            if let Some((number, kind)) = record.settle(now, self.decisions) {
                notices.push(BaseNotice::new(now, client, number, kind, ClientId::NONE));
            }
        }
    }

    /// Gives the base to `client`.
    fn hold(&mut self, client: ClientId, now: Time) -> Option<Held> {
        let record = self.records.get_mut(usize::from(client.0))?;
        record.granted = true;
        let Record { transaction, claim: BaseClaim { motion, .. }, .. } = *record;
        let goes_on = self.held.filter(|held| (held.client, held.transaction) == (client, transaction));
        Some(Held { client, transaction, motion, since: goes_on.map_or(now, |held| held.since) })
    }

    fn decision(&self, now: Time) -> BaseDecision {
        let mut decision = self.limits().because(rule(&self.line, 0));
        (decision.stamp, decision.since, decision.valid_until) = (now, now, now);
        if let Some(held) = self.held {
            decision.holder = held.client;
            decision.transaction = held.transaction;
            decision.motion = held.motion;
            decision.since = held.since;
            decision.valid_until = self.record(held.client).map_or(now, |record| record.claim.valid_until);
        }
        for place in 1..self.line.len() {
            decision.hold_back(HeldBack::new(self.line[place].client, rule(&self.line, place)));
        }
        decision
    }

    /// An otherwise empty decision with the limits of all live claims, and who set the lowest of each kind.
    fn limits(&self) -> BaseDecision {
        let mut all = BaseDecision::default();
        for (record, client) in self.records.iter().zip(ids()).filter(|(record, _)| record.live) {
            let tighter = all.limits.and(record.claim.limits);
            if tighter.linear < all.limits.linear {
                all.limited_by = client;
            }
            if tighter.angular < all.limits.angular {
                all.turn_limited_by = client;
            }
            all.limits = tighter;
        }
        all
    }

    /// Tells the previous owner that it was overridden and the new one that it has the base.
    fn tell_handover(&self, now: Time, before: Option<Held>, notices: &mut Vec<BaseNotice>) {
        let owner = |held: Option<Held>| held.map(|held| (held.client, held.transaction));
        if owner(before) == owner(self.held) {
            return;
        }
        if let (Some(old), Some(new)) = (before, self.held)
            && self.record(old.client).is_some_and(|record| record.transaction == old.transaction)
        {
            notices.push(BaseNotice::new(now, old.client, old.transaction, NoticeKind::Overridden, new.client));
        }
        if let Some(new) = self.held {
            notices.push(BaseNotice::new(now, new.client, new.transaction, NoticeKind::Granted, ClientId::NONE));
        }
    }

    /// Forwards a new command of the holder to everyone who was overridden and hangs on.
    fn tell_those_who_hang_on(&self, now: Time, before: Option<Held>, notices: &mut Vec<BaseNotice>) {
        let command = |held: Held| (held.client, held.transaction, held.motion);
        let Some(held) = self.held.filter(|held| before.map(command) != Some(command(*held))) else { return };
        for standing in self.line.iter().skip(1).filter(|standing| standing.granted) {
            let Some(record) = self.record(standing.client) else { continue };
            let kind = NoticeKind::OverriderMoves;
            let mut notice = BaseNotice::new(now, standing.client, record.transaction, kind, held.client);
            notice.motion = held.motion;
            notices.push(notice);
        }
    }

    /// Ends the waits whose time is up.
    fn end_waits(&mut self, now: Time, notices: &mut Vec<BaseNotice>) {
        let holder = self.held.map_or(ClientId::NONE, |held| held.client);
        for standing in self.line.iter().skip(1).filter(|standing| !standing.granted) {
            let Some(record) = self.records.get_mut(usize::from(standing.client.0)) else { continue };
            if now >= record.claim.wait_until
                && let Some((number, kind)) = record.end(NoticeKind::Busy)
            {
                notices.push(BaseNotice::new(now, standing.client, number, kind, holder));
            }
        }
    }

    fn record(&self, client: ClientId) -> Option<&Record> {
        self.records.get(usize::from(client.0))
    }
}

fn ids() -> impl Iterator<Item = ClientId> {
    (0..ClientId::NONE.0).map(ClientId)
}
