//! Elimination without numbers: which table comes of which.

use super::{
    nest::Nest,
    program::{Op, Step},
};

/// A table in the working memory: row-major, its first variable slowest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Block {
    /// The variables that it knows.
    pub(crate) scope: Vec<usize>,
    /// Where it begins.
    pub(crate) start: usize,
    /// How many numbers it has.
    pub(crate) len: usize,
}

impl Block {
    /// How far to move on for the next state of this variable; 0 if the table does not know it.
    pub(super) fn stride(&self, variable: usize, extents: &[usize]) -> usize {
        match self.scope.iter().position(|known| *known == variable) {
            Some(at) => cells(&self.scope[at + 1..], extents),
            None => 0,
        }
    }

    pub(super) fn knows(&self, variable: usize) -> bool {
        self.scope.contains(&variable)
    }
}

/// How many cells a table over these variables has.
pub(super) fn cells(scope: &[usize], extents: &[usize]) -> usize {
    scope.iter().fold(1usize, |cells, variable| cells.saturating_mul(extents[*variable]))
}

/// A table of probabilities, and what is known about it without looking at its numbers.
#[derive(Debug, Clone)]
pub(super) struct Potential {
    pub(super) block: Block,
    /// The chance nodes of which it is the distribution, given the rest of its scope. Summed over all of them it is 1, unless evidence was worked in.
    pub(super) heads: Vec<usize>,
    /// Whether evidence was worked in.
    pub(super) evidence: bool,
}

/// What is known of the tables in the middle of an elimination, and the steps so far.
#[derive(Debug)]
pub(super) struct Elimination<'e> {
    pub(super) extents: &'e [usize],
    /// When each variable is eliminated. Tables are laid out in this order, so that the next one to go is always the slowest, and loops are long.
    pub(super) rank: Vec<usize>,
    pub(super) probabilities: Vec<Potential>,
    pub(super) utilities: Vec<Block>,
    pub(super) steps: Vec<Step>,
    /// How many numbers the working memory holds so far.
    pub(super) size: usize,
    /// How many choices are recorded so far.
    pub(super) choices: usize,
}

