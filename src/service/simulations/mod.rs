//! Runs of the built-in simulator, a few at a time, kept for a while.
//!
//! Each run calls a service of its own over HTTP on a free loopback port: what it shows is what any client would get, and
//! neither its calls nor a flood of clients here disturb the other.

mod job;
mod live;
mod run_control;
mod trace;

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::Semaphore;

pub use job::Job;
pub use run_control::{RunControl, live_run_control, run_control};
pub use trace::trace;

use super::error::ApiError;
use revprio_lab::simulator::Scenario;
use revprio_robot::RobotModel;

/// Runs at work at a time; each keeps about one core busy.
const MOST_RUNNING: usize = 2;

/// Interactive runs at a time, beside those: each waits for the clock most of the time.
const MOST_INTERACTIVE: usize = 4;

/// Runs that are known at a time: waiting, at work and ended.
const MOST_KEPT: usize = 64;

/// Longest run in control periods.
const MOST_PERIODS: u64 = 100_000;

/// Most steps of arm and contacts in a run, substeps counted.
const MOST_STEPS: u64 = 1_000_000;

/// Control periods of all known runs together; a trace takes some 0.7 kilobytes per period, with sensors that err one, so
/// all take at most some 250 MB.
const MOST_PERIODS_KEPT: u64 = 250_000;

/// An ended run is forgotten after this time.
const KEPT_FOR: Duration = Duration::from_hours(1);

/// All runs that are known, oldest first.
pub struct Simulations {
    jobs: Mutex<Vec<Arc<Job>>>,
    turns: Arc<Semaphore>,
}

impl Default for Simulations {
    fn default() -> Self {
        Self { jobs: Mutex::default(), turns: Arc::new(Semaphore::new(MOST_RUNNING)) }
    }
}

impl Simulations {
    /// Takes in a run, which begins when its turn comes; one with a run_control at once.
    pub fn create(
        &self,
        scenario: Scenario,
        robot: Arc<RobotModel>,
        run_control: Option<RunControl>,
    ) -> Result<Arc<Job>, ApiError> {
        let periods = scenario.cycles();
        if periods > MOST_PERIODS {
            let detail = format!("{periods} control periods; a simulation here has at most {MOST_PERIODS}");
            return Err(ApiError::invalid("/scenario/duration_s", detail));
        }
        if periods * scenario.substeps as u64 > MOST_STEPS {
            let detail =
                format!("{periods} periods of so many steps; a simulation here has at most {MOST_STEPS} steps");
            return Err(ApiError::invalid("/scenario/substeps", detail));
        }
        let job = Arc::new(Job::new(scenario, run_control));
        self.keep(&job)?;
        tokio::spawn(Arc::clone(&job).run(robot, Arc::clone(&self.turns)));
        Ok(job)
    }

    /// Makes room, forgetting the oldest ended runs as far as needed, and takes the run in.
    fn keep(&self, job: &Arc<Job>) -> Result<(), ApiError> {
        let mut jobs = self.lock();
        jobs.retain(|job| job.ended_for().is_none_or(|time| time < KEPT_FOR));
        let interactive = jobs.iter().filter(|job| job.run_control().is_some() && !job.has_ended()).count();
        if job.run_control().is_some() && interactive >= MOST_INTERACTIVE {
            let detail =
                format!("{MOST_INTERACTIVE} interactive simulations are going on; end one, or try again later");
            return Err(ApiError::busy(detail));
        }
        let is_full = |jobs: &[Arc<Job>]| {
            let periods: u64 = jobs.iter().map(|job| job.periods()).sum();
            jobs.len() >= MOST_KEPT || periods + job.periods() > MOST_PERIODS_KEPT
        };
        while is_full(&jobs) {
            let Some(oldest) = jobs.iter().position(|job| job.ended_for().is_some()) else {
                return Err(ApiError::busy("as many simulations as there is room for are waiting; try again later"));
            };
            jobs.remove(oldest);
        }
        jobs.push(Arc::clone(job));
        Ok(())
    }

    /// A run by name.
    pub fn get(&self, id: &str) -> Result<Arc<Job>, ApiError> {
        self.lock().iter().find(|job| job.id() == id).cloned().ok_or_else(|| unknown(id))
    }

    /// Cancels a run that has not ended, forgets one that has.
    pub fn delete(&self, id: &str) -> Result<(), ApiError> {
        let job = self.get(id)?;
        if !job.cancel() {
            self.lock().retain(|other| !Arc::ptr_eq(other, &job));
        }
        Ok(())
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Arc<Job>>> {
        self.jobs.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn unknown(id: &str) -> ApiError {
    ApiError::not_found(format!(
        "there is no simulation `{id}`; it may be forgotten; start one with POST /v1/simulations"
    ))
}
