//! The routes that the interface description covers.

use std::sync::Arc;

use axum::Extension;
use utoipa::openapi::OpenApi;
use utoipa_axum::router::{OpenApiRouter, UtoipaMethodRouterExt};
use utoipa_axum::routes;

use super::handlers::docs::Documents;
use super::handlers::{analysis, control, docs, operation, resolve, robots, simulation};
use super::state::AppState;

/// Returns all described routes, and adds their descriptions to `document`. `documents`: the interface descriptions that two
/// of the routes send.
pub fn routes(document: OpenApi, documents: Documents) -> OpenApiRouter<Arc<AppState>> {
    OpenApiRouter::with_openapi(document)
        .routes(routes!(resolve::resolve))
        .routes(routes!(resolve::resolve_batch))
        .routes(routes!(control::step))
        .routes(routes!(control::controllers, control::create_controller))
        .routes(routes!(control::show_controller, control::replace_controller, control::delete_controller))
        .routes(routes!(control::step_controller))
        .routes(routes!(control::tare_controller))
        .routes(routes!(control::stream_controller))
        .routes(routes!(control::watch_controller))
        .routes(routes!(analysis::kinematics))
        .routes(routes!(analysis::stability))
        .routes(routes!(analysis::payload))
        .routes(routes!(robots::robots, robots::register_robot))
        .routes(routes!(robots::robot, robots::delete_robot))
        .routes(routes!(simulation::scenarios))
        .routes(routes!(simulation::scenario))
        .routes(routes!(simulation::create_simulation))
        .routes(routes!(simulation::show_simulation, simulation::delete_simulation))
        .routes(routes!(simulation::simulation_events))
        .routes(routes!(simulation::simulation_live))
        .routes(routes!(simulation::control_simulation))
        .routes(routes!(simulation::simulation_cycle))
        .routes(routes!(simulation::simulation_trace))
        .routes(routes!(operation::alive))
        .routes(routes!(operation::ready))
        .routes(routes!(operation::metrics))
        .routes(routes!(docs::document).layer(Extension(documents)))
        .routes(routes!(docs::async_document).layer(Extension(documents)))
}
