//! Topics on iceoryx2, the same code for `shared` and `local`.
//!
//! Three habits of the library shape it. Ports find each other only when they are used, so every port that is made or dropped
//! on this thread brings the others of its topic up to date at once: no sample is lost, and a reader keeps what a writer
//! published that was gone before the reader looked. A reader is served in the order of its connection slots, so each sample
//! carries its writer's number, by which the reader sorts. And a failed connection is only logged, so the handler takes note.

use std::{
    cell::RefCell,
    path::Path,
    rc::{Rc, Weak},
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
};

use iceoryx2::{
    node::{Node, NodeBuilder},
    port::{
        DegradationAction,
        publisher::{Publisher, PublisherCreateError},
        subscriber::{Subscriber, SubscriberCreateError},
        update_connections::UpdateConnections,
    },
    prelude::{
        BackpressureStrategy, Config, FileName, LogLevel, MessagingPattern, SemanticString, Service, ServiceName,
        SignalHandlingMode, ZeroCopySend, set_log_level,
    },
    service::{
        builder::publish_subscribe::{PublishSubscribeOpenError, PublishSubscribeOpenOrCreateError},
        port_factory::publish_subscribe::PortFactory,
    },
};

use super::{
    LinkError, PayloadLayout, RETIRED_WRITERS,
    bus::Claim,
    ports::{Arrival, Reader, Topic, Writer, WriterNumber},
    resources,
    robot::most_writers,
};
use crate::topics::{Payload, limits};

/// Goes before every sample.
#[derive(Debug, Clone, Copy, Default, ZeroCopySend)]
#[repr(C)]
#[type_name("orienteer::WriterStamp.v1")]
pub(super) struct WriterStamp {
    writer: WriterNumber,
}

/// Makes the node of this process. Its configuration comes from here alone, never from a file or the environment.
pub(super) fn make_node<S: Service>(directory: &Path, prefix: &str) -> Result<Node<S>, LinkError> {
    set_log_level(LogLevel::Error);
    let name = |reason| LinkError::BadName { kind: "directory of runs", name: directory.display().to_string(), reason };
    let root = directory.as_os_str().as_encoded_bytes();
    let root = iceoryx2::prelude::Path::new(root).map_err(|_| name("it holds a byte that iceoryx2 does not accept"))?;
    let mut config = Config::default();
    config.global.set_root_path(&root);
    config.global.prefix = FileName::new(prefix.as_bytes()).map_err(|_| name("its prefix is no file name"))?;
    config.global.service.cleanup_dead_nodes_on_open = false; // Done once, when the node is made.
    config.defaults.publish_subscribe.subscriber_expired_connection_buffer = RETIRED_WRITERS;
    NodeBuilder::new()
        .config(&config)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<S>()
        .map_err(|error| resources::diagnose("this process's node".into(), error.to_string(), directory))
}

/// The name of a service of a robot.
pub(super) fn service_name(robot: &str, topic: &'static str) -> Result<ServiceName, LinkError> {
    let name = format!("orienteer/{robot}/{topic}");
    ServiceName::new(&name).map_err(|_| LinkError::BadName { kind: "service", name, reason: "it is too long" })
}

type ReadingPort<S, P> = Subscriber<S, P, WriterStamp>;
type WritingPort<S, P> = Publisher<S, P, WriterStamp>;

/// What the ports of one topic in this process share.
struct Hub<S: Service + 'static, P: Payload> {
    factory: PortFactory<S, P, WriterStamp>,
    readers: RefCell<Vec<Weak<ReadingPort<S, P>>>>,
    writers: RefCell<Vec<Weak<WritingPort<S, P>>>>,
    /// Set when a connection could not be made.
    broken: Arc<AtomicBool>,
    /// Bytes of shared memory that the process's writers may come to use; `None` where samples lie in private memory.
    reserved: Option<Arc<AtomicU64>>,
    claim: Arc<Claim>,
}

/// A topic of one robot.
pub(super) struct IoxTopic<S: Service + 'static, P: Payload> {
    hub: Rc<Hub<S, P>>,
}

