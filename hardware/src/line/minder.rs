//! Somebody beside the line to a device that has no watchdog.
//!
//! Most bases stop by themselves when nobody speaks to them. Some go on for ever with the last speed that they were told, and a program
//! that is killed tells them nothing more. A [`Minder`] listens to what goes to such a device, and when nothing has come for too long it
//! says stop in the client's stead, again and again.
//!
//! It only helps if it outlives the client, so it lives in a process of its own, which holds the device's end of the line:
//!
//! ```text
//! client ══ socket ══▶ minder's process ══ serial port, TCP ══▶ device
//!        ◀════════════                  ◀══════════════════════
//! ```
//!
//! The client's [`Line`](super::Line) starts that process from the program that it runs in, which therefore begins with
//! [`mind_if_asked`]. When either process ends, the other notices at once: the minder stops the device and goes, the client opens its
//! line anew. A minder says ten times a second that it is well; one that is held up is killed, and the client stops the device itself.
//! Only whoever kills both in the same moment leaves a device that nobody minds; and only the device's end of a radio link could help
//! against that.

use std::{
    env,
    io::{self, Read, Write},
    os::{
        fd::{AsFd, OwnedFd},
        unix::{net::UnixStream, process::CommandExt},
    },
    path::PathBuf,
    process::{Child, Command, Stdio},
    str::FromStr,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::{Duration, Instant},
};

use orienteer_runtime::time::Time;
use signal_hook::{consts::signal, flag};

use super::{Address, Stream, connect, is_patience, take};

/// What makes a program mind a line, and which.
const ASKED: &str = "ORIENTEER_MIND_LINE";
/// What the minder's process is called in lists of processes.
const NAME: &str = "orienteer-minder";
/// What the minder says when it has the device.
const OPEN: &str = "open";
/// While the client is silent the device is told to stop so often.
const AGAIN: Duration = Duration::from_millis(100);
/// What has come from the device waits for no longer than this.
const LOOK: Duration = Duration::from_millis(2);
/// The device may take so long to be opened.
const PATIENCE: Duration = Duration::from_secs(5);
/// A minder says so often that it is well.
const BEAT: Duration = Duration::from_millis(100);
/// One that has not said so for this long is held up.
const HELD_UP: Duration = Duration::from_millis(400);
/// The device is told so often to stop at the end, in case that something gets lost, and a minder that is well needs no more than this to go.
const FAREWELLS: u32 = 3;
const GOES: Duration = Duration::from_millis(400);

/// What a minder has to know of a device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Minding {
    /// The bytes that stop the device, whatever it has been told before; also if that was cut off in the middle.
    pub stop: Vec<u8>,
    /// A client that says nothing for so long is as good as gone.
    pub silence: Duration,
}

/// Listens to a client, and knows when to stop the device in its stead.
///
/// ```
/// use std::time::Duration;
/// use orienteer_hardware::line::{Minder, Minding};
/// use orienteer_runtime::time::Time;
///
/// let after = |millis| Time::START + Duration::from_millis(millis);
/// let mut minder = Minder::new(Minding { stop: vec![0], silence: Duration::from_millis(250) });
/// minder.hear(after(0), b"drive");
/// assert_eq!(minder.due(after(200)), None);
/// assert_eq!(minder.due(after(251)), Some(&[0][..]));
/// ```
#[derive(Debug, Clone)]
pub struct Minder {
    minding: Minding,
    heard: Time,
    stopped: Option<Time>,
}

impl Minder {
    /// Begins to listen at [`Time::START`].
    #[must_use]
    pub fn new(minding: Minding) -> Self {
        Self { minding, heard: Time::START, stopped: None }
    }

    /// The client has sent this to the device.
    pub fn hear(&mut self, now: Time, bytes: &[u8]) {
        if !bytes.is_empty() {
            (self.heard, self.stopped) = (now, None);
        }
    }

    /// What is to be sent to the device now, if anything.
    pub fn due(&mut self, now: Time) -> Option<&[u8]> {
        let silent = now.since(self.heard) > self.minding.silence;
        if !silent || self.stopped.is_some_and(|stopped| now.since(stopped) < AGAIN) {
            return None;
        }
        self.stopped = Some(now);
        Some(&self.minding.stop)
    }
}

/// What the minder's process is asked to do, as it is handed over.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Order {
    address: Address,
    baud: u32,
    minding: Minding,
}

impl Order {
    fn text(&self) -> String {
        let stop: String = self.minding.stop.iter().map(|byte| format!("{byte:02x}")).collect();
        format!("{} {} {stop} {}", self.baud, self.minding.silence.as_millis(), self.address)
    }
}

impl FromStr for Order {
    type Err = io::Error;

    fn from_str(text: &str) -> io::Result<Self> {
        let strange = || io::Error::new(io::ErrorKind::InvalidInput, format!("`{ASKED}` is not as a client writes it: `{text}`"));
        let parts: Vec<_> = text.splitn(4, ' ').collect();
        let [baud, silence, stop, address] = parts[..] else { return Err(strange()) };
        let byte = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok();
        let stop: Option<Vec<u8>> = stop.as_bytes().chunks(2).map(byte).collect();
        let silence = Duration::from_millis(silence.parse().map_err(|_| strange())?);
        let minding = Minding { stop: stop.ok_or_else(strange)?, silence };
        Ok(Self { address: address.parse().map_err(|_| strange())?, baud: baud.parse().map_err(|_| strange())?, minding })
    }
}

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

