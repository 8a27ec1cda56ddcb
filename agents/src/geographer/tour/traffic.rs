//! Giving way to the other robots of the team.

use std::time::Duration;

use super::{Standing, Tour, choosing::PAUSE};
use crate::geographer::{compass::Quarter, map::Exit, team::Presence};

/// Whoever waits in a corridor for others to go on waits no longer than this: to name a place takes a few minutes.
const PATIENCE: Duration = Duration::from_secs(600);

/// Whether a robot makes way.
pub(super) enum Aside {
    /// Nobody asks it to; it may be shut in all the same.
    Stay { is_shut_in: bool },
    /// By this way out.
    Go(Exit),
    /// It would, but that robot is in the way.
    HeldUp(u32),
}

/// What comes of waiting for those ahead.
pub(super) enum Ahead {
    /// They have gone.
    Clear,
    /// They wait for the robot, which has to turn back.
    GiveWay,
    /// They stay where they are.
    Blocked,
}

impl Tour {
    /// If somebody waits for the robot to go: the corridor by which it can, to the place that is farthest from them.
    pub(super) fn way_aside(&self, standing: &Standing, has_time: bool) -> Aside {
        let chart = self.chart.borrow();
        let (map, team, now) = (&chart.map, &chart.team, self.pilot.now());
        let exits = Quarter::ALL.map(|arm| (standing.place, arm));
        let ways = exits.into_iter().filter_map(|exit| Some((exit, map.corridor(exit)?.1, team.in_the_way(map, exit, now))));
        let (free, held): (Vec<_>, Vec<_>) = ways.partition(|(.., by)| by.is_none());
        let is_shut_in = free.is_empty();
        let Some((asker, from)) = team.asks_to_go(has_time) else { return Aside::Stay { is_shut_in } };
        let distance = |place| map.place(place).map_or(0.0, |place| (place.at - from).norm());
        let farthest = free.into_iter().max_by(|a, b| distance(a.1.0).total_cmp(&distance(b.1.0)));
        // Whoever is there has to make way first; if nobody else is, whoever asks.
        let by = held.into_iter().filter_map(|(.., by)| by).find(|by| *by != asker);
        farthest.map_or(Aside::HeldUp(by.unwrap_or(asker)), |(exit, ..)| Aside::Go(exit))
    }

    /// Waits until nobody is at a place that the robot has left, or on the way there, and takes it back. False if they stay.
    pub(super) async fn regain(&mut self, standing: &Standing) -> bool {
        let began = self.pilot.now();
        loop {
            let by = {
                let chart = self.chart.borrow();
                let others = chart.team.comes_to(&chart.map, standing.place);
                others.filter(|_| chart.own.at != Some(standing.place)).map(|by| (by, chart.team.stands_by(by)))
            };
            match by {
                None => {
                    self.chart.borrow_mut().arrive_at(standing.place);
                    return true;
                }
                Some((_, true)) => return false,
                Some(_) if self.pilot.now().since(began) > PATIENCE => return false,
                // Between two places there is nowhere else to go: they have to make way, whoever comes first.
                Some((by, false)) => self.present(|own| Presence { held_up_by: Some(by), is_shut_in: true, ..own }),
            }
            self.rest(PAUSE).await.ok();
        }
    }

    /// The robot that is so near ahead that this one has to wait.
    pub(super) fn ahead(&self) -> Option<u32> {
        let chart = self.chart.borrow();
        let mut here = chart.in_map(self.here());
        if let Some(compass) = chart.map.compass() {
            here.heading = compass.heading(compass.nearest(here.heading));
        }
        chart.team.ahead(here)
    }

    /// Waits in a corridor until nobody is ahead any more.
    pub(super) async fn wait_for_those_ahead(&mut self) -> Ahead {
        let began = self.pilot.now();
        let waited = loop {
            let Some(by) = self.ahead() else { break Ahead::Clear };
            self.present(|own| Presence { held_up_by: Some(by), ..own });
            self.rest(PAUSE).await.ok();
            let chart = self.chart.borrow();
            if chart.team.stands_by(by) {
                break Ahead::Blocked;
            }
            if chart.team.has_to_turn_back(by) || self.pilot.now().since(began) > PATIENCE {
                break Ahead::GiveWay;
            }
        };
        self.present(|own| Presence { held_up_by: None, ..own });
        waited
    }
}
