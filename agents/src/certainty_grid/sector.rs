//! Which cells lie in a beam.
//!
//! A [`Sector`] is the part of the plane that a transducer speaks about: within `half_angle` of its axis and between two
//! distances from its face. For every row of cells it yields at most two runs of columns, found in closed form: the two
//! edges of the beam bound the row by straight lines, the circles by chords. So each cell comes up once, at any bearing,
//! and whole runs can be updated by vector instructions. (Good 1992, §2.3.1, marched along the nearer axis between rounded
//! edges, which leaves cells out around 45°.)
//!
//! A narrow beam misses every cell centre close to the face, where it is thinner than a cell; [`Coverage`] says what to do
//! about that.

use std::ops::Range;

use nalgebra::Point2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Grid;

/// Which cells count as lying in a sector.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Coverage {
    /// Those whose centre does. Thin beams leave gaps near the face.
    Centre,
    /// Those whose centre is at most half a cell beside the sector: as `centre`, but without gaps.
    #[default]
    Connected,
    /// Those that the edges of the beam touch, however little: rounds outward.
    Touch,
}

/// Part of a disc about a transducer's face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sector {
    /// The face, map frame, m.
    pub apex: Point2<f64>,
    /// Direction of the axis, map frame, rad.
    pub bearing: f64,
    /// Half the opening angle, rad; at most a right angle.
    pub half_angle: f64,
    /// Cells nearer to the face than this do not belong, m.
    pub inner: f64,
    /// Cells as far from the face as this, or farther, do not belong, m.
    pub outer: f64,
    /// Which cells count.
    pub coverage: Coverage,
}

/// Where the cells are: the geometry of a grid's window without its contents.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lattice {
    origin: Point2<f64>,
    per_metre: f64,
    width: usize,
    height: usize,
}

impl Lattice {
    /// The lattice of a grid's present window.
    #[must_use]
    pub fn of(grid: &Grid) -> Self {
        Self { origin: grid.origin(), per_metre: 1.0 / grid.cell_size(), width: grid.width(), height: grid.height() }
    }
}

/// Numbers beyond this, in cells or rad, are not those of a beam; it keeps conversions to integers far from their limits.
const FARTHEST: f64 = 1e9;

/// The half-plane `a·x + b·y ≤ d`, as a bound on `x` in a given row.
#[derive(Debug, Clone, Copy)]
struct Edge {
    slope: f64,
    at_zero: f64,
    side: Side,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Side {
    Upper,
    Lower,
    /// The edge is parallel to the rows: it admits a row or it does not.
    Row,
}

impl Edge {
    fn new(a: f64, b: f64, d: f64) -> Self {
        if a.abs() < 1e-9 {
            return Self { slope: b, at_zero: d, side: Side::Row };
        }
        let side = if a > 0.0 { Side::Upper } else { Side::Lower };
        Self { slope: -b / a, at_zero: d / a, side }
    }

    #[inline]
    fn narrow(&self, y: f64, low: &mut f64, high: &mut f64) {
        let x = self.slope * y + self.at_zero;
        match self.side {
            Side::Upper => *high = high.min(x),
            Side::Lower => *low = low.max(x),
            Side::Row if self.slope * y > self.at_zero => *high = f64::NEG_INFINITY,
            Side::Row => {}
        }
    }
}

impl Sector {
    /// Calls `visit` with a row and a run of columns, counted from the window's lower left cell, for all cells of the window
    /// that belong to the sector. Runs do not overlap. A sector with a number that is not finite
    /// or beyond all reason has no cells.
    #[inline]
    pub fn for_each_run(&self, lattice: &Lattice, mut visit: impl FnMut(usize, Range<usize>)) {
        // From here on in cells, with cell centres at whole numbers.
        let scale = lattice.per_metre;
        let x0 = (self.apex.x - lattice.origin.x) * scale - 0.5;
        let y0 = (self.apex.y - lattice.origin.y) * scale - 0.5;
        let (inner, outer) = (self.inner.max(0.0) * scale, self.outer * scale);
        let reasonable = [x0, y0, inner, outer, self.bearing, self.half_angle].iter().all(|number| number.abs() < FARTHEST);
        if !reasonable || outer <= 0.0 {
            return;
        }
        let (left, right, aside) = self.edges();
        let edges = [
            Edge::new(-left.1, left.0, aside.0),
            Edge::new(right.1, -right.0, aside.1),
            Edge::new(-self.bearing.cos(), -self.bearing.sin(), 0.0),
        ];
        let (lowest, highest) = vertical_extent(left, right, outer, aside.0.max(aside.1));
        let rows = clip(ceil(y0 + lowest), floor(y0 + highest) + 1, lattice.height);
        let (inner_squared, outer_squared) = (inner * inner, outer * outer);
        for row in rows {
            let y = row as f64 - y0;
            let rest = outer_squared - y * y;
            if rest <= 0.0 {
                continue;
            }
            let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
            for edge in &edges {
                edge.narrow(y, &mut low, &mut high);
            }
            // The rim itself is outside, the inner circle inside, so that sectors that share a circle share no cell.
            let chord = rest.sqrt();
            let start = ceil(x0 + low.clamp(-outer - 1.0, outer + 1.0)).max(floor(x0 - chord) + 1);
            let end = (floor(x0 + high.clamp(-outer - 1.0, outer + 1.0)) + 1).min(ceil(x0 + chord));
            let hole = inner_squared - y * y;
            if hole > 0.0 {
                let chord = hole.sqrt();
                let before = clip(start, end.min(floor(x0 - chord) + 1), lattice.width);
                let after = clip(start.max(ceil(x0 + chord)).max(before.end as i64), end, lattice.width);
                for run in [before, after] {
                    if !run.is_empty() {
                        visit(row, run);
                    }
                }
            } else {
                let run = clip(start, end, lattice.width);
                if !run.is_empty() {
                    visit(row, run);
                }
            }
        }
    }

