//! Who stands near?
//!
//! Bodies move in every step, so the arrangement is made anew once a step and has to be cheap: each body gets the number of the
//! cell in which its centre lies, and the bodies are sorted by cell. A query looks cells up by bisection. There is no table of
//! cells that would grow with the world, nothing is hashed, and nothing allocates once there is room for all.

use nalgebra::Point2;

use super::geometry::Disc;

/// Side of a cell, m: a ring of a few metres looks at a handful of rows.
const CELL: f64 = 4.0;
/// Rounding of sums and differences of coordinates, as a share of them and in metres.
const ROUNDING: (f64, f64) = (1e-12, 1e-9);

/// Moving bodies, arranged by where they stand. All answers are exact: those of a plain loop over all of them.
///
/// ```
/// use nalgebra::Point2;
/// use orienteer_hardware::world::{disc_grid::DiscGrid, geometry::Disc};
/// let mut grid = DiscGrid::default();
/// grid.arrange([0.0, 9.0, 2.0].map(|x| Disc::new(Point2::new(x, 0.0), 0.5)));
/// let mut found = Vec::new();
/// grid.near(Point2::new(1.0, 0.0), 1.0, &mut found);
/// assert_eq!(found, [0, 2]);
/// ```
#[derive(Debug, Clone, Default)]
pub struct DiscGrid {
    discs: Vec<Disc>,
    /// Sorted.
    places: Vec<(Cell, u32)>,
    /// The largest radius.
    largest: f64,
}

/// Row, then column.
type Cell = (i32, i32);

impl DiscGrid {
    /// The bodies in the order in which they were given.
    #[must_use]
    pub fn discs(&self) -> &[Disc] {
        &self.discs
    }

    /// Radius of the largest body, m; 0 if there is none.
    #[must_use]
    pub fn largest_radius(&self) -> f64 {
        self.largest
    }

    /// Replaces all bodies.
    pub fn arrange(&mut self, discs: impl IntoIterator<Item = Disc>) {
        self.discs.clear();
        self.discs.extend(discs);
        self.sort();
    }

    /// Adds a body behind all others.
    pub fn push(&mut self, disc: Disc) {
        self.discs.push(disc);
        self.sort();
    }

    /// Moves the centres of all bodies, in their order; those for which there is none stay.
    pub fn move_to(&mut self, centers: impl IntoIterator<Item = Point2<f64>>) {
        for (disc, center) in self.discs.iter_mut().zip(centers) {
            disc.center = center;
        }
        self.sort();
    }

    fn sort(&mut self) {
        self.largest = self.discs.iter().map(|disc| disc.radius).fold(0.0, f64::max);
        self.places.clear();
        self.places.extend(self.discs.iter().zip(0..).map(|(disc, number)| (cell(disc.center.x, disc.center.y), number)));
        self.places.sort_unstable();
    }

    /// Appends the numbers of all bodies of which some part is within `reach` (m) of a point, in ascending order.
    pub fn near(&self, at: Point2<f64>, reach: f64, found: &mut Vec<u32>) {
        let from = found.len();
        self.each_near(at, reach, |number, _| found.push(number));
        found[from..].sort_unstable();
    }

    /// Shows all bodies of which some part is within `reach` (m) of a point, in no particular order.
    pub fn each_near(&self, at: Point2<f64>, reach: f64, mut show: impl FnMut(u32, Disc)) {
        let [x, y] = [at.x, at.y].map(|v| {
            let radius = reach + self.largest;
            let rounding = ROUNDING.0 * (v.abs() + radius.abs()) + ROUNDING.1;
            (v - radius - rounding, v + radius + rounding)
        });
        let ((mut row, first), (last_row, last)) = (cell(x.0, y.0), cell(x.1, y.1));
        let mut rest = self.places.as_slice();
        while row <= last_row {
            rest = &rest[rest.partition_point(|(cell, _)| *cell < (row, first))..];
            match rest.first() {
                // Nobody is left in this row: go on with the next that has anybody.
                Some(((next, _), _)) if *next > row => row = *next,
                Some(_) => {
                    let (inside, beyond) = rest.split_at(rest.partition_point(|(cell, _)| *cell <= (row, last)));
                    for (_, number) in inside {
                        let disc = self.discs[*number as usize];
                        if (disc.center - at).norm() <= reach + disc.radius {
                            show(*number, disc);
                        }
                    }
                    rest = beyond;
                    let Some(next) = row.checked_add(1) else { break };
                    row = next;
                }
                None => break,
            }
        }
    }
}

