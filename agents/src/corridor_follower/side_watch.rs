//! Where a wall ends, and where its corner must be.

use super::Comparison;

/// Watches one side of the corridor: where it has been a wall, where that wall ended.
///
/// Positions are path lengths along the corridor, m. What is tracked is not the transducer but the *trailing edge* of its beam
/// on the wall, `D · tan α` behind the point that it faces: as long as a wall reaches into the beam it is heard, so the corner
/// is where the trailing edge was when the wall fell silent. That is why Randazza's (1989, §2.9) robot noticed the end of a
/// wall 14 cm late.
///
/// No single reading decides. The newest readings are split in two where "something, then nothing" explains them best; an
/// opening is believed if the later part is long enough and holds no more than one stray echo in five.
#[derive(Debug, Clone, Copy)]
pub struct SideWatch {
    least: f64,
    depth: f64,
    glances: [Glance; SideWatch::WINDOW],
    count: usize,
    state: State,
    /// Where the present wall began to be seen.
    wall_from: Option<f64>,
    wall_streak: usize,
    corner: Option<f64>,
    edge: f64,
    surplus: f64,
}

#[derive(Debug, Clone, Copy, Default)]
struct Glance {
    edge: f64,
    open: bool,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
enum State {
    #[default]
    Unknown,
    Wall,
    Open,
}

/// A reading within this of the expected range is the wall, m.
const WALL: f64 = 0.25;
/// Two readings of the same thing differ by less than this, m.
const ALIKE: f64 = 0.15;
/// So many readings in a row make a wall, and so many at least an opening.
const BELIEVED: usize = 5;

impl SideWatch {
    const WINDOW: usize = 16;

    /// A side about which nothing is known. A wall shorter than `least` (m) is not one whose end is an opening; an opening is
    /// at least `depth` (m) deeper than the wall.
    #[must_use]
    pub fn new(least: f64, depth: f64) -> Self {
        Self {
            least,
            depth,
            glances: Default::default(),
            count: 0,
            state: State::Unknown,
            wall_from: None,
            wall_streak: 0,
            corner: None,
            edge: f64::NEG_INFINITY,
            surplus: f64::INFINITY,
        }
    }

    /// Takes a reading of a transducer that faces the wall, taken when the robot's centre was at path length `at`.
    pub fn hear(&mut self, at: f64, reading: &Comparison) {
        let surplus = reading.surplus;
        // What stands before the wall is nearer than it, and the beam narrower there; but a stray echo is nothing that stands.
        let nearer = if (surplus - self.surplus).abs() < ALIKE { surplus.min(0.0) } else { 0.0 };
        let edge = at + reading.ahead - (reading.expected + nearer) * reading.lag;
        (self.edge, self.surplus) = (edge, surplus);
        // Something that stands before the wall is no opening, but no wall either.
        let open = surplus > self.depth;
        self.glances[self.count % Self::WINDOW] = Glance { edge, open };
        self.count += 1;
        self.wall_streak = if surplus.abs() <= WALL { self.wall_streak + 1 } else { 0 };
        if self.state != State::Wall && self.wall_streak >= BELIEVED {
            self.state = State::Wall;
            (self.wall_from, self.corner) = (Some(edge), None);
        }
        if self.state == State::Open {
            return;
        }
        if let Some(end) = self.end() {
            self.state = State::Open;
            self.corner = self.wall_from.take().filter(|from| end - from >= self.least).map(|_| end);
        }
    }

    /// True if no wall is there now.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.state == State::Open
    }

    /// Where the wall ended, if there was enough of it and the side is still open.
    #[must_use]
    pub fn corner(&self) -> Option<f64> {
        self.corner
    }

    /// Where the trailing edge of the beam met the wall when this side was heard last.
    #[must_use]
    pub fn edge(&self) -> f64 {
        self.edge
    }

