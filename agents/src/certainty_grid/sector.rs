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
    /// Cells farther from the face than this do not belong, m. Of two sectors that share a circle, each cell on it belongs to
    /// one.
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

/// The edges of a beam, as bounds on `x` in a row: `x ≥ slope·y + offset` for each of `lower`, `x ≤ ...` for each of `upper`.
/// Slots that no edge needs hold a bound that the rim keeps anyway, so that the loop over rows has no branches.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    lower: [(f64, f64); 3],
    upper: [(f64, f64); 3],
    /// Lowest and highest `y` that an edge parallel to the rows admits.
    rows: (f64, f64),
}

impl Bounds {
    /// For half-planes `a·x + b·y ≤ d`.
    fn new(edges: [(f64, f64, f64); 3], outer: f64) -> Self {
        let mut bounds = Self { lower: [(0.0, -outer); 3], upper: [(0.0, outer); 3], rows: (-outer, outer) };
        for (slot, (a, b, d)) in edges.into_iter().enumerate() {
            if a.abs() < 1e-9 {
                let (low, high) = &mut bounds.rows;
                if b > 0.0 {
                    *high = high.min(d / b);
                } else {
                    *low = low.max(d / b);
                }
            } else if a > 0.0 {
                bounds.upper[slot] = (-b / a, d / a);
            } else {
                bounds.lower[slot] = (-b / a, d / a);
            }
        }
        bounds
    }

    /// Narrows `low..high` to what the edges admit in row `y`.
    #[inline(always)]
    fn narrow(&self, y: f64, mut low: f64, mut high: f64) -> (f64, f64) {
        // Comparisons instead of `min` and `max`, which take pains with numbers that are none.
        for (slope, offset) in self.lower {
            let x = slope * y + offset;
            low = if x > low { x } else { low };
        }
        for (slope, offset) in self.upper {
            let x = slope * y + offset;
            high = if x < high { x } else { high };
        }
        (low, high)
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
        let Beam { axis, left, right, aside } = self.beam();
        let edges = [(-left.1, left.0, aside.0), (right.1, -right.0, aside.1), (-axis.0, -axis.1, 0.0)];
        let bounds = Bounds::new(edges, outer);
        let (lowest, highest) = vertical_extent(left, right, outer, aside.0.max(aside.1));
        let (lowest, highest) = (lowest.max(bounds.rows.0), highest.min(bounds.rows.1));
        let rows = clip(ceil(y0 + lowest), floor(y0 + highest) + 1, lattice.height);
        let (inner_squared, outer_squared) = (inner * inner, outer * outer);
        for row in rows {
            let y = row as f64 - y0;
            let rest = outer_squared - y * y;
            if rest <= 0.0 {
                continue;
            }
            // A run ends where the next may begin, so that sectors that share a circle share no cell.
            let chord = rest.sqrt();
            let (low, high) = bounds.narrow(y, -chord, chord);
            let (start, end) = (ceil(x0 + low.min(outer)), ceil(x0 + high.max(-outer)));
            let hole = inner_squared - y * y;
            let mut start = start;
            if hole > 0.0 {
                let chord = hole.sqrt();
                let before = clip(start, end.min(ceil(x0 - chord)), lattice.width);
                if !before.is_empty() {
                    visit(row, before);
                }
                start = start.max(ceil(x0 + chord));
            }
            let run = clip(start, end, lattice.width);
            if !run.is_empty() {
                visit(row, run);
            }
        }
    }

    fn beam(&self) -> Beam {
        let (axis_sin, axis_cos) = self.bearing.sin_cos();
        let (half_sin, half_cos) = self.half_angle.clamp(0.0, std::f64::consts::FRAC_PI_2).sin_cos();
        let turned = |sin: f64| (axis_cos * half_cos - axis_sin * sin, axis_sin * half_cos + axis_cos * sin);
        let (left, right) = (turned(half_sin), turned(-half_sin));
        let aside = match self.coverage {
            Coverage::Centre => (0.0, 0.0),
            Coverage::Connected => (0.5, 0.5),
            Coverage::Touch => (0.5 * (left.0.abs() + left.1.abs()), 0.5 * (right.0.abs() + right.1.abs())),
        };
        Beam { axis: (axis_cos, axis_sin), left, right, aside }
    }
}

/// The directions of a sector as unit vectors, and by how many cells its edges are moved outward.
struct Beam {
    axis: (f64, f64),
    left: (f64, f64),
    right: (f64, f64),
    aside: (f64, f64),
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
#[inline(always)]
fn clip(start: i32, end: i32, count: usize) -> Range<usize> {
    let start = start.max(0) as usize;
    let end = (end.max(0) as usize).min(count);
    start..end
}

/// The least whole number that is not less than `x`, for numbers below [`FARTHEST`] by magnitude twice over. Adding 1.5 · 2⁵²
/// leaves no bits for a fraction: the sum's low bits are `x` rounded. (The library's function is a call on processors without
/// SSE 4.1, which is what we compile for, and its conversion checks for numbers that can't occur here.)
#[inline(always)]
fn ceil(x: f64) -> i32 {
    const ROUNDER: f64 = 6_755_399_441_055_744.0;
    let sum = x + ROUNDER;
    sum.to_bits() as i32 + i32::from(sum - ROUNDER < x)
}

fn floor(x: f64) -> i32 {
    -ceil(-x)
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
    fn whole_numbers_are_found_without_the_library() {
        for x in [0.0, -0.0, 0.5, 1.5, -0.5, -1.5, 2.0, -3.0, 1e-12, -1e-12, 2.0e9, -2.0e9 + 0.25, 12345.25] {
            assert_eq!((f64::from(ceil(x)), f64::from(floor(x))), (x.ceil(), x.floor()), "{x}");
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
