//! Lines to devices: serial ports and network connections that never make a driver wait.
//!
//! A [`Client`] speaks to a base at the end of one, in whatever language.
//!
//! A [`Line`] is opened on a thread of its own, since a network may take seconds to answer. From then on reading and writing take what is
//! there and return. One that breaks is opened anew every half second, for as long as somebody asks for what has come.

mod address;
mod client;
mod conversation;
mod minder;

use std::{
    io::{self, Read, Write},
    net::{TcpStream, ToSocketAddrs},
    sync::mpsc::{self, Receiver, TryRecvError},
    thread::{self, JoinHandle},
    time::Duration,
};

use orienteer_runtime::time::Time;

pub use address::{Address, AddressError};
pub use client::Client;
pub use conversation::{Conversation, Stage};
pub use minder::{Minder, Minding, mind_if_asked};

/// A line that could not be opened, or broke, is opened again after so long.
const AGAIN: Duration = Duration::from_millis(500);
/// A computer that does not answer for so long is not there.
const PATIENCE: Duration = Duration::from_secs(2);
/// Of a device that sends without end no more than this is read at once, bytes.
const AT_ONCE: usize = 1 << 16;

/// Bytes to and from a device. Neither reading nor writing waits: there is [`WouldBlock`](io::ErrorKind::WouldBlock) or
/// [`TimedOut`](io::ErrorKind::TimedOut) instead.
pub trait Stream: Read + Write + Send {}

impl<S: Read + Write + Send> Stream for S {}

/// How a line stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// It has just been opened: whatever was said before was to somebody else.
    Fresh,
    /// It is open.
    Open,
    /// It is not; [`Line::trouble`] says why.
    Down,
}

/// A line to a device, opened again and again as need be.
pub struct Line {
    address: Address,
    baud: u32,
    minding: Option<Minding>,
    state: State,
    /// Takes leave of a device that was minded, until it stands.
    farewell: Option<JoinHandle<()>>,
    opened: u64,
    trouble: String,
}

enum State {
    /// It may be opened at this time; at once if there is none.
    Shut(Option<Time>),
    Opening(Receiver<io::Result<Box<dyn Stream>>>),
    Open(Box<dyn Stream>),
}

impl Line {
    /// A line that is opened when it is first asked for what has come. Only a serial port has a speed in `baud`.
    #[must_use]
    pub fn new(address: Address, baud: u32) -> Self {
        Self {
            address,
            baud,
            minding: None,
            state: State::Shut(None),
            farewell: None,
            opened: 0,
            trouble: "it is being opened".to_owned(),
        }
    }

    /// Has the line [minded](Minder): for a device that goes on when nobody speaks to it.
    #[must_use]
    pub fn minded(mut self, minding: Minding) -> Self {
        self.minding = Some(minding);
        self
    }

    /// A line that is open already, under a name: for tests, and for ways to a device that are no address. Once broken it stays so.
    #[must_use]
    pub fn over(name: &str, stream: Box<dyn Stream>) -> Self {
        Self {
            address: Address::Serial { path: name.into() },
            baud: 0,
            minding: None,
            state: State::Open(stream),
            farewell: None,
            opened: 1,
            trouble: String::new(),
        }
    }

    /// Where it leads.
    #[must_use]
    pub fn address(&self) -> &Address {
        &self.address
    }

    /// How often it has been opened.
    #[must_use]
    pub fn opened(&self) -> u64 {
        self.opened
    }

    /// Why it is down, in words that follow its address.
    #[must_use]
    pub fn trouble(&self) -> &str {
        &self.trouble
    }

    /// Shuts it, to be opened at this speed.
    pub fn open_at(&mut self, baud: u32) {
        self.baud = baud;
        self.leave(None);
    }

    /// Shuts it, to be opened again at that time. Taking leave of a device that is minded takes a while, and must not hold anybody up.
    fn leave(&mut self, again: Option<Time>) {
        let left = std::mem::replace(&mut self.state, State::Shut(again));
        if self.minding.is_some() && matches!(left, State::Open(_)) {
            self.farewell = thread::Builder::new().name("leaves a line".to_owned()).spawn(move || drop(left)).ok();
        }
    }

