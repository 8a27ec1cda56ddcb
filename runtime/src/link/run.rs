//! Where a shared run lives, and how nothing of it is left.
//!
//! ```text
//! /dev/shm/orienteer-<uid>/         this user's runs; locked while one is made, joined or removed
//!     run-<name>/owner              a public run: its process and session; the directory is locked by the owner
//!     <session>/                    the directory that iceoryx2 works in; share-locked by every process that uses it
//! /dev/shm/or<session>_*            its segments
//! ```
//!
//! Locks are `flock`s on the directories themselves, so the kernel releases them however a process dies. A session is in use
//! exactly as long as somebody holds its lock; whoever lets go last removes it, and what a killed process left is removed
//! when the next run is made or joined. Each session has an identifier of its own, never used again: a process that is
//! still attached to a dead run cannot disturb the next run of that name.

use std::{
    fs::{self, DirBuilder, File, Permissions, TryLockError},
    hash::{BuildHasher, Hasher, RandomState},
    io,
    os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt},
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use super::{LinkError, resources::SHARED_MEMORY};
use crate::descriptors;

/// A socket's name may have 107 bytes. iceoryx2 calls it `<root>/<session>/or<session>_<39 digits>.event`.
const LONGEST_ROOT: usize = 107 - (1 + SESSION_LENGTH) - (1 + 2 + SESSION_LENGTH + 1) - 39 - 6;
const SESSION_LENGTH: usize = 8;
const LONGEST_RUN: usize = 64;
/// Nobody holds the lock on the root for longer than it takes to remove a few files.
const PATIENCE: Duration = Duration::from_secs(10);
/// Who joins may do so on a thread that drives robots, and can try again.
const JOINING: Duration = Duration::from_millis(250);

/// A process's hold on a session. Dropping it removes the session if nobody else uses it.
#[derive(Debug)]
pub(super) struct Session {
    root: PathBuf,
    id: String,
    /// Share-locked.
    lock: File,
    /// The owner of a public run has its directory, locked.
    run: Option<(PathBuf, File)>,
}

impl Session {
    /// Makes a new session, public if it has a name.
    pub(super) fn create(root: Option<&Path>, run: Option<&str>) -> Result<Self, LinkError> {
        let root = choose_root(root)?;
        let _guard = lock_root(&root, PATIENCE)?;
        sweep(&root);
        let taken = run.map(|name| claim_run(&root, name)).transpose()?;
        let made = make_session_directory(&root).and_then(|(id, lock)| {
            if let Some((directory, _)) = &taken {
                let owner = directory.join("owner");
                fs::write(&owner, format!("{} {id}\n", std::process::id())).map_err(io_error("write", &owner))?;
            }
            Ok((id, lock))
        });
        match made {
            Ok((id, lock)) => Ok(Self { root: root.clone(), id, lock, run: taken }),
            Err(error) => {
                if let Some((directory, _)) = &taken {
                    let _ = fs::remove_dir_all(directory);
                }
                Err(error)
            }
        }
    }

    /// Joins the session of a public run that is going on.
    pub(super) fn join(root: Option<&Path>, run: &str) -> Result<Self, LinkError> {
        check_run_name(run)?;
        let none = || LinkError::NoSuchRun { run: run.to_owned() };
        let root = choose_root(root)?;
        let directory = root.join(format!("run-{run}"));
        if !directory.exists() {
            return Err(none());
        }
        let _guard = lock_root(&root, JOINING)?;
        sweep(&root);
        let (_, id) = read_owner(&directory).ok_or_else(none)?;
        let path = root.join(&id);
        let lock = File::open(&path).map_err(|_| none())?;
        lock.try_lock_shared().map_err(|_| LinkError::Stuck { path })?;
        Ok(Self { root: root.clone(), id, lock, run: None })
    }

    /// The directory for iceoryx2.
    pub(super) fn directory(&self) -> PathBuf {
        self.root.join(&self.id)
    }

    /// Takes the segments from everybody else. iceoryx2 makes one, by which it numbers its nodes, for all users of the machine.
    pub(super) fn make_private(&self) -> Result<(), LinkError> {
        for segment in segments(&self.id) {
            match fs::set_permissions(&segment, Permissions::from_mode(0o600)) {
                // Another process of the run may have removed it.
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(io_error("make private", &segment)(error)),
                _ => {}
            }
        }
        Ok(())
    }

