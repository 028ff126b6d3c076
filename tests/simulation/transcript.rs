//! What happened in a run, line by line. Two runs of the same seed have the same transcript.

use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::sync::{Arc, Mutex};

use tokio::time::Instant;

/// The lines of a run.
#[derive(Clone, Default)]
pub struct Transcript(Arc<Mutex<Vec<String>>>);

impl Transcript {
    /// Adds a line with the time since `start`.
    pub fn note(&self, start: Instant, who: &str, text: &str) {
        let time = start.elapsed().as_secs_f64();
        self.0.lock().unwrap().push(format!("{time:10.3} {who:9} {text}"));
    }

    pub fn lines(&self) -> Vec<String> {
        self.0.lock().unwrap().clone()
    }

    pub fn hash(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.0.lock().unwrap().hash(&mut hasher);
        hasher.finish()
    }
}

/// Returns the hash of an answer's body.
pub fn hash(bytes: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    bytes.hash(&mut hasher);
    hasher.finish()
}
