//! Worker threads for work that is not bounded by the size of an arm. Steps do not wait for it.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use tokio::sync::{Semaphore, oneshot};

use super::background::{AbandonOnDrop, Abandoned};
use super::error::ApiError;
use super::platform::{JobQueue, Platform, WorkKind};

/// The threads for one kind of work, with a queue of their own. A full queue refuses work at once.
pub struct Workers {
    kind: WorkKind,
    timeout: Duration,
    platform: Arc<dyn Platform>,
    /// Permits to run or wait.
    admitted: Arc<Semaphore>,
    /// Sends jobs to the threads, which start with the first job and end when this value is dropped.
    queue: OnceLock<JobQueue>,
}

impl Workers {
    /// Creates the queue. A job that has not finished after `timeout` is abandoned, and its client gets status 503.
    pub fn new(kind: WorkKind, timeout: Duration, platform: &Arc<dyn Platform>) -> Self {
        let admitted = Arc::new(Semaphore::new(kind.max));
        Self { kind, timeout, platform: Arc::clone(platform), admitted, queue: OnceLock::new() }
    }

    /// Runs `work` in one of the threads after the jobs before it, and waits for it. Refuses it if the queue is full.
    pub async fn run<T: Send + 'static>(
        &self,
        work: impl FnOnce(&Abandoned) -> T + Send + 'static,
    ) -> Result<T, ApiError> {
        let WorkKind { name, max, .. } = self.kind;
        let busy = |_| ApiError::busy(format!("{max} {name} are running or waiting; try again in a second"));
        // The job holds the permit, because it continues for a while after its client is gone.
        let permit = Arc::clone(&self.admitted).try_acquire_owned().map_err(busy)?;
        let (sender, answer) = oneshot::channel();
        let abandoned = Abandoned::default();
        let _guard = AbandonOnDrop::of(&abandoned);
        let job = move || {
            if abandoned.is_set() {
                return;
            }
            let result = catch_unwind(AssertUnwindSafe(|| work(&abandoned)));
            // The client may send its next request as soon as it has the answer.
            drop(permit);
            if let Ok(result) = result {
                drop(sender.send(result));
            } else {
                tracing::error!("background work failed");
            }
        };
        self.queue.get_or_init(|| self.platform.start_workers(self.kind))(Box::new(job));
        match tokio::time::timeout(self.timeout, answer).await {
            Ok(answer) => answer.map_err(|_| ApiError::internal()),
            Err(_) => Err(ApiError::deadline(self.timeout)),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;
    use crate::service::platform::OperatingSystem;

    const KIND: WorkKind = WorkKind { name: "tests", max: 2, threads: 1, low_priority: false };

    fn workers(timeout: Duration) -> Workers {
        let platform: Arc<dyn Platform> = Arc::new(OperatingSystem);
        Workers::new(KIND, timeout, &platform)
    }

    fn block_on<T>(future: impl Future<Output = T>) -> T {
        tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap().block_on(future)
    }

    fn kind<T>(result: Result<T, ApiError>) -> Option<&'static str> {
        result.err().map(|error| error.kind())
    }

    #[test]
    fn work_that_does_not_end_is_abandoned_at_its_deadline() {
        let workers = workers(Duration::from_millis(50));
        let (ended, has_ended) = mpsc::channel();
        let endless = workers.run(move |abandoned| {
            while !abandoned.is_set() {
                std::thread::sleep(Duration::from_millis(1));
            }
            ended.send(()).unwrap();
        });
        assert_eq!(kind(block_on(endless)), Some("deadline"));
        has_ended.recv_timeout(Duration::from_secs(20)).unwrap();
        assert_eq!(block_on(workers.run(|_| 7)).unwrap(), 7);
    }

    #[test]
    fn a_full_queue_refuses_work_and_an_empty_one_takes_it_again() {
        let workers = workers(Duration::from_mins(1));
        block_on(async {
            let (release, released) = mpsc::channel::<()>();
            let (first, second) = (workers.run(move |_| released.recv().is_ok()), workers.run(|_| 2));
            let third = async {
                // The first two are polled before this future.
                let refused = kind(workers.run(|_| 3).await);
                release.send(()).unwrap();
                refused
            };
            let (first, second, third) = tokio::join!(first, second, third);
            assert_eq!((kind(first), second.unwrap(), third), (None, 2, Some("busy")));
        });
        assert_eq!(block_on(workers.run(|_| 4)).unwrap(), 4);
    }

    #[test]
    fn a_panic_is_an_internal_error_and_the_thread_continues() {
        let workers = workers(Duration::from_mins(1));
        for _ in 0..3 {
            let panicked = workers.run(|_| -> u8 { panic!("meant for a test") });
            assert_eq!(kind(block_on(panicked)), Some("internal"));
        }
        assert_eq!(block_on(workers.run(|_| 5)).unwrap(), 5);
    }
}
