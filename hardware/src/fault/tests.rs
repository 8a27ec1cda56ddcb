#![allow(clippy::unwrap_used)]
use orienteer_runtime::{random::Streams, topics::Echo};

use super::*;
use crate::base::presets;

/// A base that drives on at 1 m/s once it is told to go, and a sonar that scans each 100 ms.
struct Device {
    platform: Platform,
    ring: Ring,
    twist: Twist,
    x: f64,
    last: Time,
    seq: u64,
}

fn device() -> Device {
    let ring = Ring {
        name: "one".into(),
        transducers: vec![],
        min_range: 0.1,
        max_range: 5.0,
        slot_time: 0.1,
        program: FiringProgram::default(),
    };
    Device { platform: presets::b12_huey().platform(), ring, twist: Twist::STOP, x: 0.0, last: Time::START, seq: 0 }
}

impl BaseDriver for Device {
    fn platform(&self) -> &Platform {
        &self.platform
    }

    fn command(&mut self, _: Time, twist: Twist) -> Result<(), DriverError> {
        self.twist = twist;
        Ok(())
    }

    fn poll(&mut self, now: Time) -> Result<Odometry, DriverError> {
        self.x += self.twist.linear * now.secs_since(self.last);
        self.last = now;
        Ok(Odometry { stamp: now, pose: Pose::new(self.x, 0.0, 0.0), twist: self.twist, ..Odometry::default() })
    }

    fn stop(&mut self) {
        self.twist = Twist::STOP;
    }
}

impl SonarDriver for Device {
    fn ring(&self) -> &Ring {
        &self.ring
    }

    fn set_program(&mut self, _: Time, _: &FiringProgram) {}

    fn poll(&mut self, now: Time, scans: &mut Vec<SonarScan>) -> Result<(), DriverError> {
        self.seq += 1;
        scans.push(SonarScan::from_echoes(now, self.seq, &[Echo::Range(self.seq as f32)]));
        Ok(())
    }
}

fn faulty(config: FaultConfig) -> FaultInjector<Device> {
    FaultInjector::new(device(), config, Streams::new(1).stream("ann", "faults"))
}

fn at(step: u64) -> Time {
    Time::from_nanos(step * 100_000_000)
}

fn base_run(config: FaultConfig, steps: u64) -> Vec<Result<Odometry, DriverError>> {
    let mut base = faulty(config);
    (0..steps)
        .map(|i| {
            let odometry = BaseDriver::poll(&mut base, at(i));
            let _ = base.command(at(i), Twist::new(1.0, 0.0));
            odometry
        })
        .collect()
}

fn sonar_run(config: FaultConfig, steps: u64) -> Vec<Vec<(u64, u64, Echo)>> {
    let mut sonar = faulty(config);
    (0..steps)
        .map(|i| {
            let mut scans = Vec::new();
            let _ = SonarDriver::poll(&mut sonar, at(i), &mut scans);
            scans.iter().map(|scan| (scan.seq, scan.stamp.as_nanos() / 100_000_000, scan.echo(0))).collect()
        })
        .collect()
}

fn middle() -> Vec<Interval> {
    vec![Interval { from: 0.5, to: 0.8 }]
}

#[test]
fn without_faults_nothing_changes() {
    for (i, odometry) in base_run(FaultConfig::default(), 20).into_iter().enumerate() {
        let odometry = odometry.unwrap();
        assert!((odometry.pose.x - 0.1 * i as f64).abs() < 1e-9 && odometry.stamp == at(i as u64));
    }
    for (i, scans) in sonar_run(FaultConfig::default(), 20).into_iter().enumerate() {
        assert_eq!(scans, [(i as u64 + 1, i as u64, Echo::Range(i as f32 + 1.0))]);
    }
}

