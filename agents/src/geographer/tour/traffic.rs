//! Choosing where to go, and giving way to the other robots of the team.

use std::time::Duration;

use super::{Standing, Tour};
use crate::geographer::{compass::Quarter, map::Exit, team::Sign};

/// How often a robot that has to wait looks whether it still has to.
const PAUSE: Duration = Duration::from_millis(500);
/// Who has made way stays away for so long.
const COURTESY: Duration = Duration::from_secs(5);
/// Whoever waits for others to find something waits no longer than this.
const STALLED: Duration = Duration::from_secs(3600);
/// All robots hear of a claim within so many steps.
const HEARD: u32 = 20;

/// Where a robot goes next.
enum Plan {
    /// By this way out, to explore that one.
    Go(Exit, Exit),
    /// That robot is in the way.
    HeldUp(u32),
    /// Nowhere: others are at what is left.
    Wait,
    /// Nowhere: nothing is left.
    Idle,
}

/// Whether a robot makes way.
enum Aside {
    /// Nobody asks it to, or nobody else is in the way; it may be shut in all the same.
    Stay { is_shut_in: bool },
    /// By this way out.
    Go(Exit),
    /// It would, but that robot is in the way.
    HeldUp(u32),
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
            if let Plan::Go(exit, goal) = plan {
                if self.claim(exit, Some(goal)).await {
                    return Some(exit.1);
                }
            } else {
                let mut chart = self.chart.borrow_mut();
                chart.own.held_up_by = if let Plan::HeldUp(by) = plan { Some(by) } else { None };
                chart.own.is_idle = matches!(plan, Plan::Idle);
                if chart.own.is_idle && chart.team.is_through() {
                    return None;
                }
            }
            let has_time = matches!(plan, Plan::Idle | Plan::Wait);
            match self.way_aside(standing, has_time) {
                Aside::Go(exit) if self.claim(exit, None).await => {
                    self.has_made_way = true;
                    self.pilot.say("makes way");
                    return Some(exit.1);
                }
                Aside::HeldUp(by) => {
                    let own = &mut self.chart.borrow_mut().own;
                    (own.held_up_by, own.is_shut_in) = (Some(by), true);
                }
                Aside::Stay { is_shut_in } => self.chart.borrow_mut().own.is_shut_in = is_shut_in,
                Aside::Go(_) => {}
            }
            self.rest(PAUSE).await.ok();
        }
    }

    /// Nobody has found anything for so long that nobody will: somebody stands for good where there is no way round.
    fn is_stalled(&self) -> bool {
        self.pilot.now().since(self.chart.borrow().changed) > STALLED
    }

    fn plan(&self, standing: &Standing) -> Plan {
        let chart = self.chart.borrow();
        let (map, team, now) = (&chart.map, &chart.team, self.pilot.now());
        let (place, facing) = (standing.place, standing.facing);
        let is_taken = |exit: Exit| team.explores(exit).is_some();
        let is_free = |exit: Exit| !is_taken(exit) && team.in_the_way(map, exit, now).is_none();
        let ends = |route: &[Exit]| Some((*route.first()?, *route.last()?));
        let open = map.nearest_unexplored(place, facing, is_free, |corridor| team.is_in(map, corridor).is_none());
        if let Some((first, last)) = open.as_deref().and_then(ends) {
            return team.in_the_way(map, first, now).map_or(Plan::Go(first, last), Plan::HeldUp);
        }
        if map.nearest_unexplored(place, facing, |_| true, |_| true).is_none() {
            return Plan::Idle;
        }
        let blocked = map.nearest_unexplored(place, facing, |exit| !is_taken(exit), |_| true);
        let by = blocked.iter().flatten().find_map(|exit| team.in_the_way(map, *exit, now));
        by.map_or(Plan::Wait, Plan::HeldUp)
    }

    /// Says that the robot wants to go this way, and whether it may.
    async fn claim(&mut self, exit: Exit, goal: Option<Exit>) -> bool {
        let since = self.pilot.now();
        {
            let mut chart = self.chart.borrow_mut();
            let own = &mut chart.own;
            *own = Sign { way: Some(exit), goal, since, held_up_by: None, is_idle: false, is_shut_in: false, ..*own };
            if !chart.has_mates() {
                return true;
            }
        }
        for _ in 0..HEARD {
            self.pilot.next_step().await.ok();
            let mut chart = self.chart.borrow_mut();
            if chart.team.own().is_none_or(|own| own.since != since || own.way != Some(exit)) {
                continue;
            }
            let by = chart.team.in_the_way(&chart.map, exit, since);
            if by.is_none() {
                return true;
            }
            chart.own.held_up_by = by;
            break;
        }
        self.let_go();
        false
    }

    /// Wants to go nowhere any more.
    pub(super) fn let_go(&mut self) {
        let own = &mut self.chart.borrow_mut().own;
        (own.way, own.goal) = (None, None);
    }

    /// If somebody waits for the robot to go: the corridor by which it can, to the place that is farthest from them.
    fn way_aside(&self, standing: &Standing, has_time: bool) -> Aside {
        let chart = self.chart.borrow();
        let (map, team, now) = (&chart.map, &chart.team, self.pilot.now());
        let exits = Quarter::ALL.map(|arm| (standing.place, arm));
        let ways = exits.into_iter().filter_map(|exit| Some((exit, map.corridor(exit)?.1, team.in_the_way(map, exit, now))));
        let (free, held): (Vec<_>, Vec<_>) = ways.partition(|(.., by)| by.is_none());
        let is_shut_in = free.is_empty();
        let Some((asker, from)) = team.asks_to_go(has_time) else { return Aside::Stay { is_shut_in } };
        let distance = |place| map.place(place).map_or(0.0, |place| (place.at - from).norm());
        let farthest = free.into_iter().max_by(|a, b| distance(a.1.0).total_cmp(&distance(b.1.0)));
        // Whoever is there has to make way first.
        let by = held.into_iter().filter_map(|(.., by)| by).find(|by| *by != asker);
        farthest.map(|(exit, ..)| Aside::Go(exit)).or(by.map(Aside::HeldUp)).unwrap_or(Aside::Stay { is_shut_in })
    }

    /// Waits until nobody is at a place that the robot has left, or on the way there, and takes it back.
    pub(super) async fn regain(&mut self, standing: &Standing) {
        loop {
            {
                let mut chart = self.chart.borrow_mut();
                let by = chart.team.comes_to(&chart.map, standing.place);
                if chart.own.at == Some(standing.place) || by.is_none() {
                    chart.arrive_at(standing.place);
                    return;
                }
                // Who stands there with nothing to do makes way.
                chart.own.held_up_by = by;
            }
            self.rest(PAUSE).await.ok();
        }
    }

    /// The robot that is so near ahead that this one has to wait.
    pub(super) fn ahead(&self) -> Option<u32> {
        let chart = self.chart.borrow();
        let mut here = chart.in_map(self.here());
        if let Some(compass) = chart.map.known_compass() {
            here.heading = compass.heading(compass.nearest(here.heading));
        }
        chart.team.ahead(here)
    }

    /// Waits in a corridor until nobody is ahead any more. False if the two wait for each other, and this one has to turn back.
    pub(super) async fn wait_for_those_ahead(&mut self) -> bool {
        let mut may_go_on = true;
        while let Some(by) = self.ahead() {
            self.chart.borrow_mut().own.held_up_by = Some(by);
            self.rest(PAUSE).await.ok();
            if self.chart.borrow().team.has_to_turn_back(by) {
                may_go_on = false;
                break;
            }
        }
        self.chart.borrow_mut().own.held_up_by = None;
        may_go_on
    }
}
