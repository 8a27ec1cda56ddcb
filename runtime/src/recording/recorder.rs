//! Gathers the entries of all robots and writes them on a thread of its own.

use std::{
    mem,
    sync::{
        Arc, Mutex, MutexGuard, OnceLock, PoisonError, Weak,
        mpsc::{self, Receiver, SyncSender, sync_channel},
    },
    thread::{self, JoinHandle},
    time::Duration,
};

use super::{ChunkLimits, Entries, Mission, RecordError, RecordingSummary, Sink, file::RecordingFile};
use crate::time::Time;

/// Size at which a batch goes to the writing thread. Waking a thread costs some 25 µs, so a step's entries do not go alone.
const BATCH: usize = 256 << 10;
/// A batch does not wait longer than this.
const PATIENCE: Duration = Duration::from_secs(1);
/// How many batches may wait for the disk before a step has to.
const WAITING: usize = 16;
/// Robot number and length before a robot's entries in a batch.
const FRAME: usize = 8;

/// Writes one recording.
///
/// A recording that fails (the disk is full, say) does not stop the run: [`Recorder::failure`] tells at once,
/// [`Recorder::finish`] at the end, and what comes in between is dropped. Dropped without being finished, a recorder
/// completes its file in silence.
#[derive(Debug)]
pub struct Recorder {
    desk: Arc<Mutex<Desk>>,
    failure: Arc<OnceLock<String>>,
}

/// What waits to be written, and who writes it. Nobody else asks for it before the program is ended the hard way.
#[derive(Debug)]
struct Desk {
    pending: Vec<u8>,
    /// Time of the first entries in `pending`.
    since: Option<Time>,
    writer: Option<Writer>,
    failure: Arc<OnceLock<String>>,
    place: String,
}

#[derive(Debug)]
struct Writer {
    batches: SyncSender<Vec<u8>>,
    spare: Receiver<Vec<u8>>,
    thread: JoinHandle<Result<RecordingSummary, RecordError>>,
}

/// The recordings of this process that are being written.
static OPEN: Mutex<Vec<Weak<Mutex<Desk>>>> = Mutex::new(Vec::new());

impl Recorder {
    /// Creates a recording of a mission and starts the thread that writes it.
    ///
    /// # Errors
    /// The file cannot be created or written, or no thread can be started.
    pub fn start(sink: Sink, mission: &Mission, limits: ChunkLimits) -> Result<Self, RecordError> {
        let file = RecordingFile::create(sink, mission, &limits)?;
        let place = file.place().to_owned();
        let failure = Arc::new(OnceLock::new());
        let (batches, incoming) = sync_channel(WAITING);
        // While one batch is being filled, one can be on its way, one being written, and the others wait.
        let (used, spare) = sync_channel(WAITING + 2);
        for _ in 0..WAITING + 2 {
            let _ = used.try_send(Vec::with_capacity(BATCH + BATCH / 2));
        }
        let told = Arc::clone(&failure);
        let thread = thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || write(file, &incoming, &used, &told))
            .map_err(RecordError::Thread)?;
        let pending = Vec::with_capacity(BATCH + BATCH / 2);
        let writer = Some(Writer { batches, spare, thread });
        let desk = Arc::new(Mutex::new(Desk { pending, since: None, writer, failure: failure.clone(), place }));
        let mut open = lock(&OPEN);
        open.retain(|desk| desk.strong_count() > 0);
        open.push(Arc::downgrade(&desk));
        Ok(Self { desk, failure })
    }

    /// Takes a robot's entries over and empties them. Call it once a step for each robot, in the robots' order: the
    /// order of these calls is the order in the file.
    ///
    /// Waits only if the disk is 16 batches behind: of 256 KiB, or of the entries of one second if those are fewer.
    pub fn append(&mut self, entries: &mut Entries) {
        let bytes = entries.bytes();
        if !bytes.is_empty() && self.failure.get().is_none() {
            lock(&self.desk).append(entries.robot(), entries.time, bytes);
        }
        entries.clear();
    }

    /// Why the recording has stopped, if it has.
    #[must_use]
    pub fn failure(&self) -> Option<&str> {
        self.failure.get().map(String::as_str)
    }

    /// Writes what is left, then the summary, and waits until all is done.
    ///
    /// # Errors
    /// The recording has failed, now or at any time before.
    pub fn finish(self) -> Result<RecordingSummary, RecordError> {
        lock(&self.desk).end()
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        let mut desk = lock(&self.desk);
        if desk.writer.is_some() {
            let _ = desk.end();
        }
    }
}

