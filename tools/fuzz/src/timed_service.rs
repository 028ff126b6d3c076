//! A service in memory whose answers have a budget of processor time.

use std::time::Duration;

use revprio_api::wire::Object;
use serde::de::DeserializeOwned;

use crate::Defect;
use crate::budget::{Bound, Work, processor_time};
use crate::connection::{Answer, InMemory};

/// A service in memory, and what bounds the time of its answers.
pub struct TimedService {
    bound: Bound,
    service: InMemory,
}

impl TimedService {
    /// Starts a service. `work_timeout` is the deadline of work in its worker threads.
    pub fn start(bound: Bound, work_timeout: Duration) -> Self {
        Self { bound, service: InMemory::start(work_timeout) }
    }

    /// Returns the service, for requests without a budget.
    pub fn untimed(&self) -> &InMemory {
        &self.service
    }

    /// Runs `act`, which may use this much processor time.
    pub fn timed<T>(&self, budget: Duration, act: impl FnOnce() -> Result<T, Defect>) -> Result<T, Defect> {
        let start = processor_time();
        let value = act()?;
        let used = processor_time().saturating_sub(start);
        if self.bound == Bound::ProcessorTime && used > budget {
            return Err(Defect::Slow(format!("{used:?} of processor time, more than {budget:?}")));
        }
        Ok(value)
    }

    /// Posts a body in JSON, and returns its answer in time.
    pub fn post(&self, path: &str, body: &[u8], work: Work) -> Result<Answer, Defect> {
        self.post_as(Format::Json, path, body, work)
    }

    /// Posts a body in a format, and returns its answer in time.
    pub fn post_as(&self, format: Format, path: &str, body: &[u8], work: Work) -> Result<Answer, Defect> {
        let work = Work { bytes: body.len(), ..work };
        self.timed(work.budget(), || self.service.post(path, format.media_type(), body))
    }
}

/// The format of a body.
#[derive(Debug, Clone, Copy)]
pub enum Format {
    /// JSON.
    Json,
    /// MessagePack.
    MessagePack,
}

impl Format {
    /// Returns the media type.
    pub fn media_type(self) -> &'static str {
        match self {
            Self::Json => "application/json",
            Self::MessagePack => "application/msgpack",
        }
    }

    /// Reads a request as the service does.
    pub fn read<T: DeserializeOwned>(self, body: &[u8]) -> Option<T> {
        let read = match self {
            Self::Json => serde_json::from_slice(body).ok(),
            Self::MessagePack => rmp_serde::from_slice(body).ok(),
        };
        read.map(|Object(value)| value)
    }
}

/// Returns the request, which the service accepted and which must therefore be readable.
pub fn accepted<T>(request: Option<T>) -> Result<T, Defect> {
    request.ok_or_else(|| Defect::Wrong("the service accepted a body that its type refuses".to_owned()))
}
