//! Loops over the cells of tables that know different variables.

use super::symbolic::Block;

/// The most loops that a nest has. Each runs at least twice, so no table that fits into memory needs more.
const DEPTH: usize = usize::BITS as usize;

/// One loop: how often, and how far each of three tables moves on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Loop {
    extent: usize,
    strides: [usize; 3],
}

/// Nested loops over all states of some variables, with the place in each of three tables.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Nest {
    outer: Vec<Loop>,
    inner: Loop,
}

impl Nest {
    /// Loops over these variables, the first one outermost. A table that does not know a variable stands still in its loop.
    pub(super) fn new(variables: &[usize], extents: &[usize], tables: [&Block; 3]) -> Self {
        let mut loops: Vec<Loop> = Vec::new();
        for &variable in variables.iter().filter(|variable| extents[**variable] != 1) {
            let this = Loop { extent: extents[variable], strides: tables.map(|table| table.stride(variable, extents)) };
            match loops.last_mut() {
                // Two loops that walk straight through all three tables are one.
                Some(last) if (0..3).all(|t| last.strides[t] == this.strides[t].saturating_mul(this.extent)) => {
                    *last = Loop { extent: last.extent.saturating_mul(this.extent), strides: this.strides };
                }
                _ => loops.push(this),
            }
        }
        let inner = loops.pop().unwrap_or(Loop { extent: 1, strides: [1; 3] });
        Self { outer: loops, inner }
    }

    /// How often the innermost loop runs, and how far the tables move on in it.
    pub(super) const fn inner(&self) -> (usize, [usize; 3]) {
        (self.inner.extent, self.inner.strides)
    }

    /// Calls for each run of the innermost loop, with the places where it begins.
    pub(super) fn rows(&self, mut at: [usize; 3], mut row: impl FnMut([usize; 3])) {
        let outer = &self.outer[..self.outer.len().min(DEPTH)];
        let mut count = [0usize; DEPTH];
        loop {
            row(at);
            let mut depth = outer.len();
            loop {
                let Some(next) = depth.checked_sub(1) else { return };
                depth = next;
                let Loop { extent, strides } = outer[depth];
                count[depth] += 1;
                if count[depth] < extent {
                    (0..3).for_each(|t| at[t] += strides[t]);
                    break;
                }
                count[depth] = 0;
                (0..3).for_each(|t| at[t] -= strides[t] * (extent - 1));
            }
        }
    }
}
