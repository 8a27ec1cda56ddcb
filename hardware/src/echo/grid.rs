//! What a beam may meet, in a uniform grid of cells.

use nalgebra::Point2;
use thiserror::Error;

/// How well a person sends sound back unless somebody knows better: clothes swallow about half of it.
pub const PERSON_REFLECTANCE: f64 = 0.5;

/// Side of a grid cell, m: a beam of a few metres then reads a handful of cells, each with a handful of walls.
const CELL: f64 = 1.0;
/// Cells grow beyond [`CELL`] rather than become more than this.
const MAX_CELLS: f64 = 4e6;
/// No coordinate may be farther from the origin than this, m.
const MAX_EXTENT: f64 = 1e6;
/// Items are listed in every cell within this share of a cell, so that rounding can't lose one between two cells.
const MARGIN: f64 = 1e-6;

/// A straight piece of wall. Both sides reflect; it has no thickness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall {
    /// One end, m.
    pub a: Point2<f64>,
    /// The other end, m.
    pub b: Point2<f64>,
    /// Share of the sound sent back, 0 (never heard, but still in the way) to 1.
    pub reflectance: f64,
}

impl Wall {
    /// A wall of a hard material (reflectance 1) between two points.
    #[must_use]
    pub fn new(a: Point2<f64>, b: Point2<f64>) -> Self {
        Self { a, b, reflectance: 1.0 }
    }
}

/// An edge or a corner: it scatters sound in all directions, hides nothing, and is heard from close by only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex {
    /// Where, m.
    pub at: Point2<f64>,
    /// Share of the model's vertex range from which it is heard, 0 to 1.
    pub strength: f64,
}

/// A round body: a pillar, a robot or a person.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disc {
    /// Where its middle is, m.
    pub centre: Point2<f64>,
    /// m.
    pub radius: f64,
    /// Share of the sound sent back, 0 to 1.
    pub reflectance: f64,
}

/// Why a world can't be put into a grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum GridError {
    /// A coordinate or radius is not finite, or is farther than 1000 km away.
    #[error("{kind} {index} of the world has a coordinate that is not a number or is absurdly large")]
    Absurd {
        /// `wall`, `vertex` or `pillar`.
        kind: &'static str,
        /// Its place in the list, from 0.
        index: usize,
    },
}

/// A wall with its unit normal worked out, one cache line.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(super) struct Line {
    pub(super) ax: f64,
    pub(super) ay: f64,
    pub(super) bx: f64,
    pub(super) by: f64,
    pub(super) nx: f64,
    pub(super) ny: f64,
    pub(super) reflectance: f64,
}

/// The static part of a world: walls, pillars and vertices in a uniform grid of lists, built once.
///
/// Each cell lists what touches it. There is one set of lists in which the cells of a column are neighbours and one in which
/// those of a row are, so that a beam reads all cells of a column (or row) that it covers in one go.
///
/// ```
/// use nalgebra::Point2;
/// use orienteer_hardware::echo::{SegmentGrid, Wall};
///
/// let wall = Wall::new(Point2::new(2.0, -1.0), Point2::new(2.0, 1.0));
/// let world = SegmentGrid::new(&[wall], &[], &[])?;
/// assert_eq!(world.len(), 1);
/// # Ok::<(), orienteer_hardware::echo::GridError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SegmentGrid {
    pub(super) lines: Vec<Line>,
    pub(super) pillars: Vec<Disc>,
    pub(super) vertices: Vec<Vertex>,
    pub(super) frame: Frame,
    pub(super) lines_at: Lists,
    pub(super) pillars_at: Lists,
    pub(super) vertices_at: Lists,
}

/// The things of one kind that touch each cell.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Lists {
    /// With the cells of a column side by side.
    columns: Runs,
    /// With the cells of a row side by side.
    rows: Runs,
}

