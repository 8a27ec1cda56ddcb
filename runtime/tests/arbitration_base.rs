//! What the protocol of the base promises, case by case.
#![allow(clippy::unwrap_used)]

use std::time::Duration;

use orienteer_runtime::{
    arbitration::{Clients, base::BaseArbiter, explain},
    geometry::{Limits, Twist},
    time::Time,
    topics::{ArbitrationRule, BaseClaim, BaseDecision, BaseNotice, ClientId, HeldBack, Motion, MotionKind, NoticeKind},
};

const A: ClientId = ClientId(0);
const B: ClientId = ClientId(1);
const C: ClientId = ClientId(2);
const NOBODY: ClientId = ClientId::NONE;
const STEP: Duration = Duration::from_millis(50);
const SLOW: Motion = Motion::velocity(Twist::new(0.1, 0.0));
const FAST: Motion = Motion::velocity(Twist::new(0.5, 1.0));

/// An arbiter whose clients repeat what they said last, until they fall silent.
struct Base {
    now: Time,
    arbiter: BaseArbiter,
    clients: Clients,
    claims: Vec<Option<BaseClaim>>,
    decision: BaseDecision,
    notices: Vec<(ClientId, NoticeKind, ClientId)>,
    moves: Vec<Motion>,
}

impl Base {
    fn new(priorities: &[u8]) -> Self {
        let clients: Clients = ["ann", "bob", "cem"].into_iter().zip(priorities.iter().copied()).collect();
        let arbiter = BaseArbiter::new(&clients);
        let claims = vec![None; priorities.len()];
        let decision = BaseDecision::default();
        Self { now: Time::START, arbiter, clients, claims, decision, notices: Vec::new(), moves: Vec::new() }
    }

    fn says(&mut self, client: ClientId, change: impl FnOnce(&mut BaseClaim)) -> &mut Self {
        let fresh = BaseClaim { client, wait_until: Time::FAR, motion: SLOW, ..BaseClaim::default() };
        change(self.claims[usize::from(client.0)].get_or_insert(fresh));
        self
    }

    fn asks(&mut self, client: ClientId, transaction: u32) -> &mut Self {
        self.says(client, |claim| claim.transaction = transaction)
    }

    fn falls_silent(&mut self, client: ClientId) -> &mut Self {
        self.claims[usize::from(client.0)] = None;
        self
    }

    /// One step; the holder.
    fn step(&mut self) -> ClientId {
        self.now = self.now + STEP;
        for claim in self.claims.iter_mut().flatten() {
            (claim.stamp, claim.valid_until) = (self.now, self.now + STEP + STEP / 2);
            self.arbiter.claim(claim);
        }
        let mut notices = Vec::new();
        self.decision = self.arbiter.decide(self.now, &mut notices);
        self.notices = notices.iter().map(|notice| (notice.client, notice.kind(), notice.by)).collect();
        self.moves = notices.iter().filter(|n| n.kind() == NoticeKind::OverriderMoves).map(|n| n.motion).collect();
        self.decision.holder
    }

    fn held_back(&self) -> Vec<(ClientId, ArbitrationRule)> {
        self.decision.held_back().iter().map(|held_back| (held_back.client, held_back.rule())).collect()
    }

    fn why(&self) -> String {
        explain::base(&self.decision, &self.clients).to_string()
    }
}

use ArbitrationRule::{AskedFirst, HangingOn, HeldFirst, HigherPriority, LowerPriority, NobodyAsked, OnlyClaim, Queued};
use NoticeKind::{Busy, Granted, Lapsed, Overridden, OverriderMoves};

#[test]
fn one_client_takes_and_gives_back() {
    let mut base = Base::new(&[5]);
    assert_eq!((base.step(), base.decision.rule(), base.decision.motion), (NOBODY, NobodyAsked, Motion::STOP));
    assert_eq!(base.asks(A, 1).step(), A);
    assert_eq!((base.decision.rule(), base.decision.motion, base.decision.since), (OnlyClaim, SLOW, base.now));
    assert_eq!(base.decision.valid_until, base.now + STEP + STEP / 2);
    assert_eq!(base.notices, [(A, Granted, NOBODY)]);
    assert_eq!(base.step(), A);
    assert_eq!((base.notices.len(), base.decision.since), (0, base.now - STEP));
    assert_eq!(base.asks(A, 0).step(), NOBODY);
    assert_eq!((base.decision.motion, base.decision.valid_until), (Motion::STOP, base.now));
    assert!(base.notices.is_empty());
}

#[test]
fn strictly_higher_preempts_and_equal_waits() {
    let mut base = Base::new(&[5, 5, 6]);
    base.asks(A, 1).step();
    assert_eq!(base.asks(B, 1).step(), A);
    assert_eq!((base.decision.rule(), base.held_back()), (HeldFirst, vec![(B, Queued)]));
    assert_eq!(base.asks(C, 1).step(), C);
    assert_eq!((base.decision.rule(), base.held_back()), (HigherPriority, vec![(A, HangingOn), (B, LowerPriority)]));
    assert_eq!(base.notices, [(A, Overridden, C), (C, Granted, NOBODY), (A, OverriderMoves, C)]);
}

