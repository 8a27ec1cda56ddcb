/// Watches the wall on one side: since where it is there, and where it ended.
///
/// Positions are path lengths along the corridor, m.
#[derive(Debug, Clone, Copy, Default)]
pub struct SideWatch {
    wall_from: Option<f64>,
    wall_to: f64,
    last_range: f64,
    open_streak: u32,
    wall_streak: u32,
}

/// A reading within this of the expected range is the wall, m.
const WALL: f64 = 0.25;
/// A reading this much beyond the expected range says that there is no wall, m.
const OPEN: f64 = 0.35;
/// So many readings in a row are believed; one spurious echo in a hundred then deceives once in 10⁸ readings.
const BELIEVED: u32 = 4;

impl SideWatch {
    /// Takes a reading of a transducer that faces the wall squarely, at path length `at`: `surplus` is reading minus expected
    /// range, `range` the expected one.
    pub fn hear(&mut self, at: f64, surplus: f64, range: f64) {
        if surplus > OPEN {
            self.open_streak += 1;
            self.wall_streak = 0;
        } else if surplus.abs() <= WALL {
            self.wall_streak += 1;
            self.open_streak = 0;
            if self.wall_streak == BELIEVED && self.wall_from.is_none() {
                self.wall_from = Some(at);
            }
            if self.wall_streak >= BELIEVED {
                (self.wall_to, self.last_range) = (at, range);
            }
        } else {
            // Something stands before the wall: neither a wall nor an opening.
            self.open_streak = 0;
        }
    }

    /// True if several readings in a row found no wall.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.open_streak >= BELIEVED
    }

    /// Where the wall ended, if it was there for at least `least` metres and is now open.
    ///
    /// The last echo came when the corner lay at the edge of the beam, `range · tan(half_beam)` behind the transducer.
    #[must_use]
    pub fn ended(&self, least: f64, half_beam: f64) -> Option<f64> {
        let from = self.wall_from?;
        (self.is_open() && self.wall_to - from >= least).then(|| self.wall_to - self.last_range * half_beam.tan())
    }

    /// Forgets an opening that was passed: the next wall starts anew.
    pub fn begin_anew(&mut self) {
        *self = Self::default();
    }
}
