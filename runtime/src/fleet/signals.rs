//! How the system asks a program to end.

use std::{fs, future::poll_fn, io, process, task::Poll, time::Duration};

use tokio::{
    runtime::{Builder, Runtime},
    signal::unix::{Signal, SignalKind, signal},
    time::sleep,
};

use super::FleetControl;

/// Signals that follow one another faster than this are one wish to end: `timeout` and terminals that close send theirs twice.
const ONE_WISH: Duration = Duration::from_secs(1);

/// Exit code of a program that was told twice to end.
const INTERRUPTED: i32 = 130;

/// Listens for whoever wants the program to end.
#[derive(Debug)]
pub struct Signals {
    heard: Vec<(Signal, &'static str)>,
}

impl Signals {
    /// From now on none of these signals ends the program by itself, and each one that comes is heard. Who started it with
    /// `nohup` wants it to outlive the terminal. To be called where a tokio runtime is.
    ///
    /// # Errors
    /// If the system does not let the program listen.
    pub fn listen() -> io::Result<Self> {
        let mut heard = vec![(signal(SignalKind::interrupt())?, "Ctrl-C"), (signal(SignalKind::terminate())?, "SIGTERM")];
        if !is_ignored(SignalKind::hangup()) {
            heard.push((signal(SignalKind::hangup())?, "SIGHUP, the terminal is gone"));
        }
        Ok(Self { heard })
    }

    /// Waits until somebody wants the program to end, and says how.
    pub async fn asked_to_end(&mut self) -> &'static str {
        poll_fn(|context| {
            let heard = self.heard.iter_mut().find_map(|(signal, name)| signal.poll_recv(context).is_ready().then_some(*name));
            heard.map_or(Poll::Pending, Poll::Ready)
        })
        .await
    }
}

/// Stops a fleet, or whoever else looks at its [`FleetControl`], when somebody wants the program to end, for as long as this lives.
///
/// It listens on a thread of its own, because the fleet's may be in a behaviour that never returns. Who asks again then ends
/// the program, and the recording stays as it is. (A base that is guarded has stopped long before.)
#[derive(Debug)]
pub struct Ear {
    thread: Option<Runtime>,
}

impl Ear {
    /// What comes after this is heard.
    #[must_use]
    pub fn open(control: FleetControl) -> Self {
        let thread = listen_on_a_thread(control);
        if let Err(error) = &thread {
            tracing::warn!("can't listen for signals, Ctrl-C will kill the mission instead of ending it: {error}");
        }
        Self { thread: thread.ok() }
    }
}

impl Drop for Ear {
    fn drop(&mut self) {
        if let Some(thread) = self.thread.take() {
            thread.shutdown_background();
        }
    }
}

fn listen_on_a_thread(control: FleetControl) -> io::Result<Runtime> {
    let thread = Builder::new_multi_thread().worker_threads(1).thread_name("signals").enable_all().build()?;
    let signals = {
        let _inside = thread.enter();
        Signals::listen()?
    };
    drop(thread.spawn(stop_when_asked(signals, control)));
    Ok(thread)
}

async fn stop_when_asked(mut signals: Signals, control: FleetControl) {
    let signal = signals.asked_to_end().await;
    tracing::info!("{signal}: the mission ends");
    control.stop();
    sleep(ONE_WISH).await;
    tracing::warn!("the mission is still ending, maybe a behaviour does not return; Ctrl-C once more ends the program at once");
    // Heard anew: what came in the meantime belongs to the first wish.
    let Ok(mut signals) = Signals::listen() else { return };
    let signal = signals.asked_to_end().await;
    tracing::error!("{signal} again: the program ends at once, and the recording is not closed");
    process::exit(INTERRUPTED);
}

/// True if the program was started with this signal ignored, as far as Linux tells.
fn is_ignored(kind: SignalKind) -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (kind.as_raw_value() - 1) & 1 == 1)
}
