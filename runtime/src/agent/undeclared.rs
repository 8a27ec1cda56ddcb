//! Topics that a node uses without having declared them: a mistake of its author, who is told once.

/// Such topics, in the order in which they were used.
#[derive(Debug, Default)]
pub(crate) struct Undeclared {
    topics: Vec<&'static str>,
    told: usize,
}

impl Undeclared {
    pub fn note(&mut self, topic: &'static str) {
        if !self.topics.contains(&topic) {
            self.topics.push(topic);
        }
    }

    /// Those that are new since the last call.
    pub fn news(&mut self) -> &[&'static str] {
        let before = std::mem::replace(&mut self.told, self.topics.len());
        &self.topics[before..]
    }
}
