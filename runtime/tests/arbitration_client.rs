//! The client's side of the arbitration, alone and against the arbiter, over links that lose samples.
#![allow(clippy::unwrap_used)]

use std::time::Duration;

use orienteer_runtime::{
    arbitration::{
        Clients,
        base::BaseArbiter,
        client::{BaseHandle, BaseState, SonarHandle, SonarState},
    },
    geometry::{Limits, Twist},
    random::Streams,
    time::Time,
    topics::{
        BaseDecision, BaseNotice, ClientId, FiringProgram, Motion, MotionKind, MotionReport, MotionState, NoticeKind,
        SonarDecision,
    },
};
use rand::RngExt;

const STEP: Duration = Duration::from_millis(50);
const LEASE: Duration = Duration::from_millis(120);
const AHEAD: Twist = Twist::new(0.3, 0.0);
const BACK: Twist = Twist::new(-0.1, 0.0);

/// Two handles of different priority, or more, and an arbiter.
struct Robot {
    now: Time,
    arbiter: BaseArbiter,
    handles: Vec<BaseHandle>,
}

impl Robot {
    fn new(priorities: &[u8]) -> Self {
        let clients: Clients = priorities.iter().map(|priority| ("somebody", *priority)).collect();
        let handles = (0..priorities.len()).map(|i| BaseHandle::new(ClientId(i as u16))).collect();
        Self { now: Time::START, arbiter: BaseArbiter::new(&clients), handles }
    }

    /// One step in which nothing is lost.
    fn step(&mut self) -> BaseDecision {
        self.step_losing(|_| false)
    }

    /// One step. `lost` is asked for each claim (0), each notice (1), and the decision to each client (2).
    fn step_losing(&mut self, mut lost: impl FnMut(u8) -> bool) -> BaseDecision {
        self.now = self.now + STEP;
        for handle in &mut self.handles {
            let claim = handle.claim(self.now, LEASE);
            if !lost(0) {
                self.arbiter.claim(&claim);
            }
        }
        let mut notices = Vec::new();
        let decision = self.arbiter.decide(self.now, &mut notices);
        for handle in &mut self.handles {
            let heard: Vec<BaseNotice> = notices.iter().filter(|_| !lost(1)).copied().collect();
            handle.hear(&heard, (!lost(2)).then_some(&decision), None);
        }
        decision
    }

    fn report(&mut self, id: u32, state: MotionState) {
        let report = MotionReport::new(self.now, id, state, 0.0);
        self.handles.iter_mut().for_each(|handle| handle.hear(&[], None, Some(&report)));
    }
}

#[test]
fn a_velocity_lasts_for_one_step() {
    let mut robot = Robot::new(&[5]);
    robot.handles[0].drive(AHEAD);
    assert_eq!(robot.step().motion, Motion::velocity(AHEAD));
    assert_eq!(robot.step().motion, Motion::STOP);
    assert!(robot.handles[0].is_holding());
    robot.handles[0].drive(BACK);
    assert_eq!(robot.step().motion, Motion::velocity(BACK));
    robot.handles[0].release();
    assert_eq!(robot.step().holder, ClientId::NONE);
    assert_eq!(robot.handles[0].state(), BaseState::Free);
}

#[test]
fn a_relative_motion_goes_on_until_it_is_done() {
    let mut robot = Robot::new(&[5]);
    let id = robot.handles[0].translate(0.5, 0.1);
    let motion = Motion::translate(id.get(), 0.5, 0.1);
    for _ in 0..5 {
        assert_eq!(robot.step().motion, motion);
    }
    assert_eq!(robot.handles[0].motion_state(id), MotionState::Running);
    robot.report(id.get(), MotionState::Done);
    assert_eq!(robot.handles[0].motion_state(id), MotionState::Done);
    // A base that starts anew must not move again.
    assert_eq!(robot.step().motion, Motion::STOP);

    let turn = robot.handles[0].rotate(1.0, 0.5);
    assert_ne!(turn, id);
    assert_eq!(robot.handles[0].motion_state(id), MotionState::Idle);
    robot.report(id.get(), MotionState::Blocked);
    assert_eq!(robot.handles[0].motion_state(turn), MotionState::Running);
    robot.report(turn.get(), MotionState::Blocked);
    assert_eq!(robot.handles[0].motion_state(turn), MotionState::Blocked);
}

#[test]
fn other_orders_end_a_relative_motion() {
    let end: [fn(&mut BaseHandle); 4] =
        [|handle| handle.drive(AHEAD), BaseHandle::stop, BaseHandle::release, |handle| _ = handle.rotate(1.0, 1.0)];
    for end in end {
        let mut handle = BaseHandle::new(ClientId(0));
        let id = handle.translate(0.5, 0.1);
        end(&mut handle);
        assert_ne!(handle.motion_state(id), MotionState::Running);
    }
}

