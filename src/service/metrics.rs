//! What the service counts, for Prometheus.

use std::collections::HashMap;
use std::fmt;
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use axum::http::StatusCode;
use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::registry::Registry;

use crate::wire;

/// Upper ends of the classes of answer times, s: steps take tens of microseconds, hard problems milliseconds.
const DURATIONS_S: [f64; 14] = [1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 0.01, 0.05, 0.1, 1.0, 10.0];

/// Instead of the template of a route: there is no such route.
const NO_ROUTE: &str = "none";

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

/// All counters of one service; labels take few values, whatever clients send.
pub struct Metrics {
    registry: Registry,
    requests: Family<RequestLabels, Counter>,
    durations: Family<RouteLabel, Histogram, fn() -> Histogram>,
    routes: Mutex<HashMap<String, Arc<Route>>>,
    problems: Family<TypeLabel, Counter>,
    connection_faults: Family<TypeLabel, Counter>,
    /// By path and status.
    resolutions: [[Counter; 3]; 3],
    clarabel_iterations: Counter,
    /// Handlers that panicked.
    pub panics: Counter,
    /// Steps of sessions that came more than half a period late.
    pub missed_periods: Counter,
    sessions: Gauge,
    /// Open connections.
    pub connections: Gauge<u64, AtomicU64>,
}

/// The counters of one route, looked up once.
pub struct Route {
    template: String,
    duration: Histogram,
    by_status: Mutex<Vec<(StatusCode, Counter)>>,
}

impl fmt::Debug for Metrics {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("Metrics(…)")
    }
}

impl Metrics {
    /// All at zero.
    pub fn new() -> Self {
        let mut registry = Registry::with_prefix("revprio");
        let solved = Family::<SolverLabels, Counter>::default();
        let metrics = Self {
            requests: Family::default(),
            durations: Family::new_with_constructor(|| Histogram::new(DURATIONS_S)),
            routes: Mutex::default(),
            problems: Family::default(),
            connection_faults: Family::default(),
            resolutions: ["closed_form", "active_set", "qp"].map(|path| {
                ["optimal", "not_certified", "failed"]
                    .map(|status| solved.get_or_create_owned(&SolverLabels { path, status }))
            }),
            clarabel_iterations: Counter::default(),
            panics: Counter::default(),
            missed_periods: Counter::default(),
            sessions: Gauge::default(),
            connections: Gauge::default(),
            registry: Registry::default(),
        };
        registry.register("requests", "Answers by route and status", metrics.requests.clone());
        registry.register(
            "request_duration_seconds",
            "Time from a request's headers to its answer",
            metrics.durations.clone(),
        );
        registry.register("problems", "Answers that are problems, by type", metrics.problems.clone());
        registry.register(
            "connection_faults",
            "Connections that ended otherwise than by an orderly close, by cause",
            metrics.connection_faults.clone(),
        );
        registry.register("resolutions", "Resolved problems by solver path and status", solved);
        registry.register("clarabel_iterations", "Iterations of Clarabel", metrics.clarabel_iterations.clone());
        registry.register("panics", "Handlers that panicked", metrics.panics.clone());
        registry.register(
            "missed_periods",
            "Steps of sessions more than 1.5 periods after the one before",
            metrics.missed_periods.clone(),
        );
        registry.register("sessions", "Sessions that have not ended", metrics.sessions.clone());
        registry.register("connections", "Open connections", metrics.connections.clone());
        Self { registry, ..metrics }
    }

    /// The counters of a route, by its template.
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
    pub fn answered(&self, route: &Route, status: StatusCode, duration: Duration) {
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

    /// Counts an answer that is a problem.
    pub fn refused(&self, kind: &'static str) {
        self.problems.get_or_create(&TypeLabel { r#type: kind }).inc();
    }

    /// Counts a connection that did not end well.
    pub fn connection_fault(&self, cause: &'static str) {
        self.connection_faults.get_or_create(&TypeLabel { r#type: cause }).inc();
    }

    /// Counts a resolved problem.
    pub fn solved(&self, report: &wire::SolverReport) {
        self.resolutions[report.path as usize][report.status as usize].inc();
        self.clarabel_iterations.inc_by(u64::from(report.iterations));
    }

    /// All of it as text, in the OpenMetrics format.
    pub fn text(&self, sessions: usize) -> String {
        self.sessions.set(i64::try_from(sessions).unwrap_or(i64::MAX));
        let mut text = String::new();
        // Writing into a string cannot fail.
        let _ = prometheus_client::encoding::text::encode(&mut text, &self.registry);
        text
    }
}
