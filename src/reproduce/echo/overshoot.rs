//! How far past the end of a wall a robot believes in it.
//!
//! Huey drives along a wall at 8 cm/s with 40 cm between it and the face of his right sonar. He takes the mean of twelve
//! readings at a time, and believes that the wall has ended when two means in a row are not within 20 cm of the clearance.
//! Beams are wide and the end of a wall scatters sound, so that happens some way past it: about 14 cm (Randazza 1989).

use std::time::Duration;

use nalgebra::Point2;
use orienteer_hardware::{
    echo::{GridError, Pinger, PingerError, SegmentGrid, SonarModel, Vertex, Wall},
    rings,
};
use orienteer_runtime::{geometry::Pose, random::Streams, time::Time, topics::SonarScan};
use rand::RngExt;

/// Speed along the wall, m/s.
const SPEED: f64 = 0.08;
/// From the face of the sonar to the wall, m.
const CLEARANCE: f64 = 0.40;
/// Of the sonar's face from the robot's centre, m.
const RING_RADIUS: f64 = 0.08;
/// Readings in a mean.
const READINGS: usize = 12;
/// The transducer that looks to the right.
const RIGHT: usize = 4;
const POLL: Duration = Duration::from_millis(50);
/// Nobody believes in a wall for as long as this, s.
const PATIENCE: f64 = 60.0;

/// Why a drive could not be made.
#[derive(Debug, thiserror::Error)]
pub enum DriveError {
    #[error("the ring `denning-16` is not there")]
    NoRing,
    #[error("the wall was believed in for ever")]
    Endless,
    #[error(transparent)]
    Pinger(#[from] PingerError),
    #[error(transparent)]
    Grid(#[from] GridError),
}

/// The way past the end of the wall, m.
pub fn overshoot(seed: u64) -> Result<f64, DriveError> {
    let named = rings::find("denning-16").ok_or(DriveError::NoRing)?;
    let max_range = named.ring.max_range as f32;
    let model = SonarModel { spurious: 0.0, ..named.model };
    let mut pinger = Pinger::new(named.ring, &model, Time::START)?;
    let mut rng = Streams::new(seed).stream("overshoot", "drive");
    let start = -1.0 - rng.random_range(0.0..0.1);
    let x = |time: Time| start + SPEED * time.as_secs_f64();
    let y = -CLEARANCE - RING_RADIUS;
    let end = Vertex { at: Point2::new(0.0, y), strength: 1.0 };
    let world = SegmentGrid::new(&[Wall::new(Point2::new(-9.0, y), end.at)], &[end], &[])?;
    let (mut scans, mut now, mut misses): (Vec<SonarScan>, _, _) = (Vec::new(), Time::START, 0);
    while misses < 2 {
        pinger.poll(now, now + POLL, |time| Pose::new(x(time), 0.0, 0.0), &world, &[], &mut rng, &mut scans);
        now = now + POLL;
        if now.as_secs_f64() > PATIENCE {
            return Err(DriveError::Endless);
        }
        if scans.len() >= READINGS {
            let reading = |scan: &SonarScan| scan.echo(RIGHT).free_distance(max_range).unwrap_or(max_range);
            let mean = scans.iter().map(reading).sum::<f32>() / scans.len() as f32;
            misses = if (f64::from(mean) - CLEARANCE).abs() > 0.2 { misses + 1 } else { 0 };
            scans.clear();
        }
    }
    Ok(x(now))
}
