//! Links: how samples get from one actor to another.
//!
//! A topic is a [`Payload`](crate::topics::Payload) type; a robot's topics are joined by its [`RobotBus`], from which every
//! actor takes a [`Publisher`] or a [`Subscriber`]. Three back ends stand behind these two types, chosen by one key of the
//! configuration (`mission.links`):
//!
//! | [`Backend`] | samples lie in | reaches | descriptors |
//! |---|---|---|---|
//! | `shared` | shared memory (iceoryx2 ipc) | processes of the same user that know the run's name | a dozen per topic |
//! | `local` | the process's memory (iceoryx2 local) | the threads of one process | none |
//! | `direct` | a ring on the heap | one robot, which lives on one thread | none |
//!
//! ```
//! use orienteer_runtime::link::{Backend, Bus, BusOptions};
//! use orienteer_runtime::topics::Odometry;
//!
//! let bus = Bus::open(Backend::Direct, &BusOptions::default())?;
//! let ticket = bus.robot("huey")?; // may cross threads
//! let robot = ticket.open(); // lives where the robot's actors live
//! let mut publisher = robot.publisher::<Odometry>()?;
//! let mut subscriber = robot.subscriber::<Odometry>()?;
//!
//! publisher.publish(Odometry { travelled: 1.5, ..Odometry::default() })?;
//! assert_eq!(subscriber.drain(|odometry| assert_eq!(odometry.travelled, 1.5)), 1);
//! # Ok::<(), orienteer_runtime::link::LinkError>(())
//! ```
//!
//! # What every back end promises
//!
//! Between the ports of one [`RobotBus`] the three are interchangeable: the same calls give the same results.
//!
//! * **Queues.** Every reader has a queue of [`Payload::QUEUE`](crate::topics::Payload::QUEUE) samples for each writer. When
//!   it is full the oldest sample gives way. Publishing never waits.
//! * **Order.** What a reader fetches comes writer by writer, in the order in which the writers were made, and of each writer
//!   in the order in which it published. It is *not* the order of publication across writers: a claim's own stamp says when
//!   it was made. Writers in attached processes come after those of the run's owner.
//! * **First samples.** A reader gets everything that is published after it was made, from the first sample on, whether the
//!   writer is older or younger than the reader. So make all ports of a robot first, then let its actors publish.
//! * **Late joiners** get nothing that was published before they were made.
//! * **Restarts.** What a writer has published outlives it. A reader keeps the unread samples of up to
//!   [`RETIRED_WRITERS`] writers that are gone; those of any further one are lost. A writer's place is free for its
//!   successor as soon as it is dropped.
//! * **Isolation.** Two robots, and two runs, never hear each other.
//!
//! In lockstep all actors of a robot publish and then drain at the next tick, on one thread; then results do not depend on
//! the back end. Across threads and processes a queue can overflow earlier or later, so there order is kept and losses are
//! not reproducible.
//!
//! A warm step asks for no memory, except that iceoryx2 0.10 takes one small piece for each sample that is published and gives
//! it back at once.
//!
//! # Nothing is left behind
//!
//! A `shared` run owns one directory on tmpfs and one prefix for its files in `/dev/shm`; both go when the last process that
//! uses them lets go. A process that is killed cannot tidy up, but the kernel releases its file lock, and the next
//! [`Bus::open`] of the same user removes what it left.

mod backend;
mod bell;
mod bus;
mod direct;
mod error;
pub mod frame;
mod iox;
mod ports;
mod resources;
mod robot;
mod run;
#[allow(unsafe_code)] // The single exception in this crate: tokio asks for it to watch a descriptor that it does not own.
mod watch;

pub use backend::{Backend, BusOptions};
pub use bell::{Bell, Doorbell, Wake};
pub use bus::{Bus, RobotTicket};
pub use error::{LinkError, PayloadLayout};
pub use ports::{Publisher, Subscriber};
pub use robot::RobotBus;

/// How many writers that are gone may have samples waiting with one reader.
///
/// Each costs a reader on iceoryx2 about 4 KiB of heap, so that the library's own figure of 128 is too dear for a swarm.
pub const RETIRED_WRITERS: usize = 4;
