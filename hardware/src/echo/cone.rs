//! The exact cone test: the nearest point within a beam that answers.

use nalgebra::Vector2;

use super::{
    acoustics::Acoustics,
    beam::{Answer, Beam, Contact, Source},
    columns::Columns,
    grid::{Disc, SegmentGrid},
    span::{Inside, Span},
};

/// What hides is taken this much wider, as a slope, so that no sound leaks between two walls that share a corner.
const OVERLAP: f64 = 1e-7;
/// Whether an end of a surface can be seen is decided this far inside it, as a slope: at the very end two surfaces are
/// equally far. Gaps narrower than this are taken for closed.
const INSIDE: f64 = 1e-6;
/// Surfaces hide others only if they are this much nearer, m.
const NEARER: f64 = 1e-9;
/// A beam that was split this often counts as heard by nobody; only rounding among nearly equal surfaces could get here.
const MAX_SPLITS: usize = 1000;
/// Walls are tested in lots of this many.
const CHUNK: usize = 32;

/// Memory that a search uses again and again. One for each thread.
#[derive(Debug, Clone)]
pub struct Scratch {
    /// The search in which each item was last met, so that it is taken once.
    met: Vec<u32>,
    search: u32,
    spans: Vec<Span>,
    candidates: Vec<Candidate>,
}

impl Default for Scratch {
    fn default() -> Self {
        // Ample, so that nothing grows in the middle of a run.
        Self { met: Vec::new(), search: 0, spans: Vec::with_capacity(256), candidates: Vec::with_capacity(256) }
    }
}

/// A point that would answer if it could be seen, nearest of the part of a surface between two slopes.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    range: f64,
    /// The slope at which to look whether it can be seen.
    slope: f64,
    low: f64,
    high: f64,
    /// Place of its span; for a vertex its item number.
    index: u32,
    is_vertex: bool,
}

/// What the transducer hears: the nearest point in the beam that answers and can be seen; `None` if nothing answers within
/// range. A transducer inside a body hears it at range 0.
///
/// Walls and bodies hide what lies behind them whether they answer or not. `bodies` are the moving discs; leave out the robot
/// that carries the transducer.
///
/// # Method
///
/// Cells are visited in order of distance. Each surface met is clipped to the beam. Along a wall or a circle both the range
/// and the angle of incidence grow with the distance from the normal, so the point nearest to the normal is the first to
/// answer, and if it does not answer, none does. Candidates are tried nearest first, once all cells nearer than them are
/// known. If something hides a candidate, what it hides is cut out of the surface, and the nearest points of the remaining
/// parts become candidates in turn.
///
/// ```
/// use nalgebra::Point2;
/// use orienteer_hardware::echo::{Acoustics, Beam, Scratch, SegmentGrid, SonarModel, Wall, cone};
/// use orienteer_runtime::geometry::Pose;
///
/// let wall = Wall::new(Point2::new(2.0, -1.0), Point2::new(2.0, 1.0));
/// let world = SegmentGrid::new(&[wall], &[], &[])?;
/// let model = Acoustics::new(&SonarModel::default())?;
/// let beam = |heading| Beam::new(Pose::new(0.0, 0.0, heading), 0.2, 5.0);
/// let mut scratch = Scratch::default();
/// // The wall's normal is in the beam although the axis is not on it.
/// let answer = cone(&world, &[], &beam(0.15), &model, &mut scratch);
/// assert!((answer.unwrap().range - 2.0).abs() < 1e-9);
/// // Turned away by more than beam and incidence limit allow, nothing answers.
/// assert!(cone(&world, &[], &beam(0.8), &model, &mut scratch).is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn cone(grid: &SegmentGrid, bodies: &[Disc], beam: &Beam, acoustics: &Acoustics, scratch: &mut Scratch) -> Option<Answer> {
    let mut search = Search::new(grid, beam, Some(acoustics), scratch);
    if let Err(source) = search.take_bodies(bodies) {
        return Some(Answer { range: 0.0, slope: 0.0, source });
    }
    let mut columns = Columns::new(&grid.frame, beam);
    for _ in 0..MAX_SPLITS {
        let nearest = loop {
            let nearest = search.nearest_candidate();
            let known = nearest.map_or(search.limit, |i| search.scratch.candidates[i].range.min(search.limit));
            if columns.least > known {
                break nearest?;
            }
            if let Err(source) = search.take_column(&mut columns) {
                return Some(Answer { range: 0.0, slope: 0.0, source });
            }
        };
        let candidate = search.scratch.candidates.swap_remove(nearest);
        if candidate.range > search.limit {
            return None;
        }
        match search.hidden_by(&candidate) {
            Some(blocker) => search.cut_out(&candidate, blocker),
            None => return Some(search.answer(&candidate)),
        }
    }
    None
}

