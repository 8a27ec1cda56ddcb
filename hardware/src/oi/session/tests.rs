#![allow(clippy::unwrap_used)]

use orienteer_runtime::topics::flags;

use super::*;
use crate::{
    base::presets,
    wire::oi::{
        STOP_ANYHOW,
        command::Listener,
        sensors::{Mode, bumps},
        stream,
    },
};

/// A session with somebody who says whatever the test wants.
struct Talk {
    session: Session,
    now: Time,
    sensors: Sensors,
    /// The base goes to Safe when it is asked to.
    willing: bool,
    listener: Listener,
}

impl Talk {
    fn new() -> Self {
        let profile = Profile::new(Model::CREATE_2, &presets::create2().platform());
        let sensors = Sensors { mode: Mode::Passive, ..Sensors::default() };
        Self { session: Session::new(profile), now: Time::START, sensors, willing: true, listener: Listener::default() }
    }

    /// In Safe mode, and standing.
    fn opened() -> Self {
        let mut talk = Self::new();
        for _ in 0..20 {
            talk.beat(Duration::from_millis(15));
        }
        assert_eq!((talk.session.state(), talk.sensors.mode), (State::Open, Mode::Safe));
        talk
    }

    /// What the session says after so long, without an answer.
    fn say(&mut self, span: Duration) -> Vec<String> {
        self.now = self.now + span;
        let mut said = Vec::new();
        self.session.transmit(self.now, &mut said);
        self.understand(&said)
    }

    fn understand(&mut self, said: &[u8]) -> Vec<String> {
        let (mut commands, mut safe) = (Vec::new(), false);
        self.listener.push(said, |command| {
            safe |= command == Command::Safe;
            commands.push(format!("{command:?}"));
        });
        if safe && self.willing {
            self.sensors.mode = Mode::Safe;
        }
        commands
    }

    /// A frame comes, and the session says what it says in the same moment.
    fn beat(&mut self, span: Duration) -> Vec<String> {
        let mut bytes = Vec::new();
        stream::emit(Model::CREATE_2.packets, &self.sensors, &mut bytes);
        let now = self.now + span;
        self.session.receive(now, &bytes);
        self.say(span)
    }

    /// Drives for a while; gives all speeds of the right and the left wheel that were told.
    fn drive(&mut self, seconds: f64, twist: Twist) -> Vec<(i16, i16)> {
        let mut told = Vec::new();
        for _ in 0..(seconds * 100.0).round() as u64 {
            self.session.drive(self.now, twist);
            told.extend(self.beat(Duration::from_millis(10)).iter().map(|said| speeds(said)));
        }
        told
    }

    fn flags(&self) -> u32 {
        self.session.readings().odometry().unwrap().flags
    }
}

/// The speeds in a command for the wheels.
fn speeds(said: &str) -> (i16, i16) {
    let numbers: Vec<i16> = said.split(|c: char| c != '-' && !c.is_ascii_digit()).filter_map(|n| n.parse().ok()).collect();
    let [right, left] = numbers[..] else { panic!("{said}") };
    (right, left)
}

const STAND: &str = "DriveDirect { right: 0, left: 0 }";
const MILLISECOND: Duration = Duration::from_millis(1);
const AHEAD: Twist = Twist { linear: 0.3, angular: 0.0 };

#[test]
fn the_base_is_greeted_until_it_answers_and_its_motors_go_on_standing() {
    let mut talk = Talk::new();
    assert_eq!(talk.say(MILLISECOND), ["Start"]);
    assert_eq!(talk.say(10 * MILLISECOND), [""; 0]);
    assert_eq!(talk.say(SETTLES), ["Stream([7, 9, 10, 11, 12, 14, 22, 35, 43, 44, 58])"]);
    assert_eq!(talk.say(400 * MILLISECOND), [""; 0]);
    assert_eq!(talk.say(100 * MILLISECOND), ["Start"]);
    assert_eq!(talk.session.unanswered(), 2);
    talk.say(SETTLES);
    assert_eq!((talk.beat(15 * MILLISECOND), talk.session.state()), (vec!["Safe".to_owned()], State::Open));
    assert_eq!(talk.flags(), flags::EMERGENCY_STOP);
    assert_eq!(talk.beat(15 * MILLISECOND), [STAND]);
    assert_eq!(talk.flags(), flags::ENABLED);
}

