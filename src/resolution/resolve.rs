//! The one entry: a problem in, joint velocities and their explanation out.

use super::closed_form::{self, ClosedForm};
use super::hierarchy::{Hierarchy, Singularity};
use super::problem::{Method, Problem, ProblemError, Solver};
use super::qp_cascade::{self, ActiveSet, Cascade, Guesses, Side};
use crate::linalg::{SvdError, Vector};
use crate::task::Task;

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
    /// Inequalities that hold the answer back.
    pub active_inequalities: Vec<ActiveInequality>,
    /// Inequalities that the answer breaks: all that it likes for the solver `closed_form`, those that contradict the
    /// limits, and then as little as possible, for the others.
    pub violated_inequalities: Vec<InequalityViolation>,
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
    /// Whether task k depends on lower ones although each side has its own rank: ρ(J_k) + ρ(J_{k+1}^RP) > ρ(J_k^RP).
    /// Paper: Eq. (12).
    pub algorithmic: bool,
    /// s of a task that is to be scaled, J_k q̇ = s ẋ_k: 1 where no limit cuts it; `None` where no s keeps its direction,
    /// and for a task that is not to be scaled. Reverse priority knows limits, and so scaling, at its highest task alone.
    pub scale: Option<f64>,
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

/// An inequality that holds the answer back.
#[derive(Debug, Clone, PartialEq)]
pub struct ActiveInequality {
    /// Its name.
    pub name: String,
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
    pub name: String,
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
    /// Levels that Clarabel failed to solve (iteration cap, numerical trouble); the active-set method stood in.
    pub failures: u32,
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
            if problem.allows(&unlimited.joint_velocity) {
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
        tasks: outcomes(problem, &cascade, hierarchy),
        active_limits: active_limits(problem, &cascade),
        violated_limits: violations(problem, &cascade.joint_velocity),
        active_inequalities: active_inequalities(problem, &cascade),
        violated_inequalities: violated_inequalities(problem, &cascade.joint_velocity),
        solver: SolverReport {
            path: cascade.path,
            status: if certified { Status::Optimal } else { Status::NotCertified },
            iterations: cascade.iterations,
            failures: cascade.failures,
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
    let tasks = problem.tasks.tasks().iter();
    Resolution {
        tasks: tasks.map(|task| outcome(task, &joint_velocity)).collect(),
        active_limits: Vec::new(),
        violated_limits: Vec::new(),
        active_inequalities: Vec::new(),
        violated_inequalities: violated_inequalities(problem, &joint_velocity),
        solver: SolverReport {
            path: Path::ClosedForm,
            status: Status::Failed,
            iterations: 0,
            failures: 0,
            kkt_residual: None,
        },
        singularity: Singularity { smallest_singular_value: 0.0, manipulability: 0.0, algorithmic: false },
        active_set: Vec::new(),
        joint_velocity,
    }
}

fn outcomes(problem: &Problem, cascade: &Cascade, hierarchy: &Hierarchy) -> Vec<TaskOutcome> {
    let outcome = |(k, task): (usize, &Task)| TaskOutcome {
        rank: hierarchy.stages[k].svd.rank(),
        algorithmic: hierarchy.stages[k].algorithmic,
        scale: scale(problem, cascade, k),
        ..outcome(task, &cascade.joint_velocity)
    };
    problem.tasks.tasks().iter().enumerate().map(outcome).collect()
}

/// The residual of a task of which nothing else is known.
fn outcome(task: &Task, qdot: &Vector) -> TaskOutcome {
    let achieved = &task.jacobian * qdot;
    let residual_norm = (&achieved - &task.velocity).norm();
    TaskOutcome { achieved, residual_norm, rank: 0, algorithmic: false, scale: None }
}

fn scale(problem: &Problem, cascade: &Cascade, k: usize) -> Option<f64> {
    let level = match problem.method {
        Method::ReversePriority | Method::SingularityRobust => (k == 0).then_some(0)?,
        Method::StrictReversePriority | Method::TaskPriority => k,
        Method::Pseudoinverse | Method::DampedLeastSquares => 0,
    };
    let cut = cascade.scales.get(level).copied();
    problem.tasks.tasks()[k].scaled.then(|| cut.unwrap_or(Some(1.0)))?
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
    cascade.multipliers.iter().take(lower.len()).enumerate().filter_map(active).collect()
}

fn active_inequalities(problem: &Problem, cascade: &Cascade) -> Vec<ActiveInequality> {
    let multipliers = cascade.multipliers.iter().skip(problem.tasks.joint_count());
    let active = problem.inequalities.iter().zip(multipliers).filter(|(_, multiplier)| **multiplier != 0.0);
    active
        .map(|(inequality, multiplier)| ActiveInequality {
            name: inequality.name().to_owned(),
            bound: inequality.bound(),
            // The cascade's rows have length 1.
            multiplier: multiplier / inequality.coefficients().norm(),
        })
        .collect()
}

fn violated_inequalities(problem: &Problem, qdot: &Vector) -> Vec<InequalityViolation> {
    let broken = problem.inequalities.iter().filter(|inequality| inequality.violation(qdot) > 0.0);
    broken
        .map(|inequality| InequalityViolation {
            name: inequality.name().to_owned(),
            bound: inequality.bound(),
            value: inequality.value(qdot),
        })
        .collect()
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