impl<S: Service + 'static, P: Payload> IoxTopic<S, P> {
    /// Opens the topic's service, or makes it. `reserved` counts the process's shared memory, if it is shared.
    pub(super) fn open(node: &Node<S>, claim: Arc<Claim>, reserved: Option<Arc<AtomicU64>>) -> Result<Self, LinkError> {
        let robot = claim.robot();
        let name = service_name(robot, P::TOPIC)?;
        let factory = node
            .service_builder(&name)
            .publish_subscribe::<P>()
            .user_header::<WriterStamp>()
            .max_nodes(limits::PROCESSES)
            .max_publishers(most_writers::<P>())
            .max_subscribers(limits::READERS)
            .subscriber_max_buffer_size(P::QUEUE.max(1))
            .subscriber_max_borrowed_samples(1)
            .history_size(0)
            .enable_safe_overflow(true)
            .open_or_create();
        let factory = factory.map_err(|error| Self::opening_failed(node, &name, robot, &error))?;
        let (readers, writers) = Default::default();
        let hub = Hub { factory, readers, writers, broken: Arc::default(), reserved, claim };
        Ok(Self { hub: Rc::new(hub) })
    }

    fn opening_failed(node: &Node<S>, name: &ServiceName, robot: &str, error: &PublishSubscribeOpenOrCreateError) -> LinkError {
        use PublishSubscribeOpenError as Open;
        let what = format!("topic `{}` of robot `{robot}`", P::TOPIC);
        match error {
            PublishSubscribeOpenOrCreateError::PublishSubscribeOpenError(Open::IncompatibleTypes) => {
                let found = S::details(name, node.config(), MessagingPattern::PublishSubscribe).ok().flatten().map(|details| {
                    PayloadLayout::from(&details.static_details.publish_subscribe().message_type_details().payload)
                });
                match found {
                    Some(found) => LinkError::IncompatiblePayload {
                        robot: robot.to_owned(),
                        topic: P::TOPIC,
                        found,
                        wanted: PayloadLayout::of::<P>(),
                    },
                    None => LinkError::Transport { what, cause: error.to_string() },
                }
            }
            PublishSubscribeOpenOrCreateError::PublishSubscribeOpenError(Open::ExceedsMaxNumberOfNodes) => {
                LinkError::TooManyProcesses { what, limit: limits::PROCESSES }
            }
            other => resources::diagnose(what, other.to_string(), Path::new(resources::SHARED_MEMORY)),
        }
    }
}

impl<S: Service + 'static, P: Payload> Hub<S, P> {
    fn failed(&self, port: &str, cause: String) -> LinkError {
        let what = format!("a {port} of topic `{}` of robot `{}`", P::TOPIC, self.claim.robot());
        resources::diagnose(what, cause, Path::new(resources::SHARED_MEMORY))
    }

    /// Takes note of connections that cannot be made; iceoryx2 carries on without them.
    fn watch(
        &self,
    ) -> impl Fn(iceoryx2::port::DegradationCause, &iceoryx2::port::DegradationInfo) -> DegradationAction + Send + use<S, P> {
        let broken = Arc::clone(&self.broken);
        move |_, _| {
            broken.store(true, Ordering::Relaxed);
            DegradationAction::Ignore
        }
    }

    /// Makes this thread's ports take note of others that have come or gone. Left alone they would connect when they first
    /// send or receive, which is too late to find out that descriptors or memory have run out.
    fn refresh(&self) {
        let whole = refresh(&self.readers) & refresh(&self.writers);
        if !whole {
            self.broken.store(true, Ordering::Relaxed);
        }
    }

    fn is_whole(&self, port: &str) -> Result<(), LinkError> {
        match self.broken.swap(false, Ordering::Relaxed) {
            true => Err(self.failed(port, "it cannot be connected".into())),
            false => Ok(()),
        }
    }

    /// A peer in another process that cannot be reached is its own trouble, not this actor's: say so and go on.
    fn complain(&self) {
        if self.broken.load(Ordering::Relaxed) && self.broken.swap(false, Ordering::Relaxed) {
            tracing::warn!(robot = self.claim.robot(), topic = P::TOPIC, "a reader or writer could not be connected");
        }
    }

    /// How far a writer's files may grow, a little more rather than less: a queue and a sample in hand for every reader there
    /// can be and one sample being written, a connection to each reader, and its share of the service.
    fn bytes_of_a_writer() -> u64 {
        const HEADERS: usize = 64; // iceoryx2's own and ours, with padding.
        const SERVICE: usize = 8 << 10;
        let queue = P::QUEUE.max(1);
        let samples = limits::READERS * (queue + 1) + 2;
        let connection = 512 + 48 * queue;
        (samples * (size_of::<P>() + HEADERS) + limits::READERS * connection + SERVICE) as u64
    }
}

