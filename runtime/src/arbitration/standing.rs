//! Who goes before whom, and by which rule.

use std::cmp::Reverse;

use crate::topics::{ArbitrationRule, ClientId};

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
/// use orienteer_runtime::topics::{ArbitrationRule, ClientId};
///
/// let follower = Standing { client: ClientId(0), priority: 5, arrival: 1, granted: true };
/// let avoidance = Standing { client: ClientId(1), priority: 10, arrival: 7, granted: false };
/// let mut line = [follower, avoidance];
/// rank(&mut line);
/// assert_eq!(line, [avoidance, follower]);
/// assert_eq!((rule(&line, 0), rule(&line, 1)), (ArbitrationRule::HigherPriority, ArbitrationRule::HangingOn));
/// ```
#[must_use]
pub fn rule(ranked: &[Standing], place: usize) -> ArbitrationRule {
    let (Some(first), Some(this)) = (ranked.first(), ranked.get(place)) else { return ArbitrationRule::NobodyAsked };
    if place > 0 {
        return match this {
            Standing { granted: true, .. } => ArbitrationRule::HangingOn,
            Standing { priority, .. } if *priority < first.priority => ArbitrationRule::LowerPriority,
            _ => ArbitrationRule::Queued,
        };
    }
    match ranked.get(1) {
        None => ArbitrationRule::OnlyClaim,
        Some(second) if second.priority < first.priority => ArbitrationRule::HigherPriority,
        Some(_) if first.granted => ArbitrationRule::HeldFirst,
        Some(_) => ArbitrationRule::AskedFirst,
    }
}
