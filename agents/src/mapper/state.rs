//! The mapper without its agent: a pose and a scan in, a better map out.

use std::time::Duration;

use nalgebra::Point2;
use orienteer_runtime::{
    geometry::Pose,
    robot_model::{Ring, Transducer},
    time::Time,
    topics::{Echo, MAX_TRANSDUCERS, SonarScan},
};

use super::{Config, Extent, PoseHistory, trail::Trail};
use crate::certainty_grid::{
    Grid, GridError, Layout, Window,
    decay::Decay,
    marking::{Marker, Reading, Sight},
    pairs::{self, Pair, Sounding},
    rcd::Region,
};

/// What a scan did to the map.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Report {
    /// Readings drawn; a pair that agrees counts once.
    pub readings: usize,
    /// What happened to the window.
    pub window: WindowChange,
}

/// What happened to the window of the map.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum WindowChange {
    /// Nothing.
    #[default]
    Kept,
    /// It moved with the robot.
    Moved,
    /// It became larger.
    Grew,
    /// It should have become larger, but the map has reached its limit.
    Full,
}

/// A robot's map and everything needed to keep it. See the [module](super).
#[derive(Debug, Clone)]
pub struct Mapper {
    config: Config,
    transducers: Vec<Transducer>,
    min_range: f64,
    max_range: f64,
    pairs: Vec<Pair>,
    /// Bit `i` is set if transducer `i` has a partner.
    paired: u32,
    short_sighted: u32,
    marker: Marker,
    grid: Grid,
    regions: [Region; MAX_TRANSDUCERS],
    history: PoseHistory,
    trail: Trail,
    decay: Decay,
    /// Cells driven since the map last faded.
    since_decay: f64,
    last_seq: u64,
    soundings: [Option<Sounding>; MAX_TRANSDUCERS],
    readings: Vec<Reading>,
    sights: Vec<Sight>,
}

impl Mapper {
    /// A mapper for a ring, with an empty map around the pose at which the robot starts. Transducers beyond
    /// [`MAX_TRANSDUCERS`] are ignored.
    ///
    /// # Errors
    /// [`GridError`] if the config asks for a map without cells or with too many.
    pub fn new(config: Config, ring: &Ring, start: Pose) -> Result<Self, GridError> {
        let transducers: Vec<_> = ring.transducers.iter().copied().take(MAX_TRANSDUCERS).collect();
        let layout = Layout::around(start.point(), config.cell, config.width, config.height);
        let pairs = pairs::detect(&transducers, &config.pairs);
        Ok(Self {
            grid: Grid::new(layout, config.rules())?,
            paired: pairs.iter().fold(0, |mask, pair| mask | 1 << pair.left | 1 << pair.right),
            short_sighted: config.short_sighted.iter().fold(0, |mask, i| mask | 1u32.checked_shl((*i).into()).unwrap_or(0)),
            pairs,
            transducers,
            min_range: ring.min_range,
            max_range: ring.max_range,
            marker: Marker::new(config.marking),
            regions: [Region::default(); MAX_TRANSDUCERS],
            history: PoseHistory::default(),
            trail: Trail::new(config.trail),
            decay: Decay::default(),
            since_decay: 0.0,
            last_seq: 0,
            soundings: [None; MAX_TRANSDUCERS],
            readings: Vec::with_capacity(MAX_TRANSDUCERS),
            sights: Vec::with_capacity(MAX_TRANSDUCERS),
            config,
        })
    }

    /// The map.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The map, for edits by hand and for a survey of the background.
    pub fn grid_mut(&mut self) -> &mut Grid {
        &mut self.grid
    }

    /// The settings.
    #[must_use]
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// The pairs found in the ring.
    #[must_use]
    pub fn pairs(&self) -> &[Pair] {
        &self.pairs
    }

    /// The line the robot has driven, oldest point first, map frame, m; thinned out when it becomes long.
    #[must_use]
    pub fn path(&self) -> &[Point2<f32>] {
        self.trail.path()
    }

    /// Where the robot is at a time: call it whenever a pose becomes known, so that readings find the pose at which they were
    /// taken. A pose with numbers that are not sound is ignored. Returns what happened to the window.
    pub fn track(&mut self, stamp: Time, pose: Pose) -> WindowChange {
        if !pose.is_sound() {
            return WindowChange::Kept;
        }
        self.history.push(stamp, pose);
        let change = self.make_room(pose.point());
        self.since_decay += self.trail.advance(&mut self.grid, pose.point()) / self.grid.cell_size();
        self.fade();
        change
    }