    /// Appends what has come, and opens the line if it is not open.
    pub fn receive(&mut self, now: Time, into: &mut Vec<u8>) -> Standing {
        match &mut self.state {
            State::Shut(again) => {
                if again.is_none_or(|again| now >= again) {
                    self.begin_opening(now);
                }
                Standing::Down
            }
            State::Opening(answer) => match answer.try_recv() {
                Ok(Ok(stream)) => {
                    self.opened += 1;
                    self.state = State::Open(stream);
                    Standing::Fresh
                }
                Ok(Err(error)) => self.shut(now, format!("it can't be opened: {error}")),
                Err(TryRecvError::Disconnected) => self.shut(now, "it can't be opened".to_owned()),
                Err(TryRecvError::Empty) => Standing::Down,
            },
            State::Open(stream) => match take(stream, into) {
                Ok(()) => Standing::Open,
                Err(error) => self.shut(now, format!("it broke: {error}")),
            },
        }
    }

    /// Sends these bytes, if the line is open; one that does not take them all at once is shut.
    pub fn send(&mut self, now: Time, bytes: &[u8]) {
        let State::Open(stream) = &mut self.state else { return };
        if bytes.is_empty() {
            return;
        }
        match stream.write(bytes) {
            Ok(sent) if sent == bytes.len() => {}
            Ok(_) => _ = self.shut(now, "it takes nothing more".to_owned()),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) if is_patience(&error) => _ = self.shut(now, "it takes nothing more".to_owned()),
            Err(error) => _ = self.shut(now, format!("it broke: {error}")),
        }
    }

    fn shut(&mut self, now: Time, trouble: String) -> Standing {
        self.trouble = trouble;
        self.leave(Some(now + AGAIN));
        Standing::Down
    }

    fn begin_opening(&mut self, now: Time) {
        let (tell, answer) = mpsc::channel();
        let (address, baud, minding) = (self.address.clone(), self.baud, self.minding.clone());
        let farewell = self.farewell.take();
        let open = move || {
            // A device has one line at a time.
            let _ = farewell.map(JoinHandle::join);
            let opened = match minding {
                Some(minding) => minder::open(&address, baud, &minding),
                None => connect(&address, baud),
            };
            // Nobody may be waiting any more.
            let _ = tell.send(opened);
        };
        match thread::Builder::new().name("opens a line".to_owned()).spawn(open) {
            Ok(_) => self.state = State::Opening(answer),
            Err(error) => _ = self.shut(now, format!("it can't be opened: {error}")),
        }
    }
}

impl Drop for Line {
    /// A device that is minded stands when its open line has gone, also if the program ends then.
    fn drop(&mut self) {
        self.leave(None);
        let _ = self.farewell.take().map(JoinHandle::join);
    }
}

/// Opens a device itself. Waits for that.
fn connect(address: &Address, baud: u32) -> io::Result<Box<dyn Stream>> {
    match address {
        Address::Serial { path } => {
            let port = serialport::new(path.to_string_lossy(), baud).timeout(Duration::ZERO);
            Ok(Box::new(port.open_native()?))
        }
        Address::Tcp { host, port } => {
            let mut last = io::Error::new(io::ErrorKind::NotFound, "the host has no address");
            for place in (host.as_str(), *port).to_socket_addrs()? {
                match TcpStream::connect_timeout(&place, PATIENCE) {
                    Ok(stream) => {
                        stream.set_nonblocking(true)?;
                        // A command is a few bytes, and urgent.
                        stream.set_nodelay(true)?;
                        return Ok(Box::new(stream));
                    }
                    Err(error) => last = error,
                }
            }
            Err(last)
        }
    }
}

/// Appends what has come; an error if nothing will come any more.
pub(crate) fn take(stream: &mut dyn Stream, into: &mut Vec<u8>) -> io::Result<()> {
    let mut piece = [0; 1024];
    let most = into.len() + AT_ONCE;
    while into.len() < most {
        match stream.read(&mut piece) {
            Ok(0) => return Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the other side has hung up")),
            Ok(count) => into.extend_from_slice(&piece[..count]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) if is_patience(&error) => return Ok(()),
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

/// True if nothing is wrong, only nothing there, or a signal came first.
fn is_patience(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut | io::ErrorKind::Interrupted)
}

#[cfg(test)]
mod tests;
