//! Who goes before whom, and by which rule.

use std::cmp::Reverse;

use crate::topics::{BaseRule, ClientId};

/// How a client that wants the base (or the sonar) stands when a decision is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Standing {
    /// Who.
    pub client: ClientId,
    /// Larger wins.
    pub priority: u8,
    /// Number of the decision at which its transaction was first seen.
    pub arrival: u64,
    /// It was granted before this decision: it is the owner, or an overridden owner that hangs on. Explains, never decides.
    pub granted: bool,
}

impl Standing {
    /// Orders clients: the first in line has the base.
    #[must_use]
    pub fn precedence(&self) -> (Reverse<u8>, u64, ClientId) {
        (Reverse(self.priority), self.arrival, self.client)
    }
}

/// Puts clients in line: priority, then arrival, then order in the configuration. The first has the base, the others are
/// held back.
pub fn rank(standings: &mut [Standing]) {
    standings.sort_unstable_by_key(Standing::precedence);
}

/// Why the client at `place` of a ranked line has the base (place 0) or is held back (other places).
///
/// ```
/// use orienteer_runtime::arbitration::{Standing, rank, rule};
/// use orienteer_runtime::topics::{BaseRule, ClientId};
///
/// let follower = Standing { client: ClientId(0), priority: 5, arrival: 1, granted: true };
/// let avoidance = Standing { client: ClientId(1), priority: 10, arrival: 7, granted: false };
/// let mut line = [follower, avoidance];
/// rank(&mut line);
/// assert_eq!(line, [avoidance, follower]);
/// assert_eq!((rule(&line, 0), rule(&line, 1)), (BaseRule::HigherPriority, BaseRule::HangingOn));
/// ```
#[must_use]
pub fn rule(ranked: &[Standing], place: usize) -> BaseRule {
    let (Some(first), Some(this)) = (ranked.first(), ranked.get(place)) else { return BaseRule::NobodyAsked };
    if place > 0 {
        return match this {
            Standing { granted: true, .. } => BaseRule::HangingOn,
            Standing { priority, .. } if *priority < first.priority => BaseRule::LowerPriority,
            _ => BaseRule::Queued,
        };
    }
    match ranked.get(1) {
        None => BaseRule::OnlyClaim,
        Some(second) if second.priority < first.priority => BaseRule::HigherPriority,
        Some(_) if first.granted => BaseRule::HeldFirst,
        Some(_) => BaseRule::AskedFirst,
    }
}
