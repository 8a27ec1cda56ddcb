//! In which order to eliminate.
//!
//! The greedy min-fill rule (Kjærulff 1990): next goes the variable whose neighbours lack the fewest arcs among themselves; of equals the
//! one that makes the smallest table, then the one that was added first. Rounds are kept apart, which makes the order *strong*.

/// Which variables meet in a table, and so will have to be dealt with together.
pub(super) struct Graph {
    words: usize,
    /// For each variable a set of bits: its neighbours.
    neighbours: Vec<Vec<u64>>,
}

impl Graph {
    pub(super) fn new(variables: usize) -> Self {
        let words = variables.div_ceil(64);
        Self { words, neighbours: vec![vec![0; words]; variables] }
    }

    /// All variables of a table are neighbours of each other.
    pub(super) fn join(&mut self, scope: &[usize]) {
        for &variable in scope {
            for &other in scope.iter().filter(|other| **other != variable) {
                self.neighbours[variable][other / 64] |= 1 << (other % 64);
            }
        }
    }

    /// Takes a variable out; its neighbours become neighbours of each other.
    pub(super) fn eliminate(&mut self, variable: usize) {
        let circle = std::mem::replace(&mut self.neighbours[variable], vec![0; self.words]);
        for other in members(&circle) {
            let known = &mut self.neighbours[other];
            known.iter_mut().zip(&circle).for_each(|(known, circle)| *known |= circle);
            known[other / 64] &= !(1 << (other % 64));
            known[variable / 64] &= !(1 << (variable % 64));
        }
    }

    /// Which of the candidates goes next.
    pub(super) fn next(&self, candidates: &[usize], extents: &[usize]) -> Option<usize> {
        candidates.iter().copied().min_by_key(|candidate| (self.fill(*candidate), self.weight(*candidate, extents), *candidate))
    }

    /// How many pairs of neighbours are not neighbours of each other, each counted twice.
    fn fill(&self, variable: usize) -> u32 {
        let circle = &self.neighbours[variable];
        let size: u32 = circle.iter().map(|word| word.count_ones()).sum();
        let known = |other: usize| -> u32 {
            circle.iter().zip(&self.neighbours[other]).map(|(circle, known)| (circle & known).count_ones()).sum()
        };
        members(circle).map(|other| (size - 1).saturating_sub(known(other))).sum()
    }

    /// How large the table of a variable and its neighbours would be.
    fn weight(&self, variable: usize, extents: &[usize]) -> usize {
        members(&self.neighbours[variable]).fold(extents[variable], |cells, other| cells.saturating_mul(extents[other]))
    }
}

/// The members of a set of bits, in order.
fn members(set: &[u64]) -> impl Iterator<Item = usize> {
    let bits =
        |word: u64| std::iter::successors(Some(word), |rest| Some(rest & rest.wrapping_sub(1))).take_while(|rest| *rest != 0);
    set.iter().enumerate().flat_map(move |(i, word)| bits(*word).map(move |rest| i * 64 + rest.trailing_zeros() as usize))
}
