//! Waking a process or a thread that waits for samples.

use std::{fmt, path::Path, sync::Arc, time::Duration};

use iceoryx2::{
    node::Node,
    port::{event_id::EventId, listener::ListenerCreateError, notifier::Notifier, notifier::NotifierCreateError},
    prelude::ipc,
    service::{
        builder::event::{EventOpenError, EventOpenOrCreateError},
        port_factory::event::PortFactory,
    },
};

use super::{
    LinkError,
    bus::{Claim, Fabric},
    iox::service_name,
    resources,
    watch::WatchedListener,
};
use crate::topics::limits;

/// An event service; a topic of the same name would be another service.
const SERVICE: &str = "bell";
/// With what the bells of a run's owner ring, and those of attached processes.
const OWNER: EventId = EventId::new(0);
const ATTACHED: EventId = EventId::new(1);
/// How long a waiter trusts that it would be woken. iceoryx2 0.10 can, very rarely, lose a wake-up.
const BACKSTOP: Duration = Duration::from_millis(100);

/// Wakes whoever waits at a [`Doorbell`] of the same robot in another process.
///
/// Ring it once after all publications of a step, not after each sample: without listeners that costs next to nothing, with a
/// listener that sleeps, the time to wake a thread.
pub struct Bell {
    notifier: Option<Notifier<ipc::Service>>,
    _claim: Arc<Claim>,
}

impl Bell {
    pub(super) fn new(claim: Arc<Claim>) -> Result<Self, LinkError> {
        let notifier = match &claim.bus().fabric {
            Fabric::Shared { node, .. } => Some(make_notifier(node, &claim)?),
            Fabric::Local { .. } | Fabric::Direct => None,
        };
        Ok(Self { notifier, _claim: claim })
    }

    /// Rings. Several rings may wake a waiter only once.
    ///
    /// A listener that cannot be reached is not this robot's trouble: it will look for itself within 100 ms.
    pub fn ring(&self) {
        if let Some(notifier) = &self.notifier {
            let _ = notifier.notify();
        }
    }
}

impl fmt::Debug for Bell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Bell")
    }
}

/// Why a [`Doorbell`] has returned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wake {
    /// Somebody rang.
    Rung,
    /// Nobody has rung for 100 ms. Look anyway.
    Timeout,
}

/// Waits for the [`Bell`]s of the same robot in other processes. An attached process also hears its own, unless it wants to hear
/// [only the owner](Doorbell::of_the_owner).
pub struct Doorbell {
    listener: WatchedListener,
    /// With what those bells ring that are none of its business.
    deaf_to: Option<EventId>,
    claim: Arc<Claim>,
}

impl Doorbell {
    pub(super) fn new(claim: Arc<Claim>) -> Result<Self, LinkError> {
        let Fabric::Shared { node, .. } = &claim.bus().fabric else {
            return Err(LinkError::NeedsShared { what: "a doorbell" });
        };
        if tokio::runtime::Handle::try_current().is_err() {
            return Err(LinkError::NoRuntime);
        }
        let listener = open_service(node, &claim)?.listener_builder().create().map_err(|error| match error {
            ListenerCreateError::ExceedsMaxSupportedListeners => too_many(&claim),
            other => failed(&claim, other.to_string()),
        })?;
        let listener = WatchedListener::new(listener).map_err(|error| failed(&claim, error.to_string()))?;
        let deaf_to = is_owner(&claim).then_some(OWNER);
        Ok(Self { listener, deaf_to, claim })
    }

    /// One that hears only the run's owner. In the owner's own process it hears nobody.
    #[must_use]
    pub fn of_the_owner(mut self) -> Self {
        self.deaf_to = Some(if is_owner(&self.claim) { OWNER } else { ATTACHED });
        self
    }

    /// Forgets who has rung since the last call; true if somebody had.
    pub fn forget(&mut self) -> bool {
        let mut others = false;
        // One that can't be emptied will say so when it is waited for.
        let _ = self.listener.empty(|id| others |= Some(id) != self.deaf_to);
        others
    }

    /// Waits until somebody rings, 100 ms at most. Rings since the last call count.
    ///
    /// # Errors
    /// [`LinkError::Transport`] if the system no longer lets it wait.
    pub async fn wait(&mut self) -> Result<Wake, LinkError> {
        let heard = tokio::time::timeout(BACKSTOP, async {
            loop {
                let mut others = false;
                self.listener.ready(|id| others |= Some(id) != self.deaf_to).await?;
                if others {
                    return Ok(());
                }
            }
        });
        match heard.await {
            Ok(Ok(())) => Ok(Wake::Rung),
            Ok(Err(error)) => Err(LinkError::Transport { what: "a wait at a doorbell".into(), cause: error }),
            Err(_) => {
                // A wake-up may have been lost: empty the listener, so that the next ring wakes again.
                let mut others = false;
                self.listener
                    .empty(|id| others |= Some(id) != self.deaf_to)
                    .map_err(|cause| LinkError::Transport { what: "a wait at a doorbell".into(), cause })?;
                Ok(if others { Wake::Rung } else { Wake::Timeout })
            }
        }
    }
}

impl fmt::Debug for Doorbell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Doorbell")
    }
}

fn is_owner(claim: &Claim) -> bool {
    claim.bus().first_writer == 0
}

/// With what a process's bells ring.
fn event_of(claim: &Claim) -> EventId {
    if is_owner(claim) { OWNER } else { ATTACHED }
}

fn make_notifier(node: &Node<ipc::Service>, claim: &Claim) -> Result<Notifier<ipc::Service>, LinkError> {
    let service = open_service(node, claim)?;
    service.notifier_builder().default_event_id(event_of(claim)).create().map_err(|error| match error {
        NotifierCreateError::ExceedsMaxSupportedNotifiers => too_many(claim),
        other => failed(claim, other.to_string()),
    })
}

fn open_service(node: &Node<ipc::Service>, claim: &Claim) -> Result<PortFactory<ipc::Service>, LinkError> {
    node.service_builder(&service_name(claim.robot(), SERVICE)?)
        .event()
        .max_nodes(limits::PROCESSES)
        .max_notifiers(limits::PROCESSES)
        .max_listeners(limits::PROCESSES)
        .event_id_max_value(ATTACHED.as_value())
        .open_or_create()
        .map_err(|error| match error {
            EventOpenOrCreateError::EventOpenError(EventOpenError::ExceedsMaxNumberOfNodes) => too_many(claim),
            other => failed(claim, other.to_string()),
        })
}

fn what(claim: &Claim) -> String {
    format!("the bell of robot `{}`", claim.robot())
}

fn too_many(claim: &Claim) -> LinkError {
    LinkError::TooManyProcesses { what: what(claim), limit: limits::PROCESSES }
}

fn failed(claim: &Claim, cause: String) -> LinkError {
    resources::diagnose(what(claim), cause, Path::new(resources::SHARED_MEMORY))
}
