//! From prioritised tasks to joint velocities.
//!
//! Each [`Method`] is a list of least-squares problems with priority levels and joint limits. [`Resolver`] solves them with
//! the hierarchical solver: an active-set method for all levels at once, with a certificate. It is the solver `auto`.
//!
//! The crate `revprio-reference` computes the same answers in two other ways: `ClosedForm`, the printed formulas without
//! limits, and `Qp`, Clarabel level by level. It shares the types of `revprio-problem` with this crate, and tests compare the answers. Do not
//! use `ClosedForm` on a real arm. It ignores joint limits.
//!
//! ```
//! use revprio_core::limits::VelocityBox;
//! use revprio_core::linalg::{Matrix, Vector};
//! use revprio_core::resolution::{Problem, resolve};
//! use revprio_core::task::{Task, TaskStack};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // Two joints with a speed limit of 1 rad/s. Their sum shall be 1.5 rad/s; below that, the first one shall rest.
//! let sum = Task::new("sum", Matrix::from_row_slice(1, 2, &[1.0, 1.0]), Vector::from_vec(vec![1.5]));
//! let rest = Task::new("rest", Matrix::from_row_slice(1, 2, &[1.0, 0.0]), Vector::zeros(1));
//! let tasks = TaskStack::new(vec![sum, rest])?; // highest priority first
//! let limits = VelocityBox::new(&[-1.0, -1.0], &[1.0, 1.0])?;
//! let answer = resolve(&Problem { limits, ..Problem::new(tasks) }, &[])?;
//! // The second joint moves at its limit, the first one adds the rest: the lower task gives way.
//! assert!((answer.joint_velocity[0] - 0.5).abs() < 1e-9 && (answer.joint_velocity[1] - 1.0).abs() < 1e-9);
//! assert!((answer.tasks[1].residual_norm - 0.5).abs() < 1e-9);
//! assert_eq!(answer.active_limits().map(|(joint, _)| joint).collect::<Vec<_>>(), [1]);
//! # Ok(())
//! # }
//! ```
//!
//! In the repository, `docs/solver.md` explains the hierarchical solver, its certificate and the continuity of damped
//! answers. `docs/methods.md` compares the methods, with numbers and a picture; [`Method`] has their formulas.

mod answer;
mod certified;
mod contradiction;
mod damped_targets;
mod engine;
mod hierarchy;
mod named_bounds;
mod plan;
mod plan_run;
mod regularity;
mod relaxed_levels;
mod resolver;
mod scaling;
mod singularity;
mod smoothing;
mod solution;
mod solver;
mod strict_targets;

pub use resolver::{Resolver, resolve};
pub use revprio_problem::{
    ActiveBound, ActiveSet, Bound, BoundId, BrokenBound, Certificate, CertifiedLevel, CertifiedProblem, Contradiction,
    LevelReport, MAX_UNKNOWNS, Method, Multipliers, Part, Path, Problem, ProblemError, Resolution, Side, Singularity,
    Solve, Solver, SolverReport, Status, TaskOutcome,
};
pub use solver::{Rung, RungCount, Rungs};
