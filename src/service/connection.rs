//! Open connections: their maximum number, and the timeout for clients that do not read their answer.

use std::collections::HashMap;
use std::io;
use std::pin::Pin;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, ready};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::task::AbortHandle;
use tokio::time::{Instant, Sleep};

/// A connection with so many reads and answers, the last answer not longer ago than [`LOOP_PAUSE`], is in a control loop.
const LOOP_CALLS: u64 = 8;
const LOOP_PAUSE: Duration = Duration::from_secs(1);

/// A stream without a state for so long may be closed for another connection.
const STREAM_PAUSE: Duration = Duration::from_secs(30);

/// All open connections.
#[derive(Debug)]
pub struct Connections {
    limit: usize,
    start: Instant,
    /// Counts answers. Of two answers, the later one has the larger number.
    clock: AtomicU64,
    open: Mutex<HashMap<u64, Arc<Entry>>>,
}

#[derive(Debug, Default)]
struct Entry {
    /// Value of the clock when the connection was opened or last answered.
    answered: AtomicU64,
    /// Number of reads from the client, and of writes to it.
    reads: AtomicU64,
    writes: AtomicU64,
    /// Time of the last write since the start of the service, ms.
    last_write_ms: AtomicU64,
    task: ServingTask,
}

/// The task that serves a connection: at first that of its requests, after an upgrade that of its stream.
#[derive(Debug, Clone, Default)]
pub struct ServingTask(Arc<Mutex<Serving>>);

#[derive(Debug, Default)]
struct Serving {
    task: Option<AbortHandle>,
    /// When the last state came, or the stream began; `None`: it is no stream.
    last_state: Option<Instant>,
}

impl ServingTask {
    /// Sets the task.
    pub fn set(&self, task: AbortHandle) {
        self.lock().task = Some(task);
    }

    /// Notes that a state has come, or that a stream begins.
    pub fn note_state(&self) {
        self.lock().last_state = Some(Instant::now());
    }

    fn is_running(&self) -> bool {
        self.lock().task.as_ref().is_some_and(|task| !task.is_finished())
    }

    /// Returns when the last state came to the stream; `None`: it is no stream.
    fn last_state(&self) -> Option<Instant> {
        self.lock().last_state
    }

    fn abort(&self) {
        self.lock().task.as_ref().inspect(|task| task.abort());
    }

    fn lock(&self) -> MutexGuard<'_, Serving> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The place of one connection in the table. Dropping it removes the connection.
#[derive(Debug)]
pub struct Slot {
    id: u64,
    entry: Arc<Entry>,
    all: Arc<Connections>,
}

impl Connections {
    /// Creates an empty table for at most `limit` connections.
    pub fn new(limit: usize) -> Arc<Self> {
        Arc::new(Self { limit, start: Instant::now(), clock: AtomicU64::new(0), open: Mutex::default() })
    }

    /// Adds a connection. Returns its slot, and whether another connection was closed for it. Returns `None` if no other
    /// connection could be closed.
    ///
    /// The connection without an answer for the longest time is closed: a client that sends its request slowly, or an idle
    /// one, never a client in a control loop: a flood of connections within one period must not close it. Streams come last, and only
    /// those without a state for [`STREAM_PAUSE`]: an arm may stand for a while.
    pub fn add(self: &Arc<Self>) -> Option<(Slot, bool)> {
        let full = self.count() >= self.limit;
        if full && !self.close_oldest() {
            return None;
        }
        let id = self.tick();
        let entry = Arc::new(Entry { answered: AtomicU64::new(id), ..Entry::default() });
        self.open().insert(id, Arc::clone(&entry));
        Some((Slot { id, entry, all: Arc::clone(self) }, full))
    }

    /// Closes the connection without an answer for the longest time. Returns false if no connection can be closed.
    pub fn close_oldest(&self) -> bool {
        let mut open = self.open();
        let now_ms = self.now_ms();
        let is_idle = |entry: &Entry| match entry.task.last_state() {
            Some(last) => last.elapsed() >= STREAM_PAUSE,
            None => !entry.is_in_loop(now_ms),
        };
        let idle = open.iter().filter(|(_, entry)| entry.task.is_running() && is_idle(entry));
        // No stream is before every stream.
        let oldest = idle.min_by_key(|(_, entry)| (entry.task.last_state(), entry.answered.load(Ordering::Relaxed)));
        let oldest = oldest.map(|(&id, _)| id);
        let Some(entry) = oldest.and_then(|id| open.remove(&id)) else { return false };
        entry.task.abort();
        true
    }

    /// Number of open connections.
    pub fn count(&self) -> usize {
        self.open().len()
    }

    fn now_ms(&self) -> u64 {
        u64::try_from(self.start.elapsed().as_millis()).unwrap_or(u64::MAX)
    }

    fn tick(&self) -> u64 {
        self.clock.fetch_add(1, Ordering::Relaxed)
    }