#[test]
fn speeds_change_by_the_accelerations_and_keep_to_the_limits() {
    let mut talk = Talk::opened();
    let told = talk.drive(2.0, Twist::new(9.0, 0.0));
    let step = told.windows(2).map(|pair| pair[1].0 - pair[0].0).max();
    assert!(told.last() == Some(&(500, 500)) && step <= Some(6), "0.5 m/s² in 10 ms is 5 mm/s: {step:?}, {told:?}");
    // At its top speed a base can't turn and keep it: the curve stays the same.
    let told = talk.drive(3.0, Twist::new(0.5, 1.0));
    let (right, left) = *told.last().unwrap();
    assert!(right == 500 && left == 310, "{right} {left}");
    talk.drive(2.0, Twist::STOP);
    assert_eq!(talk.drive(2.0, Twist::new(0.0, 1.0)).last(), Some(&(118, -118)), "to the left");
    assert_eq!(talk.drive(2.0, Twist::new(f64::NAN, 1.0)).last(), Some(&(0, 0)));
}

#[test]
fn a_velocity_that_nobody_renews_ends() {
    let mut talk = Talk::opened();
    talk.drive(1.0, AHEAD);
    let told: Vec<_> = (0..100).flat_map(|_| talk.beat(10 * MILLISECOND)).collect();
    assert!(told.contains(&"DriveDirect { right: 300, left: 300 }".to_owned()), "it holds for a moment: {told:?}");
    assert_eq!(told.last().unwrap(), STAND);
}

#[test]
fn wheels_are_told_ten_times_a_second_at_least() {
    let mut talk = Talk::opened();
    talk.drive(1.0, AHEAD);
    let told = talk.drive(1.0, AHEAD);
    assert!((9..=11).contains(&told.len()) && told.iter().all(|told| *told == (300, 300)), "{told:?}");
}

#[test]
fn what_is_touched_stops_the_base_with_the_bytes_that_say_so() {
    for felt in [bumps::LEFT, bumps::RIGHT, 0] {
        let mut talk = Talk::opened();
        talk.drive(1.0, AHEAD);
        talk.sensors.bumps_and_drops = felt;
        talk.sensors.cliffs[1] = felt == 0;
        // Whoever drives knows nothing of it yet.
        talk.session.drive(talk.now, AHEAD);
        assert_eq!(talk.beat(10 * MILLISECOND), [STAND]);
        assert_eq!(talk.flags(), flags::ENABLED | flags::CONTACT | flags::CONTACT_AHEAD);
        let told = talk.drive(1.0, Twist::new(0.3, 0.5));
        assert!(told.iter().all(|told| *told == (0, 0)), "ahead is blocked: {told:?}");
        assert_eq!(talk.drive(1.0, Twist::new(-0.05, 0.0)).last(), Some(&(-50, -50)), "back is not");
        assert_eq!(talk.drive(1.0, Twist::new(0.0, 0.2)).last(), Some(&(24, -24)), "nor is turning");
        (talk.sensors.bumps_and_drops, talk.sensors.cliffs) = (0, [false; 4]);
        assert_eq!(talk.drive(1.0, AHEAD).last(), Some(&(300, 300)));
    }
}

#[test]
fn a_bump_stops_a_base_that_backs_off_too() {
    let mut talk = Talk::opened();
    talk.drive(1.0, Twist::new(-0.2, 0.0));
    talk.sensors.bumps_and_drops = bumps::LEFT;
    talk.session.drive(talk.now, Twist::new(-0.2, 0.0));
    assert_eq!(talk.beat(10 * MILLISECOND), [STAND]);
    assert_eq!(talk.drive(0.02, Twist::new(-0.2, 0.0)), [(-5, -5), (-10, -10)], "then it begins again");
}

