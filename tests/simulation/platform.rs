//! The platform of a simulated service: identifiers from the seed, and worker threads that are tasks with random pauses.

use std::sync::Mutex;
use std::time::Duration;

use revprio::service::{Job, JobQueue, Platform, WorkKind};
use tokio::sync::mpsc;

use crate::random::Random;

/// A platform whose decisions come from a seed.
pub struct Simulated {
    random: Mutex<Random>,
    /// Maximum time for which a job waits before it runs. A job runs at once and as a whole.
    pub max_wait: Duration,
}

impl Simulated {
    pub fn new(random: Random, max_wait: Duration) -> Self {
        Self { random: Mutex::new(random), max_wait }
    }
}

impl Platform for Simulated {
    fn random_bytes(&self) -> [u8; 16] {
        self.random.lock().unwrap().bytes()
    }

    fn start_workers(&self, kind: WorkKind) -> JobQueue {
        let mut random = self.random.lock().unwrap().fork();
        let max_ms = u64::try_from(self.max_wait.as_millis()).unwrap();
        let (sender, mut jobs) = mpsc::unbounded_channel::<Job>();
        assert!(kind.threads > 0);
        tokio::spawn(async move {
            while let Some(job) = jobs.recv().await {
                let wait = random.millis(0, max_ms);
                if random.one_in(2) && !wait.is_zero() {
                    tokio::time::sleep(wait).await;
                }
                job();
            }
        });
        Box::new(move |job| drop(sender.send(job)))
    }
}
