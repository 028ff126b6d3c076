//! The answer: joint velocities with their explanation.

use crate::{ActiveBound, ActiveSet, BoundId, BrokenBound, Certificate, Contradiction, Singularity, Vector};

/// Joint velocities and their explanation.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Resolution {
    /// q̇, n, rad/s; always finite. Inside the limits, except by the solver `closed_form`, which ignores them.
    pub joint_velocity: Vector,
    /// Outcome of each task, highest priority first.
    pub tasks: Vec<TaskOutcome>,
    /// Bounds that hold the answer back, and the limits of joints whose bounds coincide: first joints, then constraints by their level,
    /// then rows of tasks.
    pub active_bounds: Vec<ActiveBound>,
    /// Limits and constraints that the answer breaks, in the same order. Solvers that know limits break no joint's, and
    /// constraints only where these contradict limits or each other, as little as possible.
    pub broken_bounds: Vec<BrokenBound>,
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

impl Resolution {
    /// Returns the limits of joints that hold the answer back, with the index of the joint.
    pub fn active_limits(&self) -> impl Iterator<Item = (usize, &ActiveBound)> {
        self.active_bounds.iter().filter_map(|active| Some((active.bound.id.joint()?, active)))
    }

    /// Returns the rows of constraints that hold the answer back, with the index of the constraint.
    pub fn active_constraints(&self) -> impl Iterator<Item = (usize, &ActiveBound)> {
        self.active_bounds.iter().filter_map(|active| Some((active.bound.id.constraint()?, active)))
    }

    /// Returns the rows of task `k` that hold the answer back, with the index of the row.
    pub fn active_rows(&self, k: usize) -> impl Iterator<Item = (usize, &ActiveBound)> {
        self.active_bounds.iter().filter_map(move |active| match active.bound.id {
            BoundId::Task { index, row } if index == k => Some((row, active)),
            _ => None,
        })
    }

    /// Returns the limits of joints that the answer breaks, with the index of the joint.
    pub fn broken_limits(&self) -> impl Iterator<Item = (usize, &BrokenBound)> {
        self.broken_bounds.iter().filter_map(|broken| Some((broken.bound.id.joint()?, broken)))
    }

    /// Returns the rows of constraints that the answer breaks, with the index of the constraint.
    pub fn broken_constraints(&self) -> impl Iterator<Item = (usize, &BrokenBound)> {
        self.broken_bounds.iter().filter_map(|broken| Some((broken.bound.id.constraint()?, broken)))
    }
}

/// What Clarabel did at one level.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LevelReport {
    /// Its iterations over all attempts, also those whose answer does not count; 0 where the levels above leave nothing to
    /// decide.
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
    /// s of a scaled task, J_k q̇ = s ẋ_k apart from what the joints cannot reach: 1 where no limit cuts it; `None` where no s keeps its
    /// direction, and for other tasks. Reverse priority knows limits, and so scaling, at its highest task alone.
    pub scale: Option<f64>,
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