#[derive(Debug, Clone, Default, PartialEq)]
struct Runs {
    /// Where each cell's list begins in `items`; one more than there are cells.
    starts: Vec<u32>,
    items: Vec<u32>,
}

/// Cells side by side in one column (or row) of the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cells {
    pub(super) in_column: bool,
    pub(super) first: usize,
    pub(super) count: usize,
}

/// Where the grid's cells lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) cell: f64,
    pub(super) per_cell: f64,
    pub(super) columns: i32,
    pub(super) rows: i32,
}

impl SegmentGrid {
    /// Sorts a world into cells. A wall without length is kept (indices stay those of the slices) but never met.
    ///
    /// # Errors
    /// [`GridError::Absurd`] names the first item with a coordinate that can't be meant.
    pub fn new(walls: &[Wall], vertices: &[Vertex], pillars: &[Disc]) -> Result<Self, GridError> {
        check("wall", walls, |w| {
            w.a.coords.abs().max().max(w.b.coords.abs().max()) + 0.0 * (w.a.coords.sum() + w.b.coords.sum())
        })?;
        check("vertex", vertices, |v| v.at.coords.abs().max() + 0.0 * v.at.coords.sum())?;
        check("pillar", pillars, |d| d.centre.coords.abs().max() + 0.0 * d.centre.coords.sum() + d.radius.abs())?;

        let frame = Frame::around(walls, vertices, pillars);
        let lines: Vec<_> = walls.iter().map(Line::new).collect();
        Ok(Self {
            lines_at: Lists::new(&frame, &lines, |line, visit| {
                frame.touched_by_line([line.ax, line.ay], [line.bx, line.by], visit);
            }),
            pillars_at: Lists::new(&frame, pillars, |disc, visit| frame.touched_by_disc(disc, visit)),
            vertices_at: Lists::new(&frame, vertices, |vertex, visit| {
                frame.touched_by_line([vertex.at.x, vertex.at.y], [vertex.at.x, vertex.at.y], visit);
            }),
            frame,
            lines,
            pillars: pillars.to_vec(),
            vertices: vertices.to_vec(),
        })
    }

    /// Number of items of all kinds.
    #[must_use]
    pub fn len(&self) -> usize {
        self.lines.len() + self.pillars.len() + self.vertices.len()
    }

    /// True if the world is empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Lists {
    /// `touched` calls its argument with the column and row of each cell that a thing touches.
    fn new<T>(frame: &Frame, things: &[T], touched: impl Fn(&T, &mut dyn FnMut(i32, i32))) -> Self {
        let (columns, rows) = (frame.columns as usize, frame.rows as usize);
        let mut cells = vec![Vec::new(); columns * rows];
        for (i, thing) in things.iter().enumerate() {
            touched(thing, &mut |column, row| cells[column as usize * rows + row as usize].push(i as u32));
        }
        let mut lists = Self { columns: Runs::default(), rows: Runs::default() };
        cells.iter().for_each(|cell| lists.columns.push(cell));
        for row in 0..rows {
            (0..columns).for_each(|column| lists.rows.push(&cells[column * rows + row]));
        }
        lists.columns.push(&[]);
        lists.rows.push(&[]);
        lists
    }

    /// What touches these cells. A thing that touches several of them comes several times.
    pub(super) fn of(&self, cells: Cells) -> &[u32] {
        let runs = if cells.in_column { &self.columns } else { &self.rows };
        match (runs.starts.get(cells.first), runs.starts.get(cells.first + cells.count)) {
            (Some(&start), Some(&end)) => &runs.items[start as usize..end as usize],
            _ => &[],
        }
    }
}

impl Runs {
    fn push(&mut self, cell: &[u32]) {
        self.starts.push(self.items.len() as u32);
        self.items.extend_from_slice(cell);
    }
}

