//! The echo model against a fan of rays, and what it makes of walls that real sonars have met.

mod fan;
mod overshoot;

use nalgebra::Point2;
use orienteer_hardware::{
    echo::{Acoustics, Beam, Disc, Scratch, SegmentGrid, SonarModel, Vertex, Wall, cone},
    rings,
};
use orienteer_runtime::{geometry::Pose, random::Streams};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::{Effort, Row, Suite, SuiteError, in_parallel};
use fan::Fan;

pub(super) const SUITE: Suite =
    Suite { name: "echo", help: "the exact cone test against a fan of rays, and the end of a wall as a real sonar met it", run };

/// Readings compared in each size of world.
const READINGS: u64 = 2_000;
/// Readings taken in one world.
const PER_WORLD: u64 = 20;
/// The same number of segments on each square metre whatever the world's size.
const SEGMENTS_PER_SQUARE_METRE: f64 = 0.25;
/// Readings that agree with the fan within this are the same, m.
const SAME: f64 = 0.005;
/// Drives past the end of a wall.
const DRIVES: u64 = 200;

fn run(effort: &Effort) -> Result<Vec<Row>, SuiteError> {
    let mut rows = Vec::new();
    for segments in [50, 500] {
        rows.extend(compare(effort, segments)?);
    }
    rows.push(wall_end(effort)?);
    Ok(rows)
}

/// How readings differ from the fan's.
#[derive(Debug, Default, Clone, Copy)]
struct Agreement {
    readings: u64,
    heard: u64,
    same: u64,
    /// Something that a ray hears was missed or put farther away.
    missed: u64,
    /// What the cone heard and the rays did not, or farther away: it lies between two rays, or is not there.
    nearer: u64,
    not_there: u64,
    /// Largest difference among readings that both have, m.
    worst: f64,
}

impl Agreement {
    fn add(&mut self, other: &Self) {
        self.readings += other.readings;
        self.heard += other.heard;
        self.same += other.same;
        self.missed += other.missed;
        self.nearer += other.nearer;
        self.not_there += other.not_there;
        self.worst = self.worst.max(other.worst);
    }
}

fn compare(effort: &Effort, segments: usize) -> Result<Vec<Row>, SuiteError> {
    let worlds = effort.seeds(READINGS).div_ceil(PER_WORLD);
    let what = format!("echoes among {segments} segments");
    let found = in_parallel(effort, &what, worlds, |number| {
        compare_in_one_world(&mut Streams::new(number).stream("echo", &segments.to_string()), segments)
    })?;
    let mut all = Agreement::default();
    found.iter().for_each(|agreement| all.add(agreement));
    let row = |words: &str| format!("{segments} segments: {words}");
    let share = 100.0 * all.same as f64 / all.readings.max(1) as f64;
    Ok(vec![
        Row::at_least(row("readings compared"), (worlds * PER_WORLD) as f64, all.readings as f64, ""),
        Row::at_least(row("readings that hear something"), 0.2 * all.readings as f64, all.heard as f64, ""),
        Row::at_least(row("within 5 mm of the nearest of 4001 rays"), 99.5, share, "%"),
        Row::exactly(row("echoes that a ray hears, missed or put farther away"), 0.0, all.missed as f64, "readings"),
        Row::exactly(row("echoes of points that rays show to be hidden"), 0.0, all.not_there as f64, "readings"),
        Row::at_most(
            row("heard more than 5 mm nearer, through gaps between two rays"),
            0.005 * all.readings as f64,
            all.nearer as f64,
            "readings",
        ),
        Row {
            goal: String::new(),
            holds: true,
            ..Row::at_most(row("largest difference where both hear"), 0.0, 1000.0 * all.worst, "mm")
        },
    ])
}

