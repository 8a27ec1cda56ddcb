//! Where an emulated robot is found: a port of the network, or a serial port that is none.

use std::{
    fs, io,
    io::Write,
    net::{SocketAddr, TcpListener, TcpStream, ToSocketAddrs},
    os::unix::fs::symlink,
    path::{Path, PathBuf},
    time::Duration,
};

use orienteer_runtime::time::Time;
use serialport::{SerialPort, TTYPort};

use crate::line::take;

/// A client that has said nothing for so long gives way to another.
const PATIENCE: Duration = Duration::from_secs(2);

/// Who is at the other end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Caller {
    /// Nobody.
    Nobody,
    /// Somebody who was not there before.
    New,
    /// The same as before.
    Same,
}

/// A port can't be opened.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// It is named in a way that nobody understands.
    #[error("`{0}` is no port: `tcp://127.0.0.1:8101`, `pty` or `pty:/a/path` are")]
    Name(String),
    /// Nobody can listen there.
    #[error("nobody can listen at `{name}`: {source}")]
    Listen {
        /// As it was named.
        name: String,
        /// The operating system's answer.
        source: io::Error,
    },
    /// There is something at the path already.
    #[error("`{}` is there already, and is not ours to replace", .0.display())]
    Taken(PathBuf),
}

/// Lets one client in at a time, and never waits for it.
///
/// | name | what it opens |
/// |---|---|
/// | `tcp://127.0.0.1:8101` | a port of the network; whoever can reach the address can drive the robot |
/// | `pty` | a pseudo terminal, which looks like a serial port; [`Port::name`] tells its path |
/// | `pty:/tmp/pioneer` | the same, with a link to it under that path |
pub struct Port {
    name: String,
    door: Door,
    /// When the client was heard last.
    heard: Time,
}

enum Door {
    Tcp {
        listener: TcpListener,
        client: Option<TcpStream>,
    },
    /// With a link to the terminal, if one was asked for: where it is, and where it leads.
    Pty {
        master: TTYPort,
        called: bool,
        link: Option<(PathBuf, PathBuf)>,
    },
}

impl Port {
    /// Opens it.
    ///
    /// # Errors
    /// If it is none, or nobody can listen there.
    pub fn open(name: &str) -> Result<Self, PortError> {
        let listen = |source| PortError::Listen { name: name.to_owned(), source };
        let (name, door) = if let Some(place) = name.strip_prefix("tcp://") {
            let places: Vec<SocketAddr> = place.to_socket_addrs().map_err(listen)?.collect();
            let listener = TcpListener::bind(&places[..]).map_err(listen)?;
            listener.set_nonblocking(true).map_err(listen)?;
            let name = format!("tcp://{}", listener.local_addr().map_err(listen)?);
            (name, Door::Tcp { listener, client: None })
        } else if name == "pty" || name.starts_with("pty:/") {
            let (mut master, terminal) = TTYPort::pair().map_err(|error| listen(error.into()))?;
            master.set_timeout(Duration::ZERO).map_err(|error| listen(error.into()))?;
            let path = terminal.name().unwrap_or_default();
            let link = name.strip_prefix("pty:").map(PathBuf::from);
            if let Some(link) = &link {
                put_link(Path::new(&path), link).map_err(|error| match error.kind() {
                    io::ErrorKind::AlreadyExists => PortError::Taken(link.clone()),
                    _ => listen(error),
                })?;
            }
            let name = link.as_ref().map_or_else(|| path.clone(), |link| link.display().to_string());
            let link = link.map(|link| (link, PathBuf::from(path)));
            // The terminal is not kept open: so it shows when no client is there.
            (name, Door::Pty { master, called: false, link })
        } else {
            return Err(PortError::Name(name.to_owned()));
        };
        Ok(Self { name, door, heard: Time::START })
    }

    /// Where clients find it.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Appends what has come from the client, and says who it is.
    pub fn receive(&mut self, now: Time, into: &mut Vec<u8>) -> Caller {
        let before = into.len();
        let caller = match &mut self.door {
            Door::Tcp { listener, client } => {
                let quiet = now.since(self.heard) >= PATIENCE;
                let new = accept(listener, client, quiet);
                match client.as_mut().map(|client| take(client, into)) {
                    None => Caller::Nobody,
                    Some(Ok(())) if new => Caller::New,
                    Some(Ok(())) => Caller::Same,
                    Some(Err(_)) => {
                        *client = None;
                        Caller::Nobody
                    }
                }
            }
            Door::Pty { master, called, .. } => {
                let there = take(master, into).is_ok();
                match (there, std::mem::replace(called, there)) {
                    (false, _) => Caller::Nobody,
                    (true, false) => Caller::New,
                    (true, true) => Caller::Same,
                }
            }
        };
        if into.len() > before || caller == Caller::New {
            self.heard = now;
        }
        caller
    }

    /// Sends these bytes to the client, if there is one. What it does not take is lost, as on a serial line.
    pub fn send(&mut self, bytes: &[u8]) {
        if bytes.is_empty() {
            return;
        }
        let _ = match &mut self.door {
            Door::Tcp { client: Some(client), .. } => client.write(bytes),
            Door::Tcp { client: None, .. } => Ok(0),
            Door::Pty { master, called: true, .. } => master.write(bytes),
            Door::Pty { called: false, .. } => Ok(0),
        };
    }
}

impl Drop for Port {
    fn drop(&mut self) {
        // Somebody else may have put another in its place.
        if let Door::Pty { link: Some((link, terminal)), .. } = &self.door
            && fs::read_link(link).is_ok_and(|target| target == *terminal)
        {
            let _ = fs::remove_file(link);
        }
    }
}

/// Lets in who waits at the door, if nobody is in or who is in has been `quiet`. True if the client is a new one.
fn accept(listener: &TcpListener, client: &mut Option<TcpStream>, quiet: bool) -> bool {
    let mut new = false;
    while let Ok((stream, _)) = listener.accept() {
        let taken = client.is_some() && (new || !quiet);
        if taken {
            continue; // Which shuts the newcomer's connection.
        }
        if stream.set_nonblocking(true).and_then(|()| stream.set_nodelay(true)).is_ok() {
            (*client, new) = (Some(stream), true);
        }
    }
    new
}

/// Puts a link to a terminal in the place of one that an emulator has left.
fn put_link(terminal: &Path, link: &Path) -> io::Result<()> {
    let left_over = fs::read_link(link).is_ok_and(|target| target.starts_with("/dev/pts"));
    if left_over {
        fs::remove_file(link)?;
    }
    symlink(terminal, link)
}

#[cfg(test)]
mod tests;
