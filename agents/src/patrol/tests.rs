//! The agent over a base and a follower that do what a test says.
#![allow(clippy::unwrap_used)]

use orienteer_runtime::{
    arbitration::Clients,
    geometry::{Limits, Pose},
    random::Streams,
    robot_model::{Platform, Transducer},
    topics::{ClientId, Echo, FiringProgram, Motion, MotionKind},
};

use super::*;

const PERIOD: Duration = Duration::from_millis(50);
/// Of a corridor 1.5 m wide.
const WALL: Echo = Echo::Range(0.75);

/// A robot with three transducers: ahead, to the left and to the right.
fn robot() -> RobotContext {
    let eye = |bearing| Transducer { mount: Pose::new(0.0, 0.0, bearing), half_beam: 0.2 };
    let ring = Ring {
        name: "test".into(),
        transducers: [0.0, FRAC_PI_2, -FRAC_PI_2].map(eye).into(),
        min_range: 0.1,
        max_range: 7.0,
        slot_time: 0.01,
        program: FiringProgram::default(),
    };
    let platform = Platform {
        name: "test".into(),
        radius: 0.3,
        limits: Limits { linear: 1.0, angular: 1.0 },
        acceleration: 2.0,
        angular_acceleration: 3.0,
        turning_radius: 0.0,
    };
    RobotContext {
        robot: "ann".into(),
        node: "patrol".into(),
        client: ClientId(0),
        clients: Arc::new([("patrol", 4)].into_iter().collect::<Clients>()),
        platform: Arc::new(platform),
        ring: Arc::new(ring),
        team: [].into(),
        start: Pose::default(),
        period: PERIOD,
        streams: Streams::new(1),
    }
}

/// A patrol across a place that is said to open to the left, with nothing ahead, stepped at 20 Hz.
struct Walk {
    patrol: Patrol,
    inputs: Inputs,
    out: Outputs,
    now: Time,
    travelled: f64,
    /// What is heard ahead, and to the left.
    ahead: Echo,
    left: Echo,
    /// What the follower reports.
    opening: Opening,
    /// Whether there is a follower that hears orders.
    followed: bool,
}

impl Walk {
    fn new(left: Echo) -> Self {
        let mut wiring = Wiring::default();
        Patrol::topics(&mut wiring);
        let patrol = Patrol::build(PatrolConfig::default(), &robot()).unwrap();
        let (inputs, out) = (Inputs::offline(&wiring), Outputs::offline(&wiring));
        Self {
            patrol,
            inputs,
            out,
            now: Time::START,
            travelled: 0.0,
            ahead: Echo::Nothing,
            left,
            opening: Opening::Left,
            followed: true,
        }
    }

    /// A control period in which the base moves at this speed, m/s, whatever it is told. Returns what it is told.
    fn step(&mut self, speed: f64) -> MotionKind {
        self.now = self.now + PERIOD;
        self.travelled += speed * PERIOD.as_secs_f64();
        self.inputs.settle();
        self.inputs.put(PoseEstimate { stamp: self.now, travelled: self.travelled, ..PoseEstimate::default() });
        self.inputs.put(SonarScan::from_echoes(self.now, 1, &[self.ahead, self.left, WALL]));
        // The follower is at the place at once.
        for order in self.out.published::<CorridorOrder>().iter().filter(|_| self.followed) {
            let mut report = CorridorReport::new(self.now, order.order, self.opening);
            report.length = 4.0;
            report.width = 1.5;
            self.inputs.put(report);
        }
        self.out.settle();
        self.patrol.step(self.now, &self.inputs, &mut self.out);
        self.out.base.claim(self.now, 3 * PERIOD).motion.kind()
    }

    /// How long the base, which moves at this speed, is told to go on across the place, s; no more than a minute.
    fn crossing(&mut self, speed: f64) -> f64 {
        let onward = MotionKind::Velocity(Twist::new(PatrolConfig::default().speed, 0.0));
        assert!((0..10).any(|_| self.step(0.0) == onward), "does not begin to cross");
        let start = self.now;
        while self.now.secs_since(start) < 60.0 && self.step(speed) == onward {}
        self.now.secs_since(start)
    }
}

/// Somebody may stand where the front sonar does not look, and the base will not go on.
#[test]
fn who_is_kept_from_crossing_a_place_for_too_long_turns_back() {
    let mut walk = Walk::new(WALL);
    let seconds = walk.crossing(0.0);
    assert!((8.0..8.2).contains(&seconds), "gave up after {seconds} s");
    let turn = Motion::rotate(0, PI, PatrolConfig::default().turn_rate).kind();
    assert!((0..2).any(|_| walk.step(0.0) == turn), "does not turn back");
}

/// With nothing ahead and a side open, the way ahead was taken for the far side of the opening and driven into.
#[test]
fn who_is_kept_from_crossing_where_a_side_is_open_turns_back_too() {
    let mut walk = Walk::new(Echo::Nothing);
    walk.crossing(0.0);
    let turn = Motion::rotate(0, PI, PatrolConfig::default().turn_rate).kind();
    assert!((0..2).any(|_| walk.step(0.0) == turn), "does not turn back");
}

/// A robot that was killed while it turned stands across its corridor, and went to and fro between the walls.
#[test]
fn who_stands_across_a_corridor_turns_to_where_it_goes_on() {
    for (left, angle) in [(WALL, PI), (Echo::Range(3.0), FRAC_PI_2), (Echo::Nothing, FRAC_PI_2)] {
        let mut walk = Walk::new(left);
        walk.opening = Opening::DeadEnd;
        walk.ahead = WALL;
        let turn = Motion::rotate(0, angle, PatrolConfig::default().turn_rate).kind();
        assert!((0..10).any(|_| walk.step(0.0) == turn), "{left:?}");
    }
}

/// A follower that is built anew after a panic has heard no order.
#[test]
fn an_order_is_repeated_until_it_is_reported() {
    let mut walk = Walk::new(WALL);
    walk.followed = false;
    walk.step(0.0);
    let mut orders = Vec::new();
    for _ in 0..20 {
        walk.step(0.0);
        orders.extend(walk.out.published::<CorridorOrder>().iter().map(|order| order.order));
    }
    assert!(orders.len() == 20 && orders.iter().all(|order| *order == orders[0] && *order != 0), "{orders:?}");
    walk.followed = true;
    assert!(walk.crossing(0.0) > 0.0, "the report came, and it goes on");
}

/// Protection lets a robot only creep past what is near; that is no reason to give up.
#[test]
fn who_gets_on_slowly_is_not_kept() {
    let seconds = Walk::new(Echo::Nothing).crossing(0.02);
    assert!(seconds >= 60.0, "gave up after {seconds} s");
}
