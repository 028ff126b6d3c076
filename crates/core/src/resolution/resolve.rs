//! The one entry: a problem in, joint velocities and their explanation out.
#![allow(non_snake_case)]

use super::closed_form::{ClosedForm, Descent, least_squares, reverse_priority};
use super::hierarchy::{Hierarchy, Singularity, Stage};
use super::problem::{Problem, ProblemError, Scheme, Solver};
use super::qp_cascade::{ActiveSet, Cascade, CascadeSolver, Guesses, Side};
use crate::linalg::{TaskVector, Vector};

/// Relative optimality residual up to which an answer counts as optimal.
///
/// Exact answers of task size stay below 1e-12; a wrong active set is off by orders of magnitude more than this.
const CERTIFIED: f64 = 1e-9;

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
#[derive(Debug, Clone, PartialEq, Default)]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Path {
    /// Pseudo-inverses.
    #[default]
    ClosedForm,
    /// Active sets that start from the last one, until the optimality conditions hold.
    ActiveSet,
    /// Clarabel, refined to full accuracy.
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
    let mut answer = Resolution::default();
    Resolver::default().resolve(problem, guess, &mut answer)?;
    Ok(answer)
}

/// What resolving works with, allocated once and overwritten by each problem: the same answers as [`resolve`], to the
/// last bit.
#[derive(Default)]
pub struct Resolver {
    hierarchy: Hierarchy,
    descent: Descent,
    cascade: CascadeSolver,
}

impl Resolver {
    /// Solves the problem as [`resolve`] does and overwrites `answer`.
    pub fn resolve(
        &mut self,
        problem: &Problem,
        guess: &[ActiveSet],
        answer: &mut Resolution,
    ) -> Result<(), ProblemError> {
        problem.check()?;
        self.hierarchy.update(&problem.tasks, problem.damping);
        answer.singularity = self.hierarchy.singularity();
        if problem.method.scheme() == (Scheme::LowestFirst { ignores_lower_tasks: true }) {
            self.hierarchy.spare_nothing(problem.damping);
        }
        let cascade = self.solve(problem, guess);
        if cascade.joint_velocity.iter().all(|v| v.is_finite()) {
            answer.report(problem, &cascade, &self.hierarchy);
        } else {
            answer.report(problem, &standstill(problem), &self.hierarchy);
            answer.fail();
        }
        Ok(())
    }

    fn solve(&mut self, problem: &Problem, guess: &[ActiveSet]) -> Cascade {
        let Self { hierarchy, descent, cascade } = self;
        match problem.solver {
            Solver::ClosedForm => Cascade::from(closed_form(problem, hierarchy, descent)),
            Solver::Qp => cascade.solve(problem, hierarchy, Guesses::NONE),
            Solver::Auto => {
                let unlimited = closed_form(problem, hierarchy, descent);
                if problem.allows(&unlimited.joint_velocity) {
                    Cascade::from(unlimited)
                } else {
                    cascade.solve(problem, hierarchy, Guesses::of(guess))
                }
            }
        }
    }
}

/// The answer without limits.
fn closed_form(problem: &Problem, hierarchy: &Hierarchy, descent: &mut Descent) -> ClosedForm {
    let (stages, zeta) = (&hierarchy.stages, problem.start());
    let all = |lambda| least_squares(&hierarchy.all, hierarchy.conditioning.decomposition(), &zeta, lambda);
    match problem.method.scheme() {
        Scheme::OneLevel { damped } => all(if damped { hierarchy.top().lambda } else { 0.0 }),
        _ if hierarchy.is_compatible => all(0.0),
        Scheme::LowestFirst { .. } => reverse_priority(stages, zeta),
        Scheme::HighestFirst => descent.strict_reverse_priority(stages, problem.damping, &zeta),
    }
}

/// The command when nothing could be computed: as slow as the limits allow.
fn standstill(problem: &Problem) -> Cascade {
    let joint_velocity = problem.limits.clamp(&Vector::zeros(problem.tasks.joint_count()));
    Cascade::from(ClosedForm { joint_velocity: (&joint_velocity).into(), kkt_residual: 0.0 })
}

