//! The hierarchical solver: lexicographic least squares within a box by an active-set method.
//!
//! It tries working sets until the optimality conditions hold. `docs/solver.md` explains the method; the sections named here
//! are those of that page. The answer is exact: no regularisation and no weights enter it.

mod active_set;
mod cascade;
mod conditions;
mod dependent_rows;
mod factor_row;
mod factorization;
mod problem_rows;

mod rungs;
mod search;
mod sized;

pub use rungs::{Rung, RungCount, Rungs};
pub use sized::{HierarchicalSolver, SizedSolver};

#[cfg(test)]
mod tests;
