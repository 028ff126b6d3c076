//! The answers of `revprio-core` a second and a third way, to compare with.
//!
//! | solver | computation |
//! |---|---|
//! | [`ClosedForm`] | the printed formulas with pseudo-inverses; no limits |
//! | [`Qp`] | a cascade of quadratic programs, every level by Clarabel, an interior-point solver; limits at every level |
//!
//! This crate depends on `revprio-problem` and not on `revprio-core`, and that one not on this. It builds its least-squares
//! problems, projections and damping factors itself, and decomposes matrices with faer. Do not use [`ClosedForm`] on a real
//! arm. It ignores joint limits.
//!
//! ```
//! use revprio_problem::{Matrix, Problem, Resolution, Solve, Task, TaskStack, Vector, VelocityBox};
//! use revprio_reference::Qp;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // Two joints with a speed limit of 1 rad/s. Their sum shall be 1.5 rad/s; below that, the first one shall rest.
//! let sum = Task::new("sum", Matrix::from_row_slice(1, 2, &[1.0, 1.0]), Vector::from_vec(vec![1.5]));
//! let rest = Task::new("rest", Matrix::from_row_slice(1, 2, &[1.0, 0.0]), Vector::zeros(1));
//! let limits = VelocityBox::new(&[-1.0, -1.0], &[1.0, 1.0])?;
//! let problem = Problem { limits, ..Problem::new(TaskStack::new(vec![sum, rest])?) };
//! let mut answer = Resolution::default();
//! Qp::default().solve(&problem, &[], &mut answer)?;
//! assert!((answer.joint_velocity[0] - 0.5).abs() < 1e-9 && (answer.joint_velocity[1] - 1.0).abs() < 1e-9);
//! # Ok(())
//! # }
//! ```

mod blend;
mod cascade;
mod certified;
mod certified_formula;
#[cfg_attr(not(feature = "clarabel"), path = "without_clarabel.rs")]
mod clarabel;
mod closed_form;
mod contradiction;
mod damping;
mod hierarchy;
mod level_program;
mod plan;
mod polish;
mod program;
mod qp;
mod recorder;
mod report;
mod scaled;
mod singularity;
mod step;
mod svd;
mod targets;

pub use closed_form::ClosedForm;
pub use qp::Qp;

/// Whether this build has Clarabel. Without it, [`Qp`] finds no answer.
pub const HAS_CLARABEL: bool = cfg!(feature = "clarabel");