/// Says stop for the last time.
fn stop(device: &mut dyn Stream, minding: &Minding) {
    for _ in 0..FAREWELLS {
        let _ = device.write(&minding.stop);
        thread::sleep(AGAIN / 2);
    }
}

/// Starts a minder and has it open the line. Waits for that.
pub(super) fn open(address: &Address, baud: u32, minding: &Minding) -> io::Result<Box<dyn Stream>> {
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

/// Minds a line if this process was started to do so, and never returns then. A program whose robots have devices without a watchdog
/// calls this before anything else, as the command line of Orienteer does.
pub fn mind_if_asked() {
    if let Ok(order) = env::var(ASKED) {
        std::process::exit(i32::from(mind(&order).is_err()));
    }
}

/// Passes on what goes either way, until either side has gone.
fn mind(order: &str) -> io::Result<()> {
    let ending = heed_signals()?;
    let mut client = UnixStream::from(io::stdin().as_fd().try_clone_to_owned()?);
    let beats = UnixStream::from(io::stdout().as_fd().try_clone_to_owned()?);
    beats.set_nonblocking(true)?;
    let opened = order.parse().and_then(|order: Order| Ok((connect(&order.address, order.baud)?, order.minding)));
    let (mut device, minding) = match opened {
        Ok(opened) => opened,
        Err(error) => {
            writeln!(client, "{error}")?;
            return Err(error);
        }
    };
    // Of a client that is gone by now the first look tells.
    let _ = writeln!(client, "{OPEN}");
    client.set_read_timeout(Some(LOOK))?;
    // A client that takes nothing may be held up, and the device has to be stopped.
    client.set_write_timeout(Some(LOOK))?;
    let ended = pass_on(&mut client, &beats, &mut *device, Minder::new(minding.clone()), &ending);
    stop(&mut *device, &minding);
    ended
}

/// Raised when somebody asks this process to end. That its client has gone is no reason: it has to stop the device first. So a
/// minder that was held up when its client was killed must outlive the hangup by which the system wakes it.
fn heed_signals() -> io::Result<Arc<AtomicBool>> {
    let (ending, hung_up) = (Arc::new(AtomicBool::new(false)), Arc::default());
    flag::register(signal::SIGHUP, hung_up)?;
    for signal in [signal::SIGTERM, signal::SIGINT, signal::SIGQUIT] {
        flag::register(signal, ending.clone())?;
    }
    Ok(ending)
}

fn pass_on(
    client: &mut UnixStream,
    mut beats: &UnixStream,
    device: &mut dyn Stream,
    mut minder: Minder,
    ending: &AtomicBool,
) -> io::Result<()> {
    let (began, mut beat) = (Instant::now(), Instant::now());
    let (mut piece, mut answer) = ([0; 1024], Vec::with_capacity(1024));
    while !ending.load(Ordering::Relaxed) {
        if beat.elapsed() >= BEAT {
            // A client that is held up takes none; it will have had enough of them.
            let _ = beats.write(&[0]);
            beat = Instant::now();
        }
        let count = match client.read(&mut piece) {
            Ok(0) => return Ok(()),
            Ok(count) => count,
            Err(error) if is_patience(&error) => 0,
            Err(error) => return Err(error),
        };
        let now = Time::START + began.elapsed();
        minder.hear(now, &piece[..count]);
        let said = minder.due(now).unwrap_or(&piece[..count]);
        if !said.is_empty() {
            // Of a device that takes nothing for the moment nothing is kept: what is old must not move it later.
            match device.write(said) {
                // Whatever follows would be taken for the rest of this.
                Ok(sent) if sent < said.len() => {
                    return Err(io::Error::new(io::ErrorKind::WriteZero, "the device takes nothing more"));
                }
                written => ignore_patience(written)?,
            }
        }
        answer.clear();
        take(device, &mut answer)?;
        if !answer.is_empty() {
            ignore_patience(client.write(&answer))?;
        }
    }
    Ok(())
}

fn ignore_patience(written: io::Result<usize>) -> io::Result<()> {
    match written {
        Err(error) if !is_patience(&error) => Err(error),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn an_order_comes_over_as_it_was_given() {
        for address in ["/dev/serial/by id/a b", "tcp://[::1]:8101"] {
            let minding = Minding { stop: vec![0, 145, 255], silence: Duration::from_millis(250) };
            let order = Order { address: address.parse().unwrap(), baud: 115_200, minding };
            assert_eq!(order.text().parse::<Order>().unwrap(), order);
        }
        for strange in ["", "1 2 3", "x 1 00 /dev/a", "1 x 00 /dev/a", "1 1 0g /dev/a", "1 1 é0 /dev/a", "1 1 00 nowhere"] {
            assert!(strange.parse::<Order>().is_err(), "{strange}");
        }
    }

    #[test]
    fn a_silent_client_is_spoken_for_until_it_speaks_again() {
        let mut minder = Minder::new(Minding { stop: vec![7], silence: Duration::from_millis(250) });
        let mut stops = Vec::new();
        for millis in 0..1000 {
            let now = Time::START + Duration::from_millis(millis);
            if millis % 200 == 0 && millis <= 400 {
                minder.hear(now, b"go");
            }
            if millis == 900 {
                minder.hear(now, b"");
            }
            if minder.due(now).is_some() {
                stops.push(millis);
            }
        }
        assert_eq!(stops, [651, 751, 851, 951]);
    }
}
