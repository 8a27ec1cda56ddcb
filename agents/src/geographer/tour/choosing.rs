//! Choosing where to go next.

use std::time::Duration;

use super::{HEARD, Standing, Tour, traffic::Aside};
use crate::geographer::{
    compass::Quarter,
    map::{Corridor, Exit, Route},
    team::Presence,
};

/// How often a robot that has to wait looks whether it still has to.
pub(super) const PAUSE: Duration = Duration::from_millis(500);
/// Who has made way stays away for so long.
const COURTESY: Duration = Duration::from_secs(5);
/// Whoever waits for others to find something waits no longer than this.
const STALLED: Duration = Duration::from_secs(3600);

/// Where a robot goes next.
enum Plan {
    /// By the way out `first`, to explore `goal`.
    Go { first: Exit, goal: Exit },
    /// That robot is in the way.
    HeldUp(u32),
    /// Nowhere: others are at what is left.
    Wait,
    /// Nowhere: nothing is left, or nothing that can be reached.
    Idle,
}

impl Tour {
    /// Waits until there is something to explore and nobody keeps the robot from going there. Makes way for others meanwhile. `None` when the whole floor
    /// is explored.
    pub(super) async fn choose(&mut self, standing: &Standing) -> Option<Quarter> {
        if std::mem::take(&mut self.has_made_way) {
            self.rest(COURTESY).await.ok();
        }
        loop {
            let plan = match self.plan(standing) {
                Plan::HeldUp(_) | Plan::Wait if self.is_stalled() => Plan::Idle,
                plan => plan,
            };
            if let Plan::Go { first, goal } = plan
                && self.claim(first, Some(goal)).await
            {
                return Some(first.1);
            }
            self.present(|own| match plan {
                // Whoever was quicker is in the way.
                Plan::Go { .. } => own,
                Plan::HeldUp(by) => Presence { held_up_by: Some(by), is_idle: false, ..own },
                Plan::Wait | Plan::Idle => Presence { held_up_by: None, is_idle: matches!(plan, Plan::Idle), ..own },
            });
            if self.is_done() {
                return None;
            }
            match self.way_aside(standing, matches!(plan, Plan::Idle | Plan::Wait)) {
                Aside::Go(exit) if self.claim(exit, None).await => {
                    self.has_made_way = true;
                    self.pilot.say("makes way");
                    return Some(exit.1);
                }
                Aside::Go(_) => {}
                Aside::HeldUp(by) => self.present(|own| Presence { held_up_by: Some(by), is_shut_in: true, ..own }),
                Aside::Stay { is_shut_in } => self.present(|own| Presence { is_shut_in, ..own }),
            }
            self.rest(PAUSE).await.ok();
        }
    }

    /// True if neither this robot nor any other has anything left to explore, or this one no part in it.
    fn is_done(&self) -> bool {
        let chart = self.chart.borrow();
        chart.own.stands_by || (chart.own.is_idle && chart.team.is_through())
    }

    /// Nobody has found anything for so long that nobody will: somebody stands for good where there is no way round.
    fn is_stalled(&self) -> bool {
        self.pilot.now().since(self.chart.borrow().changed) > STALLED
    }

    fn plan(&self, standing: &Standing) -> Plan {
        let chart = self.chart.borrow();
        let (map, team, now) = (&chart.map, &chart.team, self.pilot.now());
        let stays = |by: &u32| team.stands_by(*by);
        let in_the_way = |exit: Exit| team.in_the_way(map, exit, now);
        let is_taken = |exit: Exit| team.explores(exit).is_some();
        // Whoever is in the way now may go on, unless they explore no more.
        let can_be_had = |exit: Exit| !in_the_way(exit).as_ref().is_some_and(stays);
        let can_be_gone = |corridor: &Corridor| !team.is_in(map, corridor).as_ref().is_some_and(stays);
        let nearest = |free: &dyn Fn(Exit) -> bool, passable: &dyn Fn(&Corridor) -> bool| -> Option<Route> {
            map.nearest_unexplored(standing.place, standing.facing, free, passable)
        };
        let open =
            nearest(&|exit| !is_taken(exit) && in_the_way(exit).is_none(), &|corridor| team.is_in(map, corridor).is_none());
        if let Some((first, goal)) = open.and_then(|route| Some((*route.first()?, *route.last()?))) {
            return in_the_way(first).map_or(Plan::Go { first, goal }, Plan::HeldUp);
        }
        if nearest(&can_be_had, &can_be_gone).is_none() {
            return Plan::Idle;
        }
        let blocked = nearest(&|exit| !is_taken(exit) && can_be_had(exit), &can_be_gone);
        blocked.into_iter().flatten().find_map(in_the_way).map_or(Plan::Wait, Plan::HeldUp)
    }

    /// Says that the robot wants to go this way, and whether it may.
    async fn claim(&mut self, exit: Exit, goal: Option<Exit>) -> bool {
        let since = self.pilot.now();
        self.present(|own| own.wants(exit, goal, since));
        if !self.chart.borrow().has_mates() {
            return true;
        }
        let mut by = None;
        for _ in 0..HEARD {
            self.pilot.next_step().await.ok();
            let chart = self.chart.borrow();
            // Whoever wanted it at the same time has said so in the same step.
            if chart.team.own().is_some_and(|own| own.since == since && own.way == Some(exit)) {
                by = chart.team.in_the_way(&chart.map, exit, since);
                if by.is_none() {
                    return true;
                }
                break;
            }
        }
        self.present(|own| Presence { held_up_by: by, ..own.lets_go() });
        false
    }

    /// Says something else of itself from now on.
    pub(super) fn present(&self, change: impl FnOnce(Presence) -> Presence) {
        let own = &mut self.chart.borrow_mut().own;
        *own = change(*own);
    }
}
