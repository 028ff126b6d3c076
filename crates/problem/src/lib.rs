//! What the solvers of prioritised tasks share: the problem, the answer, its certificate, and the trait [`Solve`].
//!
//! This crate has types and checks. `revprio-core` and `revprio-reference` depend on it and not on each other. So their
//! answers can be compared. The solvers of both share these formulas:
//!
//! | formula | where it counts |
//! |---|---|
//! | [`Damping::fading_threshold`] | in answers near singularities |
//! | [`Damping::for_reaction`] | in the problem, before it is solved |
//! | [`VelocityBox::clamp`] | in the velocity of an answer with the status [`Status::Failed`] |
//! | [`Inequality::violation`] | in the list of broken inequalities |
//!
//! | to | see |
//! |---|---|
//! | state tasks in their order of priority | [`Task`], [`TaskStack`] |
//! | state limits and inequalities of the joint velocities | [`VelocityBox`], [`Inequality`] |
//! | choose a method and its damping | [`Method`], [`Damping`] |
//! | solve a problem | [`Problem`], [`Solve`] |
//! | read an answer and its explanation | [`Resolution`] |
//! | check an answer | [`Certificate`] |

mod answer;
mod bound;
mod certificate;
mod contradiction;
mod damping;
mod equation_rows;
mod inequality;
mod problem;
mod singularity;
mod solve;
mod task;
mod velocity_box;

pub use answer::{LevelReport, Path, Resolution, SolverReport, Status, TaskOutcome};
pub use bound::{ActiveBound, ActiveSet, Bound, BoundId, BrokenBound, Side};
pub use certificate::{Certificate, CertifiedLevel, CertifiedProblem, Multipliers, Part};
pub use contradiction::Contradiction;
pub use damping::Damping;
pub use equation_rows::EquationRows;
pub use inequality::{Inequality, InequalityError, LOWEST_CONSTRAINT_LEVEL};
pub use problem::{MAX_UNKNOWNS, Method, Problem, ProblemError, Solver};
pub use singularity::Singularity;
pub use solve::Solve;
pub use task::{Task, TaskError, TaskStack};
pub use velocity_box::{VelocityBox, VelocityBoxError};

/// A matrix of any shape.
pub type Matrix = nalgebra::DMatrix<f64>;
/// A column of any length.
pub type Vector = nalgebra::DVector<f64>;
