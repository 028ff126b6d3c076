//! A thread that watches the thread of the requests.
//!
//! The thread of the requests counts up a number, as one of its tasks. If the number stands still, that thread is stuck.
//! The watching thread then accepts the connections itself and answers each of them with 503, so that `/healthz` is true.
//! If the number stands still for longer, it reports that to the [`Supervisor`].
//!
//! Time is counted in ticks of the watching thread. A process that was stopped as a whole is therefore not stuck afterwards.

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use super::error::stuck_refusal;

/// Time between two checks.
const TICK: Duration = Duration::from_millis(100);

/// Time between two beats.
const BEAT: Duration = Duration::from_millis(40);

/// Number of ticks without a beat after which connections are answered with 503: 1 s. Beside other programs that take all
/// processors, half a second without a beat was seen at a service that was not stuck.
const LATE_TICKS: u32 = 10;

/// Maximum number of connections that are answered in one tick, and the time for the request of each.
const ANSWERS_PER_TICK: usize = 32;
const READ_TIMEOUT: Duration = Duration::from_millis(20);

/// Acts on the state of a service: tells a service manager, ends the process.
pub trait Supervisor: Send + 'static {
    /// The service listens.
    fn ready(&self) {}
    /// The service is alive. Called ten times a second.
    fn alive(&self) {}
    /// The service was told to stop.
    fn stopping(&self) {}
    /// The thread of the requests has been stuck for [`ServiceConfig::stuck_after`](super::ServiceConfig::stuck_after).
    /// Called again at every tick until it beats.
    fn stuck(&self) {}
}

/// Both sides of the watch.
#[derive(Debug)]
pub struct Heartbeat {
    beats: AtomicU64,
    /// Whether the thread of the requests has answered its last request.
    has_ended: AtomicBool,
    /// The address of the service, as long as the service listens. `None` with TLS: the watching thread has no certificate.
    listener: Mutex<Option<TcpListener>>,
}

/// The watching thread. It ends when this value is dropped.
#[derive(Debug)]
pub struct Watch {
    end: Option<mpsc::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Heartbeat {
    /// Creates a heartbeat that has not begun. The listener must not block.
    pub fn new(listener: Option<TcpListener>) -> Arc<Self> {
        Arc::new(Self { beats: AtomicU64::new(0), has_ended: AtomicBool::new(false), listener: Mutex::new(listener) })
    }

    /// Beats. This task must run on the thread of the requests.
    pub async fn run(&self) {
        loop {
            self.beats.fetch_add(1, Ordering::Relaxed);
            tokio::time::sleep(BEAT).await;
        }
    }

    /// Ends the watch, before the thread of the requests waits for other threads.
    pub fn end(&self) {
        self.has_ended.store(true, Ordering::Relaxed);
    }

    /// Closes the listener of the watching thread.
    pub fn stop_listening(&self) {
        *self.listener() = None;
    }

    /// Starts the watching thread.
    pub fn watch(
        self: &Arc<Self>,
        stuck_after: Duration,
        supervisor: Arc<impl Supervisor + Sync>,
    ) -> std::io::Result<Watch> {
        let (end, ended) = mpsc::channel();
        let heartbeat = Arc::clone(self);
        let watch = move || heartbeat.check(&ended, stuck_after, &*supervisor);
        let thread = std::thread::Builder::new().name("heartbeat".to_owned()).spawn(watch)?;
        Ok(Watch { end: Some(end), thread: Some(thread) })
    }

    fn check(&self, ended: &mpsc::Receiver<()>, stuck_after: Duration, supervisor: &impl Supervisor) {
        let (mut seen, mut ticks) = (0, 0_u32);
        while ended.recv_timeout(TICK) == Err(RecvTimeoutError::Timeout) {
            let beats = self.beats.load(Ordering::Relaxed);
            if beats != seen || self.has_ended.load(Ordering::Relaxed) {
                (seen, ticks) = (beats, 0);
                supervisor.alive();
                continue;
            }
            ticks += 1;
            if ticks == LATE_TICKS {
                tracing::error!("the thread of the requests is stuck");
            }
            if ticks >= LATE_TICKS {
                self.refuse_connections();
            }
            if TICK * ticks >= stuck_after {
                supervisor.stuck();
            }
        }
    }

    /// Answers the connections that the thread of the requests does not accept.
    fn refuse_connections(&self) {
        let listener = self.listener();
        let waiting = listener.iter().flat_map(TcpListener::incoming).take(ANSWERS_PER_TICK);
        for stream in waiting.map_while(Result::ok) {
            // A client that is gone needs no answer.
            let _ = refuse(stream);
        }
    }

    fn listener(&self) -> MutexGuard<'_, Option<TcpListener>> {
        self.listener.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Reads what has arrived of a request, and answers it.
fn refuse(mut stream: TcpStream) -> std::io::Result<()> {
    stream.set_nonblocking(false)?;
    stream.set_read_timeout(Some(READ_TIMEOUT))?;
    stream.set_write_timeout(Some(READ_TIMEOUT))?;
    // Closing a connection with unread bytes would reset it, and the client would lose the answer.
    let _ = stream.read(&mut [0; 16 << 10]);
    stream.write_all(stuck_refusal().as_bytes())
}

impl Drop for Watch {
    fn drop(&mut self) {
        drop(self.end.take());
        self.thread.take().map(JoinHandle::join);
    }
}
