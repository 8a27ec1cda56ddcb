//! Random numbers that depend on nothing but their name.
//!
//! Every random number of a run comes from a stream named by (seed, robot, purpose). Adding a robot or a sensor therefore
//! never shifts the numbers of another, and the order in which streams are used can't matter.

use rand::SeedableRng;
use rand_pcg::Pcg64;
use sha2::{Digest, Sha256};

/// The source of all random streams of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Streams {
    seed: u64,
}

impl Streams {
    /// All streams of the run with this seed.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self { seed }
    }

    /// The stream that `owner` (a robot's name, or `"world"`) uses for one purpose, from its beginning.
    ///
    /// ```
    /// use orienteer_runtime::random::Streams;
    /// use rand::RngExt;
    /// let streams = Streams::new(7);
    /// let a: u64 = streams.stream("ann", "sonar noise").random();
    /// assert_eq!(a, streams.stream("ann", "sonar noise").random::<u64>());
    /// assert_ne!(a, streams.stream("bob", "sonar noise").random::<u64>());
    /// ```
    #[must_use]
    pub fn stream(&self, owner: &str, purpose: &str) -> Pcg64 {
        let mut hash = Sha256::new();
        hash.update(self.seed.to_le_bytes());
        // Lengths keep ("ab", "c") and ("a", "bc") apart.
        hash.update((owner.len() as u64).to_le_bytes());
        hash.update(owner);
        hash.update(purpose);
        Pcg64::from_seed(hash.finalize().into())
    }

    /// The seed itself.
    #[must_use]
    pub const fn seed(&self) -> u64 {
        self.seed
    }
}