    /// Where the newest readings change from something to nothing, if they do.
    fn end(&self) -> Option<f64> {
        let held = self.count.min(Self::WINDOW);
        let glance = |n: usize| self.glances[(self.count - held + n) % Self::WINDOW];
        // Moving the split past an open reading puts that one on the wrong side, past any other one the right way.
        let mut strays = (0..held).filter(|n| !glance(*n).open).count();
        let (mut first, mut split, mut fewest, mut strays_after) = (0, 0, strays, strays);
        let mut after = strays;
        for n in 0..held {
            if glance(n).open {
                strays += 1;
            } else {
                strays -= 1;
                after -= 1;
            }
            if strays <= fewest {
                // One stray beside the end makes two splits equally good, on either side of it.
                first = if strays == fewest && n - split < 2 { first } else { n + 1 };
                (split, fewest, strays_after) = (n + 1, strays, after);
            }
        }
        if held - split < BELIEVED || strays_after * 5 > held - split {
            return None;
        }
        let cut = |split: usize| 0.5 * (glance(split.saturating_sub(1)).edge + glance(split).edge);
        Some(0.5 * (cut(first) + cut(split)))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{super::Side, *};

    /// A reading at `at` of a beam ±12° wide that looks squarely at a wall 1 m away.
    fn hear(watch: &mut SideWatch, at: f64, surplus: f64) {
        let reading = Comparison { side: Side::Left, surplus, perpendicular: true, ahead: 0.0, expected: 1.0, lag: LAG };
        watch.hear(at, &reading);
    }

    const LAG: f64 = 0.21;

    /// Readings every centimetre; nothing is heard when the wall up to `corner` has left the beam, and `strays` are spurious.
    fn pass(corner: f64, strays: &[(usize, f64)]) -> SideWatch {
        let mut watch = SideWatch::new(0.5, 0.65);
        for n in 0..200 {
            let at = 0.01 * n as f64;
            let truth = if at - LAG > corner { 2.0 } else { 0.0 };
            let stray = strays.iter().find(|(number, _)| *number == n);
            hear(&mut watch, at, stray.map_or(truth, |(_, surplus)| *surplus));
        }
        watch
    }

    #[test]
    fn a_wall_too_short_is_no_corner() {
        assert!(pass(0.2, &[]).is_open());
        assert_eq!(pass(0.2, &[]).corner(), None);
    }

    #[test]
    fn furniture_belongs_to_the_wall() {
        let mut watch = SideWatch::new(0.5, 0.65);
        for n in 0..200 {
            let at = 0.01 * f64::from(n);
            // A cupboard half a metre deep ends at 1.395 m.
            let surplus = if at < 1.0 {
                0.0
            } else if at - 0.5 * LAG < 1.395 {
                -0.5
            } else {
                1.5
            };
            hear(&mut watch, at, surplus);
        }
        // Its end, and the beam at the wall behind, between which the corner may lie.
        assert!(watch.corner().is_some_and(|corner| (corner - 1.395).abs() < 0.07), "{:?}", watch.corner());
    }

    #[test]
    fn a_recess_too_shallow_is_no_opening() {
        let mut watch = SideWatch::new(0.5, 0.65);
        for n in 0..200 {
            hear(&mut watch, 0.01 * f64::from(n), if n < 100 { 0.0 } else { 0.5 });
        }
        assert!(!watch.is_open() && watch.corner().is_none());
    }

    #[test]
    fn a_wall_after_an_opening_starts_anew() {
        let mut watch = pass(1.0, &[]);
        assert!(watch.corner().is_some());
        for n in 200..260 {
            hear(&mut watch, 0.01 * f64::from(n), 0.0);
        }
        assert!(!watch.is_open() && watch.corner().is_none());
    }

    #[test]
    fn a_stray_echo_right_after_a_corner_does_not_move_it() {
        // The reading after the first silent one is spurious: the wall ended before the one, or after the other.
        let found = pass(1.190_278, &[(142, 0.0)]).corner();
        assert!(found.is_some_and(|found| (found - 1.190_278).abs() <= 0.021), "{found:?}");
    }

    proptest! {
        #[test]
        fn one_stray_echo_does_not_move_a_corner(corner in 0.8..1.5f64, stray in 0usize..200, surplus in -0.9..6.0f64) {
            let found = pass(corner, &[(stray, surplus)]).corner();
            // Only a stray right at the corner can be mistaken for the wall, and only by itself.
            prop_assert!(found.is_some_and(|found| (found - corner).abs() <= 0.021), "{found:?}");
        }
    }
}
