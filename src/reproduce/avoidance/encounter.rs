//! Meetings of a robot and a person, drawn from a seed.

use std::f64::consts::{PI, TAU};

use orienteer_runtime::{geometry::Pose, random::Streams};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::witness::StraightOn;

/// Where people and robot meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Place {
    /// 10 m × 10 m, empty.
    Hall,
    /// 20 m long, of this width, between two cross corridors by which people come and go.
    Corridor(f64),
}

/// What the robot does until somebody comes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Task {
    Stand,
    StraightOn,
    Follow,
}

/// How the person comes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    HeadOn,
    Crossing,
    Overtaking,
}

/// One meeting of a robot and a person who does not look.
#[derive(Debug, Clone)]
pub(super) struct Encounter {
    pub seed: u64,
    pub place: Place,
    pub task: Task,
    pub kind: Kind,
    /// Walking speed, m/s.
    pub speed: f64,
    /// How far beside the robot's course, or its centre, the person's path leads, m.
    pub offset: f64,
    start: Pose,
    path: Vec<[f64; 2]>,
    /// Simulated seconds.
    pub duration: f64,
}

/// Where a corridor robot starts, along the corridor, m.
const CORRIDOR_START: f64 = 2.0;
/// Speed of the corridor follower, m/s.
const FOLLOWING: f64 = 0.3;
/// People in a corridor keep this far from its walls, m.
const FROM_WALL: f64 = 0.3;
/// How far the cross corridors lead, m: nobody gets to their ends.
const AWAY: f64 = 200.0;

impl Encounter {
    /// The encounter of this seed.
    pub fn draw(seed: u64) -> Self {
        let mut random = Streams::new(seed).stream("avoidance", "encounter");
        // One in five is of the sort that must be evaded.
        let must_evade = seed.is_multiple_of(5);
        let place = match random.random_range(0..4) {
            _ if must_evade => Place::Hall,
            0 | 1 => Place::Hall,
            2 => Place::Corridor(2.46),
            _ => Place::Corridor(1.5),
        };
        let task = match (random.random_bool(0.5), place) {
            (false, Place::Hall) => Task::StraightOn,
            (false, Place::Corridor(_)) => Task::Follow,
            (true, _) => Task::Stand,
        };
        let kind = match random.random_range(0..4) {
            _ if must_evade => Kind::HeadOn,
            0 | 1 => Kind::HeadOn,
            2 => Kind::Crossing,
            _ => Kind::Overtaking,
        };
        // One in two walks slowly: of these the robot must get out of the way.
        let speed =
            if random.random_bool(0.5) || must_evade { random.random_range(0.2..0.4) } else { random.random_range(0.4..1.2) };
        let straight_at = kind == Kind::HeadOn && (random.random_bool(0.7) || must_evade);
        let offset = if straight_at { 0.0 } else { random.random_range(-0.5..0.5) };
        let mut drawn = Self { seed, place, task, kind, speed, offset, start: Pose::default(), path: Vec::new(), duration: 60.0 };
        match place {
            Place::Hall => drawn.in_hall(&mut random),
            Place::Corridor(width) => drawn.in_corridor(width, &mut random),
        }
        drawn
    }

    /// True for somebody who walks slowly and straight at a robot that has room on all sides.
    pub fn must_evade(&self) -> bool {
        self.place == Place::Hall && self.kind == Kind::HeadOn && self.speed <= 0.4 && self.offset == 0.0
    }

    /// The robot's course is the x axis of a frame whose origin is where the two would meet.
    fn in_hall(&mut self, random: &mut Pcg64) {
        let course = random.random_range(-PI..PI);
        // Off the middle, but with 3 m and more around.
        let meeting = [5.0 + random.random_range(-1.0..1.0), 5.0 + random.random_range(-1.0..1.0)];
        let mine = if self.task == Task::Stand { 0.0 } else { StraightOn::SPEED };
        let from = match (self.kind, self.task) {
            (_, Task::Stand) => random.random_range(-PI..PI),
            (Kind::HeadOn, _) => 0.0,
            (Kind::Crossing, _) => random.random_range(0.3 * PI..0.7 * PI) * if random.random_bool(0.5) { 1.0 } else { -1.0 },
            (Kind::Overtaking, _) => PI,
        };
        // Time to the meeting: the person starts between 3 and 3.6 m away, the robot not outside the hall.
        let away = random.random_range(3.0..3.6);
        let late = if self.kind == Kind::Crossing && mine > 0.0 { random.random_range(-0.6..0.6) } else { 0.0 };
        let before = (mine * away / self.speed + late * mine).min(2.8);
        let place = |x: f64, y: f64| {
            let (sin, cos) = course.sin_cos();
            [meeting[0] + cos * x - sin * y, meeting[1] + sin * x + cos * y]
        };
        let [x, y] = place(-before, 0.0);
        let heading = if self.task == Task::Stand { random.random_range(-PI..PI) } else { course };
        self.start = Pose::new(x, y, heading);
        // The person's line passes `offset` beside the meeting point.
        let (sin, cos) = from.sin_cos();
        let along = |s: f64| place(s * cos - self.offset * sin, s * sin + self.offset * cos);
        // A slow one who comes from behind has less of a way.
        let lead = if self.kind == Kind::Overtaking && mine > 0.0 { away.max(before + 1.2) } else { away };
        self.path = [lead, -3.6].map(along).map(|p| p.map(|c| c.clamp(0.4, 9.6))).to_vec();
        self.duration = 8.0 / self.speed + 12.0;
    }