/// Connects all ports that are still there; false if one could not be.
fn refresh<T: UpdateConnections>(ports: &RefCell<Vec<Weak<T>>>) -> bool {
    let mut whole = true;
    ports.borrow_mut().retain(|port| {
        let port = port.upgrade();
        whole &= port.as_ref().is_none_or(|port| port.update_connections().is_ok());
        port.is_some()
    });
    whole
}

impl<S: Service + 'static, P: Payload> Topic<P> for IoxTopic<S, P> {
    fn writer(&self, number: WriterNumber) -> Result<Box<dyn Writer<P>>, LinkError> {
        let hub = &self.hub;
        let reservation = Reservation::take::<P>(hub.reserved.as_ref(), Hub::<S, P>::bytes_of_a_writer())?;
        let port = hub
            .factory
            .publisher_builder()
            .max_loaned_samples(1)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .set_degradation_handler(hub.watch())
            .create()
            .map_err(|error| match error {
                PublisherCreateError::ExceedsMaxSupportedPublishers => {
                    LinkError::TooManyWriters { robot: hub.claim.robot().to_owned(), topic: P::TOPIC, limit: most_writers::<P>() }
                }
                other => hub.failed("writer", other.to_string()),
            })?;
        let port = Rc::new(port);
        hub.writers.borrow_mut().push(Rc::downgrade(&port));
        hub.refresh();
        let writer =
            IoxWriter { port: Some(port), stamp: WriterStamp { writer: number }, hub: Rc::clone(hub), _reservation: reservation };
        hub.is_whole("writer")?;
        Ok(Box::new(writer))
    }

    fn reader(&self) -> Result<Box<dyn Reader<P>>, LinkError> {
        let hub = &self.hub;
        let port =
            hub.factory.subscriber_builder().set_degradation_handler(hub.watch()).create().map_err(|error| match error {
                SubscriberCreateError::ExceedsMaxSupportedSubscribers => {
                    LinkError::TooManyReaders { robot: hub.claim.robot().to_owned(), topic: P::TOPIC, limit: limits::READERS }
                }
                other => hub.failed("reader", other.to_string()),
            })?;
        let port = Rc::new(port);
        hub.readers.borrow_mut().push(Rc::downgrade(&port));
        hub.refresh();
        hub.is_whole("reader")?;
        Ok(Box::new(IoxReader { port, hub: Rc::clone(hub) }))
    }
}

/// Shared memory set aside for a writer, given back when it is dropped.
struct Reservation {
    total: Option<Arc<AtomicU64>>,
    bytes: u64,
}

impl Reservation {
    fn take<P: Payload>(total: Option<&Arc<AtomicU64>>, bytes: u64) -> Result<Self, LinkError> {
        let Some(total) = total else { return Ok(Self { total: None, bytes }) };
        let reserved = total.fetch_add(bytes, Ordering::Relaxed) + bytes;
        let reservation = Self { total: Some(Arc::clone(total)), bytes }; // Given back if it is refused.
        resources::check_room(&format!("a writer of topic `{}`", P::TOPIC), reserved, Path::new(resources::SHARED_MEMORY))?;
        Ok(reservation)
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        if let Some(total) = &self.total {
            total.fetch_sub(self.bytes, Ordering::Relaxed);
        }
    }
}

struct IoxWriter<S: Service + 'static, P: Payload> {
    /// `None` only while this is being dropped.
    port: Option<Rc<WritingPort<S, P>>>,
    stamp: WriterStamp,
    hub: Rc<Hub<S, P>>,
    _reservation: Reservation,
}

