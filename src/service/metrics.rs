//! The counters of the service, for Prometheus.

use std::collections::HashMap;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use axum::http::StatusCode;
use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::registry::{Metric, Registry};
use revprio_api::wire;

use super::log::dropped_lines;

/// Upper bounds of the histogram of answer times, s. Steps take tens of microseconds, hard problems milliseconds.
const DURATIONS_S: [f64; 14] = [1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 0.01, 0.05, 0.1, 1.0, 10.0];

/// Replaces the template of the route for requests to unknown routes.
const NO_ROUTE: &str = "none";

const PATHS: [&str; 3] = ["closed_form", "active_set", "qp"];
const STATUSES: [&str; 3] = ["optimal", "not_certified", "failed"];

type Durations = Family<RouteLabel, Histogram, fn() -> Histogram>;

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct RequestLabels {
    route: String,
    status: u16,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct RouteLabel {
    route: String,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct TypeLabel {
    r#type: &'static str,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct SolverLabels {
    path: &'static str,
    status: &'static str,
}

/// All counters of one service. Labels have few values, whatever clients send.
pub struct Metrics {
    registry: Registry,
    requests: Family<RequestLabels, Counter>,
    durations: Durations,
    routes: Mutex<HashMap<String, Arc<Route>>>,
    problems: Family<TypeLabel, Counter>,
    connection_faults: Family<TypeLabel, Counter>,
    /// By path and status, as in [`PATHS`] and [`STATUSES`].
    resolutions: [[Counter; STATUSES.len()]; PATHS.len()],
    clarabel_iterations: Counter,
    clarabel_failures: Counter,
    last_resorts: Counter,
    /// Handlers that panicked.
    pub panics: Counter,
    /// Steps of sessions more than 1.5 periods after the previous step.
    pub missed_periods: Counter,
    log_lines_dropped: Counter,
    sessions: Gauge,
    connections: Gauge,
}

/// The counters of one route.
pub struct Route {
    template: String,
    duration: Histogram,
    by_status: Mutex<Vec<(StatusCode, Counter)>>,
}

impl Metrics {
    /// Creates all counters at zero.
    pub fn new() -> Self {
        let mut registry = Registry::with_prefix("revprio");
        let all = &mut registry;
        let requests = register(all, "requests", "Answers by route and status", Family::default());
        let durations: Durations = Family::new_with_constructor(|| Histogram::new(DURATIONS_S));
        let help = "Time from the headers of a request to its answer";
        let durations = register(all, "request_duration_seconds", help, durations);
        let problems =
            register(all, "problems", "Problems in answers, batches and streams, by type", Family::default());
        let help = "Connections that did not end with an orderly close, by cause";
        let connection_faults = register(all, "connection_faults", help, Family::default());
        let help = "Resolved problems by solver path and status";
        let resolutions: Family<SolverLabels, Counter> = register(all, "resolutions", help, Family::default());
        let clarabel_iterations = register(all, "clarabel_iterations", "Iterations of Clarabel", Counter::default());
        let help = "Levels that Clarabel failed to solve, with the solver qp";
        let clarabel_failures = register(all, "clarabel_failures", help, Counter::default());
        let help =
            "Problems for which the solver auto needed its last resort, one change of the active limits at a time";
        let last_resorts = register(all, "last_resorts", help, Counter::default());
        let panics = register(all, "panics", "Handlers that panicked", Counter::default());
        let help = "Steps of sessions more than 1.5 periods after the previous step";
        let missed_periods = register(all, "missed_periods", help, Counter::default());
        let help = "Lines of the log that could not be written";
        let log_lines_dropped = register(all, "log_lines_dropped", help, Counter::default());
        let sessions = register(all, "sessions", "Sessions that have not ended", Gauge::default());
        let connections = register(all, "connections", "Open connections", Gauge::default());
        let resolutions =
            PATHS.map(|path| STATUSES.map(|status| resolutions.get_or_create_owned(&SolverLabels { path, status })));
        Self {
            registry,
            requests,
            durations,
            routes: Mutex::default(),
            problems,
            connection_faults,
            resolutions,
            clarabel_iterations,
            clarabel_failures,
            last_resorts,
            panics,
            missed_periods,
            log_lines_dropped,
            sessions,
            connections,
        }
    }

    /// Returns the counters of a route, by its template.
    pub fn route(&self, template: Option<&str>) -> Arc<Route> {
        let template = template.unwrap_or(NO_ROUTE);
        let mut routes = self.routes.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(route) = routes.get(template) {
            return Arc::clone(route);
        }
        let duration = self.durations.get_or_create_owned(&RouteLabel { route: template.to_owned() });
        let route = Arc::new(Route { template: template.to_owned(), duration, by_status: Mutex::default() });
        routes.insert(template.to_owned(), Arc::clone(&route));
        route
    }

    /// Counts an answer.
    pub fn count_answer(&self, route: &Route, status: StatusCode, duration: Duration) {
        route.duration.observe(duration.as_secs_f64());
        let mut by_status = route.by_status.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, counter)) = by_status.iter().find(|(known, _)| *known == status) {
            counter.inc();
            return;
        }
        let labels = RequestLabels { route: route.template.clone(), status: status.as_u16() };
        let counter = self.requests.get_or_create_owned(&labels);
        counter.inc();
        by_status.push((status, counter));
    }

    /// Returns the number of answers of all routes.
    pub fn answers(&self) -> u64 {
        let routes = self.routes.lock().unwrap_or_else(PoisonError::into_inner);
        let of_route = |route: &Arc<Route>| -> u64 {
            let by_status = route.by_status.lock().unwrap_or_else(PoisonError::into_inner);
            by_status.iter().map(|(_, counter)| counter.get()).sum()
        };
        routes.values().map(of_route).sum()
    }

    /// Counts an answer, an item of a batch or a message of a stream that is a problem.
    pub fn count_problem(&self, kind: &'static str) {
        self.problems.get_or_create(&TypeLabel { r#type: kind }).inc();
    }

    /// Counts a connection that did not end with an orderly close.
    pub fn count_connection_fault(&self, cause: &'static str) {
        self.connection_faults.get_or_create(&TypeLabel { r#type: cause }).inc();
    }

    /// Counts a resolved problem of any route.
    pub fn count_resolution(&self, report: &wire::SolverReport) {
        let path = match report.path {
            wire::Path::ClosedForm => 0,
            wire::Path::ActiveSet => 1,
            wire::Path::Qp => 2,
        };
        let status = match report.status {
            wire::Status::Optimal => 0,
            wire::Status::NotCertified => 1,
            wire::Status::Failed => 2,
        };
        self.resolutions[path][status].inc();
        self.clarabel_iterations.inc_by(u64::from(report.iterations));
        self.clarabel_failures.inc_by(u64::from(report.failures));
        self.last_resorts.inc_by(u64::from(report.last_resorts));
    }

    /// Returns all metrics in the OpenMetrics text format. `sessions`, `connections`: those that are open now.
    pub fn text(&self, sessions: usize, connections: usize) -> String {
        for (gauge, count) in [(&self.sessions, sessions), (&self.connections, connections)] {
            gauge.set(i64::try_from(count).unwrap_or(i64::MAX));
        }
        self.log_lines_dropped.inner().store(dropped_lines(), Ordering::Relaxed);
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = prometheus_client::encoding::text::encode(&mut text, &self.registry);
        text
    }
}

/// Registers a metric.
fn register<M: Metric + Clone>(registry: &mut Registry, name: &str, help: &str, metric: M) -> M {
    registry.register(name, help, metric.clone());
    metric
}
