//! What the service takes from the operating system besides connections and time: threads for long work, random bytes.
//!
//! The simulation of `tests/simulation` replaces it, so that a seed decides both.

use std::sync::{Arc, Mutex, PoisonError, mpsc};

use uuid::Uuid;

use revprio_local::all_cores::lower_priority;

/// Work for another thread.
pub type Job = Box<dyn FnOnce() + Send>;

/// Passes jobs to threads. A job that is dropped instead of run counts as failed.
pub type JobQueue = Box<dyn Fn(Job) + Send + Sync>;

/// A kind of work.
#[derive(Debug, Clone, Copy)]
pub struct WorkKind {
    /// Name of the jobs in error texts, in the plural.
    pub name: &'static str,
    /// Maximum number of jobs at a time, running and waiting.
    pub max: usize,
    /// Number of threads.
    pub threads: usize,
    /// Whether the threads have a lower priority than the thread of the steps.
    pub low_priority: bool,
}

/// What the service takes from the operating system.
pub trait Platform: Send + Sync + 'static {
    /// Returns random bytes for an identifier. No other call returns the same bytes.
    fn random_bytes(&self) -> [u8; 16];

    /// Starts the threads for one kind of work. They run jobs in order, and end when the queue is dropped.
    fn start_workers(&self, kind: WorkKind) -> JobQueue;
}

/// The operating system itself.
#[derive(Debug, Clone, Copy, Default)]
pub struct OperatingSystem;

impl Platform for OperatingSystem {
    fn random_bytes(&self) -> [u8; 16] {
        Uuid::new_v4().into_bytes()
    }

    fn start_workers(&self, kind: WorkKind) -> JobQueue {
        let (sender, jobs) = mpsc::channel::<Job>();
        let jobs = Arc::new(Mutex::new(jobs));
        for _ in 0..kind.threads {
            let jobs = Arc::clone(&jobs);
            let run = move || {
                if kind.low_priority {
                    lower_priority();
                }
                // The lock is free while a job runs.
                let next = || jobs.lock().unwrap_or_else(PoisonError::into_inner).recv();
                while let Ok(job) = next() {
                    job();
                }
            };
            if let Err(error) = std::thread::Builder::new().name("worker".to_owned()).spawn(run) {
                tracing::error!(%error, "cannot start a thread for {}", kind.name);
            }
        }
        // Without any thread the job is dropped.
        Box::new(move |job| drop(sender.send(job)))
    }
}
