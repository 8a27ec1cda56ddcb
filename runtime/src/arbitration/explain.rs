//! Decisions as sentences for people.
//!
//! The same words whether asked live or of a recording: they depend on the decision and on the table of clients only.

use std::{
    f64::consts::PI,
    fmt::{self, Display, Formatter},
};

use crate::{
    arbitration::Clients,
    time::Time,
    topics::{ArbitrationRule, BaseDecision, BaseNotice, ClientId, HeldBack, Motion, MotionKind, NoticeKind, SonarDecision},
};

/// Says who has the base, why, who is held back, and what limits are in force.
///
/// ```
/// use orienteer_runtime::arbitration::{Clients, explain};
/// use orienteer_runtime::geometry::Twist;
/// use orienteer_runtime::time::Time;
/// use orienteer_runtime::topics::{BaseDecision, ArbitrationRule, ClientId, HeldBack, Motion};
///
/// let clients: Clients = [("corridor-follower", 5), ("avoidance", 10)].into_iter().collect();
/// let mut decision = BaseDecision::default().because(ArbitrationRule::HigherPriority);
/// decision.holder = ClientId(1);
/// decision.since = Time::from_secs_f64(12.35);
/// decision.motion = Motion::velocity(Twist::new(-0.1, 0.0));
/// decision.limits.linear = 0.15;
/// decision.limited_by = ClientId(1);
/// decision.hold_back(HeldBack::new(ClientId(0), ArbitrationRule::HangingOn));
/// assert_eq!(
///     explain::base(&decision, &clients).to_string(),
///     "avoidance has the base since 12.35 s: higher priority (10) than corridor-follower (5), which hangs on; \
///      it drives at -0.10 m/s; speed limited to 0.15 m/s by avoidance"
/// );
/// ```
#[must_use]
pub fn base<'a>(decision: &'a BaseDecision, clients: &'a Clients) -> impl Display + 'a {
    fmt::from_fn(move |f| {
        let who = Who { clients, thing: "the base" };
        who.has_it(f, decision.holder, decision.since, decision.rule(), decision.held_back())?;
        if decision.holder != ClientId::NONE {
            write!(f, "; it {}", Order(&decision.motion))?;
        }
        if decision.limited_by != ClientId::NONE {
            write!(f, "; speed limited to {:.2} m/s by {}", decision.limits.linear, who.name(decision.limited_by))?;
        }
        if decision.turn_limited_by != ClientId::NONE {
            let rate = degrees(decision.limits.angular);
            write!(f, "; turn rate limited to {rate:.1} deg/s by {}", who.name(decision.turn_limited_by))?;
        }
        Ok(())
    })
}

/// Says whose firing program runs, why, who is held back, and what the safety floor adds.
#[must_use]
pub fn sonar<'a>(decision: &'a SonarDecision, clients: &'a Clients) -> impl Display + 'a {
    fmt::from_fn(move |f| {
        let who = Who { clients, thing: "the sonar" };
        who.has_it(f, decision.holder, decision.since, decision.rule(), decision.held_back())?;
        if decision.holder == ClientId::NONE {
            write!(f, "; the ring's own program runs")?;
        }
        if decision.floor != 0 {
            write!(f, "; the safety floor adds firings of ")?;
            list(f, (0..32).filter(|bit| decision.floor & (1 << bit) != 0), " and ", |f, bit| write!(f, "{bit}"))?;
        }
        Ok(())
    })
}

/// Says what happened to a client's transaction.
#[must_use]
pub fn notice<'a>(notice: &'a BaseNotice, clients: &'a Clients) -> impl Display + 'a {
    fmt::from_fn(move |f| {
        let who = Who { clients, thing: "the base" };
        let (client, by) = (who.name(notice.client), who.name(notice.by));
        write!(f, "{client}'s transaction {} ", notice.transaction)?;
        match notice.kind() {
            NoticeKind::Granted => write!(f, "has the base"),
            NoticeKind::Overridden => write!(f, "is overridden by {by}"),
            NoticeKind::OverriderMoves => write!(f, "hangs on while {by} {}", Order(&notice.motion)),
            NoticeKind::Busy => write!(f, "ends: {by} did not free the base in time"),
            NoticeKind::Lapsed => write!(f, "ends: its claim was not renewed in time"),
        }
    })
}