#[test]
fn who_hangs_on_comes_before_equals_that_wait() {
    // B is before A in every order but this one.
    let mut base = Base::new(&[5, 5, 9]);
    base.asks(B, 1).step();
    base.asks(A, 1).asks(C, 1).step();
    assert_eq!(base.held_back(), [(B, HangingOn), (A, LowerPriority)]);
    assert_eq!(base.asks(C, 0).step(), B);
    assert_eq!((base.decision.rule(), base.notices.clone()), (HeldFirst, vec![(B, Granted, NOBODY)]));
    assert_eq!(base.asks(B, 0).step(), A);
}

#[test]
fn equals_that_come_at_once_go_by_their_order() {
    let mut base = Base::new(&[5, 5, 5]);
    assert_eq!(base.asks(C, 1).asks(B, 1).asks(A, 1).step(), A);
    assert_eq!((base.decision.rule(), base.held_back()), (AskedFirst, vec![(B, Queued), (C, Queued)]));
    // A new number is a new request: behind those who wait.
    assert_eq!(base.asks(A, 2).step(), B);
    assert_eq!(base.held_back(), [(C, Queued), (A, Queued)]);
    assert_eq!(base.notices, [(B, Granted, NOBODY)]);
}

#[test]
fn overrides_unwind_in_order() {
    let mut base = Base::new(&[3, 6, 9]);
    base.asks(A, 1).step();
    base.asks(B, 1).step();
    base.asks(C, 1).step();
    assert_eq!(base.notices, [(B, Overridden, C), (C, Granted, NOBODY), (B, OverriderMoves, C), (A, OverriderMoves, C)]);
    assert_eq!(base.held_back(), [(B, HangingOn), (A, HangingOn)]);
    assert_eq!(base.asks(C, 0).step(), B);
    assert_eq!(base.notices, [(B, Granted, NOBODY), (A, OverriderMoves, B)]);
    assert_eq!(base.asks(B, 0).step(), A);
    // Each override is told, not only the first.
    base.asks(B, 2).step();
    assert_eq!(base.notices, [(A, Overridden, B), (B, Granted, NOBODY), (A, OverriderMoves, B)]);
}

#[test]
fn who_hangs_on_hears_of_each_command_once() {
    let mut base = Base::new(&[3, 6]);
    base.asks(A, 1).step();
    base.asks(B, 1).step();
    assert_eq!(base.moves, [SLOW]);
    base.step();
    assert!(base.notices.is_empty());
    base.says(B, |claim| claim.motion = FAST).step();
    assert_eq!((base.notices.clone(), base.moves.clone()), (vec![(A, OverriderMoves, B)], vec![FAST]));
    // A motion that is no number is no change from one step to the next.
    base.says(B, |claim| claim.motion = Motion::velocity(Twist::new(f64::NAN, 0.0))).step();
    assert_eq!(base.moves, [Motion::STOP]);
    base.step();
    assert!(base.notices.is_empty());
    // One who has given up hears nothing.
    base.asks(A, 0).says(B, |claim| claim.motion = SLOW).step();
    assert!(base.notices.is_empty());
}

#[test]
fn a_wait_ends_at_the_first_decision_at_its_deadline() {
    let mut base = Base::new(&[5, 5]);
    base.asks(A, 1).step();
    let deadline = base.now + 2 * STEP;
    base.asks(B, 1).says(B, |claim| claim.wait_until = deadline).step();
    assert_eq!(base.held_back(), [(B, Queued)]);
    base.step();
    assert_eq!(base.notices, [(B, Busy, A)]);
    // The number is dead, and says so, even if the base is free by now.
    assert_eq!(base.asks(A, 0).says(B, |claim| claim.wait_until = Time::FAR).step(), NOBODY);
    assert_eq!(base.notices, [(B, Busy, NOBODY)]);
    assert_eq!(base.asks(B, 2).step(), B);
}

#[test]
fn at_its_deadline_a_wait_may_end_well() {
    let mut base = Base::new(&[5, 5]);
    base.asks(A, 1).step();
    let deadline = base.now + STEP;
    base.asks(A, 0).asks(B, 1).says(B, |claim| claim.wait_until = deadline);
    assert_eq!(base.step(), B);
    assert_eq!(base.notices, [(B, Granted, NOBODY)]);
}

#[test]
fn no_deadline_ends_hanging_on() {
    let mut base = Base::new(&[3, 6]);
    base.asks(A, 1).says(A, |claim| claim.wait_until = Time::START).step();
    base.asks(B, 1).step();
    for _ in 0..20 {
        base.step();
        assert!(base.notices.is_empty());
    }
    assert_eq!(base.asks(B, 0).step(), A);
}

