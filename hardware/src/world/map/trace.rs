//! Following the borders of the solid cells of a bitmap.

use nalgebra::Vector2;

/// A corner of a cell, in cells from the lower left corner of the bitmap.
pub(super) type Corner = Vector2<i32>;

/// Directions of travel, counter-clockwise from +x.
const STEPS: [(i32, i32); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

/// Which cells are solid. Beyond the edge everything is free.
#[derive(Debug, Clone)]
pub(super) struct Bitmap {
    width: usize,
    height: usize,
    solid: Vec<bool>,
}

impl Bitmap {
    pub(super) fn new(width: usize, height: usize, solid: Vec<bool>) -> Self {
        debug_assert_eq!(solid.len(), width * height);
        Self { width, height, solid }
    }

    fn is_solid(&self, x: i32, y: i32) -> bool {
        self.index(x, y).is_some_and(|i| self.solid[i])
    }

    fn index(&self, x: i32, y: i32) -> Option<usize> {
        let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
        (x < self.width && y < self.height).then_some(y * self.width + x)
    }

    /// Turns over every patch of less than `smallest` cells: solid ones first, then free ones that don't touch the edge.
    pub(super) fn drop_specks(&mut self, smallest: usize) {
        for solid in [true, false] {
            let mut seen = vec![false; self.solid.len()];
            let mut patch = Vec::new();
            for start in 0..self.solid.len() {
                if seen[start] || self.solid[start] != solid {
                    continue;
                }
                let at_edge = self.collect_patch(start, &mut seen, &mut patch);
                if patch.len() < smallest && (solid || !at_edge) {
                    patch.iter().for_each(|i| self.solid[*i] = !solid);
                }
            }
        }
    }

    /// Collects the patch that a cell belongs to; true if it touches the edge. Solid cells join by corners too.
    fn collect_patch(&self, start: usize, seen: &mut [bool], patch: &mut Vec<usize>) -> bool {
        let solid = self.solid[start];
        let mut at_edge = false;
        let mut done = 0;
        patch.clear();
        patch.push(start);
        seen[start] = true;
        while let Some(&cell) = patch.get(done) {
            done += 1;
            let (x, y) = ((cell % self.width) as i32, (cell / self.width) as i32);
            for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
                if !solid && dx != 0 && dy != 0 {
                    continue;
                }
                match self.index(x + dx, y + dy) {
                    Some(next) if !seen[next] && self.solid[next] == solid => {
                        seen[next] = true;
                        patch.push(next);
                    }
                    Some(_) => {}
                    None => at_edge = true,
                }
            }
        }
        at_edge
    }

    /// All borders as closed chains of unit steps, solid cells on the left: counter-clockwise about matter, clockwise about
    /// holes. Each chain lists every corner it passes.
    pub(super) fn borders(&self) -> Vec<Vec<Corner>> {
        let columns = self.width + 1;
        let mut leaving = self.leaving_steps();
        let mut borders = Vec::new();
        for start in 0..leaving.len() {
            while leaving[start] != 0 {
                let mut chain = Vec::new();
                let mut at = start;
                let mut heading = leaving[start].trailing_zeros() as usize;
                loop {
                    let (x, y) = ((at % columns) as i32, (at / columns) as i32);
                    chain.push(Corner::new(x, y));
                    leaving[at] &= !(1 << heading);
                    at = at.wrapping_add_signed((STEPS[heading].0 + STEPS[heading].1 * columns as i32) as isize);
                    // Where two solid cells touch at a corner, the right turn goes from one to the other and joins them.
                    let turns = [heading + 3, heading, heading + 1].map(|h| h % 4);
                    match turns.into_iter().find(|h| leaving[at] & (1 << h) != 0) {
                        Some(next) => heading = next,
                        None => break,
                    }
                }
                borders.push(chain);
            }
        }
        borders
    }

    /// For each corner of a cell, a bit for each direction in which a border leaves it.
    fn leaving_steps(&self) -> Vec<u8> {
        let columns = self.width + 1;
        let mut leaving = vec![0_u8; columns * (self.height + 1)];
        let mut mark = |x: i32, y: i32, heading: usize| leaving[y as usize * columns + x as usize] |= 1 << heading;
        for y in 0..self.height as i32 {
            for x in (0..self.width as i32).filter(|x| self.is_solid(*x, y)) {
                let sides = [(x, y, 0, -1), (x + 1, y, 1, 0), (x + 1, y + 1, 0, 1), (x, y + 1, -1, 0)];
                for (heading, (from_x, from_y, dx, dy)) in sides.into_iter().enumerate() {
                    if !self.is_solid(x + dx, y + dy) {
                        mark(from_x, from_y, heading);
                    }
                }
            }
        }
        leaving
    }
}
