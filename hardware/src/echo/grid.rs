use nalgebra::Point2;
use thiserror::Error;

/// How well a person sends sound back unless somebody knows better: clothes swallow about half of it.
pub const PERSON_REFLECTANCE: f64 = 0.5;

/// Side of a grid cell, m. One metre was the fastest for beams of a few metres among worlds of 50 to 5000 segments.
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

/// What an item number of the grid stands for.
#[derive(Debug, Clone, Copy)]
pub(super) enum Item {
    Wall(usize),
    Pillar(usize),
    Vertex(usize),
}

/// The static part of a world: walls, pillars and vertices in a uniform grid of lists, built once.
///
/// Each cell lists the items that touch it. Cells hold numbers, not coordinates: walls come first, then pillars, then
/// vertices.
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
    /// Where the walls and pillars of each cell begin in `items`, and where its vertices do; one more than two for each cell.
    starts: Vec<u32>,
    items: Vec<u32>,
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

        let mut grid = Self {
            lines: walls.iter().map(Line::new).collect(),
            pillars: pillars.to_vec(),
            vertices: vertices.to_vec(),
            frame: Frame::around(walls, vertices, pillars),
            starts: Vec::new(),
            items: Vec::new(),
        };
        let mut cells = vec![Vec::new(); grid.frame.cells()];
        for item in 0..grid.len() {
            grid.touched(item, |cell| cells[cell].push(item as u32));
        }
        let surfaces = grid.lines.len() + grid.pillars.len();
        for cell in cells {
            // Numbers ascend, so the vertices come last.
            let vertices = cell.partition_point(|item| (*item as usize) < surfaces);
            grid.starts.extend([grid.items.len(), grid.items.len() + vertices].map(|start| start as u32));
            grid.items.extend(cell);
        }
        grid.starts.push(grid.items.len() as u32);
        Ok(grid)
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

    /// The numbers of the walls and pillars, and of the vertices, that touch a cell.
    pub(super) fn cell(&self, index: usize) -> (&[u32], &[u32]) {
        match self.starts.get(2 * index..2 * index + 3) {
            Some(&[start, vertices, end]) => {
                (&self.items[start as usize..vertices as usize], &self.items[vertices as usize..end as usize])
            }
            _ => (&[], &[]),
        }
    }

    pub(super) fn item(&self, number: usize) -> Item {
        let (walls, pillars) = (self.lines.len(), self.pillars.len());
        if number < walls {
            Item::Wall(number)
        } else if number < walls + pillars {
            Item::Pillar(number - walls)
        } else {
            Item::Vertex(number - walls - pillars)
        }
    }

    /// Calls `visit` with every cell that an item touches.
    fn touched(&self, number: usize, mut visit: impl FnMut(usize)) {
        let frame = self.frame;
        match self.item(number) {
            Item::Wall(i) => {
                let line = &self.lines[i];
                frame.touched_by_line([line.ax, line.ay], [line.bx, line.by], visit);
            }
            Item::Pillar(i) => {
                let Disc { centre, radius, .. } = self.pillars[i];
                let (left, right) = frame.span(centre.x - radius, centre.x + radius, frame.x, frame.columns);
                let (bottom, top) = frame.span(centre.y - radius, centre.y + radius, frame.y, frame.rows);
                for (column, row) in (left..=right).flat_map(|column| (bottom..=top).map(move |row| (column, row))) {
                    visit(frame.index(column, row));
                }
            }
            Item::Vertex(i) => {
                let at = self.vertices[i].at;
                frame.touched_by_line([at.x, at.y], [at.x, at.y], &mut visit);
            }
        }
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

    fn cells(&self) -> usize {
        self.columns as usize * self.rows as usize
    }

    pub(super) fn index(&self, column: i32, row: i32) -> usize {
        row as usize * self.columns as usize + column as usize
    }

    /// The cells along one axis that an interval touches, with a margin, clamped to the grid.
    fn span(&self, low: f64, high: f64, origin: f64, count: i32) -> (i32, i32) {
        let cell_of = |at: f64, margin: f64| (((at - origin) / self.cell + margin).floor() as i32).clamp(0, count - 1);
        (cell_of(low, -MARGIN), cell_of(high, MARGIN))
    }

    /// Visits column by column the rows between the line's heights at the column's two sides.
    fn touched_by_line(&self, a: [f64; 2], b: [f64; 2], mut visit: impl FnMut(usize)) {
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
            for row in bottom..=top {
                visit(self.index(column, row));
            }
        }
    }
}
