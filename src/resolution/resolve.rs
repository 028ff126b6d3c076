//! The one entry: a problem in, joint velocities and their explanation out.

use super::closed_form::{self, ClosedForm};
use super::hierarchy::{Hierarchy, Singularity};
use super::problem::{Method, Problem, ProblemError, Solver};
use super::qp_cascade::{self, ActiveSet, Cascade, Guesses, Side};
use crate::linalg::{SvdError, Vector};

/// Relative optimality residual up to which an answer counts as optimal.
///
/// Exact answers of task size stay below 1e-12; a wrong active set is off by orders of magnitude more than this.
const CERTIFIED: f64 = 1e-9;

/// Joint velocities and why they are what they are.
#[derive(Debug, Clone, PartialEq)]
pub struct Resolution {
    /// q̇, n, rad/s; always finite. Inside the limits, except by the solver `closed_form`, which ignores them.
    pub joint_velocity: Vector,
    /// What became of each task, highest priority first.
    pub tasks: Vec<TaskOutcome>,
    /// Limits that hold the answer back.
    pub active_limits: Vec<ActiveLimit>,
    /// Limits that the answer breaks; empty for every solver that knows them.
    pub violated_limits: Vec<LimitViolation>,
    /// How the answer was found and how sure it is.
    pub solver: SolverReport,
    /// How near the tasks are to singularities.
    pub singularity: Singularity,
    /// Active limits level by level, the guess for the next period.
    pub active_set: Vec<ActiveSet>,
}

/// What became of one task.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskOutcome {
    /// J_k q̇, m_k, m/s or rad/s.
    pub achieved: Vector,
    /// ‖J_k q̇ − ẋ_k‖.
    pub residual_norm: f64,
    /// ρ(J_k).
    pub rank: usize,
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
    /// Multiplier ≥ 0 at the highest level that the limit holds back; 0 for a joint whose bounds coincide and that holds
    /// back no more than lower levels, which is listed all the same. It says how much ½‖J_k q̇ − ẋ_k‖² of that level would
    /// fall per rad/s of a wider limit.
    pub multiplier: f64,
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

/// Which way led to the answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Path {
    /// Pseudo-inverses.
    ClosedForm,
    /// The last active set, confirmed by its optimality conditions.
    ActiveSet,
    /// Clarabel, polished.
    Qp,
}

/// How sure the answer is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// The optimality conditions hold; those of the problem without limits for the solver `closed_form`.
    Optimal,
    /// They do not hold closely enough; the command is inside the limits, but may not be the best one.
    NotCertified,
    /// No answer was found; the command is the slowest one inside the limits.
    Failed,
}

/// How the answer was found and how sure it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolverReport {
    /// Which way led to the answer.
    pub path: Path,
    /// How sure it is.
    pub status: Status,
    /// Iterations of Clarabel over all levels.
    pub iterations: u32,
    /// Largest relative residual of the optimality conditions over all levels, dimensionless; `None` without an
    /// answer, or where its scale is beyond the numbers (rows of 1e-160).
    pub kkt_residual: Option<f64>,
}

/// Solves the problem; `guess` are the active limits of the period before (empty: none).
///
/// A numerical failure is not an error but an answer with a status: the control loop needs a safe command either way.
pub fn resolve(problem: &Problem, guess: &[ActiveSet]) -> Result<Resolution, ProblemError> {
    problem.check()?;
    let answer = Hierarchy::new(&problem.tasks, problem.damping).and_then(|hierarchy| {
        let sparing = problem.method != Method::SingularityRobust;
        let hierarchy = if sparing { hierarchy } else { hierarchy.sparing_nothing() };
        let cascade = solve(problem, &hierarchy, guess)?;
        Ok((cascade, hierarchy))
    });
    Ok(match answer {
        Ok((cascade, hierarchy)) if cascade.joint_velocity.iter().all(|v| v.is_finite()) => {
            report(problem, cascade, &hierarchy)
        }
        _ => standstill(problem),
    })
}

fn solve(problem: &Problem, hierarchy: &Hierarchy, guess: &[ActiveSet]) -> Result<Cascade, SvdError> {
    match problem.solver {
        Solver::ClosedForm => Ok(Cascade::from(closed_form(problem, hierarchy)?)),
        Solver::Qp => qp_cascade::solve(problem, hierarchy, Guesses::NONE),
        Solver::Auto => {
            let unlimited = closed_form(problem, hierarchy)?;
            if problem.limits.violation(&unlimited.joint_velocity) == 0.0 {
                Ok(Cascade::from(unlimited))
            } else {
                qp_cascade::solve(problem, hierarchy, Guesses::of(guess))
            }
        }
    }
}

