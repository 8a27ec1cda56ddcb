//! Maps a building from a real log: 413 scans of eight fixed sonars.
#![allow(clippy::unwrap_used, missing_docs)]

use std::{fs, path::PathBuf};

use orienteer_agents::mapper::{Config, Mapper, files, picture};
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

#[test]
fn pictures() {
    let Some(log) = Log::read() else { return };
    let Ok(out) = std::env::var("MAP_OUT") else { return };
    for (name, config) in
        [("default", Config::default()), ("luey", Config { cell: 0.1, extent: Config::default().extent, ..Config::luey() })]
    {
        for (side, sign) in [("right", 1.0), ("mirrored", -1.0)] {
            let mapper = log.map(&config, sign);
            let file = PathBuf::from(&out).join(format!("{name}-{side}.png"));
            picture::save(mapper.grid(), mapper.path(), picture::PictureStyle::default(), &file).unwrap();
            println!("{name} {side} {:?}", files::summarize(mapper.grid()));
        }
    }
}
