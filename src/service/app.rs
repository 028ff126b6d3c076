//! The whole application: all routes, the gate before them, and the state that they share.

use std::sync::Arc;
use std::time::Duration;

use axum::http::{HeaderName, HeaderValue, Method, header};
use axum::middleware::from_fn_with_state;
use axum::routing::get;
use axum::{Extension, Router};
use tower_http::cors::CorsLayer;
use utoipa::openapi::OpenApi;

use super::error::ApiError;
use super::gate::{admission, gate};
use super::handlers::docs::{self, Documents};
use super::handlers::page;
use super::openapi::{asyncapi_document, openapi_document};
use super::request_id::REQUEST_ID;
use super::routes::routes;
use super::state::AppState;

/// All routes with their state, ready to be served.
#[derive(Clone)]
pub struct Service {
    pub(super) router: Router,
    pub(super) app: Arc<AppState>,
}

/// Returns all routes of the service.
pub fn router(app: AppState) -> Service {
    let documents = Documents { openapi: openapi_document, asyncapi: asyncapi_document };
    let (routes, _) = routes(OpenApi::default()).split_for_parts();
    let routes = routes
        .route("/", get(page::home))
        .route("/dashboard/{file}", get(page::file))
        .route("/docs", get(docs::home))
        .route("/docs/", get(docs::page))
        .route("/docs/{file}", get(docs::file))
        .layer(Extension(documents));
    behind_gate(routes, app)
}

/// Puts the gate before the routes, and answers unknown routes and methods with problems.
fn behind_gate(routes: Router<Arc<AppState>>, app: AppState) -> Service {
    let app = Arc::new(app);
    let mut router = routes
        .fallback(|uri: axum::http::Uri| async move {
            ApiError::not_found(format!("there is no route {}; see /openapi.json", uri.path()))
        })
        .method_not_allowed_fallback(|| async { ApiError::method_not_allowed() })
        .layer(from_fn_with_state(Arc::clone(&app), admission));
    // Preflight requests have no token.
    if !app.config.allowed_origins.is_empty() {
        router = router.layer(cors(&app.config.allowed_origins));
    }
    let router = router.layer(from_fn_with_state(Arc::clone(&app), gate));
    Service { router: router.with_state(Arc::clone(&app)), app }
}

/// Lets pages of these origins read answers.
fn cors(origins: &[String]) -> CorsLayer {
    let origins: Vec<HeaderValue> = origins.iter().filter_map(|origin| origin.parse().ok()).collect();
    let request_headers: [HeaderName; 4] = [header::CONTENT_TYPE, header::AUTHORIZATION, header::ACCEPT, REQUEST_ID];
    CorsLayer::new()
        .allow_origin(origins)
        .allow_methods([Method::GET, Method::POST, Method::DELETE])
        .allow_headers(request_headers)
        .expose_headers([header::LOCATION, header::RETRY_AFTER, REQUEST_ID])
        .max_age(Duration::from_hours(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::service::handlers::operation;
    use crate::service::{Robots, RunningServer};

    /// Returns status and body of an answer.
    fn get_text(url: &str) -> (u16, String) {
        let agent: ureq::Agent = ureq::Agent::config_builder().http_status_as_error(false).build().into();
        let mut response = agent.get(url).header("x-request-id", "mine-1").call().unwrap();
        (response.status().as_u16(), response.body_mut().read_to_string().unwrap())
    }

    #[test]
    fn a_panic_is_answered_as_a_problem_with_the_request_id_and_counted() {
        async fn panics() -> &'static str {
            panic!("meant for a test")
        }
        let routes = Router::new().route("/panic", get(panics)).route("/metrics", get(operation::metrics));
        let server = RunningServer::start(behind_gate(routes, AppState::new(Robots::built_in()))).unwrap();
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
