//! How the system asks a program to end.

use std::{fs, future::poll_fn, io, task::Poll};

use tokio::signal::unix::{SignalKind, signal};

/// Waits until somebody wants the program to end, and says how. From the first call on, none of these signals ends it by itself.
/// Who started it with `nohup` wants it to outlive the terminal.
///
/// # Errors
/// If the system does not let the program listen.
pub async fn asked_to_end() -> io::Result<&'static str> {
    let mut signals = vec![(signal(SignalKind::interrupt())?, "Ctrl-C"), (signal(SignalKind::terminate())?, "SIGTERM")];
    if !is_ignored(SignalKind::hangup()) {
        signals.push((signal(SignalKind::hangup())?, "SIGHUP, the terminal is gone"));
    }
    let heard = poll_fn(|context| {
        let heard = signals.iter_mut().find_map(|(signal, name)| signal.poll_recv(context).is_ready().then_some(*name));
        heard.map_or(Poll::Pending, Poll::Ready)
    });
    Ok(heard.await)
}

/// True if the program was started with this signal ignored, as far as Linux tells.
fn is_ignored(kind: SignalKind) -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (kind.as_raw_value() - 1) & 1 == 1)
}
