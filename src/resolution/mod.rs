//! From prioritised tasks to joint velocities.
//!
//! Two ways lead there. The *closed form* is the literature's pseudo-inverse formula; it knows no limits. The
//! *QP cascade* poses the same problem as a sequence of small least-squares problems with joint limits as
//! inequalities. Inside the limits both give the same vector, and tests hold them to it.
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
    ActiveInequality, ActiveLimit, InequalityViolation, LimitViolation, Path, Resolution, SolverReport, Status,
    TaskOutcome, resolve,
};