impl<S: Service + 'static, P: Payload> IoxWriter<S, P> {
    fn failed(&self, cause: &dyn std::fmt::Display) -> LinkError {
        let what = format!("a sample of topic `{}` of robot `{}`", P::TOPIC, self.hub.claim.robot());
        LinkError::Transport { what, cause: cause.to_string() }
    }
}

impl<S: Service + 'static, P: Payload> Writer<P> for IoxWriter<S, P> {
    fn publish(&mut self, sample: &P) -> Result<usize, LinkError> {
        let Some(port) = &self.port else { return Ok(0) };
        let mut loan = port.loan_uninit().map_err(|error| self.failed(&error))?;
        *loan.user_header_mut() = self.stamp;
        let readers = loan.write_payload(*sample).send().map_err(|error| self.failed(&error))?;
        self.hub.complain();
        Ok(readers)
    }
}

impl<S: Service + 'static, P: Payload> Drop for IoxWriter<S, P> {
    fn drop(&mut self) {
        drop(self.port.take());
        self.hub.refresh(); // Readers retire it in the order in which writers go.
    }
}

struct IoxReader<S: Service + 'static, P: Payload> {
    port: Rc<ReadingPort<S, P>>,
    hub: Rc<Hub<S, P>>,
}

impl<S: Service + 'static, P: Payload> Reader<P> for IoxReader<S, P> {
    fn fetch(&mut self, into: &mut Vec<Arrival<P>>) {
        // A writer in another process may be faster than this loop: stop after what can have waited when it began.
        let most = (most_writers::<P>() + RETIRED_WRITERS) * P::QUEUE.max(1);
        for _ in 0..most {
            match self.port.receive() {
                Ok(Some(sample)) => into.push(Arrival { writer: sample.user_header().writer, sample: *sample.payload() }),
                Ok(None) => break,
                Err(error) => {
                    tracing::warn!(robot = self.hub.claim.robot(), topic = P::TOPIC, %error, "cannot receive");
                    break;
                }
            }
        }
        self.hub.complain();
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::os::unix::fs::MetadataExt;

    use crate::link::{Backend, Bus, BusOptions, bus::Fabric};
    use crate::topics::{BaseClaim, BaseNotice, Odometry, Payload, SonarScan, limits};

    /// One topic with all the readers and as many writers as asked for, and what its files may grow to.
    fn reserved_and_real<P: Payload>(writers: usize) -> (u64, u64) {
        let directory = tempfile::tempdir_in("/dev/shm").unwrap();
        let options = BusOptions { run: None, root: Some(directory.path().join("r")) };
        let bus = Bus::open(Backend::Shared, &options).unwrap();
        let robot = bus.robot("huey").unwrap().open();
        let ports: Vec<_> = (0..writers).map(|_| robot.publisher::<P>().unwrap()).collect();
        let readers: Vec<_> = (0..limits::READERS).map(|_| robot.subscriber::<P>().unwrap()).collect();
        let mut ports = ports;
        for port in &mut ports {
            assert_eq!(port.publish(P::default()).unwrap(), readers.len());
        }
        let Fabric::Shared { _session: session, reserved, .. } = bus.fabric() else { unreachable!() };
        let prefix = session.prefix();
        let real = std::fs::read_dir("/dev/shm").unwrap().flatten().filter_map(|entry| {
            let ours = entry.file_name().to_string_lossy().starts_with(&prefix);
            ours.then(|| entry.metadata().map_or(0, |status| status.size()))
        });
        (reserved.load(std::sync::atomic::Ordering::Relaxed), real.sum())
    }

    #[test]
    fn what_is_reserved_covers_what_the_files_may_grow_to() {
        for (reserved, real) in [
            reserved_and_real::<SonarScan>(1),
            reserved_and_real::<Odometry>(1),
            reserved_and_real::<BaseNotice>(1),
            reserved_and_real::<BaseClaim>(1),
            reserved_and_real::<BaseClaim>(limits::NODES),
        ] {
            assert!((real..2 * real).contains(&reserved), "{reserved} reserved for {real}");
        }
    }
}
