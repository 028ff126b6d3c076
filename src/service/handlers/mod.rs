//! One function per route: extract, call, convert.

pub mod analysis;
pub mod control;
pub mod operation;
pub mod page;
pub mod resolve;
pub mod robots;
pub mod simulation;

use std::sync::Arc;

use axum::extract::State;

use super::app::AppState;

/// What every handler can reach.
type Shared = State<Arc<AppState>>;
