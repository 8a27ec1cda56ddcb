//! The links of a run: one [`Bus`] per process, from which each robot gets its own.

use std::{
    collections::BTreeSet,
    fmt,
    path::Path,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicU32, AtomicU64, Ordering},
    },
};

use iceoryx2::{
    node::Node,
    prelude::{ipc, local},
};

use super::{
    Backend, BusOptions, LinkError, RobotBus, iox,
    ports::WriterNumber,
    run::{self, Session},
};
use crate::descriptors;

/// The links of one run in one process. A cheap handle, to be cloned and sent to where it is needed.
#[derive(Clone)]
pub struct Bus {
    inner: Arc<Inner>,
}

/// What carries samples.
pub(super) enum Fabric {
    /// The node lives in the session's directory, so it goes first.
    Shared {
        node: Node<ipc::Service>,
        reserved: Arc<AtomicU64>,
        _session: Session,
    },
    Local {
        node: Node<local::Service>,
    },
    Direct,
}

pub(super) struct Inner {
    pub(super) fabric: Fabric,
    /// Added to the number of each writer of this bus: 0 for the run's owner.
    pub(super) first_writer: WriterNumber,
    robots: Mutex<BTreeSet<String>>,
}

impl Bus {
    /// Opens the links of a new run.
    ///
    /// With [`Backend::Shared`] this also removes whatever killed runs of this user have left, and raises the process's limit
    /// on open files as far as it goes.
    ///
    /// # Errors
    /// [`LinkError::RunTaken`] if a run of that name is going on, [`LinkError::BadName`], [`LinkError::PathTooLong`],
    /// [`LinkError::NoPermission`], [`LinkError::Stuck`] or [`LinkError::Io`] about its directory, and whatever hinders
    /// iceoryx2. Only `shared` uses the options.
    pub fn open(backend: Backend, options: &BusOptions) -> Result<Self, LinkError> {
        let fabric = match backend {
            Backend::Shared => shared(Session::create(options.root.as_deref(), options.run.as_deref())?)?,
            Backend::Local => {
                // Nothing is ever written to this place. The prefix keeps the buses of one process apart.
                let (nowhere, prefix) = (Path::new("/dev/null"), run::prefix_of(&run::fresh_id()));
                Fabric::Local { node: iox::make_node(nowhere, &prefix)? }
            }
            Backend::Direct => Fabric::Direct,
        };
        Ok(Self::new(fabric, 0))
    }

    /// Attaches to the run `run` that another process of this user has opened with [`Backend::Shared`] and that name.
    ///
    /// The run's owner may end at any time; then the attached ports fall silent.
    ///
    /// # Errors
    /// [`LinkError::NoSuchRun`] if no such run is going on; otherwise as [`Bus::open`].
    pub fn attach(run: &str, options: &BusOptions) -> Result<Self, LinkError> {
        static ATTACHED: AtomicU32 = AtomicU32::new(0);
        let fabric = shared(Session::join(options.root.as_deref(), run)?)?;
        let (process, nth) = (u64::from(std::process::id()), ATTACHED.fetch_add(1, Ordering::Relaxed));
        Ok(Self::new(fabric, (process << 32) + (u64::from(nth) << 16)))
    }

    fn new(fabric: Fabric, first_writer: WriterNumber) -> Self {
        Self { inner: Arc::new(Inner { fabric, first_writer, robots: Mutex::default() }) }
    }

    #[cfg(test)]
    pub(super) fn fabric(&self) -> &Fabric {
        &self.inner.fabric
    }

    /// What carries the samples.
    #[must_use]
    pub fn backend(&self) -> Backend {
        match self.inner.fabric {
            Fabric::Shared { .. } => Backend::Shared,
            Fabric::Local { .. } => Backend::Local,
            Fabric::Direct => Backend::Direct,
        }
    }

    /// The right to be robot `name` on this bus: to be sent to the robot's thread and opened there. It is free again when the
    /// robot's bus and all its ports are dropped.
    ///
    /// # Errors
    /// [`LinkError::RobotTaken`] if somebody has it; [`LinkError::BadName`] unless the name is 1 to 64 letters, digits, `-`,
    /// `_` and `.`.
    pub fn robot(&self, name: &str) -> Result<RobotTicket, LinkError> {
        check_robot_name(name)?;
        let mut robots = self.inner.robots.lock().unwrap_or_else(PoisonError::into_inner);
        if !robots.insert(name.to_owned()) {
            return Err(LinkError::RobotTaken { robot: name.to_owned() });
        }
        Ok(RobotTicket { claim: Claim { robot: name.to_owned(), bus: Arc::clone(&self.inner) } })
    }
}

impl fmt::Debug for Bus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Bus").field("backend", &self.backend()).finish_non_exhaustive()
    }
}

fn shared(session: Session) -> Result<Fabric, LinkError> {
    descriptors::raise_limit();
    let node = iox::make_node(&session.directory(), &session.prefix())?;
    session.make_private()?;
    Ok(Fabric::Shared { node, reserved: Arc::default(), _session: session })
}

fn check_robot_name(name: &str) -> Result<(), LinkError> {
    let reason = if name.is_empty() {
        "it is empty"
    } else if name.len() > 64 {
        "it has more than 64 bytes"
    } else if !name.bytes().all(|b| b.is_ascii_alphanumeric() || b"-_.".contains(&b)) {
        "it holds something other than letters, digits, `-`, `_` and `.`"
    } else {
        return Ok(());
    };
    Err(LinkError::BadName { kind: "robot", name: name.to_owned(), reason })
}

/// Keeps a robot's name, and the bus, for as long as anything of the robot lives.
pub(super) struct Claim {
    robot: String,
    bus: Arc<Inner>,
}

impl Claim {
    pub(super) fn robot(&self) -> &str {
        &self.robot
    }

    pub(super) fn bus(&self) -> &Inner {
        &self.bus
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        self.bus.robots.lock().unwrap_or_else(PoisonError::into_inner).remove(&self.robot);
    }
}

/// The right to make one robot's ports, on the thread where it is opened. Made by [`Bus::robot`].
pub struct RobotTicket {
    claim: Claim,
}

impl RobotTicket {
    /// Opens the robot's bus on this thread, where it stays.
    #[must_use]
    pub fn open(self) -> RobotBus {
        RobotBus::new(Arc::new(self.claim))
    }
}

impl fmt::Debug for RobotTicket {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "RobotTicket({})", self.claim.robot)
    }
}
