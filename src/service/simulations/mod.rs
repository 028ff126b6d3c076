//! Runs of the built-in simulator: a queue, and the results of ended runs.
//!
//! Each run calls the controller through [`InProcess`](super::in_process::InProcess) in its own thread. Its joint
//! velocities equal those over HTTP to the last bit, and it does not compete with the requests of clients.

mod job;
mod operator;
mod trace;

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use revprio_lab::simulator::Scenario;
use revprio_local::simulation::{RunControl, check_size};
use revprio_robot::RobotModel;
use tokio::sync::Semaphore;

pub use job::Job;
pub use trace::trace_answer;

use super::error::ApiError;

/// Maximum number of simulations that run at a time. Each uses about one core.
const MAX_RUNNING: usize = 2;

/// Maximum number of interactive simulations at a time, in addition. Each waits for the clock most of the time.
const MAX_INTERACTIVE: usize = 4;

/// An interactive simulation that no client has watched or commanded for this time makes room for a new one: its client
/// may have gone without a word. Two frames or commands of a client in use are less than a second apart.
const ROOM_TIME: Duration = Duration::from_secs(5);

/// Maximum number of known simulations: waiting, running and ended.
const MAX_KEPT: usize = 64;

/// Maximum number of control periods of all known simulations together. A trace uses about 0.7 kilobytes per period, or
/// 1 kilobyte with noisy sensors, so all traces use at most about 250 MB.
const MAX_PERIODS_KEPT: u64 = 250_000;

/// An ended simulation is deleted after this time.
const KEEP_TIME: Duration = Duration::from_hours(1);

/// All known simulations, the oldest first.
pub struct Simulations {
    jobs: Mutex<Vec<Arc<Job>>>,
    /// Permits to run.
    permits: Arc<Semaphore>,
}

impl Default for Simulations {
    fn default() -> Self {
        Self { jobs: Mutex::default(), permits: Arc::new(Semaphore::new(MAX_RUNNING)) }
    }
}

impl Simulations {
    /// Adds a simulation. It runs after the earlier ones. A simulation with a `run_control` is interactive and runs at once.
    pub fn create(
        &self,
        scenario: Scenario,
        robot: Arc<RobotModel>,
        run_control: Option<RunControl>,
    ) -> Result<Arc<Job>, ApiError> {
        check_size(&scenario)?;
        let job = Arc::new(Job::new(scenario, run_control));
        self.keep(&job)?;
        tokio::spawn(Arc::clone(&job).run(robot, Arc::clone(&self.permits)));
        Ok(job)
    }

    /// Adds a simulation. Deletes the oldest ended ones if there are too many.
    fn keep(&self, job: &Arc<Job>) -> Result<(), ApiError> {
        let mut jobs = self.lock();
        jobs.retain(|job| job.ended_for().is_none_or(|time| time < KEEP_TIME));
        let is_full = |jobs: &[Arc<Job>]| {
            let periods: u64 = jobs.iter().map(|job| job.periods()).sum();
            jobs.len() >= MAX_KEPT || periods + job.periods() > MAX_PERIODS_KEPT
        };
        let has_ended = |job: &Arc<Job>| job.ended_for().is_some();
        let is_needed = |job: &&Arc<Job>| !has_ended(job) && !is_left_alone(job);
        let busy = || ApiError::busy("too many simulations are waiting or running; try again later");
        // A refused simulation deletes no other.
        if is_full(&jobs.iter().filter(is_needed).cloned().collect::<Vec<_>>()) {
            return Err(busy());
        }
        let crowding = if job.is_interactive() { crowding(&jobs)? } else { None };
        while is_full(&jobs) {
            let place = jobs.iter().position(has_ended).or_else(|| left_alone(&jobs)).ok_or_else(busy)?;
            jobs.remove(place).cancel();
        }
        // One that was removed has ended already.
        if let Some(crowding) = crowding.filter(|it| jobs.iter().any(|job| Arc::ptr_eq(job, it))) {
            crowding.finish();
        }
        jobs.push(Arc::clone(job));
        Ok(())
    }

    /// Returns a simulation by its ID.
    pub fn get(&self, id: &str) -> Result<Arc<Job>, ApiError> {
        self.lock().iter().find(|job| job.id() == id).cloned().ok_or_else(|| {
            ApiError::not_found(format!(
                "there is no simulation `{id}`; it may have been deleted; start one with POST /v1/simulations"
            ))
        })
    }

    /// Cancels a simulation that has not ended. Deletes one that has ended.
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

/// Returns the interactive simulation that must end before another one begins; `None` if there is room.
fn crowding(jobs: &[Arc<Job>]) -> Result<Option<Arc<Job>>, ApiError> {
    if jobs.iter().filter_map(|job| job.unattended_for()).count() < MAX_INTERACTIVE {
        return Ok(None);
    }
    let detail = || format!("{MAX_INTERACTIVE} interactive simulations are running; end one, or try again later");
    left_alone(jobs).map(|place| Some(Arc::clone(&jobs[place]))).ok_or_else(|| ApiError::busy(detail()))
}

/// Returns whether an interactive simulation was left alone for longer than [`ROOM_TIME`].
fn is_left_alone(job: &Job) -> bool {
    job.unattended_for().is_some_and(|time| time > ROOM_TIME)
}

/// Returns the interactive simulation that was left alone longest, for longer than [`ROOM_TIME`].
fn left_alone(jobs: &[Arc<Job>]) -> Option<usize> {
    let places = (0..jobs.len()).filter(|&place| is_left_alone(&jobs[place]));
    places.max_by_key(|&place| jobs[place].unattended_for())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn job(periods: u32) -> Arc<Job> {
        let mut scenario = Scenario::find("stiff_wall").unwrap();
        scenario.duration_s = f64::from(periods) * scenario.controller.period_s;
        Arc::new(Job::new(scenario, None))
    }

    #[test]
    fn a_refused_simulation_deletes_no_other() {
        let simulations = Simulations::default();
        let ended = job(1000);
        for kept in [&ended, &job(100_000), &job(100_000)] {
            simulations.keep(kept).unwrap();
        }
        ended.cancel();
        assert!(simulations.keep(&job(60_000)).is_err());
        assert!(simulations.get(ended.id()).is_ok());
        simulations.keep(&job(49_500)).unwrap();
        assert!(simulations.get(ended.id()).is_err());
    }
}