    fn open(&self) -> MutexGuard<'_, HashMap<u64, Arc<Entry>>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Entry {
    /// Returns whether requests and answers alternate. Watchers read nothing more, and slow clients get no answers.
    fn is_in_loop(&self, now_ms: u64) -> bool {
        let is_recent = || {
            let pause = now_ms.saturating_sub(self.last_write_ms.load(Ordering::Relaxed));
            Duration::from_millis(pause) <= LOOP_PAUSE
        };
        [&self.reads, &self.writes].into_iter().all(|count| count.load(Ordering::Relaxed) >= LOOP_CALLS) && is_recent()
    }
}

impl Slot {
    /// Returns the counter of reads.
    pub fn reads(&self) -> Reads {
        Reads { entry: Arc::clone(&self.entry), seen: AtomicU64::new(0) }
    }

    /// Returns the place of the task that serves the connection.
    pub fn task(&self) -> ServingTask {
        self.entry.task.clone()
    }
}

/// Tells requests that arrived together from requests that arrived one after the other.
#[derive(Debug)]
pub struct Reads {
    entry: Arc<Entry>,
    /// Number of reads at the last request.
    seen: AtomicU64,
}

impl Reads {
    /// Returns whether bytes have arrived since the last call.
    pub fn has_new(&self) -> bool {
        let reads = self.entry.reads.load(Ordering::Relaxed);
        self.seen.swap(reads, Ordering::Relaxed) != reads
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        self.all.open().remove(&self.id);
    }
}

/// A connection that ends when its client reads no byte of an answer for too long.
#[derive(Debug)]
pub struct Connection<S> {
    stream: S,
    slot: Slot,
    write_timeout: Duration,
    /// The timer that runs while the client does not read.
    stalled: Option<Pin<Box<Sleep>>>,
}

impl<S> Connection<S> {
    /// Wraps an accepted stream.
    pub fn new(stream: S, slot: Slot, write_timeout: Duration) -> Self {
        Self { stream, slot, write_timeout, stalled: None }
    }

    fn after_write(&mut self, context: &mut Context, result: Poll<io::Result<usize>>) -> Poll<io::Result<usize>> {
        if result.is_ready() {
            self.stalled = None;
            let Slot { entry, all, .. } = &self.slot;
            entry.answered.store(all.tick(), Ordering::Relaxed);
            entry.last_write_ms.store(all.now_ms(), Ordering::Relaxed);
            entry.writes.fetch_add(1, Ordering::Relaxed);
            return result;
        }
        let timeout = self.write_timeout;
        let stalled = self.stalled.get_or_insert_with(|| Box::pin(tokio::time::sleep(timeout)));
        ready!(stalled.as_mut().poll(context));
        Poll::Ready(Err(io::ErrorKind::TimedOut.into()))
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Connection<S> {
    fn poll_read(mut self: Pin<&mut Self>, context: &mut Context, into: &mut ReadBuf) -> Poll<io::Result<()>> {
        let result = Pin::new(&mut self.stream).poll_read(context, into);
        if result.is_ready() {
            self.slot.entry.reads.fetch_add(1, Ordering::Relaxed);
        }
        result
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Connection<S> {
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let result = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.after_write(context, result)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context,
        slices: &[io::IoSlice],
    ) -> Poll<io::Result<usize>> {
        let result = Pin::new(&mut self.stream).poll_write_vectored(context, slices);
        self.after_write(context, result)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adds a connection whose task runs, as a stream without a state for a time if there is one.
    fn add(all: &Arc<Connections>, pause: Option<u64>) -> Option<(Slot, ServingTask)> {
        let (slot, _) = all.add()?;
        let task = slot.task();
        task.set(tokio::spawn(std::future::pending::<()>()).abort_handle());
        task.lock().last_state = pause.and_then(|pause| Instant::now().checked_sub(Duration::from_secs(pause)));
        Some((slot, task))
    }

    #[tokio::test(start_paused = true)]
    async fn streams_are_closed_last_and_only_after_a_long_pause() {
        tokio::time::advance(Duration::from_secs(1000)).await;
        let all = Connections::new(4);
        let [long, longer, short] = [40, 50, 2].map(|pause| add(&all, Some(pause)).unwrap());
        let plain = add(&all, None).unwrap();
        let is_open = |slot: &Slot| all.open().contains_key(&slot.id);
        let second = add(&all, Some(0)).unwrap();
        assert!(!is_open(&plain.0) && is_open(&longer.0), "the plain connection is the first");
        let third = add(&all, Some(0)).unwrap();
        assert!(!is_open(&longer.0) && is_open(&long.0), "then the stream with the longest pause");
        let fourth = add(&all, Some(0)).unwrap();
        assert!(!is_open(&long.0) && is_open(&short.0));
        assert!(add(&all, None).is_none(), "streams in use stay open");
        drop((second, third, fourth));
    }
}