#[test]
fn delayed_readings_come_whole_and_late() {
    let config = FaultConfig { delay: 0.3, ..FaultConfig::default() };
    let odometry = base_run(config.clone(), 20);
    assert_eq!(odometry[10].as_ref().unwrap().stamp, at(7));
    let scans = sonar_run(config, 20);
    assert!(scans[2].is_empty());
    assert_eq!(scans[10], [(8, 7, Echo::Range(8.0))]);
}

#[test]
fn frozen_values_have_new_stamps() {
    let config = FaultConfig { freeze: middle(), ..FaultConfig::default() };
    let odometry = base_run(config.clone(), 20);
    let x = |i: usize| odometry[i].as_ref().unwrap().pose.x;
    assert_eq!((x(5), x(7)), (x(4), x(4)));
    assert!(x(8) > x(4) + 0.35);
    assert_eq!(odometry[7].as_ref().unwrap().stamp, at(7));
    let scans = sonar_run(config, 20);
    assert_eq!((scans[7][0], scans[8][0]), ((8, 7, Echo::Range(5.0)), (9, 8, Echo::Range(9.0))));
}

#[test]
fn a_lost_link_fails_loudly_and_the_firmware_stops_the_base() {
    let config = FaultConfig { link_lost: middle(), ..FaultConfig::default() };
    let odometry = base_run(config.clone(), 20);
    assert!(matches!(odometry[5], Err(DriverError::LinkLost { .. })) && odometry[5].as_ref().unwrap_err().may_recover());
    let x = |i: usize| odometry[i].as_ref().unwrap().pose.x;
    assert!((x(8) - x(4)) < 0.15, "it stood while the link was lost: {}", x(8) - x(4));
    assert!(x(10) > x(8));
    assert_eq!(sonar_run(config, 20).iter().map(Vec::len).sum::<usize>(), 17);
}

/// Whoever finds that commands fail tells the driver to stop, which takes the same lost way.
#[test]
fn a_stop_does_not_get_through_a_lost_link() {
    let config = FaultConfig { link_lost: middle(), firmware_timeout: 0.25, ..FaultConfig::default() };
    let mut base = faulty(config);
    let driven: Vec<f64> = (0..10)
        .map(|i| {
            let _ = BaseDriver::poll(&mut base, at(i));
            if base.command(at(i), Twist::new(1.0, 0.0)).is_err() {
                BaseDriver::stop(&mut base);
            }
            BaseDriver::poll(&mut base.inner, at(i)).unwrap().pose.x
        })
        .collect();
    assert!(driven[6] > driven[5], "it goes on at first: {driven:?}");
    assert!((driven[8] - driven[7]).abs() < 1e-9, "then the firmware stops it: {driven:?}");
}

#[test]
fn nan_and_silence_hold_for_their_interval() {
    let config = FaultConfig { not_a_number: middle(), silent: middle(), ..FaultConfig::default() };
    for (i, odometry) in base_run(config.clone(), 20).into_iter().enumerate() {
        assert_eq!(odometry.unwrap().twist.is_finite(), !(5..8).contains(&i));
    }
    for (i, scans) in sonar_run(config, 20).into_iter().enumerate() {
        assert_eq!(scans.is_empty(), (5..8).contains(&i), "{i}");
    }
}

#[test]
fn about_the_configured_share_is_dropped_and_the_same_with_the_same_seed() {
    let config = FaultConfig { drop: 0.25, ..FaultConfig::default() };
    let scans = sonar_run(config.clone(), 1000);
    let lost = scans.iter().filter(|scans| scans.is_empty()).count();
    assert!((180..320).contains(&lost), "{lost}");
    assert_eq!(scans, sonar_run(config.clone(), 1000));
    let stamps: Vec<_> = base_run(config, 1000).into_iter().map(|odometry| odometry.unwrap().stamp).collect();
    let repeated = stamps.windows(2).filter(|pair| pair[0] == pair[1]).count();
    assert!((180..320).contains(&repeated), "{repeated}");
}