    /// Draws the fresh readings of a scan. Does nothing before the first pose, or if the scan's number is that of the scan before
    /// (numbers begin with 1).
    pub fn scan(&mut self, scan: &SonarScan) -> Report {
        if scan.seq == self.last_seq || self.history.newest().is_none() {
            return Report::default();
        }
        self.last_seq = scan.seq;
        self.listen(scan);
        self.fuse();
        self.sights.clear();
        self.sights.extend(self.readings.iter().map(|reading| self.marker.sight(&self.grid, reading)));
        for (reading, sight) in self.readings.iter().zip(&self.sights) {
            self.marker.clear(&mut self.grid, reading, *sight);
        }
        for (reading, sight) in self.readings.iter().zip(&self.sights) {
            self.marker.mark(&mut self.grid, reading, *sight);
        }
        Report { readings: self.readings.len(), window: WindowChange::Kept }
    }

    /// [`track`](Self::track) and [`scan`](Self::scan) in one: `pose` is the pose at the scan's stamp.
    pub fn update(&mut self, pose: Pose, scan: &SonarScan) -> Report {
        let window = self.track(scan.stamp, pose);
        Report { window, ..self.scan(scan) }
    }

    /// Turns echoes into soundings: range, weight, and where the transducer was.
    fn listen(&mut self, scan: &SonarScan) {
        let half_angle = self.config.marking.half_angle_deg.to_radians();
        let mut known: Option<(f32, Pose)> = None;
        for (i, transducer) in self.transducers.iter().enumerate() {
            self.soundings[i] = None;
            if !scan.is_fresh(i) {
                continue;
            }
            let (range, silent) = match scan.echo(i) {
                Echo::Range(range) if f64::from(range) < self.max_range => (f64::from(range), false),
                Echo::Range(_) | Echo::Nothing => (self.max_range, true),
                Echo::TooNear if self.config.mark_too_near => (self.min_range, false),
                Echo::TooNear | Echo::NotFired => continue,
            };
            let mut weight = self.regions[i].take(range, &self.config.regions);
            if silent {
                weight = weight.min(self.config.marking.silence.most_weight);
            }
            let age = scan.age(i);
            // Transducers of one slot share a pose.
            let pose = match known {
                Some((same, pose)) if same == age => Some(pose),
                _ => self.history.at(scan.stamp - Duration::try_from_secs_f32(age).unwrap_or_default()),
            };
            let Some(pose) = pose else { continue };
            known = Some((age, pose));
            self.soundings[i] = Some(Sounding {
                face: pose.then(transducer.mount),
                range,
                silent,
                weight: f32::from(weight),
                half_angle: half_angle.min(transducer.half_beam),
            });
        }
    }

    /// Turns soundings into readings.
    fn fuse(&mut self) {
        self.readings.clear();
        for pair in &self.pairs {
            match (&self.soundings[pair.left], &self.soundings[pair.right]) {
                (Some(left), Some(right)) => pairs::fuse(left, right, &self.config.pairs, &mut self.readings),
                (Some(one), None) | (None, Some(one)) => self.readings.push(pairs::alone(one)),
                (None, None) => {}
            }
        }
        for (i, sounding) in self.soundings.iter().enumerate() {
            let Some(sounding) = sounding.as_ref().filter(|_| self.paired & 1 << i == 0) else { continue };
            let mut reading = pairs::alone(sounding);
            if self.short_sighted & 1 << i != 0 {
                if sounding.silent || sounding.range >= self.config.short_sight {
                    continue;
                }
                reading.cone = None;
            }
            self.readings.push(reading);
        }
    }

    /// Moves or enlarges the window if the robot needs it.
    fn make_room(&mut self, robot: Point2<f64>) -> WindowChange {
        let here = self.grid.index_of(robot);
        let cells = |length: f64| (length / self.grid.cell_size()).ceil() as usize;
        match self.config.extent {
            Extent::Recentre { margin } => {
                // A margin that leaves no middle would move the window in every step.
                let most = (self.grid.width().min(self.grid.height()) / 2).saturating_sub(1);
                if !self.grid.near_edge(here, cells(margin).min(most)) {
                    return WindowChange::Kept;
                }
                self.grid.recentre(here);
                WindowChange::Moved
            }
            Extent::Grow { block, most_area } => {
                let reach = cells(self.max_range.min(MOST_REACH) + 1.0);
                let side = 2 * reach + 1;
                let wanted = Window { first: here.offset(-(reach as i32), -(reach as i32)), width: side, height: side };
                let limit = (most_area / self.grid.cell_area()) as usize;
                match self.grid.grow_to(wanted, cells(block), limit) {
                    Ok(false) => WindowChange::Kept,
                    Ok(true) => WindowChange::Grew,
                    Err(_) => WindowChange::Full,
                }
            }
        }
    }

    fn fade(&mut self) {
        let config = self.config.decay;
        if self.since_decay >= 1.0 {
            if config.enabled {
                let fade = config.per_cell * self.since_decay.min(config.most_cells) as f32;
                self.decay.apply(&mut self.grid, fade);
            }
            self.since_decay = 0.0;
        }
    }
}

/// No ring hears farther than this, m, whatever its description says.
const MOST_REACH: f64 = 50.0;

#[cfg(test)]
#[path = "state_tests.rs"]
mod tests;
