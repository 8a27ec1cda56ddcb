//! Scripts against the real arbiter and a base that does as it is told, without any actor.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::{
    cell::RefCell,
    f64::consts::{FRAC_PI_2, PI},
    rc::Rc,
    time::Duration,
};

use orienteer_runtime::{
    agent::{Aborted, Inputs, Outputs, Script, Strategy, Wiring},
    arbitration::{Clients, base::BaseArbiter},
    geometry::{Limits, Pose, Twist},
    time::Time,
    topics::{BaseClaim, ClientId, Motion, MotionKind, MotionReport, MotionState, PoseEstimate},
};

const PERIOD: Duration = Duration::from_millis(50);

/// A script, the arbiter, somebody more important, and a base that completes each motion in a few steps.
struct Bench {
    script: Script,
    inputs: Inputs,
    out: Outputs,
    arbiter: BaseArbiter,
    now: Time,
    pose: Pose,
    motion: Motion,
    left: u32,
    /// What the boss claims in each step.
    boss: BaseClaim,
    said: Vec<Motion>,
    /// The body touches something: ahead if positive, behind if negative. The base goes away from it, and nowhere else; nowhere at
    /// all if that is no number.
    touches: f64,
}

const STEPS_PER_MOTION: u32 = 5;

impl Bench {
    fn new(wiring: &Wiring, script: Script) -> Self {
        let clients: Clients = [("script", 5), ("boss", 9)].into_iter().collect();
        Self {
            script,
            inputs: Inputs::offline(wiring),
            out: Outputs::offline(wiring),
            arbiter: BaseArbiter::new(&clients),
            now: Time::START,
            pose: Pose::default(),
            motion: Motion::STOP,
            left: 0,
            boss: BaseClaim { client: ClientId(1), ..BaseClaim::default() },
            said: Vec::new(),
            touches: 0.0,
        }
    }

    fn step(&mut self) -> Option<Result<(), Aborted>> {
        self.now = self.now + PERIOD;
        self.inputs.settle();
        self.inputs.put(PoseEstimate { stamp: self.now, pose: self.pose, ..PoseEstimate::default() });
        let end = self.script.step(self.now, &self.inputs, &mut self.out);
        self.arbiter.claim(&self.out.base.claim(self.now, 3 * PERIOD));
        let lease = self.now + 3 * PERIOD;
        self.arbiter.claim(&BaseClaim { stamp: self.now, valid_until: lease, wait_until: Time::FAR, ..self.boss });
        let mut notices = Vec::new();
        let decision = self.arbiter.decide(self.now, &mut notices);
        let report = self.execute(decision.motion);
        self.out.base.hear(&notices, Some(&decision), Some(&report));
        self.out.settle();
        end
    }

    fn execute(&mut self, motion: Motion) -> MotionReport {
        if motion != self.motion {
            self.motion = motion;
            self.left = STEPS_PER_MOTION;
            self.said.push(motion);
        }
        self.left = self.left.saturating_sub(1);
        let is_held = match motion.kind() {
            MotionKind::Translate { distance, .. } => self.touches.is_nan() || distance * self.touches > 0.0,
            MotionKind::Rotate { .. } => self.touches != 0.0,
            MotionKind::Stop | MotionKind::Velocity(_) => false,
        };
        if is_held {
            return MotionReport::new(self.now, motion.id, MotionState::Blocked, 0.0);
        }
        let state = if self.left == 0 { MotionState::Done } else { MotionState::Running };
        if self.left == 1 {
            match motion.kind() {
                MotionKind::Translate { distance, .. } => (self.pose, self.touches) = (self.pose.along_arc(distance, 0.0), 0.0),
                MotionKind::Rotate { angle, .. } => self.pose = self.pose.along_arc(0.0, angle),
                MotionKind::Stop | MotionKind::Velocity(_) => {}
            }
        }
        MotionReport::new(self.now, motion.id, state, 0.0)
    }

    fn run(&mut self) -> Result<(), Aborted> {
        (0..500).find_map(|_| self.step()).expect("the script ends")
    }
}

fn wiring() -> Wiring {
    let mut wiring = Wiring::default();
    wiring.reads::<PoseEstimate>();
    wiring
}

#[test]
fn a_square_brings_the_robot_back() {
    let script = Script::new(&wiring(), |pilot| async move {
        for _ in 0..4 {
            pilot.translate(1.0, 0.2).await?;
            pilot.rotate(FRAC_PI_2, 0.5).await?;
        }
        Ok(())
    });
    let mut bench = Bench::new(&wiring(), script);
    assert_eq!(bench.run(), Ok(()));
    assert!(bench.pose.distance(&Pose::default()) < 1e-9);
    assert!(bench.now >= Time::START + PERIOD * 8 * (STEPS_PER_MOTION - 1), "each motion took its time");
}

#[test]
fn a_higher_priority_comes_out_of_the_question_mark_and_the_base_is_free_afterwards() {
    let script = Script::new(&wiring(), |pilot| async move { pilot.translate(1.0, 0.2).await });
    let mut bench = Bench::new(&wiring(), script);
    assert!(bench.step().is_none() && bench.step().is_none());
    bench.boss.transaction = 1;
    assert_eq!(bench.run(), Err(Aborted::Overridden { by: ClientId(1) }));
    bench.boss.transaction = 0;
    bench.step();
    assert_eq!(bench.motion, Motion::STOP, "nobody wants the base any more");
}