/// Casts of numbers beyond the range of an `i32` end at its rim, which keeps their order.
fn cell(x: f64, y: f64) -> Cell {
    ((y / CELL).floor() as i32, (x / CELL).floor() as i32)
}

#[cfg(test)]
mod tests {
    use proptest::{collection::vec, prelude::*};

    use super::*;

    fn linear(discs: &[Disc], at: Point2<f64>, reach: f64) -> Vec<u32> {
        let near = |(disc, _): &(&Disc, u32)| (disc.center - at).norm() <= reach + disc.radius;
        discs.iter().zip(0..).filter(near).map(|(_, number)| number).collect()
    }

    /// Mostly within a few cells of each other, often on the borders between them, sometimes absurd.
    fn coordinate() -> impl Strategy<Value = f64> {
        prop_oneof![
            6 => -20.0..20.0,
            3 => (-5..5i32).prop_map(|i| f64::from(i) * CELL),
            2 => -600.0..600.0,
            1 => prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(f64::NEG_INFINITY), Just(1e300), Just(-1e18), Just(8.6e9)],
        ]
    }

    fn point() -> impl Strategy<Value = Point2<f64>> {
        (coordinate(), coordinate()).prop_map(|(x, y)| Point2::new(x, y))
    }

    fn disc() -> impl Strategy<Value = Disc> {
        let radius = prop_oneof![4 => 0.1..0.6, 1 => Just(0.0), 1 => 0.0..9.0];
        (point(), radius).prop_map(|(center, radius)| Disc::new(center, radius))
    }

    fn finite() -> impl Strategy<Value = Point2<f64>> {
        point().prop_filter("somebody asks from somewhere", |p| p.coords.iter().all(|v| v.is_finite()))
    }

    fn reach() -> impl Strategy<Value = f64> {
        prop_oneof![4 => 0.0..12.0, 2 => (0..4i32).prop_map(|i| f64::from(i) * CELL), 1 => -1.0..0.0, 1 => 0.0..1e3, 1 => Just(f64::INFINITY)]
    }

    proptest! {
        #[test]
        fn finds_whom_a_loop_over_all_finds_and_in_the_same_order(
            discs in vec(disc(), 0..60), moved in vec(point(), 0..60), from in vec((finite(), reach()), 1..20)
        ) {
            let mut grid = DiscGrid::default();
            grid.arrange(discs.iter().copied());
            for moves in [vec![], moved] {
                grid.move_to(moves);
                for (at, reach) in &from {
                    let mut found = vec![];
                    grid.near(*at, *reach, &mut found);
                    prop_assert_eq!(found, linear(grid.discs(), *at, *reach));
                }
            }
        }

        #[test]
        fn who_just_touches_is_found(x in -1e3..1e3f64, y in -1e3..1e3f64, angle in -4.0..4.0f64, reach in 0.0..20.0f64) {
            let at = Point2::new(x, y);
            let center = at + nalgebra::Vector2::new(angle.cos(), angle.sin()) * (reach + 0.25);
            let mut grid = DiscGrid::default();
            grid.push(Disc::new(center, 0.25));
            let mut found = vec![];
            grid.near(at, reach, &mut found);
            prop_assert_eq!(found, linear(grid.discs(), at, reach));
        }
    }
}
