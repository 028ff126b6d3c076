//! The state that all requests share.

use std::sync::Arc;

use tokio::sync::Semaphore;

use super::admission_queue::AdmissionQueue;
use super::background::Quota;
use super::config::ServiceConfig;
use super::connection::Connections;
use super::drain::Drain;
use super::metrics::Metrics;
use super::request_id::RequestIds;
use super::robots::Robots;
use super::sessions::Sessions;
use super::simulations::Simulations;
use super::stepper_cache::StepperCache;

/// Maximum number of batches at a time, running and waiting. Each may hold a body and an answer of about 20 MB.
const MAX_BATCHES: usize = 4;

/// Maximum number of large problems at a time, running and waiting.
const MAX_LARGE_PROBLEMS: usize = 16;

/// Maximum number of stability margins at a time, running and waiting. A margin at the maximum delay takes some seconds.
const MAX_MARGINS: usize = 8;

/// The state that all requests share.
pub struct AppState {
    /// The arms that requests can name.
    pub robots: Robots,
    /// The settings of the service.
    pub config: ServiceConfig,
    pub(super) sessions: Sessions,
    pub(super) stepper_cache: StepperCache,
    pub(super) batches: Quota,
    pub(super) large_problems: Quota,
    pub(super) margins: Quota,
    pub(super) simulations: Simulations,
    pub(super) connections: Arc<Connections>,
    pub(super) metrics: Arc<Metrics>,
    pub(super) admission_queue: AdmissionQueue,
    /// Permits for reading large bodies.
    pub(super) large_bodies: Semaphore,
    pub(super) request_ids: RequestIds,
    pub(super) drain: Drain,
}

impl AppState {
    /// Creates the state of a service with the default settings.
    pub fn new(robots: Robots) -> Self {
        Self::with_config(robots, ServiceConfig::default())
    }

    /// Creates the state of a service.
    pub fn with_config(robots: Robots, config: ServiceConfig) -> Self {
        let metrics = Arc::new(Metrics::new());
        Self {
            robots: robots.with_idle_timeout(config.session_idle),
            sessions: Sessions::new(config.max_sessions, config.session_idle, Arc::clone(&metrics)),
            stepper_cache: StepperCache::default(),
            batches: Quota::new("batches", MAX_BATCHES),
            large_problems: Quota::new("large problems", MAX_LARGE_PROBLEMS),
            margins: Quota::new("stability margins", MAX_MARGINS),
            simulations: Simulations::default(),
            connections: Connections::new(config.max_connections),
            metrics,
            admission_queue: AdmissionQueue::default(),
            large_bodies: Semaphore::new(config.max_large_bodies.min(Semaphore::MAX_PERMITS)),
            request_ids: RequestIds::default(),
            drain: Drain::new(),
            config,
        }
    }
}
