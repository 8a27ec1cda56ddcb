//! Who may claim, with which priority.

use crate::topics::ClientId;

/// A node that may claim the base or the sonar.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Client {
    /// Its name in the robot's configuration.
    pub name: String,
    /// Larger wins.
    pub priority: u8,
}

/// All nodes of a robot, in the order of its configuration: the place in the table is the [`ClientId`].
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Clients(Vec<Client>);

impl Clients {
    /// A table of clients; the first gets `ClientId(0)`.
    #[must_use]
    pub fn new(clients: Vec<Client>) -> Self {
        Self(clients)
    }

    /// The client with this id, if there is one.
    #[must_use]
    pub fn get(&self, id: ClientId) -> Option<&Client> {
        self.0.get(usize::from(id.0))
    }

    /// The id of the client with this name, if there is one.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<ClientId> {
        self.iter().find(|(_, client)| client.name == name).map(|(id, _)| id)
    }

    /// All clients with their ids, in order.
    pub fn iter(&self) -> impl Iterator<Item = (ClientId, &Client)> {
        (0..u16::MAX).map(ClientId).zip(&self.0)
    }
}

impl<S: Into<String>> FromIterator<(S, u8)> for Clients {
    /// Clients from names and priorities.
    fn from_iter<I: IntoIterator<Item = (S, u8)>>(entries: I) -> Self {
        Self(entries.into_iter().map(|(name, priority)| Client { name: name.into(), priority }).collect())
    }
}