    fn in_corridor(&mut self, width: f64, random: &mut Pcg64) {
        let heading = if self.task == Task::Follow { 0.0 } else { random.random_range(0.0..TAU) - PI };
        let half = 0.5 * width - FROM_WALL;
        let stands = if self.task == Task::Stand { 9.0 } else { CORRIDOR_START };
        self.start = Pose::new(stands, random.random_range(-0.1..0.1), heading);
        let beside = self.offset.clamp(-half, half);
        let (west, east) = (-3.0, 20.0);
        self.path = match self.kind {
            Kind::HeadOn => {
                let from = (stands + random.random_range(3.5..8.0)).min(19.0);
                vec![[from, beside], [west, beside], [west, AWAY]]
            }
            Kind::Overtaking => vec![[stands - random.random_range(2.0..4.0), beside], [east, beside], [east, AWAY]],
            Kind::Crossing => {
                // From wall to wall, slantwise, across the robot's way; out at the end behind the robot.
                let at = stands + if self.task == Task::Stand { 0.0 } else { random.random_range(1.5..5.0) };
                let (side, slant) = (if random.random_bool(0.5) { half } else { -half }, random.random_range(0.3..1.5));
                vec![[at + 2.5 + slant, side], [at + slant, side], [at - slant, -side], [west, -side], [west, AWAY]]
            }
        };
        self.duration = if self.task == Task::Follow { 160.0 } else { 15.0 / self.speed + 10.0 };
    }

    /// The mission and its world, as files.
    pub fn files(&self) -> Vec<(String, Vec<u8>)> {
        let agent = match self.task {
            Task::Stand => String::new(),
            Task::StraightOn => "[robot.agent.straight-on]\n".to_owned(),
            Task::Follow => format!("[robot.agent.corridor-follower]\nautostart = true\ncruise_speed = {FOLLOWING}\n"),
        };
        let mission = format!(
            "[mission]\nseed = {}\nduration = {:.3}\nlinks = \"direct\"\nthreads = 1\n\n[world]\nfile = \"world.toml\"\n\n\
             [record]\nenabled = false\n\n[[robot]]\nname = \"huey\"\nbase = {{ driver = \"sim\", platform = \"b12-huey\" }}\n\
             sonar = {{ driver = \"sim\", ring = \"denning-16\" }}\n\
             start = {{ x = {:.4}, y = {:.4}, heading_deg = {:.3} }}\n\n\
             [robot.agent.where-am-i]\n[robot.agent.avoidance]\n[robot.agent.witness]\n{agent}",
            self.seed,
            self.duration,
            self.start.x,
            self.start.y,
            self.start.heading.to_degrees(),
        );
        let walls = match self.place {
            Place::Hall => "[[room]]\ncorners = [[0.0, 0.0], [10.0, 10.0]]\n".to_owned(),
            Place::Corridor(width) => format!(
                "[[corridor]]\nalong = [[-4.0, 0.0], [21.0, 0.0]]\nwidth = {width}\n\
                 [[corridor]]\nalong = [[-3.0, {0:.2}], [-3.0, 210.0]]\nwidth = 2.0\n\
                 [[corridor]]\nalong = [[20.0, {0:.2}], [20.0, 210.0]]\nwidth = 2.0\n",
                -0.5 * width
            ),
        };
        let waypoints: Vec<String> = self.path.iter().map(|[x, y]| format!("[{x:.4}, {y:.4}]")).collect();
        let person = format!(
            "[[person]]\npath = [{}]\nspeed = {:.4}\npause = {}\ncourtesy = \"ignores\"\n",
            waypoints.join(", "),
            self.speed,
            // In the hall the person stays where the path ends.
            if self.place == Place::Hall { 3600.0 } else { 0.0 },
        );
        vec![
            ("mission.toml".to_owned(), mission.into_bytes()),
            ("world.toml".to_owned(), format!("{walls}{person}").into_bytes()),
        ]
    }
}
