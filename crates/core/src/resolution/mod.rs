//! From prioritised tasks to joint velocities.
//!
//! There are two solvers. The *closed form* is the literature's pseudo-inverse formula; it knows no limits. The
//! *QP cascade* poses the same problem as a sequence of small least-squares problems with joint limits as
//! inequalities. Inside the limits both give the same vector, and tests hold them to it.
//!
//! ```
//! use revprio_core::limits::VelocityBox;
//! use revprio_core::linalg::{Matrix, Vector};
//! use revprio_core::resolution::{Problem, resolve};
//! use revprio_core::task::{Task, TaskStack};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // Two joints, of which none may move faster than 1 rad/s: their sum is to be 1.5 rad/s, and the first one to rest.
//! let sum = Task::new("sum", Matrix::from_row_slice(1, 2, &[1.0, 1.0]), Vector::from_vec(vec![1.5]));
//! let rest = Task::new("rest", Matrix::from_row_slice(1, 2, &[1.0, 0.0]), Vector::zeros(1));
//! let tasks = TaskStack::new(vec![sum, rest])?; // highest priority first
//! let limits = VelocityBox::new(&[-1.0, -1.0], &[1.0, 1.0])?;
//! let answer = resolve(&Problem { limits, ..Problem::new(tasks) }, &[])?;
//! // The second joint does what it may, the first one the rest: the lower task gives way.
//! assert!((answer.joint_velocity[0] - 0.5).abs() < 1e-9 && (answer.joint_velocity[1] - 1.0).abs() < 1e-9);
//! assert!((answer.tasks[1].residual_norm - 0.5).abs() < 1e-9);
//! assert_eq!(answer.active_limits[0].joint, 1);
//! # Ok(())
//! # }
//! ```
//!
//! `docs/methods.md` in the repository compares the methods, with numbers and a picture; [`Method`] has their formulas.

mod certificate;
mod closed_form;
#[cfg(test)]
mod faults;
mod hierarchy;
mod problem;
mod qp_cascade;
mod resolve;

pub use hierarchy::Singularity;
pub use problem::{Method, Problem, ProblemError, Solver};
pub use qp_cascade::{ActiveSet, Side};
pub use resolve::{
    ActiveInequality, ActiveLimit, InequalityViolation, LimitViolation, Path, Resolution, Resolver, SolverReport,
    Status, TaskOutcome, resolve,
};
