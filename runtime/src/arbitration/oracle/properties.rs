//! What must hold of every history, whatever the rules in detail.

use super::{Breach, History, Outcome, Property, Step, run};
use crate::{
    geometry::{Limits, Twist},
    time::Time,
    topics::{ArbitrationRule, BaseClaim, BaseNotice, ClientId, MotionKind, NoticeKind},
};

/// What is known of a client from outside.
#[derive(Clone, Default)]
struct Seen {
    claim: BaseClaim,
    /// Its transaction was granted, or ended by the arbiter.
    granted: bool,
    over: bool,
}

impl Seen {
    fn live(&self, now: Time) -> bool {
        now < self.claim.valid_until
    }
}

/// Looks over the arbiter's shoulder from step to step.
pub fn watch(history: &History, outcomes: &[Outcome]) -> Result<(), Breach> {
    let mut seen = vec![Seen::default(); history.priorities.len()];
    let mut owner = (ClientId::NONE, 0);
    for (i, (step, outcome)) in history.steps.iter().zip(outcomes).enumerate() {
        for claim in &step.claims {
            if let Some(client) = seen.get_mut(usize::from(claim.client.0)).filter(|client| client.claim.stamp <= claim.stamp) {
                client.claim = *claim;
            }
        }
        // A number is judged as it stands when it is decided, not in between.
        for (client, before) in seen.iter_mut().zip(numbers_before(history, i)) {
            if client.claim.transaction != before {
                (client.granted, client.over) = (false, false);
            }
        }
        let at = |property: Property, rule: Result<(), String>| {
            rule.map_err(|what| Breach { property, what: format!("step {i}: {what}: {outcome:#?}") })
        };
        at(Property::Holder, holder_has_a_live_claim(&seen, step.now, outcome))?;
        at(Property::Limits, limits_never_raise(&seen, step.now, outcome))?;
        at(Property::ToldOnce, told_once(&seen, step.now, owner, outcome))?;
        at(Property::WaitsEnd, waits_end(&mut seen, step.now, outcome))?;
        owner = (outcome.decision.holder, outcome.decision.transaction);
    }
    Ok(())
}

/// The numbers that the clients' newest claims had before a step.
fn numbers_before(history: &History, step: usize) -> Vec<u32> {
    let mut newest = vec![(Time::START, 0); history.priorities.len()];
    for claim in history.steps[..step].iter().flat_map(|step| &step.claims) {
        if let Some(newest) = newest.get_mut(usize::from(claim.client.0)).filter(|newest| newest.0 <= claim.stamp) {
            *newest = (claim.stamp, claim.transaction);
        }
    }
    newest.into_iter().map(|(_, number)| number).collect()
}

fn holder_has_a_live_claim(seen: &[Seen], now: Time, Outcome { decision, .. }: &Outcome) -> Result<(), String> {
    let Some(holder) = decision.holder.known() else {
        let rests = decision.motion.kind() == MotionKind::Stop && decision.rule() == ArbitrationRule::NobodyAsked;
        return ensure(rests && decision.held_back().is_empty(), "something moves for nobody, or nobody wins");
    };
    let holds = &seen[usize::from(holder.0)];
    let claimed = holds.claim.transaction != 0 && holds.claim.transaction == decision.transaction;
    ensure(claimed && holds.live(now) && decision.valid_until == holds.claim.valid_until, "the holder has no live claim")?;
    ensure(decision.motion.kind() == holds.claim.motion.kind(), "the motion is not the holder's")
}

fn limits_never_raise(seen: &[Seen], now: Time, Outcome { decision, .. }: &Outcome) -> Result<(), String> {
    let bound = |bound: f64| if bound > 0.0 { bound } else { 0.0 };
    let live = || seen.iter().filter(|client| client.live(now)).map(|client| client.claim.limits);
    let allowed = |speed: f64, turn: f64| live().all(|limits| speed <= bound(limits.linear) && turn <= bound(limits.angular));
    let Limits { linear, angular } = decision.limits;
    ensure(allowed(linear, angular), "the limits are wider than one of them")?;
    let (limited, wanted) = (decision.limited_motion().kind(), decision.motion.kind());
    match (limited, wanted) {
        (MotionKind::Velocity(limited), MotionKind::Velocity(wanted)) => {
            let Twist { linear, angular } = limited;
            ensure(allowed(linear.abs(), angular.abs()), "a velocity is above a limit")?;
            let slower = |limited: f64, wanted: f64| limited.abs() <= wanted.abs() && limited * wanted >= 0.0;
            ensure(slower(linear, wanted.linear) && slower(angular, wanted.angular), "a limit raised or turned a velocity")
        }
        (MotionKind::Translate { distance, speed }, MotionKind::Translate { distance: asked, speed: most }) => {
            ensure(distance == asked && speed <= most && allowed(speed, 0.0), "a translation is not as limited")
        }
        (MotionKind::Rotate { angle, rate }, MotionKind::Rotate { angle: asked, rate: most }) => {
            ensure(angle == asked && rate <= most && allowed(0.0, rate), "a rotation is not as limited")
        }
        (MotionKind::Stop, MotionKind::Stop) => Ok(()),
        _ => Err("a limit made another motion".into()),
    }
}

