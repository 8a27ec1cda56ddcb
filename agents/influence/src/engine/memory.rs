//! The numbers of one elimination, and the arithmetic on them.

use super::{
    nest::Nest,
    program::{Input, Op, Program, Source, Step},
    symbolic::Block,
};
use crate::diagram::{Diagram, VariableId};

/// The memory of a program. It can be used over and over, and then nothing is allocated.
#[derive(Debug, Clone)]
pub(crate) struct Workspace {
    cells: Vec<f64>,
    choices: Vec<usize>,
}

impl Workspace {
    /// The numbers of a table.
    pub(crate) fn block(&self, block: &Block) -> &[f64] {
        &self.cells[block.start..block.start + block.len]
    }

    /// The recorded choices of a stage.
    pub(crate) fn choices(&self, record: &Block) -> &[usize] {
        &self.choices[record.start..record.start + record.len]
    }
}

impl Program {
    /// Memory for this program. All weights are 1.
    pub(crate) fn workspace(&self) -> Workspace {
        let mut workspace = Workspace { cells: vec![0.0; self.size], choices: vec![0; self.choices] };
        for input in self.inputs.iter().filter(|input| matches!(input.source, Source::Weights(_))) {
            workspace.cells[input.block.start..input.block.start + input.block.len].fill(1.0);
        }
        workspace
    }

    /// Takes the numbers over from a diagram of the structure that the program was made for. Fixed variables are in the state that
    /// `state` gives; what it gives must exist.
    pub(crate) fn load(&self, diagram: &Diagram, state: impl Fn(VariableId) -> usize, workspace: &mut Workspace) {
        for Input { source, block, nest, cut } in &self.inputs {
            let Source::Node(node) = *source else { continue };
            let table = diagram.table(node);
            let start = cut.iter().map(|(variable, stride)| state(*variable) * stride).sum();
            let (extent, [from, _, to]) = nest.inner();
            nest.rows([start, 0, block.start], |[a, _, out]| {
                (0..extent).for_each(|k| workspace.cells[out + k * to] = table[a + k * from]);
            });
        }
    }

    /// The weights of a variable, to be changed; nothing if it has none.
    pub(crate) fn weights<'w>(&self, variable: VariableId, workspace: &'w mut Workspace) -> Option<&'w mut [f64]> {
        let input = self.inputs.iter().find(|input| input.source == Source::Weights(variable))?;
        workspace.cells.get_mut(input.block.start..input.block.start + input.block.len)
    }

    /// Eliminates.
    pub(crate) fn run(&self, workspace: &mut Workspace) {
        for step in &self.steps {
            step.run(workspace);
        }
    }
}

impl Step {
    fn run(&self, Workspace { cells, choices }: &mut Workspace) {
        // Whatever is read lies before what is written.
        let (done, rest) = cells.split_at_mut(self.out.start);
        let out = &mut rest[..self.out.len()];
        let at = [self.a, self.b, 0];
        match self.op {
            Op::Fill(value) => out.fill(value),
            Op::Multiply => pairs(&self.nest, at, done, out, |out, a, b| *out = a * b),
            Op::Add => pairs(&self.nest, at, done, out, |out, a, b| *out = a + b),
            Op::Contract => {
                out.fill(0.0);
                pairs(&self.nest, at, done, out, |out, a, b| *out += a * b);
            }
            Op::Sum => {
                out.fill(0.0);
                singles(&self.nest, at, done, out, |out, a| *out += a);
            }
            Op::First => singles(&self.nest, at, done, out, |out, a| *out = a),
            Op::DivideBy => singles(&self.nest, at, done, out, |out, a| *out = if a == 0.0 { 0.0 } else { *out / a }),
            Op::MultiplyBy => singles(&self.nest, at, done, out, |out, a| *out *= a),
            Op::AddTo => singles(&self.nest, at, done, out, |out, a| *out += a),
            Op::Maximise { choices: start, alternatives, stride } => {
                let choices = &mut choices[start..start + out.len()];
                out.fill(f64::NEG_INFINITY);
                choices.fill(0);
                for alternative in 0..alternatives {
                    let (extent, [from, _, to]) = self.nest.inner();
                    self.nest.rows([self.a + alternative * stride, 0, 0], |[a, _, at]| {
                        for k in 0..extent {
                            let (value, at) = (done[a + k * from], at + k * to);
                            if value > out[at] {
                                (out[at], choices[at]) = (value, alternative);
                            }
                        }
                    });
                }
            }
        }
    }
}

/// One operation on each cell of two tables and the result. The frequent kinds of rows have a loop of their own, which can be vectorised.
fn pairs(nest: &Nest, at: [usize; 3], done: &[f64], out: &mut [f64], mut op: impl FnMut(&mut f64, f64, f64)) {
    let (extent, strides) = nest.inner();
    nest.rows(at, |[a, b, o]| match strides {
        [1, 1, 1] => {
            let operands = done[a..a + extent].iter().zip(&done[b..b + extent]);
            out[o..o + extent].iter_mut().zip(operands).for_each(|(out, (a, b))| op(out, *a, *b));
        }
        [1, 0, 1] => {
            let b = done[b];
            out[o..o + extent].iter_mut().zip(&done[a..a + extent]).for_each(|(out, a)| op(out, *a, b));
        }
        [0, 1, 1] => {
            let a = done[a];
            out[o..o + extent].iter_mut().zip(&done[b..b + extent]).for_each(|(out, b)| op(out, a, *b));
        }
        [i, j, k] => (0..extent).for_each(|n| op(&mut out[o + n * k], done[a + n * i], done[b + n * j])),
    });
}

/// One operation on each cell of a table and the result.
fn singles(nest: &Nest, at: [usize; 3], done: &[f64], out: &mut [f64], mut op: impl FnMut(&mut f64, f64)) {
    let (extent, strides) = nest.inner();
    nest.rows(at, |[a, _, o]| match strides {
        [1, _, 1] => out[o..o + extent].iter_mut().zip(&done[a..a + extent]).for_each(|(out, a)| op(out, *a)),
        [i, _, k] => (0..extent).for_each(|n| op(&mut out[o + n * k], done[a + n * i])),
    });
}
