//! The answer: joint velocities with their explanation.

use std::sync::Arc;

use crate::{ActiveSet, Certificate, Contradiction, Side, Singularity, Vector};

/// Joint velocities and their explanation.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Resolution {
    /// q̇, n, rad/s; always finite. Inside the limits, except by the solver `closed_form`, which ignores them.
    pub joint_velocity: Vector,
    /// Outcome of each task, highest priority first.
    pub tasks: Vec<TaskOutcome>,
    /// Active limits: bounds that the answer reaches and that restrict it.
    pub active_limits: Vec<ActiveLimit>,
    /// Limits that the answer breaks; empty for every solver that knows them.
    pub violated_limits: Vec<LimitViolation>,
    /// Inequalities that hold the answer back.
    pub active_inequalities: Vec<ActiveInequality>,
    /// Inequalities that the answer breaks: any of them for the solver `closed_form`, and those that contradict the limits,
    /// as little as possible, for the others.
    pub violated_inequalities: Vec<InequalityViolation>,
    /// Inequality rows that cannot be kept together, with what contradicts them; one entry per priority level.
    pub contradictions: Vec<Contradiction>,
    /// How the answer was found and how sure it is.
    pub solver: SolverReport,
    /// How near the tasks are to singularities.
    pub singularity: Singularity,
    /// Active limits, the guess for the next period.
    pub active_set: Vec<ActiveSet>,
    /// What Clarabel did at each level, in the order of solution; empty for other solvers.
    pub levels: Vec<LevelReport>,
    /// What a check of the answer needs, if the problem wants it.
    pub certificate: Option<Box<Certificate>>,
}

/// What Clarabel did at one level.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LevelReport {
    /// Its iterations over all attempts, except for those of a second solution that does not count; 0 where the levels above
    /// leave nothing to decide.
    pub iterations: u32,
    /// Largest relative residual of the optimality conditions of the level at Clarabel's answer, dimensionless; infinite
    /// without an answer. Where the level was solved again from its first answer, this is the residual of the first one.
    pub clarabel_residual: f64,
    /// The same after the polish, one linear solve on Clarabel's active set, if that is more accurate; otherwise before it.
    /// Where the level was solved again from its first answer, this is the residual of the last one.
    ///
    /// It is at least the relative change that lower levels made to the rows that the level keeps. So it can be larger than
    /// `clarabel_residual`.
    pub residual: f64,
}

/// The outcome of one task.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TaskOutcome {
    /// J_k q̇, m_k, m/s or rad/s.
    pub achieved: Vector,
    /// ‖J_k q̇ − ẋ_k‖, or the norm of what is missing to the bounds of an inequality task.
    pub residual_norm: f64,
    /// ρ(J_k).
    pub rank: usize,
    /// Whether task k depends on lower ones although each side has its own rank: ρ(J_k) + ρ(J_{k+1}^RP) > ρ(J_k^RP).
    /// Paper: Eq. (12).
    pub algorithmic: bool,
    /// s of a scaled task, J_k q̇ = s ẋ_k: 1 where no limit cuts it; `None` where no s keeps its direction, and for other
    /// tasks. Reverse priority knows limits, and so scaling, at its highest task alone.
    pub scale: Option<f64>,
    /// Rows of an inequality task that hold the answer back.
    pub active_rows: Vec<ActiveRow>,
}

/// A row of an inequality task that holds the answer back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActiveRow {
    /// Index of the row, from 0.
    pub row: usize,
    /// Which bound.
    pub side: Side,
    /// Multiplier ≥ 0 at the highest level that the row holds back.
    pub multiplier: f64,
}

/// A limit that holds the answer back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActiveLimit {
    /// Joint index, from 0.
    pub joint: usize,
    /// Which bound.
    pub side: Side,
    /// The bound, rad/s.
    pub value: f64,
    /// Multiplier ≥ 0 at the highest level that the limit holds back; 0 for a joint whose bounds coincide and that holds no
    /// level back, which is listed all the same. It says how much ½‖J_k q̇ − ẋ_k‖² of that level would fall per rad/s of a
    /// wider limit.
    pub multiplier: f64,
}

/// An inequality that holds the answer back.
#[derive(Debug, Clone, PartialEq)]
pub struct ActiveInequality {
    /// Its name.
    pub name: Arc<str>,
    /// b.
    pub bound: f64,
    /// Multiplier ≥ 0 at the highest level that it holds back: how much ½‖J_k q̇ − ẋ_k‖² of that level would fall per unit
    /// of a larger b.
    pub multiplier: f64,
}

/// An inequality that the answer breaks.
#[derive(Debug, Clone, PartialEq)]
pub struct InequalityViolation {
    /// Its name.
    pub name: Arc<str>,
    /// b.
    pub bound: f64,
    /// a·q̇, above b.
    pub value: f64,
}

/// A limit that the answer breaks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitViolation {
    /// Joint index, from 0.
    pub joint: usize,
    /// Which bound.
    pub side: Side,
    /// The bound, rad/s.
    pub limit: f64,
    /// The velocity, rad/s.
    pub value: f64,
}

/// The way that led to the answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Path {
    /// No bound is active: the answer of the pseudo-inverse formulas.
    #[default]
    ClosedForm,
    /// Working sets that start from the last one, until the optimality conditions hold.
    ActiveSet,
    /// Clarabel's answer at every level.
    Qp,
}

/// How sure the answer is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Status {
    /// The optimality conditions hold; those of the problem without limits for the solver `closed_form`.
    Optimal,
    /// They do not hold closely enough; the command is inside the limits, but may not be the best one.
    NotCertified,
    /// No answer was found; the command is the slowest one inside the limits.
    #[default]
    Failed,
}

/// How the answer was found and how sure it is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SolverReport {
    /// The way that led to the answer.
    pub path: Path,
    /// How sure it is.
    pub status: Status,
    /// Iterations of Clarabel over all levels.
    pub iterations: u32,
    /// Levels without an answer of Clarabel: it refused the numbers, or reported numerical trouble or that there is no solution.
    /// Its answers at the cap of iterations or without progress count as answers, and their residual judges them. Where a
    /// level has no answer, the problem keeps what the levels above achieved.
    pub failures: u32,
    /// Problems for which the hierarchical solver needed its last resort, one change of the working set at a time.
    pub last_resorts: u32,
    /// Largest relative residual of the optimality conditions over all levels, dimensionless; `None` without an
    /// answer, or where its scale is beyond the numbers (rows of 1e-160).
    pub kkt_residual: Option<f64>,
    /// Whether a rank decision lies so near its threshold that rounding may have decided it.
    pub rank_uncertain: bool,
    /// Working sets (sets of active limits) that were tried.
    pub working_sets: u32,
}
