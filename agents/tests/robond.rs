//! Maps a building from a real log: 413 scans of eight fixed sonars.
#![allow(clippy::unwrap_used, missing_docs)]

use std::{fs, path::PathBuf};

use nalgebra::Point2;
use orienteer_agents::{
    certainty_grid::{Grid, Occupancy},
    mapper::{Config, Mapper, files, picture},
};
use orienteer_runtime::{
    geometry::Pose,
    robot_model::{Ring, Transducer},
    time::Time,
    topics::{Echo, FiringProgram, SonarScan},
};

const BEARINGS_DEG: [f64; 8] = [-90.0, -37.5, -22.5, -7.5, 7.5, 22.5, 37.5, 90.0];
const NO_ECHO_MM: f64 = 5110.0;

struct Log {
    scans: Vec<(Pose, SonarScan)>,
}

fn data() -> Option<PathBuf> {
    let here = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    here.ancestors().map(|dir| dir.join("shared/data/robond-8sonar")).find(|dir| dir.is_dir())
}

fn rows(file: PathBuf) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(file).unwrap();
    text.lines().map(|line| line.split_whitespace().map(|word| word.parse().unwrap()).collect()).collect()
}

impl Log {
    fn read() -> Option<Self> {
        let Some(dir) = data() else {
            eprintln!("skipped: ../shared/data/robond-8sonar is not there");
            return None;
        };
        let poses = rows(dir.join("poses.txt"));
        let measurements = rows(dir.join("measurement.txt"));
        let start = poses[0][0];
        let scans = poses
            .iter()
            .zip(&measurements)
            .enumerate()
            .map(|(i, (pose, ranges))| {
                assert_eq!(pose[0], ranges[0]);
                let stamp = Time::from_secs_f64((pose[0] - start) * 1e-3);
                let echo = |mm: &f64| if *mm >= NO_ECHO_MM { Echo::Nothing } else { Echo::Range((mm * 1e-3) as f32) };
                let echoes: Vec<_> = ranges[1..].iter().map(echo).collect();
                let pose = Pose::new(pose[1] * 1e-3, pose[2] * 1e-3, (pose[3] * 0.1).to_radians());
                (pose, SonarScan::from_echoes(stamp, i as u64 + 1, &echoes))
            })
            .collect();
        Some(Self { scans })
    }

    fn map(&self, config: &Config, bearing_sign: f64) -> Mapper {
        let transducers = BEARINGS_DEG
            .map(|bearing| Transducer {
                mount: Pose::new(0.0, 0.0, bearing_sign * bearing.to_radians()),
                half_beam: 10f64.to_radians(),
            })
            .to_vec();
        let ring = Ring {
            name: "robond".to_owned(),
            transducers,
            min_range: 0.17,
            max_range: NO_ECHO_MM * 1e-3,
            slot_time: 0.0,
            program: FiringProgram::default(),
        };
        let mut mapper = Mapper::new(config.clone(), &ring, self.scans[0].0).unwrap();
        for (pose, scan) in &self.scans {
            mapper.update(*pose, scan);
        }
        mapper
    }
}

/// Where the nearest occupied cell stands on one side of the first corridor, which runs along x: its y at each 10 cm.
fn wall(grid: &Grid, side: f64) -> Vec<f64> {
    let occupied = |x: f64, y: f64| grid.occupancy(grid.index_of(Point2::new(x, y))) == Occupancy::Occupied;
    let nearest = |x: f64| (0..25).map(|i| 0.1 * f64::from(i)).find(|y| occupied(x, side * y));
    (10..90).filter_map(|i| nearest(0.1 * f64::from(i))).collect()
}

/// Mean distance of a wall from its median line, m.
fn roughness(wall: &[f64]) -> f64 {
    let middle = median(wall);
    wall.iter().map(|y| (y - middle).abs()).sum::<f64>() / wall.len() as f64
}

fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn the_map_shows_the_building() {
    let Some(log) = Log::read() else { return };
    let mapper = log.map(&Config::default(), 1.0);
    let grid = mapper.grid();
    let summary = files::summarize(grid);
    eprintln!("{summary:?}");
    // The robot drove 25 m through corridors about two metres wide.
    assert!((60.0..130.0).contains(&summary.free_area), "{}", summary.free_area);
    assert!((400..1200).contains(&summary.occupied), "{}", summary.occupied);
    // Where it drove there is no wall.
    let length: f32 = mapper.path().windows(2).map(|leg| (leg[1] - leg[0]).norm()).sum();
    assert!((24.0..26.0).contains(&length), "{length}");
    assert!(mapper.path().iter().all(|point| grid.occupancy(grid.index_of(point.cast())) == Occupancy::Free));
    // Both walls of the first corridor stand along most of it.
    let (left, right) = (wall(grid, 1.0), wall(grid, -1.0));
    let width = median(&left) + median(&right);
    eprintln!("walls at {} and {} of 80 places, {width:.1} m apart", left.len(), right.len());
    assert!(left.len() >= 64 && right.len() >= 64);
    assert!((1.9..2.3).contains(&width), "{width}");
}

#[test]
fn walls_are_straight_only_if_the_ring_is_the_right_way_round() {
    let Some(log) = Log::read() else { return };
    let rough = |sign: f64| {
        let mapper = log.map(&Config::default(), sign);
        [1.0, -1.0].map(|side| roughness(&wall(mapper.grid(), side)))
    };
    let (as_given, mirrored) = (rough(1.0), rough(-1.0));
    eprintln!("roughness {as_given:.3?} m, mirrored {mirrored:.3?} m");
    assert!(as_given.iter().sum::<f64>() * 1.5 < mirrored.iter().sum());
    assert!(as_given.iter().all(|rough| *rough < 0.1));
}

#[test]
fn the_source_s_own_settings_leave_far_more_false_ground() {
    let Some(log) = Log::read() else { return };
    let naive = Config { cell: 0.1, extent: Config::default().extent, ..Config::luey() };
    let (free, naive_free) = (log.map(&Config::default(), 1.0).grid().counts().free, log.map(&naive, 1.0).grid().counts().free);
    eprintln!("{free} free cells, {naive_free} with the source's settings");
    assert!(free * 3 < naive_free * 2);
}

/// Writes the pictures into the directory named by `MAP_OUT`.
#[test]
fn pictures() {
    let (Some(log), Ok(out)) = (Log::read(), std::env::var("MAP_OUT")) else { return };
    for (name, sign) in [("robond", 1.0), ("robond-mirrored", -1.0)] {
        let mapper = log.map(&Config::default(), sign);
        let stem = PathBuf::from(&out).join(name);
        files::save(mapper.grid(), &stem, files::Mode::Trinary).unwrap();
        let file = stem.with_extension("picture.png");
        picture::save(mapper.grid(), mapper.path(), picture::PictureStyle::default(), &file).unwrap();
    }
}
