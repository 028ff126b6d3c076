//! Routes.

use std::sync::Arc;

use axum::Router;
use axum::response::IntoResponse;
use axum::routing::{get, post};
use tower_http::catch_panic::CatchPanicLayer;

use super::handlers;
use super::problem::Problem;
use super::robots::Robots;
use super::sessions::Sessions;

/// What all requests share.
pub struct App {
    /// The arms that requests can name.
    pub robots: Robots,
    pub(super) sessions: Sessions,
}

impl App {
    /// A service for these robots, without sessions yet.
    pub fn new(robots: Robots) -> Self {
        Self { robots, sessions: Sessions::default() }
    }
}

/// All routes of the service.
pub fn router(app: App) -> Router {
    Router::new()
        .route("/v1/resolve", post(handlers::resolve))
        .route("/v1/step", post(handlers::step))
        .route("/v1/controllers", post(handlers::create_controller))
        .route("/v1/controllers/{id}", get(handlers::show_controller).delete(handlers::delete_controller))
        .route("/v1/controllers/{id}/step", post(handlers::step_controller))
        .route("/v1/stability", post(handlers::stability))
        .route("/v1/robots", get(handlers::robots).post(handlers::register_robot))
        .route("/v1/robots/{name}", get(handlers::robot).delete(handlers::delete_robot))
        .route("/healthz", get(|| async { "ok" }))
        .fallback(|uri: axum::http::Uri| async move {
            Problem::not_found(format!("there is no route {}; see the interface description", uri.path()))
        })
        .method_not_allowed_fallback(|| async { Problem::method_not_allowed() })
        .layer(CatchPanicLayer::custom(|_| {
            tracing::error!("a handler panicked");
            Problem::internal().into_response()
        }))
        .with_state(Arc::new(app))
}