    /// Begins the name of each of the session's files in `/dev/shm`.
    pub(super) fn prefix(&self) -> String {
        prefix_of(&self.id)
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        let guard = lock_root(&self.root, PATIENCE);
        if guard.is_err() && self.root.exists() {
            return; // Somebody could be joining this very moment. The next run will sweep.
        }
        if let Some((directory, _lock)) = self.run.take() {
            let _ = fs::remove_dir_all(directory);
        }
        if self.lock.try_lock().is_ok() {
            remove_session(&self.root, &self.id);
        }
    }
}

/// An identifier that no session of this machine has had, also fit as a private prefix for links without files.
pub(super) fn fresh_id() -> String {
    const DIGITS: &[u8; 36] = b"0123456789abcdefghijklmnopqrstuvwxyz";
    let mut hasher = RandomState::new().build_hasher(); // Seeded by the system, and differently at each call.
    hasher.write_u32(std::process::id());
    let mut rest = hasher.finish();
    (0..SESSION_LENGTH)
        .map(|_| {
            let digit = usize::try_from(rest % 36).unwrap_or(0);
            rest /= 36;
            char::from(DIGITS[digit])
        })
        .collect()
}

/// What the names of a session's files begin with.
pub(super) fn prefix_of(id: &str) -> String {
    format!("or{id}_")
}

fn is_session_id(name: &str) -> bool {
    name.len() == SESSION_LENGTH && name.bytes().all(|b| b.is_ascii_digit() || b.is_ascii_lowercase())
}

fn check_run_name(name: &str) -> Result<(), LinkError> {
    let reason = if name.is_empty() {
        "it is empty"
    } else if name.len() > LONGEST_RUN {
        "it is too long"
    } else if !name.bytes().all(|b| b.is_ascii_alphanumeric() || b"-_.".contains(&b)) {
        "it holds something other than letters, digits, `-`, `_` and `.`"
    } else {
        return Ok(());
    };
    Err(LinkError::BadName { kind: "run", name: name.to_owned(), reason })
}

fn choose_root(asked: Option<&Path>) -> Result<PathBuf, LinkError> {
    let path = asked.map_or_else(
        || {
            let user = rustix::process::geteuid().as_raw();
            let tmpfs = Path::new(SHARED_MEMORY);
            let place = if tmpfs.is_dir() { tmpfs.to_path_buf() } else { std::env::temp_dir() };
            place.join(format!("orienteer-{user}"))
        },
        Path::to_path_buf,
    );
    let length = path.as_os_str().len();
    if length > LONGEST_ROOT {
        return Err(LinkError::PathTooLong { path, length, limit: LONGEST_ROOT });
    }
    Ok(path)
}

/// The lock on the root. Letting go of it removes the root if no run is left in it.
struct RootLock<'a> {
    root: &'a Path,
    _directory: File,
}

impl Drop for RootLock<'_> {
    fn drop(&mut self) {
        let _ = fs::remove_dir(self.root); // Fails, as it should, while anything is in it.
    }
}

/// Makes the root if need be and locks it. Everybody makes, joins and removes runs under this lock alone.
fn lock_root(root: &Path, patience: Duration) -> Result<RootLock<'_>, LinkError> {
    let give_up = Instant::now() + patience;
    loop {
        match DirBuilder::new().recursive(false).mode(0o700).create(root) {
            Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(io_error("make", root)(error)),
            _ => check_root(root)?,
        }
        let directory = match File::open(root) {
            Ok(directory) => directory,
            Err(error) if error.kind() == io::ErrorKind::NotFound => continue, // Removed this very moment.
            Err(error) => return Err(io_error("open", root)(error)),
        };
        match directory.try_lock() {
            Ok(()) if is_at(&directory, root) => return Ok(RootLock { root, _directory: directory }),
            Ok(()) => {} // Another process has just removed the directory that was locked.
            Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(1)),
            Err(TryLockError::Error(error)) => return Err(io_error("lock", root)(error)),
        }
        if Instant::now() > give_up {
            return Err(LinkError::Stuck { path: root.to_owned() });
        }
    }
}