/// `reach` gives the largest magnitude of an item's coordinates, NaN if one is not a number.
fn check<T>(kind: &'static str, items: &[T], reach: impl Fn(&T) -> f64) -> Result<(), GridError> {
    match items.iter().position(|item| !(0.0..=MAX_EXTENT).contains(&reach(item))) {
        Some(index) => Err(GridError::Absurd { kind, index }),
        None => Ok(()),
    }
}

impl Line {
    fn new(wall: &Wall) -> Self {
        let along = wall.b - wall.a;
        // A wall without length gets no normal: all its comparisons are then false.
        let normal = along / along.norm();
        Self {
            ax: wall.a.x,
            ay: wall.a.y,
            bx: wall.b.x,
            by: wall.b.y,
            nx: -normal.y,
            ny: normal.x,
            reflectance: wall.reflectance,
        }
    }
}

impl Frame {
    fn around(walls: &[Wall], vertices: &[Vertex], pillars: &[Disc]) -> Self {
        let corner = |d: &Disc, sign: f64| d.centre.map(|c| c + sign * d.radius);
        let points = walls.iter().flat_map(|w| [w.a, w.b]).chain(vertices.iter().map(|v| v.at));
        let points = points.chain(pillars.iter().flat_map(|d| [corner(d, -1.0), corner(d, 1.0)]));
        let (mut low, mut high) = (Point2::new(f64::MAX, f64::MAX), Point2::new(f64::MIN, f64::MIN));
        for point in points {
            low = low.inf(&point);
            high = high.sup(&point);
        }
        if low.x > high.x {
            (low, high) = (Point2::origin(), Point2::origin());
        }
        let size = high - low;
        let mut cell = CELL;
        while (size.x / cell + 2.0) * (size.y / cell + 2.0) > MAX_CELLS {
            cell *= 2.0;
        }
        // Half a cell of border: nothing lies on the rim.
        let count = |length: f64| (length / cell) as i32 + 2;
        Self {
            x: low.x - 0.5 * cell,
            y: low.y - 0.5 * cell,
            cell,
            per_cell: cell.recip(),
            columns: count(size.x),
            rows: count(size.y),
        }
    }

    /// The cells along one axis that an interval touches, with a margin, clamped to the grid.
    fn span(&self, low: f64, high: f64, origin: f64, count: i32) -> (i32, i32) {
        let cell_of = |at: f64, margin: f64| (((at - origin) / self.cell + margin).floor() as i32).clamp(0, count - 1);
        (cell_of(low, -MARGIN), cell_of(high, MARGIN))
    }

    fn touched_by_disc(&self, disc: &Disc, visit: &mut dyn FnMut(i32, i32)) {
        let Disc { centre, radius, .. } = *disc;
        let (left, right) = self.span(centre.x - radius, centre.x + radius, self.x, self.columns);
        let (bottom, top) = self.span(centre.y - radius, centre.y + radius, self.y, self.rows);
        (left..=right).for_each(|column| (bottom..=top).for_each(|row| visit(column, row)));
    }

    /// Visits column by column the rows between the line's heights at the column's two sides.
    fn touched_by_line(&self, a: [f64; 2], b: [f64; 2], visit: &mut dyn FnMut(i32, i32)) {
        let (a, b) = if a[0] <= b[0] { (a, b) } else { (b, a) };
        let (left, right) = self.span(a[0], b[0], self.x, self.columns);
        let height = |x: f64| {
            let share = ((x - a[0]) / (b[0] - a[0])).clamp(0.0, 1.0);
            a[1] + share * (b[1] - a[1])
        };
        let steep = b[0] - a[0] <= MARGIN * self.cell;
        for column in left..=right {
            let west = self.x + (f64::from(column) - MARGIN) * self.cell;
            let east = self.x + (f64::from(column) + 1.0 + MARGIN) * self.cell;
            let (y0, y1) = if steep { (a[1], b[1]) } else { (height(west), height(east)) };
            let (bottom, top) = self.span(y0.min(y1), y0.max(y1), self.y, self.rows);
            (bottom..=top).for_each(|row| visit(column, row));
        }
    }
}