fn told_once(seen: &[Seen], now: Time, before: (ClientId, u32), outcome: &Outcome) -> Result<(), String> {
    let Outcome { decision, notices } = outcome;
    let lost = before.0.known().filter(|owner| {
        let client = &seen[usize::from(owner.0)];
        before != (decision.holder, decision.transaction) && client.claim.transaction == before.1 && client.live(now)
    });
    let mut told = of_kind(notices, NoticeKind::Overridden);
    let right = told.next().map(|notice| (notice.client, notice.transaction, notice.by))
        == lost.map(|owner| (owner, before.1, decision.holder));
    ensure(right && told.next().is_none(), "the overridden owner, and nobody else, is to be told once")
}

fn waits_end(seen: &mut [Seen], now: Time, Outcome { decision, notices }: &Outcome) -> Result<(), String> {
    for notice in notices {
        let client = &mut seen[usize::from(notice.client.0)];
        let valid = match notice.kind() {
            NoticeKind::Granted => !std::mem::replace(&mut client.granted, true) || !client.over,
            NoticeKind::Overridden | NoticeKind::OverriderMoves => client.granted && !client.over,
            NoticeKind::Busy => std::mem::replace(&mut client.over, true) || (!client.granted && client.claim.wait_until <= now),
            NoticeKind::Lapsed => std::mem::replace(&mut client.over, true) || !client.live(now),
        };
        ensure(valid && notice.transaction == client.claim.transaction, "a notice that can't be")?;
    }
    for (i, client) in seen.iter().enumerate() {
        let waits = client.claim.transaction != 0 && client.live(now) && !client.granted && !client.over;
        ensure(!waits || now < client.claim.wait_until, "a wait goes on after its end")?;
        let named = decision.held_back().iter().any(|held_back| usize::from(held_back.client.0) == i);
        ensure(!waits || named, "a client waits without being named")?;
    }
    Ok(())
}

/// How many claims come in a step, or are lost, makes no difference: only the newest counts.
pub fn lost_claims_cost_nothing(history: &History, outcomes: &[Outcome]) -> Result<(), Breach> {
    let mut newest = vec![Time::START; history.priorities.len()];
    let mut sparse = history.clone();
    for step in &mut sparse.steps {
        let mut counts: Vec<Option<BaseClaim>> = vec![None; newest.len()];
        for claim in step.claims.drain(..) {
            let place = usize::from(claim.client.0);
            if place < newest.len() && claim.stamp >= newest[place] {
                (newest[place], counts[place]) = (claim.stamp, Some(claim));
            }
        }
        step.claims.extend(counts.into_iter().flatten());
    }
    ensure(run(&sparse) == outcomes, "claims that don't count made a difference")
        .map_err(|what| Breach { property: Property::LostClaims, what })
}

/// While a transaction is held, it makes no difference whether clients of lower priority ask at all.
pub fn lower_priorities_alter_nothing(history: &History, outcomes: &[Outcome]) -> Result<(), Breach> {
    let Some(least) = history.priorities.iter().copied().max() else { return Ok(()) };
    let mut without = history.clone();
    for Step { claims, .. } in &mut without.steps {
        for claim in claims {
            if history.priorities.get(usize::from(claim.client.0)).is_some_and(|priority| *priority < least) {
                claim.transaction = 0;
            }
        }
    }
    for (i, (with, without)) in outcomes.iter().zip(run(&without)).enumerate() {
        let output = |outcome: &Outcome| {
            let decision = &outcome.decision;
            let base = (decision.holder, decision.transaction, decision.motion, decision.since, decision.valid_until);
            (base, decision.limits, decision.limited_by, decision.turn_limited_by)
        };
        let priority = with.decision.holder.known().map(|holder| history.priorities[usize::from(holder.0)]);
        let same = if priority == Some(least) {
            output(with) == output(&without)
        } else {
            without.decision.holder == ClientId::NONE && with.decision.limits == without.decision.limits
        };
        ensure(same, "a lower priority altered the output")
            .map_err(|what| Breach { property: Property::LowerPriority, what: format!("step {i}: {what}") })?;
    }
    Ok(())
}

fn of_kind(notices: &[BaseNotice], kind: NoticeKind) -> impl Iterator<Item = &BaseNotice> {
    notices.iter().filter(move |notice| notice.kind() == kind)
}

fn ensure(holds: bool, what: &str) -> Result<(), String> {
    if holds { Ok(()) } else { Err(what.into()) }
}