#[test]
fn a_script_may_catch_the_abort_and_try_again() {
    let tries = Rc::new(RefCell::new(0));
    let counter = tries.clone();
    let script = Script::new(&wiring(), |pilot| async move {
        loop {
            *counter.borrow_mut() += 1;
            match pilot.translate(1.0, 0.2).await {
                Ok(()) => return Ok(()),
                Err(_) => {
                    pilot.release();
                    pilot.sleep(Duration::from_millis(300)).await?;
                }
            }
        }
    });
    let mut bench = Bench::new(&wiring(), script);
    bench.step();
    bench.boss.transaction = 1;
    bench.step();
    bench.step();
    bench.boss.transaction = 0;
    assert_eq!(bench.run(), Ok(()));
    assert_eq!(*tries.borrow(), 2);
    assert!((bench.pose.x - 1.0).abs() < 1e-9, "only the second try got there");
}

#[test]
fn a_velocity_is_kept_until_something_else_is_ordered() {
    let script = Script::new(&wiring(), |pilot| async move {
        pilot.drive(Twist::new(0.3, 0.1));
        pilot.sleep(Duration::from_secs(1)).await?;
        pilot.stop();
        pilot.sleep(Duration::from_millis(200)).await
    });
    let mut bench = Bench::new(&wiring(), script);
    for _ in 0..15 {
        assert!(bench.step().is_none());
        assert_eq!(bench.motion, Motion::velocity(Twist::new(0.3, 0.1)));
    }
    assert_eq!(bench.run(), Ok(()));
    assert_eq!(bench.said.len(), 2, "one velocity, one stop");
}

#[test]
fn a_condition_may_use_the_pilot() {
    let script = Script::new(&wiring(), |pilot| async move {
        let mut looks = 0;
        pilot
            .until(|inputs| {
                looks += 1;
                assert_eq!(inputs.latest::<PoseEstimate>().copied(), pilot.latest::<PoseEstimate>());
                pilot.say(format!("look {looks}"));
                pilot.drive(Twist::new(0.1 * f64::from(looks), 0.0));
                pilot.limit(Limits { linear: 0.5, angular: 0.5 });
                looks == 3
            })
            .await?;
        pilot.stop();
        pilot.next_step().await
    });
    let mut bench = Bench::new(&wiring(), script);
    assert_eq!(bench.run(), Ok(()));
    assert_eq!(bench.said[..2], [0.1, 0.2].map(|speed| Motion::velocity(Twist::new(speed, 0.0))));
}

#[test]
fn move_to_ends_at_the_saved_pose_by_every_strategy() {
    let goal = Pose::new(-1.0, 2.0, 0.7);
    for (strategy, motions) in [(Strategy::Straight, 3), (Strategy::SidewaysFirst, 5), (Strategy::ForwardFirst, 5)] {
        let script = Script::new(&wiring(), move |pilot| async move {
            let handle = pilot.save_pose(goal).ok_or(Aborted::TimedOut)?;
            pilot.move_to(handle, strategy, 0.2, 0.5).await
        });
        let mut bench = Bench::new(&wiring(), script);
        assert_eq!(bench.run(), Ok(()), "{strategy:?}");
        assert!(bench.pose.distance(&goal) < 0.011, "{strategy:?}: {:?}", bench.pose);
        assert!((bench.pose.heading - 0.7).abs() < 0.006);
        let moves = bench.said.iter().filter(|motion| motion.id != 0).count();
        assert!(moves <= motions, "{strategy:?} took {moves} motions");
    }
}

#[test]
fn strategies_are_named_after_the_way_they_go_first() {
    for (strategy, corner) in [(Strategy::SidewaysFirst, (0.0, 2.0)), (Strategy::ForwardFirst, (1.0, 0.0))] {
        let script = Script::new(&wiring(), move |pilot| async move {
            let handle = pilot.save_pose(Pose::new(1.0, 2.0, 0.0)).ok_or(Aborted::TimedOut)?;
            pilot.move_to(handle, strategy, 0.2, 0.5).await
        });
        let mut bench = Bench::new(&wiring(), script);
        let passed = (0..500).any(|_| {
            bench.step();
            bench.pose.distance(&Pose::new(corner.0, corner.1, 0.0)) < 1e-6
        });
        assert!(passed, "{strategy:?} does not pass {corner:?}");
    }
}

#[test]
fn a_goal_behind_is_reached_in_reverse() {
    let script = Script::new(&wiring(), |pilot| async move {
        let handle = pilot.save_pose(Pose::new(-0.5, 0.05, 0.0)).ok_or(Aborted::TimedOut)?;
        pilot.move_to(handle, Strategy::Straight, 0.2, 0.5).await
    });
    let mut bench = Bench::new(&wiring(), script);
    assert_eq!(bench.run(), Ok(()));
    let turned: f64 = bench
        .said
        .iter()
        .map(|motion| match motion.kind() {
            MotionKind::Rotate { angle, .. } => angle.abs(),
            _ => 0.0,
        })
        .sum();
    assert!(turned < 0.25 * PI, "turned by {turned}");
}

#[test]
fn who_touches_something_gets_away_from_it_and_turns_then() {
    for touches in [1.0, -1.0] {
        let script = Script::new(&wiring(), |pilot| async move { pilot.rotate(FRAC_PI_2, 0.5).await });
        let mut bench = Bench { touches, ..Bench::new(&wiring(), script) };
        assert_eq!(bench.run(), Ok(()));
        assert!((bench.pose.heading - FRAC_PI_2).abs() < 1e-9 && bench.pose.x * touches < 0.0, "{:?}", bench.pose);
    }
}

#[test]
fn who_can_get_away_in_no_direction_says_so() {
    let script = Script::new(&wiring(), |pilot| async move { pilot.rotate(FRAC_PI_2, 0.5).await });
    let mut bench = Bench { touches: f64::NAN, ..Bench::new(&wiring(), script) };
    assert_eq!(bench.run(), Err(Aborted::Blocked));
}
