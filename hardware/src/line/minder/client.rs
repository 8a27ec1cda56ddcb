//! The client's end: starts a minder, and sees to it that the device stands if that one can't.

use std::{
    env,
    io::{self, Read, Write},
    os::{
        fd::OwnedFd,
        unix::{net::UnixStream, process::CommandExt},
    },
    path::PathBuf,
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use super::{
    LOOK, Minding,
    order::{ASKED, OPEN, Order},
    stop,
};
use crate::line::{Address, Stream, connect, is_patience};

/// What the minder's process is called in lists of processes.
const NAME: &str = "orienteer-minder";
/// The device may take so long to be opened.
const PATIENCE: Duration = Duration::from_secs(5);
/// A minder that has not said that it is well for this long is held up.
const HELD_UP: Duration = Duration::from_millis(400);
/// One that is well needs no more than this to go.
const GOES: Duration = Duration::from_millis(400);

/// The client's end of a line that is minded.
struct Minded {
    stream: UnixStream,
    /// The minder says here that it is well, and said so last at that time.
    beats: UnixStream,
    well: Instant,
    minder: Child,
    order: Order,
}

impl Minded {
    /// An error if the minder is held up: then nothing gets through, and nobody minds the device.
    fn check(&mut self) -> io::Result<()> {
        // If this process was held up itself, the beats of that time are all there.
        let mut beats = [0; 64];
        while matches!(self.beats.read(&mut beats), Ok(1..)) {
            self.well = Instant::now();
        }
        if self.well.elapsed() < HELD_UP { Ok(()) } else { Err(io::Error::other("the process that minds it is held up")) }
    }

    /// True if the minder ends by itself, as it does when its client goes: the device is stopped then.
    fn goes(&mut self) -> bool {
        let began = Instant::now();
        while began.elapsed() < GOES && self.check().is_ok() {
            match self.minder.try_wait() {
                Ok(None) => thread::sleep(LOOK),
                ended => return matches!(ended, Ok(Some(status)) if status.success()),
            }
        }
        false
    }
}

impl Read for Minded {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        self.check()?;
        self.stream.read(into)
    }
}

impl Write for Minded {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

impl Drop for Minded {
    /// Waits until the device has been stopped: by the minder, or by this process if the minder can't.
    fn drop(&mut self) {
        let _ = self.stream.shutdown(std::net::Shutdown::Both);
        if !self.goes() {
            let _ = self.minder.kill();
            let _ = self.minder.wait();
            if let Ok(mut device) = connect(&self.order.address, self.order.baud) {
                stop(&mut *device, &self.order.minding);
            }
        }
    }
}

/// Starts a minder and has it open the line. Waits for that.
pub fn open(address: &Address, baud: u32, minding: &Minding) -> io::Result<Box<dyn Stream>> {
    if env::var_os(ASKED).is_some() {
        return Err(io::Error::other("this process was started to mind a line"));
    }
    let order = Order { address: address.clone(), baud, minding: minding.clone() };
    let (mut stream, theirs) = UnixStream::pair()?;
    let (beats, their_beats) = UnixStream::pair()?;
    let mut minder = Command::new(program()?)
        .arg0(NAME)
        .env(ASKED, order.text())
        .stdin(Stdio::from(OwnedFd::from(theirs)))
        .stdout(Stdio::from(OwnedFd::from(their_beats)))
        .stderr(Stdio::null())
        // Ctrl-C is for the client.
        .process_group(0)
        .spawn()?;
    let answer = stream.set_read_timeout(Some(PATIENCE)).and_then(|()| read_line(&mut stream));
    let trouble = match answer {
        Ok(line) if line == OPEN => {
            stream.set_nonblocking(true)?;
            beats.set_nonblocking(true)?;
            return Ok(Box::new(Minded { stream, beats, well: Instant::now(), minder, order }));
        }
        Ok(line) if !line.is_empty() => line,
        Err(error) if is_patience(&error) => format!("nobody has opened it within {} s", PATIENCE.as_secs()),
        _ => "nobody minds it: the program does not begin with `orienteer_hardware::line::mind_if_asked()`".to_owned(),
    };
    let _ = minder.kill();
    minder.wait()?;
    Err(io::Error::other(trouble))
}

/// The running program, also if its file has been replaced since.
fn program() -> io::Result<PathBuf> {
    if cfg!(target_os = "linux") { Ok("/proc/self/exe".into()) } else { env::current_exe() }
}

/// A line of text, byte by byte so that nothing behind it is taken; an empty one if the other side hangs up.
fn read_line(stream: &mut UnixStream) -> io::Result<String> {
    let (mut line, mut byte) = (Vec::new(), [0]);
    while stream.read(&mut byte)? == 1 && byte != *b"\n" {
        line.push(byte[0]);
    }
    Ok(String::from_utf8_lossy(&line).into_owned())
}
