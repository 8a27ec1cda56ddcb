#![allow(clippy::unwrap_used)]

use std::time::Duration;

use orienteer_runtime::{geometry::Limits, topics::Echo};

use super::{super::corridor_filter::fixtures, *};

/// A follower in a straight corridor without an end, stepped at 20 Hz.
struct Walk {
    follower: Follower,
    now: Time,
    pose: Pose,
    seq: u64,
    /// Whether somebody else keeps the base from moving.
    held: bool,
}

impl Walk {
    fn new() -> Self {
        let limits = Limits { linear: 1.0, angular: 1.0 };
        let platform = Platform {
            name: "test".into(),
            radius: 0.3,
            limits,
            acceleration: 2.0,
            angular_acceleration: 3.0,
            turning_radius: 0.0,
        };
        let config = CorridorFollowerConfig::default();
        let mut follower = Follower::new(config, Arc::new(fixtures::ring()), Arc::new(platform)).unwrap();
        follower.begin();
        Self { follower, now: Time::START, pose: Pose::default(), seq: 0, held: false }
    }

    fn step(&mut self) -> Wish {
        let twist = match self.follower.wish(self.now) {
            Wish::Drive(twist) if !self.held => twist,
            Wish::Report { opening, width, ahead, length } => return Wish::Report { opening, width, ahead, length },
            _ => Twist::STOP,
        };
        self.now = self.now + Duration::from_millis(50);
        self.seq += 1;
        self.pose = self.pose.after(twist, 0.05);
        self.follower.moved(&Odometry { stamp: self.now, pose: self.pose, twist, ..Odometry::default() });
        let hear = |transducer| fixtures::range(transducer, self.pose.y, self.pose.heading, 1.5);
        let echoes: Vec<Echo> = fixtures::ring().transducers.iter().map(hear).collect();
        self.follower.heard(&SonarScan::from_echoes(self.now, self.seq, &echoes));
        Wish::Drive(twist)
    }

    fn steps(&mut self, seconds: f64) -> Wish {
        let mut last = Wish::Nothing;
        for _ in 0..(seconds * 20.0) as u32 {
            last = self.step();
            if matches!(last, Wish::Report { .. }) {
                break;
            }
        }
        last
    }
}

#[test]
fn who_is_kept_from_going_on_for_too_long_turns_back() {
    let mut walk = Walk::new();
    assert!(matches!(walk.steps(5.0), Wish::Drive(twist) if twist.linear > 0.1));
    // Somebody stands where the front sonar does not look, and the base will not go on.
    walk.held = true;
    assert!(matches!(walk.steps(14.5), Wish::Drive(_)), "patience is 5 s, three times that if nothing is seen ahead");
    assert!(matches!(walk.steps(1.0), Wish::Report { opening: Opening::DeadEnd, .. }));
}

#[test]
fn time_under_an_override_is_no_waiting() {
    let mut walk = Walk::new();
    walk.steps(5.0);
    walk.held = true;
    for _ in 0..4 {
        walk.steps(5.0);
        walk.follower.overridden();
    }
    walk.held = false;
    assert!(matches!(walk.steps(4.0), Wish::Drive(twist) if twist.linear > 0.1));
}