/// What a ray along the beam's axis meets first, whether it answers or not; `None` if nothing is within range. The surface
/// `except` is transparent. From inside a body nothing is met.
#[must_use]
pub fn first_surface(
    grid: &SegmentGrid,
    bodies: &[Disc],
    beam: &Beam,
    except: Option<Source>,
    scratch: &mut Scratch,
) -> Option<Contact> {
    let ray = Beam { tan_half: 0.0, sec_half: 1.0, cos_half: 1.0, ..*beam };
    let mut search = Search::new(grid, &ray, None, scratch);
    search.except = except;
    search.take_bodies(bodies).ok()?;
    let mut columns = Columns::new(&grid.frame, &ray);
    while columns.least <= search.limit {
        search.take_column(&mut columns).ok()?;
    }
    let spans = search.scratch.spans.iter().map(|span| (span.at(0.0).0, span)).filter(|hit| hit.0 <= ray.max_range);
    let (range, span) = spans.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let (x, y) = span.normal_ahead(range);
    let normal = Vector2::new(x * ray.axis.x - y * ray.axis.y, x * ray.axis.y + y * ray.axis.x);
    let source = source(grid, span.number);
    Some(Contact { range, at: ray.origin + ray.axis * range, normal, reflectance: span.reflectance, source })
}

/// What a span or candidate belongs to: walls are numbered first, then pillars, vertices and bodies.
fn source(grid: &SegmentGrid, number: u32) -> Source {
    let (walls, pillars, vertices) = (grid.lines.len(), grid.pillars.len(), grid.vertices.len());
    match number as usize {
        n if n < walls => Source::Wall(n),
        n if n < walls + pillars => Source::Pillar(n - walls),
        n if n < walls + pillars + vertices => Source::Vertex(n - walls - pillars),
        n => Source::Body(n - walls - pillars - vertices),
    }
}

/// One search in progress.
struct Search<'a> {
    grid: &'a SegmentGrid,
    beam: &'a Beam,
    /// `None` if only surfaces are wanted, not answers.
    acoustics: Option<&'a Acoustics>,
    scratch: &'a mut Scratch,
    except: Option<Source>,
    /// Nothing beyond this can be heard: the beam's range, or where the whole beam is blocked, m.
    limit: f64,
    /// Vertices farther away are not heard, m.
    vertex_reach: f64,
    /// From the right edge to `covered.0` and from `covered.1` to the left edge the beam is blocked, at most this far away, m².
    covered: (f64, f64),
    depth_squared: f64,
}

impl<'a> Search<'a> {
    fn new(grid: &'a SegmentGrid, beam: &'a Beam, acoustics: Option<&'a Acoustics>, scratch: &'a mut Scratch) -> Self {
        scratch.spans.clear();
        scratch.candidates.clear();
        scratch.search = scratch.search.wrapping_add(1);
        if scratch.met.len() < grid.len() || scratch.search == 0 {
            scratch.met.clear();
            scratch.met.resize(grid.len(), 0);
            scratch.search = 1;
        }
        let covered = (-beam.tan_half, beam.tan_half);
        let vertex_reach = acoustics.map_or(f64::NEG_INFINITY, |a| a.vertex_reach(1.0));
        Self { grid, beam, acoustics, scratch, except: None, limit: beam.max_range, vertex_reach, covered, depth_squared: 0.0 }
    }

    /// Takes the moving bodies. Fails with the one that the transducer is inside of.
    fn take_bodies(&mut self, bodies: &[Disc]) -> Result<(), Source> {
        for (i, body) in bodies.iter().enumerate() {
            if self.except != Some(Source::Body(i)) {
                self.take_disc(body, (self.grid.len() + i) as u32).map_err(|Inside| Source::Body(i))?;
            }
        }
        Ok(())
    }

    /// Takes everything in the next column of cells that was not met before. Fails with the pillar that the transducer is
    /// inside of.
    fn take_column(&mut self, columns: &mut Columns) -> Result<(), Source> {
        let vertices_are_heard = columns.least <= self.vertex_reach;
        let cells = columns.advance();
        let grid = self.grid;
        for chunk in grid.lines_at.of(cells).chunks(CHUNK) {
            self.take_walls(chunk);
        }
        // Few worlds have pillars, and their lists are as long as the world is large.
        let pillars = if grid.pillars.is_empty() { &[] } else { grid.pillars_at.of(cells) };
        for &i in pillars {
            let number = (grid.lines.len() + i as usize) as u32;
            if self.except != Some(Source::Pillar(i as usize)) && self.is_new(number) {
                self.take_disc(&grid.pillars[i as usize], number).map_err(|Inside| Source::Pillar(i as usize))?;
            }
        }
        if vertices_are_heard {
            grid.vertices_at.of(cells).iter().for_each(|i| self.take_vertex(*i as usize));
        }
        Ok(())
    }

    /// True if the item was not met in this search before; it is from now on.
    fn is_new(&mut self, number: u32) -> bool {
        std::mem::replace(&mut self.scratch.met[number as usize], self.scratch.search) != self.scratch.search
    }