#[test]
fn no_two_clients_use_the_same_motion() {
    let mut handles: Vec<BaseHandle> = (0..24).map(|i| BaseHandle::new(ClientId(i))).collect();
    let mut ids: Vec<u32> =
        handles.iter_mut().flat_map(|handle| [handle.translate(1.0, 1.0), handle.rotate(1.0, 1.0)]).map(|id| id.get()).collect();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), 48);
    assert!(!ids.contains(&0));
}

#[test]
fn motions_that_make_no_sense_are_blocked() {
    let mut robot = Robot::new(&[5]);
    let id = robot.handles[0].translate(f64::NAN, 0.1);
    assert_eq!(robot.handles[0].motion_state(id), MotionState::Blocked);
    let decision = robot.step();
    assert_eq!((decision.holder, decision.motion), (ClientId(0), Motion::STOP));
    robot.handles[0].drive(Twist::new(f64::INFINITY, 0.0));
    assert_eq!(robot.step().motion.kind(), MotionKind::Stop);
}

#[test]
fn an_override_is_survived_by_driving_on() {
    let mut robot = Robot::new(&[5, 10]);
    robot.handles[0].drive(AHEAD);
    robot.step();
    for _ in 0..3 {
        robot.handles[0].drive(AHEAD);
        robot.handles[1].drive(BACK);
        robot.step();
        assert_eq!(robot.handles[0].state(), BaseState::Overridden { by: ClientId(1) });
        assert_eq!(robot.handles[0].overrider_motion(), Motion::velocity(BACK));
    }
    robot.handles[0].drive(AHEAD);
    robot.handles[1].release();
    let decision = robot.step();
    assert_eq!((decision.holder, decision.transaction), (ClientId(0), 1));
    assert!(robot.handles[0].is_holding());
}

#[test]
fn a_relative_motion_is_not_taken_up_again_after_an_override() {
    let mut robot = Robot::new(&[5, 10]);
    let id = robot.handles[0].translate(2.0, 0.3);
    robot.step();
    robot.handles[1].drive(BACK);
    robot.step();
    assert_eq!(robot.handles[0].motion_state(id), MotionState::Blocked);
    robot.handles[1].release();
    let decision = robot.step();
    assert_eq!((decision.holder, decision.motion), (ClientId(0), Motion::STOP));
}

#[test]
fn who_surrenders_asks_again_from_the_back_of_the_queue() {
    let mut robot = Robot::new(&[5, 10, 5]);
    robot.handles[0].surrender();
    robot.handles[0].drive(AHEAD);
    robot.step();
    robot.handles[1].drive(BACK);
    robot.handles[2].stop();
    robot.step();
    assert_eq!(robot.handles[0].state(), BaseState::Overridden { by: ClientId(1) });
    robot.handles[0].drive(AHEAD);
    assert_eq!(robot.handles[0].state(), BaseState::Waiting);
    robot.step();
    robot.handles[1].release();
    assert_eq!(robot.step().holder, ClientId(2));
    robot.handles[2].release();
    let decision = robot.step();
    assert_eq!((decision.holder, decision.transaction), (ClientId(0), 2));
}

#[test]
fn surrender_can_be_chosen_while_overridden() {
    let mut robot = Robot::new(&[5, 10]);
    robot.handles[0].drive(AHEAD);
    robot.step();
    robot.handles[1].stop();
    robot.step();
    robot.handles[0].surrender();
    robot.step();
    robot.handles[1].release();
    assert_eq!(robot.step().holder, ClientId::NONE);
    assert_eq!(robot.handles[0].state(), BaseState::Overridden { by: ClientId(1) }, "until another command");
}

#[test]
fn a_grant_that_crosses_a_surrender_is_not_taken() {
    let mut robot = Robot::new(&[5, 10]);
    robot.handles[0].drive(AHEAD);
    robot.step();
    robot.handles[1].stop();
    robot.step();
    robot.handles[0].surrender();
    robot.handles[1].release();
    let mut claims = 0;
    let decision = robot.step_losing(|what| {
        claims += u8::from(what == 0);
        what == 0 && claims == 1
    });
    assert_eq!(decision.holder, ClientId(0), "its surrender was lost");
    assert_eq!(robot.handles[0].state(), BaseState::Overridden { by: ClientId(1) });
    assert_eq!(robot.step().holder, ClientId::NONE);
}

