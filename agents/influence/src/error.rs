//! Why a question has no answer.

use thiserror::Error;

/// Why a diagram can't be solved, or a question about it not be answered.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SolveError {
    /// A variable that is not in the diagram.
    #[error("variable {index} is not in the diagram {diagram:?}; ids belong to the diagram that they were made for")]
    UnknownVariable {
        /// Its number.
        index: usize,
        /// What the diagram is called.
        diagram: String,
    },
    /// A variable that is named twice where each may stand once.
    #[error("{variable:?} is asked for twice")]
    Repeated {
        /// Which variable.
        variable: String,
    },
    /// A state that a variable does not have.
    #[error("{variable:?} has {states} states, so none with the number {state}; they are counted from 0")]
    UnknownState {
        /// Which variable.
        variable: String,
        /// How many states it has.
        states: usize,
        /// Which state was asked for.
        state: usize,
    },
    /// Likelihoods that do not fit the states.
    #[error("{found} likelihoods were given for {variable:?}, which has {states} states; give one for each")]
    LikelihoodSize {
        /// Which variable.
        variable: String,
        /// How many states it has.
        states: usize,
        /// How many likelihoods there are.
        found: usize,
    },
    /// A number that is no likelihood.
    #[error("{value} is no likelihood for {variable:?}; they lie between 0 and 1, so divide them all by the largest")]
    Likelihood {
        /// Which variable.
        variable: String,
        /// What was given.
        value: f64,
    },
    /// Likelihoods for a decision.
    #[error(
        "{decision:?} is a decision, of which it is known which alternative was taken, not how likely; tell its state instead"
    )]
    LikelihoodOfDecision {
        /// Which decision.
        decision: String,
    },
    /// Evidence on what a decision, that is still to be made, can change.
    #[error(
        "{variable:?} is known, but {decision:?} can still change it; what is known is known before all decisions that are open, so tell \
         which alternative was taken as well"
    )]
    EvidenceAfterDecision {
        /// The variable.
        variable: String,
        /// The decision.
        decision: String,
    },
    /// Evidence that can't be; or that is less probable than 10⁻³⁰⁷.
    #[error("this evidence is impossible: its probability is 0")]
    Impossible,
    /// A decision on which the answer depends.
    #[error(
        "the answer depends on the decision {decision:?}; tell which alternative was taken, or solve the diagram and ask it under the policies"
    )]
    Undecided {
        /// Which decision.
        decision: String,
    },
    /// Decisions that may be made in either order.
    #[error(
        "it is not said which is made first, {first:?} or {second:?}: no path of arcs leads from one to the other; draw an arc between \
         them, or give the diagram limited memory"
    )]
    UnorderedDecisions {
        /// A decision.
        first: String,
        /// Another one.
        second: String,
    },
    /// A diagram for which there is not enough memory.
    #[error(
        "this would take {cells} numbers ({} MiB), which is more than {limit}; look for nodes that many arcs meet in, or a decision that \
         remembers too much", cells / (1 << 17)
    )]
    TooLarge {
        /// How many numbers of 8 bytes; `usize::MAX` if that many can't be counted.
        cells: usize,
        /// How many there may be.
        limit: usize,
    },
    /// A plan for a diagram with limited memory.
    #[error("{diagram:?} has limited memory; plans are for perfect memory, so use `solve`")]
    LimitedMemory {
        /// What the diagram is called.
        diagram: String,
    },
    /// A plan for another structure.
    #[error("the plan was made for another structure than that of {diagram:?}; nodes, states and arcs must be the same")]
    OtherStructure {
        /// What the diagram is called.
        diagram: String,
    },
    /// Evidence of a kind for which nothing was prepared.
    #[error("{variable:?} was not expected to be {}", if *.told { "known" } else { "unknown: its state was to be told each time" })]
    Unprepared {
        /// The variable.
        variable: String,
        /// Whether something was told, or nothing.
        told: bool,
    },
    /// A variable that would have to be known for the answer.
    #[error("the answer depends on {variable:?}; tell its state as well")]
    MissingPast {
        /// The variable.
        variable: String,
    },
    /// A variable that can't be seen before a decision, because it comes after it.
    #[error("{variable:?} can't be seen before {decision:?}, because the decision has an influence on it")]
    NotObservable {
        /// The variable.
        variable: String,
        /// The decision.
        decision: String,
    },
    /// Information has a value only where the best policy is known.
    #[error(
        "with limited memory only a local maximum was found, and the difference of two of them says nothing about information"
    )]
    OnlyLocal,
}
