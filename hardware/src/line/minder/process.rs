//! The minder's process, between a client and a device.

use std::{
    env,
    io::{self, Read, Write},
    os::{fd::AsFd, unix::net::UnixStream},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use orienteer_runtime::time::Time;
use signal_hook::{consts::signal, flag};

use super::{
    LOOK, Minder,
    order::{ASKED, OPEN, Order},
    stop,
};
use crate::line::{Stream, connect, is_patience, take};

/// A minder says so often that it is well.
const BEAT: Duration = Duration::from_millis(100);

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