#[test]
fn wheels_that_drop_stand_until_they_are_down_and_were_told_to_stand() {
    let mut talk = Talk::opened();
    talk.drive(1.0, AHEAD);
    talk.sensors.bumps_and_drops = bumps::LEFT_DROP;
    talk.session.drive(talk.now, AHEAD);
    assert_eq!(talk.beat(10 * MILLISECOND), [STAND]);
    assert_eq!(talk.flags(), flags::ENABLED | flags::EMERGENCY_STOP);
    // The base goes to Passive; nobody asks for its motors as long as it hangs, nor as long as it is to move.
    talk.sensors.mode = Mode::Passive;
    assert_eq!(talk.drive(3.0, Twist::STOP), []);
    talk.sensors.bumps_and_drops = 0;
    assert_eq!(talk.drive(3.0, AHEAD), []);
    assert_eq!(talk.flags(), flags::EMERGENCY_STOP);
    talk.session.drive(talk.now, Twist::STOP);
    assert_eq!(talk.beat(10 * MILLISECOND), ["Safe"]);
    // Whoever wants to move before the motors are on has to wait, and to say stop first.
    let told = talk.drive(1.0, AHEAD);
    assert!(!told.is_empty() && told.iter().all(|told| *told == (0, 0)), "{told:?}");
    talk.drive(0.1, Twist::STOP);
    assert_eq!(talk.drive(1.0, AHEAD).last(), Some(&(300, 300)));
}

#[test]
fn hands_have_a_second_to_get_away() {
    let mut talk = Talk::opened();
    (talk.sensors.bumps_and_drops, talk.sensors.mode) = (bumps::RIGHT_DROP, Mode::Passive);
    talk.beat(10 * MILLISECOND);
    talk.sensors.bumps_and_drops = 0;
    for beat in 0..99 {
        assert_eq!(talk.beat(10 * MILLISECOND), [""; 0], "{beat}");
    }
    assert_eq!(talk.beat(20 * MILLISECOND), ["Safe"]);
}

#[test]
fn a_base_that_stays_passive_is_asked_twice_a_second() {
    let mut talk = Talk::opened();
    (talk.sensors.mode, talk.willing) = (Mode::Passive, false);
    talk.now = talk.now + SAFE_AGAIN;
    let asked: usize = (0..200).map(|_| talk.beat(10 * MILLISECOND).len()).sum();
    assert_eq!(asked, 4);
}

#[test]
fn a_base_that_falls_silent_is_greeted_anew_and_begins_standing() {
    let mut talk = Talk::opened();
    talk.drive(1.0, AHEAD);
    let before = talk.session.readings().odometry().unwrap();
    let said: Vec<_> = (0..40).flat_map(|_| talk.say(10 * MILLISECOND)).collect();
    assert_eq!(said.iter().filter(|said| *said == "Start").count(), 1, "{said:?}");
    assert_eq!(talk.session.state(), State::Opening);
    (talk.sensors.left_encoder, talk.sensors.right_encoder, talk.sensors.mode) = (9000, 9000, Mode::Passive);
    // Somebody has gone on to command all the time.
    assert_eq!(talk.drive(0.5, AHEAD), []);
    assert_eq!(talk.session.readings().odometry().unwrap().pose, before.pose);
    let told: Vec<_> = (0..50).flat_map(|_| talk.beat(10 * MILLISECOND)).collect();
    assert!(told[0] == "Safe" && told[1..].iter().all(|told| told == STAND), "{told:?}");
    assert_eq!(talk.drive(1.0, AHEAD).last(), Some(&(300, 300)));
}

#[test]
fn who_was_held_up_begins_standing() {
    let mut talk = Talk::opened();
    talk.drive(1.0, AHEAD);
    talk.now = talk.now + GONE;
    assert_eq!(talk.drive(0.03, AHEAD), [(0, 0), (5, 5), (10, 10)]);
}

#[test]
fn halt_and_close_say_so_at_once_in_whatever_state() {
    let mut said = Vec::new();
    Talk::new().session.halt(&mut said);
    assert_eq!(said, STOP);
    let mut talk = Talk::opened();
    talk.drive(1.0, AHEAD);
    said.clear();
    talk.session.halt(&mut said);
    assert_eq!(said, STOP);
    assert!((0..100).flat_map(|_| talk.beat(10 * MILLISECOND)).all(|told| told == STAND));
    said.clear();
    talk.session.close(&mut said);
    assert_eq!(talk.understand(&said), [STAND, "StreamRuns(false)", "Start"]);
    assert_eq!(talk.session.state(), State::Greeting);
}

/// Whoever minds the line swallows nothing of what it says itself: all that a session sends is shorter.
#[test]
fn nothing_that_is_said_is_longer_than_what_a_stop_can_end() {
    let mut longest = Vec::new();
    Command::Stream(&Model::CREATE_2.packets.iter().map(|id| *id as u8).collect::<Vec<_>>()).emit(&mut longest);
    assert!(longest.len() <= STOP_ANYHOW.len() - STOP.len() && FILLER.len() >= longest.len());
}