impl Elimination<'_> {
    /// Sums a chance node out.
    pub(super) fn sum(&mut self, variable: usize) {
        let utilities = take(&mut self.utilities, |block| block.knows(variable));
        let mut known = take(&mut self.probabilities, |potential| potential.block.knows(variable));
        known.sort_by_key(|potential| potential.block.len);
        let evidence = known.iter().any(|potential| potential.evidence);
        let mut heads: Vec<usize> = known.iter().flat_map(|potential| potential.heads.iter().copied()).collect();
        heads.retain(|head| *head != variable);
        // A distribution that is summed over all that it is of is 1, and need not be carried along.
        let sums_to_one = heads.is_empty() && !evidence;
        let blocks: Vec<Block> = known.into_iter().map(|potential| potential.block).collect();
        if let Some(utility) = self.fold(Op::Add, utilities) {
            let Some(probability) = self.fold(Op::Multiply, blocks) else { return };
            // A step reads what lies before the place that it writes to, so the divisor comes first.
            let total = (!sums_to_one).then(|| self.contract(variable, &probability, None));
            let expected = self.contract(variable, &probability, Some(&utility));
            if let Some(block) = total {
                self.divide(&expected, &block);
                self.probabilities.push(Potential { block, heads, evidence });
            }
            self.utilities.push(expected);
        } else if !sums_to_one {
            let mut blocks = blocks;
            let Some(last) = blocks.pop() else { return };
            let block = match self.fold(Op::Multiply, blocks) {
                Some(rest) => self.contract(variable, &rest, Some(&last)),
                None => self.contract(variable, &last, None),
            };
            self.probabilities.push(Potential { block, heads, evidence });
        }
    }

    /// Takes the best alternative of a decision. Returns where the choices are recorded, unless there is nothing to choose.
    pub(super) fn maximise(&mut self, variable: usize) -> Option<Block> {
        // Nothing that was seen before can depend on the decision, so one alternative says it for all.
        for i in 0..self.probabilities.len() {
            if self.probabilities[i].block.knows(variable) {
                let from = self.probabilities[i].block.clone();
                self.probabilities[i].block = self.reduce(Op::First, variable, &from);
            }
        }
        let known = take(&mut self.utilities, |block| block.knows(variable));
        let gain = self.fold(Op::Add, known)?;
        let choices = self.choices;
        let best = self.reduce(
            Op::Maximise { choices, alternatives: self.extents[variable], stride: gain.stride(variable, self.extents) },
            variable,
            &gain,
        );
        self.choices = self.choices.saturating_add(best.len);
        let record = Block { start: choices, ..best.clone() };
        self.utilities.push(best);
        Some(record)
    }

    /// All remaining tables in one, over exactly these variables in this order: a product or a sum.
    pub(super) fn gather(&mut self, op: Op, over: &[usize], blocks: &[Block]) -> Block {
        let out = self.allocate(over.to_vec());
        let fill = if matches!(op, Op::MultiplyBy) { 1.0 } else { 0.0 };
        self.steps.push(Step::new(Op::Fill(fill), Nest::new(over, self.extents, [&out, &out, &out]), [&out, &out, &out]));
        for block in blocks {
            self.steps.push(Step::new(op, Nest::new(over, self.extents, [block, block, &out]), [block, block, &out]));
        }
        out
    }

    /// Takes memory for a table.
    pub(super) fn allocate(&mut self, scope: Vec<usize>) -> Block {
        let len = cells(&scope, self.extents);
        let start = self.size;
        self.size = self.size.saturating_add(len);
        Block { scope, start, len }
    }

    /// All these tables in one; `None` of none.
    fn fold(&mut self, op: Op, blocks: Vec<Block>) -> Option<Block> {
        blocks.into_iter().reduce(|a, b| {
            let scope = self.union(&[&a, &b]);
            let out = self.allocate(scope.clone());
            self.steps.push(Step::new(op, Nest::new(&scope, self.extents, [&a, &b, &out]), [&a, &b, &out]));
            out
        })
    }

    /// The sum over one variable of a product, or of one table.
    fn contract(&mut self, variable: usize, a: &Block, b: Option<&Block>) -> Block {
        let scope = self.union(&[a, b.unwrap_or(a)]);
        let rest = scope.iter().copied().filter(|known| *known != variable).collect();
        let out = self.allocate(rest);
        let (op, b) = b.map_or((Op::Sum, a), |b| (Op::Contract, b));
        self.steps.push(Step::new(op, Nest::new(&scope, self.extents, [a, b, &out]), [a, b, &out]));
        out
    }

    /// One table, without one variable.
    fn reduce(&mut self, op: Op, variable: usize, from: &Block) -> Block {
        let rest: Vec<usize> = self.union(&[from]).into_iter().filter(|known| *known != variable).collect();
        let out = self.allocate(rest.clone());
        self.steps.push(Step::new(op, Nest::new(&rest, self.extents, [from, from, &out]), [from, from, &out]));
        out
    }

    fn divide(&mut self, expected: &Block, total: &Block) {
        let nest = Nest::new(&expected.scope, self.extents, [total, total, expected]);
        self.steps.push(Step::new(Op::DivideBy, nest, [total, total, expected]));
    }

    /// All variables of some tables, those that are eliminated first coming first.
    fn union(&self, blocks: &[&Block]) -> Vec<usize> {
        let mut scope: Vec<usize> = blocks.iter().flat_map(|block| block.scope.iter().copied()).collect();
        scope.sort_by_key(|variable| (self.rank[*variable], *variable));
        scope.dedup();
        scope
    }
}

/// Takes out what fulfils a condition, and keeps the order of both.
fn take<T>(from: &mut Vec<T>, condition: impl Fn(&T) -> bool) -> Vec<T> {
    let (taken, left) = std::mem::take(from).into_iter().partition(condition);
    *from = left;
    taken
}
