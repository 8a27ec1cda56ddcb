//! The robot's latest poses.

use orienteer_runtime::{geometry::Pose, time::Time};

/// The robot's latest poses, to place readings that are older than the newest pose.
#[derive(Debug, Clone)]
pub struct PoseHistory {
    entries: [(Time, Pose); Self::LENGTH],
    /// Number of poses ever taken since the history was last emptied.
    taken: usize,
}

impl Default for PoseHistory {
    fn default() -> Self {
        Self { entries: [(Time::START, Pose::default()); Self::LENGTH], taken: 0 }
    }
}

impl PoseHistory {
    /// How many poses are kept: 3.2 s at 20 Hz, longer than the pass of any ring.
    pub const LENGTH: usize = 64;

    /// Takes the pose at a time. A pose older than the newest one means that time has started anew: all earlier poses are
    /// dropped. A second pose of the same time replaces the first.
    pub fn push(&mut self, stamp: Time, pose: Pose) {
        match self.newest() {
            Some((newest, _)) if stamp < newest => self.taken = 0,
            Some((newest, _)) if stamp == newest => self.taken -= 1,
            _ => {}
        }
        self.entries[self.taken % Self::LENGTH] = (stamp, pose);
        self.taken += 1;
    }

    /// The newest pose.
    #[must_use]
    pub fn newest(&self) -> Option<(Time, Pose)> {
        self.back(0)
    }

    /// The pose at a time, between two poses along the arc that joins them; the newest or the oldest pose beyond the ends.
    /// `None` while there are no poses.
    #[must_use]
    pub fn at(&self, time: Time) -> Option<Pose> {
        let (mut later, mut pose) = self.newest()?;
        for back in 1..Self::LENGTH {
            if time >= later {
                break;
            }
            let Some((earlier, before)) = self.back(back) else { break };
            if time >= earlier {
                let share = time.secs_since(earlier) / later.secs_since(earlier);
                return Some(if before == pose { pose } else { before.interpolate(pose, share) });
            }
            (later, pose) = (earlier, before);
        }
        Some(pose)
    }

    fn back(&self, steps: usize) -> Option<(Time, Pose)> {
        (steps < self.taken.min(Self::LENGTH)).then(|| self.entries[(self.taken - 1 - steps) % Self::LENGTH])
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn at(seconds: f64) -> Time {
        Time::from_secs_f64(seconds)
    }

    #[test]
    fn poses_between_two_are_on_the_arc() {
        let mut history = PoseHistory::default();
        assert_eq!(history.at(at(1.0)), None);
        for i in 0..200 {
            let t = f64::from(i) * 0.1;
            history.push(at(t), Pose::default().along_arc(t, 0.5 * t));
        }
        for t in [19.9, 19.85, 18.0, 14.02, 13.6001] {
            let want = Pose::default().along_arc(t, 0.5 * t);
            assert!(history.at(at(t)).unwrap().distance(&want) < 1e-6, "{t}");
        }
        assert_eq!(history.at(at(50.0)), history.at(at(19.9)));
        // the oldest of 64
        assert!(history.at(at(1.0)).unwrap().distance(&Pose::default().along_arc(13.6, 6.8)) < 1e-9);
    }

    #[test]
    fn time_may_start_anew() {
        let mut history = PoseHistory::default();
        history.push(at(5.0), Pose::new(1.0, 0.0, 0.0));
        history.push(at(5.0), Pose::new(2.0, 0.0, 0.0));
        assert_eq!(history.at(at(0.0)), Some(Pose::new(2.0, 0.0, 0.0)));
        history.push(at(1.0), Pose::new(3.0, 0.0, 0.0));
        assert_eq!(history.at(at(9.0)), Some(Pose::new(3.0, 0.0, 0.0)));
        assert_eq!(history.newest().unwrap().0, at(1.0));
    }
}
