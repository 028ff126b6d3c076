//! Sends each input to the check of its target.

use std::time::Duration;

use crate::budget::Bound;
use crate::target::Target;
use crate::timed_service::{Format, TimedService};
use crate::{Defect, bodies, frames, session, stability, urdf};

/// Number of times that a late answer is asked for again. The first one may pay for memory pages or a new thread.
const ATTEMPTS: usize = 5;

/// Deadline of work in worker threads, which have a low priority. It bounds hangs, not the processor time.
const WORK_TIMEOUT: Duration = Duration::from_secs(10);

/// Sends inputs to a service, and checks its answers.
pub struct Checker {
    target: Target,
    service: TimedService,
}

impl Checker {
    /// Starts a service in memory for the inputs of this target.
    pub fn start(target: Target, bound: Bound) -> Self {
        let work_timeout = if target == Target::Stability { stability::TIMEOUT } else { WORK_TIMEOUT };
        Self { target, service: TimedService::start(bound, work_timeout) }
    }

    /// Sends an input to the service. Returns the first defect.
    pub fn check(&self, input: &[u8]) -> Result<(), Defect> {
        let mut result = Ok(());
        for _ in 0..ATTEMPTS {
            result = match self.target {
                Target::Json => bodies::check(&self.service, input, Format::Json),
                Target::MessagePack => bodies::check(&self.service, input, Format::MessagePack),
                Target::Stability => stability::check(&self.service, input),
                Target::Urdf => urdf::check(&self.service, input),
                Target::Stream => frames::check(&self.service, input),
                Target::Controller => session::check(&self.service, input),
            };
            if !matches!(result, Err(Defect::Slow(_))) {
                break;
            }
        }
        result
    }
}
