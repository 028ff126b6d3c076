//! Routes.

use std::sync::Arc;

use axum::Router;
use axum::response::IntoResponse;
use axum::routing::get;
use tower_http::catch_panic::CatchPanicLayer;
use utoipa::OpenApi as _;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::body;
use super::handlers;
use super::openapi::{self, ApiDoc};
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
    let (routes, _) = described().split_for_parts();
    routes
        .route("/docs", get(openapi::docs_home))
        .route("/docs/", get(openapi::docs_page))
        .route("/docs/{file}", get(openapi::docs_file))
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

/// All routes with their descriptions.
pub(super) fn described() -> OpenApiRouter<Arc<App>> {
    OpenApiRouter::with_openapi(ApiDoc::openapi())
        .routes(routes!(handlers::resolve))
        .routes(routes!(handlers::resolve_batch))
        .routes(routes!(handlers::step))
        .routes(routes!(handlers::create_controller))
        .routes(routes!(handlers::show_controller, handlers::delete_controller))
        .routes(routes!(handlers::step_controller))
        .routes(routes!(handlers::stream_controller))
        .routes(routes!(handlers::watch_controller))
        .routes(routes!(handlers::kinematics))
        .routes(routes!(handlers::stability))
        .routes(routes!(handlers::robots, handlers::register_robot))
        .routes(routes!(handlers::robot, handlers::delete_robot))
        .routes(routes!(handlers::scenarios))
        .routes(routes!(handlers::scenario))
        .routes(routes!(handlers::create_simulation))
        .routes(routes!(handlers::show_simulation, handlers::delete_simulation))
        .routes(routes!(handlers::simulation_events))
        .routes(routes!(handlers::simulation_trace))
        .routes(routes!(handlers::alive))
        .routes(routes!(openapi::document))
        .routes(routes!(openapi::async_document))
}
