//! Routes.

use std::sync::Arc;

use axum::Router;
use axum::response::IntoResponse;
use axum::routing::{get, post};
use tower_http::catch_panic::CatchPanicLayer;

use super::body;
use super::handlers;
use super::problem::Problem;
use super::resolve::Batches;
use super::robots::Robots;
use super::sessions::Sessions;
use super::simulations::Simulations;

/// What all requests share.
pub struct App {
    /// The arms that requests can name.
    pub robots: Arc<Robots>,
    pub(super) sessions: Sessions,
    pub(super) batches: Batches,
    pub(super) simulations: Simulations,
}

impl App {
    /// A service for these robots, without sessions yet.
    pub fn new(robots: Robots) -> Self {
        let (batches, simulations) = (Batches::default(), Simulations::default());
        Self { robots: Arc::new(robots), sessions: Sessions::default(), batches, simulations }
    }
}

/// All routes of the service.
pub fn router(app: App) -> Router {
    Router::new()
        .route("/v1/resolve", post(handlers::resolve))
        .route("/v1/resolve/batch", post(handlers::resolve_batch))
        .route("/v1/step", post(handlers::step))
        .route("/v1/controllers", post(handlers::create_controller))
        .route("/v1/controllers/{id}", get(handlers::show_controller).delete(handlers::delete_controller))
        .route("/v1/controllers/{id}/step", post(handlers::step_controller))
        .route("/v1/controllers/{id}/stream", get(handlers::stream_controller))
        .route("/v1/controllers/{id}/watch", get(handlers::watch_controller))
        .route("/v1/kinematics", post(handlers::kinematics))
        .route("/v1/stability", post(handlers::stability))
        .route("/v1/robots", get(handlers::robots).post(handlers::register_robot))
        .route("/v1/robots/{name}", get(handlers::robot).delete(handlers::delete_robot))
        .route("/v1/scenarios", get(handlers::scenarios))
        .route("/v1/scenarios/{name}", get(handlers::scenario))
        .route("/v1/simulations", post(handlers::create_simulation))
        .route("/v1/simulations/{id}", get(handlers::show_simulation).delete(handlers::delete_simulation))
        .route("/v1/simulations/{id}/events", get(handlers::simulation_events))
        .route("/v1/simulations/{id}/trace", get(handlers::simulation_trace))
        .route("/healthz", get(|| async { "ok" }))
        .fallback(|uri: axum::http::Uri| async move {
            Problem::not_found(format!("there is no route {}; see the interface description", uri.path()))
        })
        .method_not_allowed_fallback(|| async { Problem::method_not_allowed() })
        .layer(axum::middleware::from_fn(body::written))
        .layer(CatchPanicLayer::custom(|_| {
            tracing::error!("a handler panicked");
            Problem::internal().into_response()
        }))
        .with_state(Arc::new(app))
}
