use std::sync::Arc;

use orienteer_runtime::{
    geometry::Pose,
    robot_model::Ring,
    time::Time,
    topics::{Echo, Odometry, SonarScan},
};

/// What each transducer has heard in the last half second, freed of the robot's own motion.
///
/// While the robot moves straight on, a beam at bearing `b` gets nearer to anything that stands still by `cos b` of the
/// distance driven. Added back, the reading of a thing at rest is constant, and the slope of a line fitted to the sum is the
/// speed at which a thing comes nearer by itself. A median of three readings goes before, so that one spurious echo does not
/// break the history; a jump does, because then the beam has met something else. Turning makes every beam sweep, so histories
/// begin anew after a turn.
#[derive(Debug)]
pub struct Surroundings {
    ring: Arc<Ring>,
    radius: f64,
    tracks: Vec<Track>,
    pose: Option<Pose>,
    travelled: f64,
    /// Speed along the heading, m/s.
    speed: f64,
    turned_at: Time,
}

/// Something that a transducer hears.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Threat {
    /// Where it is, rad from the heading.
    pub bearing: f64,
    /// Distance from the robot's centre, m.
    pub distance: f64,
    /// Distance from the body, m.
    pub clearance: f64,
    /// How fast it comes nearer by itself, m/s.
    pub approach: f64,
    /// How fast the gap shrinks, own motion included, m/s.
    pub closing: f64,
    /// How much nearer it has come by itself within the history, m.
    pub came: f64,
}

const HISTORY: usize = 24;
/// Slopes of fewer readings than this are not worth anything.
const ENOUGH: usize = 8;
/// A change between two readings that no person walks, m.
const JUMP: f64 = 0.25;
/// Turning faster than this, rad/s, sweeps the beams.
const SWEEPING: f64 = 0.1;

#[derive(Debug, Clone, Copy, Default)]
struct Track {
    recent: [f64; 3],
    heard: usize,
    samples: [(f64, f64); HISTORY],
    len: usize,
    next: usize,
    range: Option<f64>,
}

impl Surroundings {
    /// Nothing heard yet, by this ring on a body of this radius (m).
    #[must_use]
    pub fn new(ring: Arc<Ring>, radius: f64) -> Self {
        let tracks = vec![Track::default(); ring.transducers.len()];
        Self { ring, radius, tracks, pose: None, travelled: 0.0, speed: 0.0, turned_at: Time::START }
    }

    /// Follows the robot's own motion.
    pub fn moved(&mut self, odometry: &Odometry) {
        if let Some(last) = self.pose {
            self.travelled += last.between(odometry.pose).x;
        }
        self.pose = Some(odometry.pose);
        self.speed = odometry.twist.linear;
        if odometry.twist.angular.abs() > SWEEPING {
            self.turned_at = odometry.stamp;
            for track in &mut self.tracks {
                track.len = 0;
            }
        }
    }

    /// Takes a scan.
    pub fn heard(&mut self, scan: &SonarScan) {
        let time = scan.stamp.as_secs_f64();
        for (i, transducer) in self.ring.transducers.iter().enumerate().filter(|(i, _)| scan.is_fresh(*i)) {
            let along = self.travelled * transducer.mount.heading.cos();
            let age = f64::from(scan.age(i));
            self.tracks[i].push(time - age, scan.echo(i), along, self.ring.max_range);
        }
    }

    /// Everything within hearing, one entry for each transducer that hears something.
    pub fn all(&self) -> impl Iterator<Item = Threat> + '_ {
        self.ring.transducers.iter().zip(&self.tracks).filter_map(|(transducer, track)| {
            let range = track.range?;
            let bearing = transducer.mount.heading;
            let reach = transducer.mount.x * bearing.cos() + transducer.mount.y * bearing.sin();
            let (approach, came) = track.approach();
            let distance = range + reach;
            let closing = approach + self.speed * bearing.cos();
            Some(Threat { bearing, distance, clearance: (distance - self.radius).max(0.0), approach, closing, came })
        })
    }

    /// How far the body could go toward `bearing` (rad from the heading) before it touches something, m; at most `limit`.
    #[must_use]
    pub fn free_toward(&self, bearing: f64, margin: f64, limit: f64) -> f64 {
        let swath = self.radius + margin;
        self.all()
            .filter_map(|thing| {
                let (sin, cos) = (thing.bearing - bearing).sin_cos();
                let (ahead, beside) = (thing.distance * cos, thing.distance * sin);
                (ahead > 0.0 && beside.abs() < swath).then(|| ahead - (swath * swath - beside * beside).sqrt())
            })
            .fold(limit, f64::min)
            .max(0.0)
    }
}

impl Track {
    fn push(&mut self, time: f64, echo: Echo, along: f64, max_range: f64) {
        let Some(free) = echo.free_distance(max_range as f32) else { return };
        self.recent[self.heard % 3] = f64::from(free);
        self.heard += 1;
        if self.heard < 3 {
            return;
        }
        let [a, b, c] = self.recent;
        let range = a.max(b).min(a.min(b).max(c));
        self.range = (range < max_range).then_some(range);
        let still = range + along;
        let last = self.samples[(self.next + HISTORY - 1) % HISTORY].1;
        if range >= max_range || (self.len > 0 && (still - last).abs() > JUMP) {
            self.len = 0;
        }
        self.samples[self.next] = (time, still);
        self.next = (self.next + 1) % HISTORY;
        self.len = (self.len + 1).min(HISTORY);
    }

    /// Speed at which the thing comes nearer by itself, and by how much it has, from a line fitted to the history.
    fn approach(&self) -> (f64, f64) {
        if self.len < ENOUGH {
            return (0.0, 0.0);
        }
        let newest = (self.next + HISTORY - 1) % HISTORY;
        let origin = self.samples[newest].0;
        let mut sums = [0.0; 4];
        let mut oldest = 0.0;
        for k in 0..self.len {
            let (time, range) = self.samples[(newest + HISTORY - k) % HISTORY];
            let t = time - origin;
            oldest = t;
            sums = [sums[0] + t, sums[1] + range, sums[2] + t * t, sums[3] + t * range];
        }
        let n = self.len as f64;
        let spread = n * sums[2] - sums[0] * sums[0];
        if spread <= 0.0 {
            return (0.0, 0.0);
        }
        let slope = (n * sums[3] - sums[0] * sums[1]) / spread;
        (-slope, slope * oldest)
    }
}
