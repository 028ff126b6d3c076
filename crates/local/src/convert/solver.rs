//! The solver of a request.

use revprio_api::wire;
use revprio_core::resolution::Solver;
use revprio_reference::HAS_CLARABEL;

use super::checks::{Result, check};
use super::terms;

/// Returns the solver, unless this build lacks it.
pub fn solver(name: wire::Solver) -> Result<Solver> {
    let is_here = HAS_CLARABEL || name != wire::Solver::Qp;
    check(
        is_here,
        "/solver",
        "`qp` needs Clarabel, which this build does not have; use `auto`, or start `revprio serve`",
    )?;
    Ok(terms::solver(name))
}