fn compare_in_one_world(rng: &mut Pcg64, segments: usize) -> Result<Agreement, SuiteError> {
    let world = RandomWorld::new(rng, segments);
    let grid = SegmentGrid::new(&world.walls, &world.vertices, &world.pillars).map_err(SuiteError::from_display)?;
    let named = rings::find("denning-16").ok_or_else(|| SuiteError("the ring `denning-16` is not there".into()))?;
    let mut scratch = Scratch::default();
    let mut agreement = Agreement::default();
    for _ in 0..PER_WORLD {
        let limit_deg = rng.random_range(5.0..60.0);
        let model = SonarModel { vertex_range: 1.5, ..SonarModel::default().with_incidence_limit(limit_deg) };
        let acoustics = Acoustics::new(&model).map_err(SuiteError::from_display)?;
        let turn = std::f64::consts::PI;
        let pose = Pose::new(world.coordinate(rng), world.coordinate(rng), rng.random_range(-turn..turn));
        let half_beam = rng.random_range(5f64.to_radians()..25f64.to_radians());
        let fan = Fan { pose, half_beam, max_range: named.ring.max_range, limit: limit_deg.to_radians(), vertex_range: 1.5 };
        let beam = Beam::new(pose, half_beam, named.ring.max_range);
        let answer = cone(&grid, &[], &beam, &acoustics, &mut scratch);
        let near = world.within(&fan);
        agreement.readings += 1;
        agreement.heard += u64::from(answer.is_some());
        let not_there = answer.is_some_and(|answer| near.hides(pose.point(), answer.at(&beam)));
        agreement.not_there += u64::from(not_there);
        match (answer.map(|answer| answer.range), fan.nearest(&near)) {
            (None, None) => agreement.same += 1,
            (Some(cone), Some(rays)) => {
                agreement.same += u64::from((cone - rays).abs() <= SAME);
                agreement.missed += u64::from(cone > rays + SAME);
                agreement.nearer += u64::from(cone < rays - SAME);
                agreement.worst = agreement.worst.max((cone - rays).abs());
            }
            (None, Some(_)) => agreement.missed += 1,
            (Some(_), None) => agreement.nearer += 1,
        }
    }
    Ok(agreement)
}

/// Walls and boxes thrown about.
#[derive(Default)]
struct RandomWorld {
    half_size: f64,
    walls: Vec<Wall>,
    vertices: Vec<Vertex>,
    pillars: Vec<Disc>,
}

impl RandomWorld {
    fn new(rng: &mut Pcg64, segments: usize) -> Self {
        let half_size = 0.5 * (segments as f64 / SEGMENTS_PER_SQUARE_METRE).sqrt();
        let mut world = Self { half_size, ..Self::default() };
        while world.walls.len() < segments {
            let at = Point2::new(world.coordinate(rng), world.coordinate(rng));
            let turn = rng.random_range(0.0..std::f64::consts::TAU);
            let (along, across) = (rng.random_range(0.2..4.0), rng.random_range(0.2..2.0));
            let corner =
                |x: f64, y: f64| Point2::new(at.x + x * turn.cos() - y * turn.sin(), at.y + x * turn.sin() + y * turn.cos());
            if segments - world.walls.len() >= 4 && rng.random_bool(0.3) {
                let corners = [corner(0.0, 0.0), corner(along, 0.0), corner(along, across), corner(0.0, across)];
                world.walls.extend((0..4).map(|i| Wall::new(corners[i], corners[(i + 1) % 4])));
                world.vertices.extend(corners.map(|at| Vertex { at, strength: 1.0 }));
            } else {
                world.walls.push(Wall::new(at, corner(along, 0.0)));
            }
        }
        for _ in 0..segments / 25 {
            let centre = Point2::new(world.coordinate(rng), world.coordinate(rng));
            world.pillars.push(Disc { centre, radius: rng.random_range(0.1..0.4), reflectance: 1.0 });
        }
        world
    }

    fn coordinate(&self, rng: &mut Pcg64) -> f64 {
        rng.random_range(-self.half_size..self.half_size)
    }

    /// What can matter to a fan: saves the rays the trouble with the rest.
    fn within(&self, fan: &Fan) -> Self {
        let (from, reach) = (fan.pose.point(), fan.max_range);
        let near = |wall: &&Wall| fan::distance(from, wall.a, wall.b) <= reach;
        Self {
            half_size: self.half_size,
            walls: self.walls.iter().filter(near).copied().collect(),
            vertices: self.vertices.iter().filter(|vertex| (vertex.at - from).norm() <= reach).copied().collect(),
            pillars: self.pillars.iter().filter(|disc| (disc.centre - from).norm() - disc.radius <= reach).copied().collect(),
        }
    }

    /// True if something stands between two points; what touches the second does not.
    fn hides(&self, from: Point2<f64>, at: Point2<f64>) -> bool {
        let way = at - from;
        let length = way.norm();
        if length < 1e-6 {
            return false;
        }
        fan::first(self, from, way / length).is_some_and(|hit| hit.range < length - 1e-4)
    }
}

fn wall_end(effort: &Effort) -> Result<Row, SuiteError> {
    let drives = effort.seeds(DRIVES);
    let ways = in_parallel(effort, "ends of walls", drives, |seed| overshoot::overshoot(seed).map_err(SuiteError::from_display))?;
    let mean = 100.0 * ways.iter().sum::<f64>() / drives as f64;
    let row = format!("wall believed past its end, 8 cm/s, 40 cm clearance, mean of {drives}");
    Ok(Row { goal: "14 ± 3".into(), holds: (mean - 14.0).abs() <= 3.0, ..Row::at_most(row, 17.0, mean, "cm") }
        .reported("about 14 (Randazza 1989)"))
}
