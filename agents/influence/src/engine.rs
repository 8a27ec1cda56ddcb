//! Variable elimination, prepared once and run many times.
//!
//! A [`Program`] is what remains of an elimination when the numbers are left out: which tables are multiplied, summed and maximised in
//! which order, and where in memory each of them lies. [`compile`](Program::compile) makes it from the structure of a diagram
//! and knows how much memory it takes before any is asked for. [`Program::run`] then does nothing but arithmetic, in loops without branches and
//! without allocating.
//!
//! The elimination is Dechter's (1996) with the potentials of Jensen, Jensen & Dittmer (1994): beside the probabilities Φ there are the
//! utilities Ψ, always kept as *conditional expectations*. So at any time `∏Φ · ΣΨ` is what is to be summed and maximised, and `ΣΨ` alone is the
//! expected utility given what has not been eliminated yet.
//!
//! | eliminated | of those tables that know `x` | remains |
//! |---|---|---|
//! | chance `x` | `φ = ∏Φₓ`, `ψ = ΣΨₓ` | `Σₓ φ` and `Σₓ φψ / Σₓ φ` |
//! | decision `x` | `φ = ∏Φₓ`, which is the same for all alternatives, `ψ = ΣΨₓ` | `φ` and `maxₓ ψ` |

mod memory;
mod nest;
mod order;
mod program;
mod symbolic;

pub(crate) use memory::Workspace;
pub(crate) use program::{Mark, Program, Round, Task};

/// How many numbers the working memory may hold: 256 MiB of them.
pub const MAX_CELLS: usize = 1 << 25;