/// Anybody can make a directory in `/dev/shm`: refuse one that others own or can write to.
fn check_root(root: &Path) -> Result<(), LinkError> {
    let refuse = |reason: String| Err(LinkError::NoPermission { path: root.to_owned(), reason });
    let status = match fs::symlink_metadata(root) {
        Ok(status) => status,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()), // The caller tries again.
        Err(error) => return Err(io_error("look at", root)(error)),
    };
    let user = rustix::process::geteuid().as_raw();
    if !status.is_dir() {
        refuse("it is not a directory".into())
    } else if status.uid() != user {
        refuse(format!("it belongs to user {}, not to {user}", status.uid()))
    } else if status.mode() & 0o077 != 0 {
        refuse(format!("others have access to it (mode {:o})", status.mode() & 0o777))
    } else {
        Ok(())
    }
}

fn is_at(file: &File, path: &Path) -> bool {
    match (file.metadata(), fs::symlink_metadata(path)) {
        (Ok(open), Ok(named)) => (open.dev(), open.ino()) == (named.dev(), named.ino()),
        _ => false,
    }
}

fn claim_run(root: &Path, name: &str) -> Result<(PathBuf, File), LinkError> {
    check_run_name(name)?;
    let directory = root.join(format!("run-{name}"));
    match DirBuilder::new().mode(0o700).create(&directory) {
        // A run that is over has been swept away by now.
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            let pid = read_owner(&directory).map(|(pid, _)| pid);
            return Err(LinkError::RunTaken { run: name.to_owned(), pid });
        }
        made => made.map_err(io_error("make", &directory))?,
    }
    let lock = File::open(&directory).map_err(io_error("open", &directory))?;
    lock.try_lock().map_err(|_| LinkError::Stuck { path: directory.clone() })?;
    Ok((directory, lock))
}

fn read_owner(directory: &Path) -> Option<(u32, String)> {
    let text = fs::read_to_string(directory.join("owner")).ok()?;
    let (pid, id) = text.trim_end().split_once(' ')?;
    is_session_id(id).then_some((pid.parse().ok()?, id.to_owned()))
}

fn make_session_directory(root: &Path) -> Result<(String, File), LinkError> {
    loop {
        let id = fresh_id();
        let path = root.join(&id);
        match DirBuilder::new().mode(0o700).create(&path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => continue,
            made => made.map_err(io_error("make", &path))?,
        }
        let lock = File::open(&path).map_err(io_error("open", &path))?;
        lock.try_lock_shared().map_err(|_| LinkError::Stuck { path: path.clone() })?;
        return Ok((id, lock));
    }
}

/// Removes what dead processes have left. The root is locked.
fn sweep(root: &Path) {
    let Ok(entries) = fs::read_dir(root) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let Some(name) = name.to_str() else { continue };
        // Whatever cannot be told counts as being in use.
        let in_use = || File::open(entry.path()).map_or(true, |directory| directory.try_lock().is_err());
        if is_session_id(name) {
            if !in_use() {
                remove_session(root, name);
            }
        } else if name.starts_with("run-") && !in_use() {
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

/// Removes a session's files. Its directory goes last, so that a process killed meanwhile leaves a trace to sweep by.
fn remove_session(root: &Path, id: &str) {
    for segment in segments(id) {
        let _ = fs::remove_file(segment);
    }
    let _ = fs::remove_dir_all(root.join(id));
}

/// The session's files in `/dev/shm`.
fn segments(id: &str) -> impl Iterator<Item = PathBuf> {
    let prefix = prefix_of(id);
    let entries = fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten();
    entries.filter(move |entry| entry.file_name().as_encoded_bytes().starts_with(prefix.as_bytes())).map(|entry| entry.path())
}

fn io_error(what: &'static str, path: &Path) -> impl FnOnce(io::Error) -> LinkError {
    let path = path.to_owned();
    move |source| match source.kind() {
        // It is no fault of the directory.
        _ if descriptors::is_shortage(&source) => {
            LinkError::OutOfDescriptors { what: format!("the files of a run in {}", path.display()), limit: descriptors::limit() }
        }
        io::ErrorKind::PermissionDenied => LinkError::NoPermission { path, reason: format!("cannot {what} it: {source}") },
        _ => LinkError::Io { what, path, source },
    }
}
