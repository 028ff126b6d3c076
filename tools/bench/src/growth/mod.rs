//! Growth of times with joints, tasks, sessions, items of a batch, and concurrent simulations.

mod arms;
mod cycles;
mod requests;
pub mod simulations;

use super::error::BenchError;
use super::plan::Plan;
use super::series::Growth;

/// Measures all growth curves.
pub fn curves(plan: &Plan) -> Result<Vec<Growth>, BenchError> {
    Ok(vec![
        cycles::joints(plan)?,
        cycles::tasks(plan)?,
        requests::sessions(plan)?,
        requests::batch(plan)?,
        simulations::side_by_side(plan)?,
    ])
}