    /// Unit vectors along the left and the right edge, and by how many cells each edge is moved outward.
    fn edges(&self) -> ((f64, f64), (f64, f64), (f64, f64)) {
        let half = self.half_angle.clamp(0.0, std::f64::consts::FRAC_PI_2);
        let (left_sin, left_cos) = (self.bearing + half).sin_cos();
        let (right_sin, right_cos) = (self.bearing - half).sin_cos();
        let aside = match self.coverage {
            Coverage::Centre => (0.0, 0.0),
            Coverage::Connected => (0.5, 0.5),
            Coverage::Touch => (0.5 * (left_sin.abs() + left_cos.abs()), 0.5 * (right_sin.abs() + right_cos.abs())),
        };
        ((left_cos, left_sin), (right_cos, right_sin), aside)
    }
}

/// Lowest and highest `y` of the sector between two edges, relative to its apex.
fn vertical_extent(left: (f64, f64), right: (f64, f64), outer: f64, aside: f64) -> (f64, f64) {
    let (a, b) = (left.1 * outer, right.1 * outer);
    let (mut low, mut high) = (a.min(b).min(0.0) - aside, a.max(b).max(0.0) + aside);
    // Going counter-clockwise from the right edge to the left one, y has its maximum where x turns from + to -.
    if right.0 >= 0.0 && left.0 <= 0.0 {
        high = outer;
    }
    if right.0 <= 0.0 && left.0 >= 0.0 {
        low = -outer;
    }
    (low.max(-outer), high.min(outer))
}

/// The part of `start..end` that lies in `0..count`.
#[inline]
fn clip(start: i64, end: i64, count: usize) -> Range<usize> {
    let start = start.clamp(0, count as i64) as usize;
    let end = end.clamp(0, count as i64) as usize;
    start..end.max(start)
}

// The library's `floor` is a call on processors without SSE 4.1, which is what we compile for.
#[inline(always)]
fn floor(x: f64) -> i64 {
    let whole = x as i64;
    whole - i64::from(whole as f64 > x)
}

#[inline(always)]
fn ceil(x: f64) -> i64 {
    let whole = x as i64;
    whole + i64::from((whole as f64) < x)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::f64::consts::{FRAC_PI_2, PI};

    use proptest::prelude::*;

    use super::*;
    use crate::certainty_grid::{CellIndex, Layout, Rules};

    fn grid(cell: f64) -> Grid {
        let layout = Layout { cell, width: 61, height: 47, origin: Point2::new(-3.0, -2.0) };
        Grid::new(layout, Rules::default()).unwrap()
    }

    /// How far inside the sector a point lies, m: negative outside. Written from the definition, by angles.
    fn depth(sector: &Sector, cell: f64, point: Point2<f64>) -> f64 {
        let offset = point - sector.apex;
        let distance = offset.norm();
        let angle = orienteer_runtime::geometry::angle::turn(sector.bearing, offset.y.atan2(offset.x));
        let beside = |edge: f64| {
            let edge_bearing = sector.bearing + edge * sector.half_angle;
            let aside = match sector.coverage {
                Coverage::Centre => 0.0,
                Coverage::Connected => 0.5 * cell,
                Coverage::Touch => 0.5 * cell * (edge_bearing.sin().abs() + edge_bearing.cos().abs()),
            };
            aside - distance * (edge * angle - sector.half_angle).sin()
        };
        let ahead = distance * angle.cos();
        // sin() is the signed distance from the edge's line within a right angle of it
        let beside = if angle.abs() + sector.half_angle <= PI { beside(1.0).min(beside(-1.0)) } else { -1.0 };
        beside.min(ahead).min(distance - sector.inner).min(sector.outer - distance)
    }

    fn sectors() -> impl Strategy<Value = (f64, Sector)> {
        let coverage = prop_oneof![Just(Coverage::Centre), Just(Coverage::Connected), Just(Coverage::Touch)];
        let place = (-4.0..4.0f64, -3.0..4.0f64, -PI..PI);
        (0.05..0.4f64, place, 0.0..FRAC_PI_2, 0.0..5.0f64, 0.0..3.0f64, coverage).prop_map(
            |(cell, (x, y, bearing), half_angle, outer, inner, coverage)| {
                (cell, Sector { apex: Point2::new(x, y), bearing, half_angle, inner, outer, coverage })
            },
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(600))]
        #[test]
        fn runs_are_the_cells_whose_centre_lies_inside((cell, sector) in sectors()) {
            let grid = grid(cell);
            let mut hits = vec![0u8; grid.width() * grid.height()];
            sector.for_each_run(&Lattice::of(&grid), |row, run| {
                for column in run {
                    hits[row * grid.width() + column] += 1;
                }
            });
            for row in 0..grid.height() as i32 {
                for column in 0..grid.width() as i32 {
                    let index = CellIndex::new(column, row);
                    let depth = depth(&sector, cell, grid.centre_of(index));
                    if depth.abs() > 1e-7 {
                        prop_assert_eq!(hits[grid.slot(index).unwrap()], u8::from(depth > 0.0), "{:?} {:e}", index, depth);
                    }
                }
            }
        }

        #[test]
        fn sectors_that_share_a_circle_share_no_cell(
            x in -20i32..20, y in -20i32..20, bearing in -8i32..8, inner in 0i32..30, more in 1i32..9,
        ) {
            // Round numbers, so that many centres lie on the circle exactly.
            let grid = grid(0.1);
            let (inner, outer) = (f64::from(inner) * 0.1, f64::from(inner + more) * 0.1);
            let apex = Point2::new(f64::from(x) * 0.05, f64::from(y) * 0.05);
            let near = Sector {
                apex, bearing: f64::from(bearing) * PI / 8.0, half_angle: 0.6, inner: 0.0, outer: inner, coverage: Coverage::Connected,
            };
            let mut hits = vec![0u8; grid.width() * grid.height()];
            for sector in [near, Sector { inner, outer, ..near }] {
                sector.for_each_run(&Lattice::of(&grid), |row, run| run.for_each(|column| hits[row * grid.width() + column] += 1));
            }
            let mut whole = vec![0u8; hits.len()];
            let both = Sector { outer, ..near };
            both.for_each_run(&Lattice::of(&grid), |row, run| run.for_each(|column| whole[row * grid.width() + column] += 1));
            prop_assert_eq!(hits, whole);
        }

        #[test]
        fn a_connected_beam_has_no_gap_along_its_axis((cell, sector) in sectors()) {
            let sector = Sector { inner: 0.0, coverage: Coverage::Connected, half_angle: 0.02, ..sector };
            let grid = grid(cell);
            let mut covered = vec![false; grid.width() * grid.height()];
            sector.for_each_run(&Lattice::of(&grid), |row, run| run.for_each(|column| covered[row * grid.width() + column] = true));
            // Each cell through whose middle third the axis passes.
            let mut distance = cell;
            while distance < sector.outer - cell {
                let on_axis = sector.apex + distance * nalgebra::Vector2::new(sector.bearing.cos(), sector.bearing.sin());
                let index = grid.index_of(on_axis);
                let beside = (grid.centre_of(index) - on_axis).abs().max();
                if let Some(slot) = grid.slot(index).filter(|_| beside < 0.3 * cell) {
                    prop_assert!(covered[slot]);
                }
                distance += 0.1 * cell;
            }
        }
    }

    #[test]
    fn numbers_that_are_not_finite_mark_nothing() {
        let good = Sector {
            apex: Point2::new(0.0, 0.0),
            bearing: 0.0,
            half_angle: 0.2,
            inner: 0.0,
            outer: 1.0,
            coverage: Coverage::default(),
        };
        let bad = [
            Sector { bearing: f64::NAN, ..good },
            Sector { outer: f64::INFINITY, ..good },
            Sector { apex: Point2::new(1e300, 0.0), ..good },
            Sector { apex: Point2::new(0.0, -1e30), outer: 2e30, ..good },
            Sector { outer: -1.0, ..good },
        ];
        for sector in bad {
            sector.for_each_run(&Lattice::of(&grid(0.1)), |_, _| panic!("{sector:?} has cells"));
        }
    }
}