#[test]
fn any_sign_of_an_override_will_do() {
    let at = Time::from_nanos;
    let (me, other) = (ClientId(0), ClientId(1));
    let mut moves = BaseNotice::new(at(2), me, 1, NoticeKind::OverriderMoves, other);
    moves.motion = Motion::velocity(BACK);
    let mut decision = BaseDecision::default();
    (decision.stamp, decision.holder, decision.transaction) = (at(2), other, 4);
    for (notices, decision, motion) in [(vec![moves], None, moves.motion), (vec![], Some(&decision), Motion::STOP)] {
        let mut handle = BaseHandle::new(me);
        let id = handle.translate(1.0, 0.1);
        handle.hear(&[BaseNotice::new(at(1), me, 1, NoticeKind::Granted, ClientId::NONE)], None, None);
        handle.hear(&notices, decision, None);
        assert_eq!(handle.state(), BaseState::Overridden { by: other });
        assert_eq!(handle.motion_state(id), MotionState::Blocked);
        assert_eq!(handle.overrider_motion(), motion);
        // What an overrider did once is forgotten by the next time.
        let mut again = BaseDecision::default();
        for (stamp, holder, transaction) in [(3, me, 1), (4, ClientId(2), 7)] {
            (again.stamp, again.holder, again.transaction) = (at(stamp), holder, transaction);
            handle.hear(&[], Some(&again), None);
        }
        assert_eq!((handle.state(), handle.overrider_motion()), (BaseState::Overridden { by: ClientId(2) }, Motion::STOP));
        handle.hear(&[BaseNotice::new(at(5), me, 1, NoticeKind::OverriderMoves, ClientId(3))], None, None);
        assert_eq!(handle.state(), BaseState::Overridden { by: ClientId(3) });
    }
}

#[test]
fn a_wait_ends_as_busy_and_the_next_command_begins_anew() {
    let mut robot = Robot::new(&[5, 5]);
    robot.handles[0].stop();
    robot.step();
    robot.handles[1].wait_at_most(2 * STEP);
    robot.handles[1].drive(AHEAD);
    for _ in 0..2 {
        robot.step();
        assert_eq!(robot.handles[1].state(), BaseState::Waiting);
    }
    robot.step();
    assert_eq!(robot.handles[1].state(), BaseState::Busy);
    robot.step();
    assert_eq!(robot.handles[1].state(), BaseState::Busy, "until another command");
    robot.handles[1].drive(AHEAD);
    assert_eq!(robot.handles[1].state(), BaseState::Waiting);
    robot.handles[0].release();
    assert_eq!(robot.step().transaction, 2);
}

#[test]
fn a_limit_lasts_for_one_step_and_needs_no_transaction() {
    let mut robot = Robot::new(&[5, 10]);
    robot.handles[0].drive(AHEAD);
    robot.handles[1].limit(Limits { linear: 0.2, angular: 1.0 });
    robot.handles[1].limit(Limits { linear: 0.25, angular: 0.5 });
    let decision = robot.step();
    assert_eq!((decision.holder, decision.limits), (ClientId(0), Limits { linear: 0.2, angular: 0.5 }));
    assert_eq!(robot.step().limits, Limits::NONE);
    assert_eq!(robot.handles[1].state(), BaseState::Free);
}

#[test]
fn a_silent_client_loses_its_transaction_and_can_begin_another() {
    let mut robot = Robot::new(&[5]);
    robot.handles[0].drive(AHEAD);
    robot.step();
    for _ in 0..4 {
        robot.step_losing(|what| what == 0);
    }
    assert_eq!(robot.handles[0].state(), BaseState::Lapsed);
    robot.handles[0].drive(AHEAD);
    assert_eq!(robot.step().transaction, 2);
    assert!(robot.handles[0].is_holding());
}

#[test]
fn a_client_that_missed_its_end_is_told_again() {
    let mut robot = Robot::new(&[5, 5]);
    robot.handles[0].stop();
    robot.step();
    robot.handles[1].wait_at_most(Duration::ZERO);
    robot.handles[1].drive(AHEAD);
    robot.step_losing(|what| what == 1);
    assert_eq!(robot.handles[1].state(), BaseState::Waiting);
    robot.step();
    assert_eq!(robot.handles[1].state(), BaseState::Busy);
}

#[test]
fn a_restarted_client_gets_the_base() {
    // At once, while its old claim lives; and after that has lapsed.
    for pause in [0, 5] {
        for lost_reports in [false, true] {
            let mut robot = Robot::new(&[5]);
            let before = robot.handles[0].translate(1.0, 0.1);
            robot.step();
            robot.report(before.get(), MotionState::Done);
            robot.handles[0] = BaseHandle::new(ClientId(0));
            for _ in 0..pause {
                robot.step_losing(|what| what == 0);
            }
            if !lost_reports {
                robot.report(before.get(), MotionState::Done);
            }
            let after = robot.handles[0].translate(1.0, 0.1);
            assert_eq!(after == before, lost_reports, "an old motion's id names an old motion");
            robot.step();
            robot.handles[0].stop();
            robot.step();
            robot.handles[0].stop();
            robot.step();
            assert!(robot.handles[0].is_holding());
        }
    }
}

