//! Routes.

use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::http::{HeaderName, HeaderValue, Method, header};
use axum::middleware::from_fn_with_state;
use axum::routing::get;
use tokio::sync::Semaphore;
use tower_http::cors::CorsLayer;
use utoipa::OpenApi as _;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::admission_queue::AdmissionQueue;
use super::background::Quota;
use super::config::ServiceConfig;
use super::connection::Connections;
use super::drain::Drain;
use super::error::ApiError;
use super::gate::{RequestIds, gate};
use super::handlers;
use super::metrics::Metrics;
use super::openapi::{self, ApiDoc};
use super::recent::Recent;
use super::resolve::MAX_BATCHES;
use super::robots::Robots;
use super::sessions::Sessions;
use super::simulations::Simulations;

/// Stability margins at a time; one with the longest delay takes some seconds.
const MAX_MARGINS: usize = 8;

/// What all requests share.
pub struct AppState {
    /// The arms that requests can name.
    pub robots: Robots,
    /// What an operator can tune.
    pub config: ServiceConfig,
    pub(super) sessions: Sessions,
    pub(super) recent: Recent,
    pub(super) batches: Quota,
    pub(super) margins: Quota,
    pub(super) simulations: Simulations,
    pub(super) connections: Arc<Connections>,
    pub(super) metrics: Arc<Metrics>,
    pub(super) admission_queue: AdmissionQueue,
    /// Quota for large bodies while they are read.
    pub(super) large_bodies: Semaphore,
    pub(super) request_ids: RequestIds,
    pub(super) drain: Drain,
}

impl AppState {
    /// A service for these robots, without sessions yet, as it is by default.
    pub fn new(robots: Robots) -> Self {
        Self::with_config(robots, ServiceConfig::default())
    }

    /// A service for these robots, without sessions yet.
    pub fn with_config(robots: Robots, config: ServiceConfig) -> Self {
        let metrics = Arc::new(Metrics::new());
        Self {
            robots: robots.ending_after(config.session_idle),
            sessions: Sessions::new(config.max_sessions, config.session_idle, Arc::clone(&metrics)),
            recent: Recent::default(),
            batches: Quota::new(MAX_BATCHES),
            margins: Quota::new(MAX_MARGINS),
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

/// All routes with what they share, ready to be served.
#[derive(Clone)]
pub struct Service {
    pub(super) router: Router,
    pub(super) app: Arc<AppState>,
}

/// All routes of the service.
pub fn router(app: AppState) -> Service {
    let (routes, _) = described().split_for_parts();
    let routes = routes
        .route("/", get(handlers::page::home))
        .route("/dashboard/{file}", get(handlers::page::file))
        .route("/docs", get(openapi::docs_home))
        .route("/docs/", get(openapi::docs_page))
        .route("/docs/{file}", get(openapi::docs_file));
    guarded(routes, app)
}

/// All routes with their descriptions.
pub(super) fn described() -> OpenApiRouter<Arc<AppState>> {
    OpenApiRouter::with_openapi(ApiDoc::openapi())
        .routes(routes!(handlers::resolve::resolve))
        .routes(routes!(handlers::resolve::resolve_batch))
        .routes(routes!(handlers::control::step))
        .routes(routes!(handlers::control::controllers, handlers::control::create_controller))
        .routes(routes!(handlers::control::show_controller, handlers::control::delete_controller))
        .routes(routes!(handlers::control::step_controller))
        .routes(routes!(handlers::control::stream_controller))
        .routes(routes!(handlers::control::watch_controller))
        .routes(routes!(handlers::analysis::kinematics))
        .routes(routes!(handlers::analysis::stability))
        .routes(routes!(handlers::robots::robots, handlers::robots::register_robot))
        .routes(routes!(handlers::robots::robot, handlers::robots::delete_robot))
        .routes(routes!(handlers::simulation::scenarios))
        .routes(routes!(handlers::simulation::scenario))
        .routes(routes!(handlers::simulation::create_simulation))
        .routes(routes!(handlers::simulation::show_simulation, handlers::simulation::delete_simulation))
        .routes(routes!(handlers::simulation::simulation_events))
        .routes(routes!(handlers::simulation::simulation_live))
        .routes(routes!(handlers::simulation::control_simulation))
        .routes(routes!(handlers::simulation::simulation_cycle))
        .routes(routes!(handlers::simulation::simulation_trace))
        .routes(routes!(handlers::operation::alive))
        .routes(routes!(handlers::operation::ready))
        .routes(routes!(handlers::operation::metrics))
        .routes(routes!(openapi::document))
        .routes(routes!(openapi::async_document))
}

/// The routes behind the gate, with problems for what they do not know.
fn guarded(routes: Router<Arc<AppState>>, app: AppState) -> Service {
    let app = Arc::new(app);
    let mut router = routes
        .fallback(|uri: axum::http::Uri| async move {
            ApiError::not_found(format!("there is no route {}; see the interface description", uri.path()))
        })
        .method_not_allowed_fallback(|| async { ApiError::method_not_allowed() })
        .layer(from_fn_with_state(Arc::clone(&app), gate));
    if !app.config.allowed_origins.is_empty() {
        router = router.layer(cors(&app.config.allowed_origins));
    }
    Service { router: router.with_state(Arc::clone(&app)), app }
}

/// Lets pages of these origins read answers.
fn cors(origins: &[String]) -> CorsLayer {
    let request_id = HeaderName::from_static("x-request-id");
    let origins: Vec<HeaderValue> = origins.iter().filter_map(|origin| origin.parse().ok()).collect();
    CorsLayer::new()
        .allow_origin(origins)
        .allow_methods([Method::GET, Method::POST, Method::DELETE])
        .allow_headers([header::CONTENT_TYPE, header::AUTHORIZATION, header::ACCEPT, request_id.clone()])
        .expose_headers([header::LOCATION, header::RETRY_AFTER, request_id])
        .max_age(Duration::from_hours(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::service::RunningServer;

    /// An answer's status and body.
    fn get_text(url: &str) -> (u16, String) {
        let agent: ureq::Agent = ureq::Agent::config_builder().http_status_as_error(false).build().into();
        let mut response = agent.get(url).header("x-request-id", "mine-1").call().unwrap();
        (response.status().as_u16(), response.body_mut().read_to_string().unwrap())
    }

    #[test]
    fn a_panic_is_a_problem_that_is_named_and_counted() {
        async fn panics() -> &'static str {
            panic!("meant for a test")
        }
        let routes = Router::new().route("/panic", get(panics)).route("/metrics", get(handlers::operation::metrics));
        let server = RunningServer::start(guarded(routes, AppState::new(Robots::built_in()))).unwrap();
        let (status, body) = get_text(&(server.url() + "/panic"));
        let problem: serde_json::Value = serde_json::from_str(&body).unwrap();
        assert_eq!((status, &problem["type"]), (500, &"/problems/internal".into()));
        assert_eq!(problem["request_id"], "mine-1");
        assert!(!body.contains("meant for a test"), "{body}");
        let (_, metrics) = get_text(&(server.url() + "/metrics"));
        for line in ["revprio_panics_total 1", r#"revprio_requests_total{route="/panic",status="500"} 1"#] {
            assert!(metrics.contains(line), "{line} is not in {metrics}");
        }
    }
}