    /// Takes those of at most [`CHUNK`] walls that are new and in the beam.
    fn take_walls(&mut self, numbers: &[u32]) {
        // Which walls pass is as good as random, and a mispredicted branch costs more than the test of a wall: so collect first.
        let mut passed = [0; CHUNK];
        let mut count = 0;
        for &number in numbers {
            let passes = self.is_new(number) & Span::may_meet(&self.grid.lines[number as usize], self.beam);
            passed[count] = number;
            count += usize::from(passes);
        }
        for &number in &passed[..count] {
            if self.except != Some(Source::Wall(number as usize))
                && let Some(span) = Span::of_line(&self.grid.lines[number as usize], self.beam, number)
            {
                self.take(span);
            }
        }
    }

    fn take_disc(&mut self, disc: &Disc, number: u32) -> Result<(), Inside> {
        if let Some(span) = Span::of_disc(disc, self.beam, number)? {
            self.take(span);
        }
        Ok(())
    }

    fn take_vertex(&mut self, index: usize) {
        let Some(acoustics) = self.acoustics else { return };
        let vertex = &self.grid.vertices[index];
        let (x, y) = self.beam.local(vertex.at.x, vertex.at.y);
        let reach = acoustics.vertex_reach(vertex.strength).min(self.limit);
        let square = x * x + y * y;
        if (y.abs() <= self.beam.tan_half * x) & (square <= reach * reach) & (x > 0.0) {
            let slope = y / x;
            let index = (self.grid.lines.len() + self.grid.pillars.len() + index) as u32;
            let candidate = Candidate { range: square.sqrt(), slope, low: slope, high: slope, index, is_vertex: true };
            self.scratch.candidates.push(candidate);
        }
    }

    /// Takes a surface in: as a candidate, as something that hides, and for how far the beam reaches at all.
    fn take(&mut self, span: Span) {
        let index = self.scratch.spans.len() as u32;
        if self.propose(&span, index, span.low, span.high) {
            self.scratch.spans.push(span);
            if self.acoustics.is_some() {
                self.cover(&span);
            } else {
                self.limit = self.limit.min(span.at(0.0).0);
            }
        }
    }

    /// Proposes the nearest point of the part of a surface between two slopes. False if that is out of reach altogether.
    fn propose(&mut self, span: &Span, index: u32, low: f64, high: f64) -> bool {
        let (slope, range, cos_incidence) = span.nearest(low, high);
        if range > self.limit {
            return false;
        }
        if high - low > 2.0 * INSIDE && self.acoustics.is_some_and(|a| a.answers(range, cos_incidence, span.reflectance)) {
            let slope = slope.max(low + INSIDE).min(high - INSIDE);
            self.scratch.candidates.push(Candidate { range, slope, low, high, index, is_vertex: false });
        }
        true
    }

    /// Notes how much of the beam a surface blocks. Once surfaces that join block all of it, nothing beyond them is heard.
    fn cover(&mut self, span: &Span) {
        let right = span.low - OVERLAP <= self.covered.0 && span.high > self.covered.0;
        let left = span.high + OVERLAP >= self.covered.1 && span.low < self.covered.1;
        if right || left {
            self.depth_squared = self.depth_squared.max(span.depth_squared());
            if right {
                self.covered.0 = span.high;
            }
            if left {
                self.covered.1 = span.low;
            }
            if self.covered.0 + OVERLAP >= self.covered.1 {
                self.limit = self.limit.min(self.depth_squared.sqrt() + NEARER);
            }
        }
    }

    fn nearest_candidate(&self) -> Option<usize> {
        let candidates = &self.scratch.candidates;
        (0..candidates.len()).min_by(|a, b| candidates[*a].range.total_cmp(&candidates[*b].range))
    }

    /// A surface that hides the candidate, if any: its place among the spans.
    fn hidden_by(&self, candidate: &Candidate) -> Option<usize> {
        let t = candidate.slope;
        let sec = (1.0 + t * t).sqrt();
        let range = if candidate.is_vertex { candidate.range } else { self.scratch.spans[candidate.index as usize].at(t).0 };
        let range = range - NEARER;
        self.scratch
            .spans
            .iter()
            .position(|span| span.low - OVERLAP <= t && t <= span.high + OVERLAP && span.hides(t, sec, range))
    }

    /// Replaces a hidden candidate by the nearest points to both sides of what the blocker hides of its surface.
    fn cut_out(&mut self, candidate: &Candidate, blocker: usize) {
        if candidate.is_vertex {
            return;
        }
        let span = self.scratch.spans[candidate.index as usize];
        let blocker = self.scratch.spans[blocker];
        let t = candidate.slope;
        let (mut from, mut to) = ((blocker.low - OVERLAP).min(t), (blocker.high + OVERLAP).max(t));
        // Beyond a crossing the blocker is the one behind.
        blocker.crossings(&span, |crossing| {
            if crossing < t {
                from = from.max(crossing);
            } else if crossing > t {
                to = to.min(crossing);
            }
        });
        if from > candidate.low {
            self.propose(&span, candidate.index, candidate.low, from);
        }
        if to < candidate.high {
            self.propose(&span, candidate.index, to, candidate.high);
        }
    }

    fn answer(&self, candidate: &Candidate) -> Answer {
        let number = if candidate.is_vertex { candidate.index } else { self.scratch.spans[candidate.index as usize].number };
        Answer { range: candidate.range, slope: candidate.slope, source: source(self.grid, number) }
    }
}