/// Turns ids into names for one of the two things that are arbitrated.
struct Who<'a> {
    clients: &'a Clients,
    thing: &'static str,
}

impl Who<'_> {
    fn name(&self, id: ClientId) -> impl Display {
        fmt::from_fn(move |f| match (self.clients.get(id), id.known()) {
            (Some(client), _) => f.write_str(&client.name),
            (None, Some(ClientId(number))) => write!(f, "client {number}"),
            (None, None) => f.write_str("nobody"),
        })
    }

    fn priority(&self, id: ClientId) -> u8 {
        self.clients.get(id).map_or(0, |client| client.priority)
    }

    fn has_it(
        &self,
        f: &mut Formatter,
        holder: ClientId,
        since: Time,
        rule: ArbitrationRule,
        held_back: &[HeldBack],
    ) -> fmt::Result {
        let thing = self.thing;
        if holder == ClientId::NONE {
            return write!(f, "nobody has asked for {thing}");
        }
        write!(f, "{} has {thing} since {:.2} s: ", self.name(holder), since.as_secs_f64())?;
        let priority = self.priority(holder);
        match rule {
            ArbitrationRule::OnlyClaim => write!(f, "nobody else wants it")?,
            ArbitrationRule::HigherPriority => write!(f, "higher priority ({priority}) than ")?,
            ArbitrationRule::HeldFirst => write!(f, "at equal priority ({priority}) it keeps what it had, before ")?,
            ArbitrationRule::AskedFirst => write!(f, "at equal priority ({priority}) it asked first, before ")?,
            // Not rules by which anybody gets anything; a decision that was tampered with.
            ArbitrationRule::NobodyAsked
            | ArbitrationRule::LowerPriority
            | ArbitrationRule::HangingOn
            | ArbitrationRule::Queued => {
                write!(f, "for no reason that it could have, before ")?;
            }
        }
        list(f, held_back.iter(), ", and ", |f, other| self.held_back(f, other))
    }

    fn held_back(&self, f: &mut Formatter, other: &HeldBack) -> fmt::Result {
        let state = match other.rule() {
            ArbitrationRule::HangingOn => "which hangs on",
            ArbitrationRule::Queued => "which is queued",
            _ => "which waits",
        };
        write!(f, "{} ({}), {state}", self.name(other.client), self.priority(other.client))
    }
}

/// A motion, as what somebody does.
struct Order<'a>(&'a Motion);

impl Display for Order<'_> {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self.0.kind() {
            MotionKind::Stop => write!(f, "stands"),
            MotionKind::Velocity(twist) if twist.is_stop() => write!(f, "stands"),
            MotionKind::Velocity(twist) if twist.angular == 0.0 => write!(f, "drives at {:.2} m/s", twist.linear),
            MotionKind::Velocity(twist) if twist.linear == 0.0 => write!(f, "turns at {:.1} deg/s", degrees(twist.angular)),
            MotionKind::Velocity(twist) => {
                write!(f, "drives at {:.2} m/s and turns at {:.1} deg/s", twist.linear, degrees(twist.angular))
            }
            MotionKind::Translate { distance, speed } => write!(f, "moves {distance:.2} m at up to {speed:.2} m/s"),
            MotionKind::Rotate { angle, rate } => {
                write!(f, "turns by {:.1} deg at up to {:.1} deg/s", degrees(angle), degrees(rate))
            }
        }
    }
}

/// Writes items with commas between them, but `and` before the last.
fn list<T>(
    f: &mut Formatter,
    items: impl Iterator<Item = T>,
    and: &str,
    write_item: impl Fn(&mut Formatter, T) -> fmt::Result,
) -> fmt::Result {
    let mut items = items.enumerate().peekable();
    while let Some((i, item)) = items.next() {
        if i > 0 {
            f.write_str(if items.peek().is_some() { ", " } else { and })?;
        }
        write_item(f, item)?;
    }
    Ok(())
}

fn degrees(radians: f64) -> f64 {
    radians * 180.0 / PI
}