impl Resolution {
    /// Sets the answer from the result of the cascade.
    fn report(&mut self, problem: &Problem, cascade: &Cascade, hierarchy: &Hierarchy) {
        let certified = cascade.kkt_residual <= CERTIFIED;
        assign(&mut self.joint_velocity, &cascade.joint_velocity);
        self.tasks.resize_with(hierarchy.stages.len(), TaskOutcome::default);
        for (k, (task, stage)) in self.tasks.iter_mut().zip(&hierarchy.stages).enumerate() {
            task.report(stage, &cascade.joint_velocity);
            task.scale = scale(problem, cascade, k);
        }
        refill(&mut self.active_limits, active_limits(problem, cascade));
        refill(&mut self.violated_limits, violations(problem, &cascade.joint_velocity));
        refill(&mut self.active_inequalities, active_inequalities(problem, cascade));
        refill(&mut self.violated_inequalities, violated_inequalities(problem, &self.joint_velocity));
        self.solver = SolverReport {
            path: cascade.path,
            status: if certified { Status::Optimal } else { Status::NotCertified },
            iterations: cascade.iterations,
            failures: cascade.failures,
            kkt_residual: Some(cascade.kkt_residual).filter(|residual| residual.is_finite()),
        };
        refill(&mut self.active_set, cascade.active_sets.iter().cloned());
    }

    /// Sets the status `failed`.
    fn fail(&mut self) {
        self.violated_limits.clear();
        self.solver = SolverReport { status: Status::Failed, kkt_residual: None, ..self.solver };
        self.singularity = Singularity { smallest_singular_value: 0.0, manipulability: 0.0, algorithmic: false };
        for task in &mut self.tasks {
            (task.rank, task.algorithmic, task.scale) = (0, false, None);
        }
    }
}

impl TaskOutcome {
    fn report(&mut self, stage: &Stage, qdot: &TaskVector) {
        let achieved = &stage.J_k * qdot;
        self.residual_norm = (&achieved - &stage.xdot_k).norm();
        self.rank = stage.rank;
        self.algorithmic = stage.algorithmic;
        assign(&mut self.achieved, &achieved);
    }
}

/// Overwrites a vector, in place where it has the size.
fn assign(to: &mut Vector, from: &TaskVector) {
    if to.len() == from.len() {
        to.copy_from_slice(from);
    } else {
        *to = from.to_vector();
    }
}

fn refill<T>(list: &mut Vec<T>, entries: impl Iterator<Item = T>) {
    list.clear();
    list.extend(entries);
}

fn scale(problem: &Problem, cascade: &Cascade, k: usize) -> Option<f64> {
    let level = match problem.method.scheme() {
        Scheme::LowestFirst { .. } => (k == 0).then_some(0)?,
        Scheme::HighestFirst => k,
        Scheme::OneLevel { .. } => 0,
    };
    let cut = cascade.scales.get(level).copied();
    problem.tasks.tasks()[k].scaled.then(|| cut.unwrap_or(Some(1.0)))?
}

/// Limits with a multiplier, and joints that their bounds hold fast.
fn active_limits(problem: &Problem, cascade: &Cascade) -> impl Iterator<Item = ActiveLimit> {
    let (lower, upper) = (problem.limits.lower(), problem.limits.upper());
    let limits_count = cascade.path != Path::ClosedForm;
    let active = move |(joint, &signed): (usize, &f64)| {
        let (side, bounds) = if signed < 0.0 { (Side::Lower, lower) } else { (Side::Upper, upper) };
        let held_fast = limits_count && lower[joint] == upper[joint];
        let limit = ActiveLimit { joint, side, value: bounds[joint], multiplier: signed.abs() };
        (held_fast || signed != 0.0).then_some(limit)
    };
    cascade.multipliers.iter().take(lower.len()).enumerate().filter_map(active)
}

fn active_inequalities(problem: &Problem, cascade: &Cascade) -> impl Iterator<Item = ActiveInequality> {
    let multipliers = cascade.multipliers.iter().skip(problem.tasks.joint_count());
    let active = problem.inequalities.iter().zip(multipliers).filter(|(_, multiplier)| **multiplier != 0.0);
    active.map(|(inequality, multiplier)| ActiveInequality {
        name: inequality.name().to_owned(),
        bound: inequality.bound(),
        // The cascade's rows have length 1.
        multiplier: multiplier / inequality.coefficients().norm(),
    })
}

fn violated_inequalities(problem: &Problem, qdot: &Vector) -> impl Iterator<Item = InequalityViolation> {
    let broken = problem.inequalities.iter().filter(|inequality| inequality.violation(qdot) > 0.0);
    broken.map(|inequality| InequalityViolation {
        name: inequality.name().to_owned(),
        bound: inequality.bound(),
        value: inequality.value(qdot),
    })
}

fn violations(problem: &Problem, qdot: &TaskVector) -> impl Iterator<Item = LimitViolation> {
    let (lower, upper) = (problem.limits.lower(), problem.limits.upper());
    let broken = move |(joint, &value): (usize, &f64)| {
        let limit = value.max(lower[joint]).min(upper[joint]);
        let side = if value > limit { Side::Upper } else { Side::Lower };
        ((value - limit).abs() > 0.0).then_some(LimitViolation { joint, side, limit, value })
    };
    qdot.iter().enumerate().filter_map(broken)
}