/// Behaviours do anything, links lose anything. As long as nothing is lost, every handle knows how it stands; when things
/// were lost, two steps without losses set it right.
#[test]
fn handles_and_arbiter_agree() {
    for history in 0..400 {
        let mut rng = Streams::new(history).stream("robot", "test");
        let priorities: Vec<u8> = (0..rng.random_range(1..5)).map(|_| rng.random_range(0..3)).collect();
        let mut robot = Robot::new(&priorities);
        let (mut quiet, mut grants) = (2, 0);
        for _ in 0..200 {
            for handle in &mut robot.handles {
                match rng.random_range(0..14) {
                    0 => handle.release(),
                    1 => _ = handle.translate(1.0, 0.1),
                    2 => handle.wait_at_most(STEP * rng.random_range(0..5)),
                    3 => handle.wait_forever(),
                    4 => handle.surrender(),
                    5 => handle.hang_on(),
                    6 => handle.stop(),
                    7 | 8 => handle.drive(AHEAD),
                    _ => {}
                }
            }
            let losing = rng.random_bool(0.3);
            let decision = robot.step_losing(|_| losing && rng.random_bool(0.4));
            quiet = if losing { 0 } else { quiet + 1 };
            grants += u32::from(decision.holder != ClientId::NONE);
            for (i, handle) in robot.handles.iter().enumerate().filter(|_| quiet >= 2) {
                let holds = decision.holder == ClientId(i as u16);
                let waits = decision.held_back().iter().any(|held_back| held_back.client == ClientId(i as u16));
                let right = match handle.state() {
                    BaseState::Holding => holds,
                    BaseState::Waiting => waits && !holds,
                    BaseState::Overridden { by } => !holds && (!waits || by == decision.holder),
                    BaseState::Free | BaseState::Busy | BaseState::Lapsed => !holds,
                };
                assert!(right, "history {history}: client {i} thinks {:?}\n{decision:#?}", handle.state());
            }
        }
        assert!(grants > 0);
    }
}

#[test]
fn answers_from_the_past_are_ignored() {
    let me = ClientId(3);
    let mut handle = BaseHandle::new(me);
    handle.drive(AHEAD);
    let at = Time::from_nanos;
    handle.hear(&[BaseNotice::new(at(20), me, 1, NoticeKind::Granted, ClientId::NONE)], None, None);
    let mut old = BaseDecision::default();
    (old.stamp, old.holder, old.transaction) = (at(10), ClientId(4), 9);
    handle.hear(&[BaseNotice::new(at(10), me, 1, NoticeKind::Busy, ClientId(4))], Some(&old), None);
    assert_eq!(handle.state(), BaseState::Holding);
    // Nor does the end of an earlier transaction concern this one, nor another client's.
    handle.hear(&[BaseNotice::new(at(30), me, 7, NoticeKind::Busy, ClientId(4))], None, None);
    handle.hear(&[BaseNotice::new(at(30), ClientId(4), 1, NoticeKind::Lapsed, me)], None, None);
    assert_eq!(handle.state(), BaseState::Holding);
}

#[test]
fn a_sonar_handle_follows_the_decisions() {
    let mut handle = SonarHandle::new(ClientId(1));
    let decide = |holder| {
        let mut decision = SonarDecision::default();
        decision.holder = holder;
        decision
    };
    let mut program = FiringProgram::default();
    program.slots.push(0b1);
    handle.hear(&decide(ClientId(1)));
    assert_eq!(handle.state(), SonarState::Free);
    handle.run(program);
    handle.hear(&decide(ClientId(0)));
    assert_eq!(handle.state(), SonarState::Waiting);
    handle.hear(&decide(ClientId(1)));
    assert_eq!(handle.state(), SonarState::Holding);
    handle.hear(&decide(ClientId(0)));
    handle.hear(&decide(ClientId(2)));
    assert_eq!(handle.state(), SonarState::Overridden { by: ClientId(2) });
    let claim = handle.claim(Time::START, LEASE);
    assert_eq!((claim.program, claim.valid_until), (program, Time::START + LEASE));
    handle.run(FiringProgram::default());
    assert_eq!(handle.state(), SonarState::Free);
    assert!(handle.claim(Time::START, LEASE).program.slots.is_empty());
}