impl Desk {
    fn append(&mut self, robot: usize, time: Time, bytes: &[u8]) {
        self.pending.extend_from_slice(&(robot as u32).to_le_bytes());
        self.pending.extend_from_slice(&(bytes.len() as u32).to_le_bytes());
        self.pending.extend_from_slice(bytes);
        let since = *self.since.get_or_insert(time);
        if self.pending.len() >= BATCH || time.since(since) >= PATIENCE {
            self.send();
        }
    }

    fn send(&mut self) {
        self.since = None;
        let Some(writer) = &self.writer else { return };
        let empty = writer.spare.try_recv().unwrap_or_default();
        if writer.batches.send(mem::replace(&mut self.pending, empty)).is_err() {
            let _ = self.failure.set(self.panicked().to_string());
        }
    }

    fn panicked(&self) -> RecordError {
        RecordError::Panicked { place: self.place.clone() }
    }

    fn end(&mut self) -> Result<RecordingSummary, RecordError> {
        if !self.pending.is_empty() {
            self.send();
        }
        let Some(Writer { batches, thread, .. }) = self.writer.take() else { return Err(self.panicked()) };
        drop(batches);
        thread.join().unwrap_or_else(|_| Err(self.panicked()))
    }
}

/// Completes all recordings of this process with what they have got, for a program that is about to end with its missions hanging.
/// Gives up on one whose disk does not answer for so long.
pub(crate) fn complete_all(patience: Duration) {
    let desks: Vec<_> = lock(&OPEN).iter().filter_map(Weak::upgrade).collect();
    let (done, wait) = mpsc::channel();
    let all = move || {
        for desk in desks {
            let _ = lock(&desk).end();
        }
        let _ = done.send(());
    };
    if thread::Builder::new().name("completes recordings".to_owned()).spawn(all).is_ok() {
        let _ = wait.recv_timeout(patience);
    }
}

/// Whoever panicked while it held this has left it usable: bytes are appended one whole entry after the other, or not at all.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The writing thread: goes on taking batches after a failure, so that nobody waits for it.
fn write(
    mut file: RecordingFile,
    incoming: &Receiver<Vec<u8>>,
    used: &SyncSender<Vec<u8>>,
    failure: &OnceLock<String>,
) -> Result<RecordingSummary, RecordError> {
    let mut result = Ok(());
    while let Ok(mut batch) = incoming.recv() {
        if result.is_ok() {
            result = append_batch(&mut file, &batch);
            if let Err(error) = &result {
                let _ = failure.set(error.to_string());
            }
        }
        batch.clear();
        let _ = used.try_send(batch);
    }
    result?;
    file.finish()
}

fn append_batch(file: &mut RecordingFile, mut batch: &[u8]) -> Result<(), RecordError> {
    while let Some((frame, rest)) = batch.split_first_chunk::<FRAME>() {
        let [r0, r1, r2, r3, l0, l1, l2, l3] = *frame;
        let robot = u32::from_le_bytes([r0, r1, r2, r3]) as usize;
        let length = u32::from_le_bytes([l0, l1, l2, l3]) as usize;
        let Some((entries, rest)) = rest.split_at_checked(length) else { return Err(RecordError::Entries { robot }) };
        file.append(robot, entries)?;
        batch = rest;
    }
    Ok(())
}
