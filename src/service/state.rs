//! The state that all requests share.

use std::sync::Arc;

use revprio_local::all_cores::threads_beside_steps;
use tokio::sync::Semaphore;

use super::admission_queue::AdmissionQueue;
use super::config::ServiceConfig;
use super::connection::Connections;
use super::drain::Drain;
use super::failures::Failures;
use super::metrics::Metrics;
use super::platform::{OperatingSystem, Platform, WorkKind};
use super::request_id::RequestIds;
use super::robots::Robots;
use super::sessions::Sessions;
use super::simulations::Simulations;
use super::stepper_cache::StepperCache;
use super::workers::Workers;

/// A batch uses all cores while it runs. Each may hold a body and an answer of about 20 MB.
const BATCHES: WorkKind = WorkKind { name: "batches", max: 4, threads: 1, low_priority: true };

/// A margin at the maximum delay takes some seconds.
const MARGINS: WorkKind = WorkKind { name: "stability margins", max: 8, threads: 1, low_priority: true };

/// New controllers, robots and simulations: checks and stability warnings.
const NEW: WorkKind =
    WorkKind { name: "new controllers, robots or simulations", max: 64, threads: 1, low_priority: true };

/// Batches take longer than other work by this factor.
const BATCH_TIMEOUT_FACTOR: u32 = 10;

/// The state that all requests share.
pub struct AppState {
    /// The arms that requests can name.
    pub robots: Robots,
    /// The settings of the service.
    pub config: ServiceConfig,
    pub(super) sessions: Sessions,
    pub(super) stepper_cache: StepperCache,
    /// Work above the budgets of [`price`](super::price), and work without a bound. Each kind has its own queue.
    pub(super) batches: Workers,
    pub(super) large_problems: Workers,
    pub(super) large_steps: Workers,
    pub(super) margins: Workers,
    pub(super) new: Workers,
    pub(super) simulations: Simulations,
    pub(super) connections: Arc<Connections>,
    pub(super) metrics: Arc<Metrics>,
    pub(super) admission_queue: AdmissionQueue,
    /// Permits for reading large bodies.
    pub(super) large_bodies: Semaphore,
    pub(super) request_ids: RequestIds,
    pub(super) failures: Failures,
    pub(super) drain: Drain,
}

impl AppState {
    /// Creates the state of a service with the default settings.
    pub fn new(robots: Robots) -> Self {
        Self::with_config(robots, ServiceConfig::default())
    }

    /// Creates the state of a service.
    pub fn with_config(robots: Robots, config: ServiceConfig) -> Self {
        let platform: Arc<dyn Platform> = Arc::new(OperatingSystem);
        Self::on_platform(robots, config, &platform)
    }

    /// Creates the state of a service on a platform that may be simulated.
    pub fn on_platform(robots: Robots, config: ServiceConfig, platform: &Arc<dyn Platform>) -> Self {
        let metrics = Arc::new(Metrics::new());
        let threads = threads_beside_steps();
        let large_problems = WorkKind { name: "large problems", max: 32, threads, low_priority: true };
        // Arms wait for steps.
        let large_steps = WorkKind { name: "large steps", max: 32, threads, low_priority: false };
        Self {
            robots: robots.with_idle_timeout(config.session_idle),
            sessions: Sessions::new(
                config.max_sessions,
                config.session_idle,
                Arc::clone(&metrics),
                Arc::clone(platform),
            ),
            stepper_cache: StepperCache::default(),
            batches: Workers::new(BATCHES, config.work_timeout * BATCH_TIMEOUT_FACTOR, platform),
            large_problems: Workers::new(large_problems, config.work_timeout, platform),
            large_steps: Workers::new(large_steps, config.work_timeout, platform),
            margins: Workers::new(MARGINS, config.work_timeout, platform),
            new: Workers::new(NEW, config.work_timeout, platform),
            simulations: Simulations::default(),
            connections: Connections::new(config.max_connections),
            metrics,
            admission_queue: AdmissionQueue::default(),
            large_bodies: Semaphore::new(config.max_large_bodies.min(Semaphore::MAX_PERMITS)),
            request_ids: RequestIds::new(&**platform),
            failures: Failures::default(),
            drain: Drain::new(),
            config,
        }
    }
}
