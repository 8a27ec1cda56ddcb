//! Standard error, which a thread of its own writes.
//!
//! Who reads it may stop reading: a pipe is full then, or somebody has pressed Ctrl-S at the terminal. That thread waits, and nobody
//! else does: no robot stops because of a log line, and a signal still ends the program.

use std::{
    io::{self, Write},
    sync::{
        OnceLock,
        atomic::{AtomicU64, Ordering},
        mpsc::{Receiver, SyncSender, sync_channel},
    },
    thread,
    time::Duration,
};

/// So many tasks wait for the thread. Lines that come on top of them are left out, and counted.
const WAITING: usize = 1 << 14;

/// What the thread does, one after the other.
enum Task {
    Write(Vec<u8>),
    Do(Box<dyn FnOnce() + Send>),
    /// Says that all before it is done.
    Answer(SyncSender<()>),
}

/// The way to the thread.
struct Desk {
    tasks: SyncSender<Task>,
    /// Lines that were left out, of which nobody has been told.
    missing: AtomicU64,
}

static DESK: OnceLock<Option<Desk>> = OnceLock::new();

fn desk() -> Option<&'static Desk> {
    DESK.get_or_init(|| Desk::open(WAITING, write_now).ok()).as_ref()
}

/// Hands whole lines over; never waits.
pub fn write(lines: &[u8]) {
    match desk() {
        Some(desk) => desk.write(lines),
        None => write_now(lines),
    }
}

/// Has this done where lines are written; not at all if too much waits there. Never waits.
pub fn instruct(task: impl FnOnce() + Send + 'static) {
    if let Some(desk) = desk() {
        let _ = desk.tasks.try_send(Task::Do(Box::new(task)));
    }
}

/// Waits until all that was handed over so far is written.
pub fn settle() {
    if let Some(desk) = desk() {
        desk.settle();
    }
}

/// The same, but gives up after so long, or at once if too much waits.
pub fn settle_within(patience: Duration) {
    if let Some(desk) = desk() {
        desk.settle_within(patience);
    }
}

/// What is handed over while this lives is written before it is gone, even if the program panics.
pub struct Settled;

impl Drop for Settled {
    fn drop(&mut self) {
        settle();
    }
}

fn write_now(lines: &[u8]) {
    // A line that nobody wants to read must not end a mission.
    let put = || _ = io::stderr().lock().write_all(lines);
    match super::progress::shown() {
        Some(bar) => bar.suspend(put),
        None => put(),
    }
}

impl Desk {
    fn open(waiting: usize, write: impl Fn(&[u8]) + Send + 'static) -> io::Result<Self> {
        let (tasks, incoming) = sync_channel(waiting);
        thread::Builder::new().name("stderr".to_owned()).spawn(move || work(&incoming, write))?;
        Ok(Self { tasks, missing: AtomicU64::new(0) })
    }

    fn write(&self, lines: &[u8]) {
        self.tell_of_missing();
        // What comes after a gap of which there is no room to tell belongs to it.
        if self.missing.load(Ordering::Relaxed) > 0 || self.tasks.try_send(Task::Write(lines.to_vec())).is_err() {
            self.missing.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn tell_of_missing(&self) {
        let missing = self.missing.swap(0, Ordering::Relaxed);
        if missing > 0 && self.tasks.try_send(Task::Write(gap(missing))).is_err() {
            self.missing.fetch_add(missing, Ordering::Relaxed);
        }
    }

    fn settle(&self) {
        let missing = self.missing.swap(0, Ordering::Relaxed);
        if missing > 0 {
            let _ = self.tasks.send(Task::Write(gap(missing)));
        }
        let (answer, answered) = sync_channel(1);
        if self.tasks.send(Task::Answer(answer)).is_ok() {
            let _ = answered.recv();
        }
    }

    fn settle_within(&self, patience: Duration) {
        self.tell_of_missing();
        let (answer, answered) = sync_channel(1);
        if self.tasks.try_send(Task::Answer(answer)).is_ok() {
            let _ = answered.recv_timeout(patience);
        }
    }
}

fn gap(missing: u64) -> Vec<u8> {
    format!("({missing} lines are left out here: they came faster than they were read)\n").into_bytes()
}

fn work(incoming: &Receiver<Task>, write: impl Fn(&[u8])) {
    while let Ok(task) = incoming.recv() {
        match task {
            Task::Write(lines) => write(&lines),
            Task::Do(task) => task(),
            // Whoever asked may have given up.
            Task::Answer(answer) => _ = answer.send(()),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::sync::{Arc, Mutex, mpsc::channel};

    use super::*;

    #[test]
    fn nobody_waits_for_a_reader_and_what_is_left_out_is_counted_where_it_is() {
        let (read, reading) = channel::<()>();
        let written = Arc::new(Mutex::new(String::new()));
        let sink = written.clone();
        let desk = Desk::open(8, move |lines| {
            let _ = reading.recv();
            sink.lock().unwrap().push_str(std::str::from_utf8(lines).unwrap());
        })
        .unwrap();
        for number in 0..100 {
            desk.write(format!("{number}\n").as_bytes());
        }
        desk.settle_within(Duration::from_millis(1));
        assert_eq!(*written.lock().unwrap(), "", "nobody has read yet");
        drop(read);
        desk.settle();
        desk.write(b"100\n");
        desk.settle();

        let written = written.lock().unwrap();
        let (before, after) = written.split_once('(').unwrap();
        let before: Vec<usize> = before.lines().map(|line| line.parse().unwrap()).collect();
        // One line may be in the writer's hands already.
        assert!((8..=9).contains(&before.len()) && before.iter().copied().eq(0..before.len()), "{before:?}");
        assert_eq!(
            after,
            format!("{} lines are left out here: they came faster than they were read)\n100\n", 100 - before.len())
        );
    }
}