#[test]
fn silence_frees_the_base() {
    let mut base = Base::new(&[5, 3]);
    base.asks(A, 1).asks(B, 1).step();
    assert_eq!(base.falls_silent(A).step(), A);
    assert_eq!(base.step(), B);
    assert_eq!(base.notices, [(A, Lapsed, NOBODY), (B, Granted, NOBODY)]);
    // It comes back with its old number, which is dead.
    assert_eq!(base.asks(A, 1).step(), B);
    assert_eq!(base.notices, [(A, Lapsed, NOBODY)]);
    assert_eq!(base.asks(A, 2).step(), A);
}

#[test]
fn limits_of_all_count_whoever_has_the_base() {
    let mut base = Base::new(&[5, 3, 9]);
    base.asks(A, 1).says(A, |claim| claim.motion = FAST);
    base.says(B, |claim| claim.limits = Limits { linear: 0.25, angular: f64::MAX });
    base.says(C, |claim| claim.limits = Limits { linear: f64::MAX, angular: 0.8 });
    assert_eq!(base.step(), A);
    assert_eq!(base.decision.limits, Limits { linear: 0.25, angular: 0.8 });
    assert_eq!((base.decision.limited_by, base.decision.turn_limited_by), (B, C));
    assert_eq!(base.decision.motion, FAST);
    assert_eq!(base.decision.limited_motion().kind(), MotionKind::Velocity(Twist::new(0.25, 0.5)));
    // The holder's own, and of equals the first.
    base.says(A, |claim| claim.limits = Limits { linear: 0.25, angular: f64::NAN }).step();
    assert_eq!((base.decision.limited_by, base.decision.turn_limited_by), (A, A));
    assert_eq!(base.decision.limited_motion().kind(), MotionKind::Velocity(Twist::STOP));
    // A limit lapses like everything else.
    base.falls_silent(B).falls_silent(C).says(A, |claim| claim.limits = Limits::NONE);
    base.step();
    base.step();
    assert_eq!((base.decision.limits, base.decision.limited_by), (Limits::NONE, NOBODY));
}

#[test]
fn strangers_and_latecomers_are_not_heard() {
    let mut base = Base::new(&[5]);
    base.asks(A, 1).step();
    let claim = BaseClaim { client: A, transaction: 2, valid_until: Time::FAR, ..BaseClaim::default() };
    base.arbiter.claim(&claim);
    base.arbiter.claim(&BaseClaim { client: B, stamp: base.now, ..claim });
    base.arbiter.claim(&BaseClaim { client: NOBODY, stamp: base.now, ..claim });
    let decision = base.arbiter.decide(base.now, &mut Vec::new());
    assert_eq!((decision.holder, decision.transaction, decision.held_back().len()), (A, 1, 0));
}

#[test]
fn decisions_are_explained() {
    let mut base = Base::new(&[5, 5, 10]);
    base.step();
    assert_eq!(base.why(), "nobody has asked for the base");
    base.asks(A, 1).asks(B, 1).says(A, |claim| claim.motion = FAST).step();
    assert_eq!(
        base.why(),
        "ann has the base since 0.10 s: at equal priority (5) it asked first, before bob (5), which is queued; \
         it drives at 0.50 m/s and turns at 57.3 deg/s"
    );
    base.says(B, |claim| claim.limits = Limits { linear: 0.2, angular: 0.5 }).step();
    assert_eq!(
        base.why(),
        "ann has the base since 0.10 s: at equal priority (5) it keeps what it had, before bob (5), which is queued; \
         it drives at 0.50 m/s and turns at 57.3 deg/s; speed limited to 0.20 m/s by bob; turn rate limited to 28.6 deg/s by bob"
    );
    base.says(B, |claim| claim.limits = Limits::NONE)
        .asks(C, 1)
        .says(C, |claim| claim.motion = Motion::rotate(1, 0.5, 0.25))
        .step();
    assert_eq!(
        base.why(),
        "cem has the base since 0.20 s: higher priority (10) than ann (5), which hangs on, and bob (5), which waits; \
         it turns by 28.6 deg at up to 14.3 deg/s"
    );
    base.asks(A, 0).asks(B, 0).says(C, |claim| claim.motion = Motion::translate(1, -0.5, 0.25)).step();
    assert_eq!(base.why(), "cem has the base since 0.20 s: nobody else wants it; it moves -0.50 m at up to 0.25 m/s");
}

#[test]
fn anything_that_a_recording_may_hold_is_explained() {
    let clients: Clients = [("ann", 5)].into_iter().collect();
    let mut decision = BaseDecision::default().because(ArbitrationRule::Queued);
    decision.holder = C;
    decision.hold_back(HeldBack::new(NOBODY, ArbitrationRule::NobodyAsked));
    assert_eq!(
        explain::base(&decision, &clients).to_string(),
        "client 2 has the base since 0.00 s: for no reason that it could have, before nobody (0), which waits; it stands"
    );
    let notice = |kind| explain::notice(&BaseNotice::new(Time::START, A, 4, kind, C), &clients).to_string();
    assert_eq!(notice(Overridden), "ann's transaction 4 is overridden by client 2");
    assert_eq!(notice(OverriderMoves), "ann's transaction 4 hangs on while client 2 stands");
    assert_eq!(notice(Busy), "ann's transaction 4 ends: client 2 did not free the base in time");
}