fn closed_form(problem: &Problem, hierarchy: &Hierarchy) -> Result<ClosedForm, SvdError> {
    let (tasks, top, zeta) = (&problem.tasks, hierarchy.top(), problem.start());
    match problem.method {
        Method::Pseudoinverse => Ok(closed_form::least_squares(tasks, top, &zeta, 0.0)),
        Method::DampedLeastSquares => Ok(closed_form::least_squares(tasks, top, &zeta, top.lambda)),
        Method::ReversePriority | Method::SingularityRobust => closed_form::reverse_priority(&hierarchy.stages, &zeta),
        Method::StrictReversePriority | Method::TaskPriority => {
            closed_form::strict_reverse_priority(tasks, problem.damping, &zeta)
        }
    }
}

fn report(problem: &Problem, cascade: Cascade, hierarchy: &Hierarchy) -> Resolution {
    let certified = cascade.kkt_residual <= CERTIFIED;
    Resolution {
        tasks: outcomes(problem, &cascade.joint_velocity, |k| hierarchy.stages[k].svd.rank()),
        active_limits: active_limits(problem, &cascade),
        violated_limits: violations(problem, &cascade.joint_velocity),
        solver: SolverReport {
            path: cascade.path,
            status: if certified { Status::Optimal } else { Status::NotCertified },
            iterations: cascade.iterations,
            kkt_residual: Some(cascade.kkt_residual).filter(|residual| residual.is_finite()),
        },
        singularity: hierarchy.singularity(),
        active_set: cascade.active_sets,
        joint_velocity: cascade.joint_velocity,
    }
}

/// The command when nothing could be computed: as slow as the limits allow.
fn standstill(problem: &Problem) -> Resolution {
    let joint_velocity = problem.limits.clamp(&Vector::zeros(problem.tasks.joint_count()));
    Resolution {
        tasks: outcomes(problem, &joint_velocity, |_| 0),
        active_limits: Vec::new(),
        violated_limits: Vec::new(),
        solver: SolverReport { path: Path::ClosedForm, status: Status::Failed, iterations: 0, kkt_residual: None },
        singularity: Singularity { smallest_singular_value: 0.0, manipulability: 0.0, algorithmic: false },
        active_set: Vec::new(),
        joint_velocity,
    }
}

fn outcomes(problem: &Problem, qdot: &Vector, rank: impl Fn(usize) -> usize) -> Vec<TaskOutcome> {
    let outcome = |(k, task): (usize, &crate::task::Task)| {
        let achieved = &task.jacobian * qdot;
        TaskOutcome { residual_norm: (&achieved - &task.velocity).norm(), achieved, rank: rank(k) }
    };
    problem.tasks.tasks().iter().enumerate().map(outcome).collect()
}

/// Limits with a multiplier, and joints that their bounds hold fast.
fn active_limits(problem: &Problem, cascade: &Cascade) -> Vec<ActiveLimit> {
    let (lower, upper) = (problem.limits.lower(), problem.limits.upper());
    let limits_count = cascade.path != Path::ClosedForm;
    let active = |(joint, &signed): (usize, &f64)| {
        let (side, bounds) = if signed < 0.0 { (Side::Lower, lower) } else { (Side::Upper, upper) };
        let held_fast = limits_count && lower[joint] == upper[joint];
        let limit = ActiveLimit { joint, side, value: bounds[joint], multiplier: signed.abs() };
        (held_fast || signed != 0.0).then_some(limit)
    };
    cascade.multipliers.iter().enumerate().filter_map(active).collect()
}

fn violations(problem: &Problem, qdot: &Vector) -> Vec<LimitViolation> {
    let nearest = problem.limits.clamp(qdot);
    let broken = |joint: usize| {
        let (value, limit) = (qdot[joint], nearest[joint]);
        let side = if value > limit { Side::Upper } else { Side::Lower };
        ((value - limit).abs() > 0.0).then_some(LimitViolation { joint, side, limit, value })
    };
    (0..qdot.len()).filter_map(broken).collect()
}
