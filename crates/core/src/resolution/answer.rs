//! The answer: joint velocities with their explanation.

use std::sync::Arc;

use super::closed_form::ClosedForm;
use super::contradiction::Contradiction;
use super::engine::Engine;
use super::level::{ActiveSet, Side, Solution, refill};
use super::plan::{Origin, PlannedProblem};
use super::plan_run::PlanRun;
use super::problem::Problem;
use super::singularity::{Singularities, Singularity, TaskSingularity};
use super::solver::SizedSolver;
use crate::linalg::{Vector, all_finite, write_product};
use crate::task::Task;

/// Relative optimality residual up to which an answer counts as optimal.
///
/// Exact answers of task size stay below 1e-12. A wrong active set is off by orders of magnitude more than this.
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
    /// Clarabel's active bounds, evaluated and corrected by the hierarchical solver.
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
    /// Levels that Clarabel failed to solve (iteration cap, numerical trouble); the hierarchical solver stood in.
    pub failures: u32,
    /// Largest relative residual of the optimality conditions over all levels, dimensionless; `None` without an
    /// answer, or where its scale is beyond the numbers (rows of 1e-160).
    pub kkt_residual: Option<f64>,
    /// Whether a rank decision lies so near its threshold that rounding may have decided it.
    pub rank_uncertain: bool,
    /// Working sets (sets of active limits) that were tried.
    pub working_sets: u32,
}

impl Resolution {
    /// Sets the answer from the solution of a plan.
    pub(super) fn report(
        &mut self,
        problem: &Problem,
        singularities: &Singularities,
        run: &mut PlanRun,
        engine: &Engine,
    ) {
        let PlanRun { planned, solution, scales, contradictions, has_task_values, .. } = run;
        let counts = engine.clarabel_counts();
        let path = match counts {
            Some(_) => Path::Qp,
            None if solution.working_set.is_empty() => Path::ClosedForm,
            None => Path::ActiveSet,
        };
        let achieved = if *has_task_values { solution.row_values.as_slice() } else { &[] };
        self.report_velocity(problem, singularities, &solution.x, achieved);
        for (task, (scale, stated)) in self.tasks.iter_mut().zip(scales.iter().zip(problem.tasks.tasks())) {
            task.scale = scale.filter(|_| stated.scaled);
        }
        let is_failed = self.solver.status == Status::Failed;
        self.report_solver(path, solution);
        if is_failed {
            self.clear_bounds();
            return;
        }
        self.report_bounds(problem, planned, solution);
        std::mem::swap(&mut self.contradictions, contradictions);
        self.solver.rank_uncertain |= singularities.rank_uncertain;
        if let Some(counts) = counts {
            (self.solver.iterations, self.solver.failures) = (counts.iterations, counts.failures);
        }
        if self.active_set.len() != 1 {
            self.active_set.resize_with(1, ActiveSet::new);
        }
        planned.write_active_set(problem, &solution.working_set, &mut self.active_set[0]);
    }

    /// Sets the answer to the solution without limits, which is finite and meets every task and limit.
    pub(super) fn report_unlimited(
        &mut self,
        problem: &Problem,
        singularities: &Singularities,
        solver: &dyn SizedSolver,
        residual: f64,
    ) {
        self.set_velocity(solver.x());
        self.singularity.set(singularities, &problem.tasks);
        let achieved = if singularities.has_only_equations { solver.row_values() } else { &[] };
        self.report_tasks(problem, singularities, achieved);
        self.violated_limits.clear();
        self.violated_inequalities.clear();
        self.clear_bounds();
        self.report_pinned(problem);
        self.solver = SolverReport {
            status: status(residual),
            kkt_residual: Some(residual).filter(|residual| residual.is_finite()),
            rank_uncertain: singularities.rank_uncertain,
            working_sets: 1,
            ..SolverReport::default()
        };
    }

    /// Sets the answer to that of the printed formulas.
    pub(super) fn report_closed_form(&mut self, problem: &Problem, closed: &ClosedForm, singularities: &Singularities) {
        self.report_velocity(problem, singularities, closed.joint_velocity.as_slice(), &[]);
        if self.solver.status != Status::Failed {
            self.violated_limits.extend(violations(problem, &self.joint_velocity));
        }
        self.clear_bounds();
        let residual = closed.kkt_residual;
        let rank_uncertain = singularities.rank_uncertain;
        let kkt_residual = Some(residual).filter(|residual| residual.is_finite());
        self.solver = if self.solver.status == Status::Failed {
            SolverReport::default()
        } else {
            SolverReport { status: status(residual), kkt_residual, rank_uncertain, ..SolverReport::default() }
        };
    }

    /// Sets the velocity and what follows from it alone. A velocity that is not finite is replaced by standstill, with the
    /// status `failed`. `achieved`: as for [`Self::report_tasks`].
    fn report_velocity(&mut self, problem: &Problem, singularities: &Singularities, x: &[f64], achieved: &[f64]) {
        let x = &x[..problem.tasks.joint_count()];
        let is_finite = all_finite(x);
        if is_finite {
            self.set_velocity(x);
            self.singularity.set(singularities, &problem.tasks);
            self.solver.status = Status::NotCertified;
        } else {
            self.joint_velocity = problem.limits.clamp(&Vector::zeros(x.len()));
            self.singularity = Singularity::default();
            self.solver.status = Status::Failed;
        }
        self.report_tasks(problem, singularities, if is_finite { achieved } else { &[] });
        if !is_finite {
            for outcome in &mut self.tasks {
                (outcome.rank, outcome.algorithmic, outcome.scale) = (0, false, None);
            }
        }
        self.violated_limits.clear();
        let broken = problem.inequalities.iter().filter(|inequality| inequality.violation(&self.joint_velocity) > 0.0);
        let violation = |inequality: &crate::limits::Inequality| InequalityViolation {
            name: inequality.shared_name(),
            bound: inequality.bound(),
            value: inequality.value(&self.joint_velocity),
        };
        refill(&mut self.violated_inequalities, broken.map(violation));
    }

    fn set_velocity(&mut self, x: &[f64]) {
        if self.joint_velocity.len() != x.len() {
            self.joint_velocity = Vector::zeros(x.len());
        }
        self.joint_velocity.as_mut_slice().copy_from_slice(x);
    }

    /// Sets the outcomes of the tasks at the velocity. `achieved`: the values of the rows of all tasks; empty: they are computed.
    fn report_tasks(&mut self, problem: &Problem, singularities: &Singularities, mut achieved: &[f64]) {
        let tasks = problem.tasks.tasks();
        self.tasks.resize_with(tasks.len(), TaskOutcome::default);
        for ((outcome, task), known) in self.tasks.iter_mut().zip(tasks).zip(&singularities.tasks) {
            let own = achieved.split_off(..task.jacobian.nrows());
            outcome.report(task, *known, self.joint_velocity.as_slice(), own);
        }
    }

    fn clear_bounds(&mut self) {
        self.active_limits.clear();
        self.active_inequalities.clear();
        self.contradictions.clear();
        self.active_set.clear();
    }

    /// Lists joints whose bounds coincide.
    fn report_pinned(&mut self, problem: &Problem) {
        let bounds = problem.limits.lower().as_slice().iter().zip(problem.limits.upper().as_slice());
        for (joint, (_, &value)) in bounds.enumerate().filter(|(_, (lower, upper))| lower == upper) {
            self.active_limits.push(ActiveLimit { joint, side: Side::Upper, value, multiplier: 0.0 });
        }
    }

    /// Sets active limits, inequalities and rows from the multipliers.
    fn report_bounds(&mut self, problem: &Problem, planned: &PlannedProblem, solution: &Solution) {
        let (lower, upper) = (problem.limits.lower().as_slice(), problem.limits.upper().as_slice());
        let active = |(joint, &multiplier): (usize, &f64)| {
            let (side, bounds) = if multiplier < 0.0 { (Side::Lower, lower) } else { (Side::Upper, upper) };
            let is_active = lower[joint] == upper[joint] || multiplier != 0.0;
            is_active.then_some(ActiveLimit { joint, side, value: bounds[joint], multiplier: multiplier.abs() })
        };
        refill(&mut self.active_limits, solution.multipliers[..lower.len()].iter().enumerate().filter_map(active));
        self.active_inequalities.clear();
        let rows = planned.origins.iter().zip(&solution.row_multipliers);
        for (origin, &multiplier) in rows.filter(|(_, multiplier)| **multiplier != 0.0) {
            match *origin {
                Origin::Inequality(index) => {
                    let inequality = &problem.inequalities[index];
                    self.active_inequalities.push(ActiveInequality {
                        name: inequality.shared_name(),
                        bound: inequality.bound(),
                        // Planned rows have length one.
                        multiplier: multiplier.abs() / inequality.coefficients().norm(),
                    });
                }
                Origin::Task { task, row } => {
                    let side = if multiplier < 0.0 { Side::Lower } else { Side::Upper };
                    self.tasks[task].active_rows.push(ActiveRow { row, side, multiplier: multiplier.abs() });
                }
                Origin::Auxiliary => {}
            }
        }
    }

    fn report_solver(&mut self, path: Path, solution: &Solution) {
        if self.solver.status == Status::Failed {
            self.solver = SolverReport { path, ..SolverReport::default() };
            return;
        }
        self.solver = SolverReport {
            path,
            status: if solution.is_optimal { status(solution.kkt_residual) } else { Status::NotCertified },
            kkt_residual: Some(solution.kkt_residual).filter(|residual| residual.is_finite()),
            rank_uncertain: solution.rank_uncertain,
            working_sets: solution.working_sets,
            ..SolverReport::default()
        };
    }
}

impl TaskOutcome {
    /// Sets the outcome at q̇, whose product with the Jacobian may be known; a scaled task that no limit cuts has the scale 1.
    fn report(&mut self, task: &Task, known: TaskSingularity, joint_velocity: &[f64], achieved: Option<&[f64]>) {
        let rows = task.jacobian.nrows();
        if self.achieved.len() != rows {
            self.achieved = Vector::zeros(rows);
        }
        match achieved {
            Some(achieved) => self.achieved.as_mut_slice().copy_from_slice(achieved),
            None => write_product(&task.jacobian, joint_velocity, self.achieved.as_mut_slice()),
        }
        let bounds = task.lower.as_slice().iter().zip(task.upper.as_slice());
        let mut square = 0.0;
        for (achieved, (lower, upper)) in self.achieved.as_slice().iter().zip(bounds) {
            let (above, below) = (achieved - upper, lower - achieved);
            let missing = if above > below { above } else { below };
            square += if missing > 0.0 { missing * missing } else { 0.0 };
        }
        self.residual_norm = square.sqrt();
        self.rank = known.rank;
        self.algorithmic = known.algorithmic;
        self.scale = task.scaled.then_some(1.0);
        self.active_rows.clear();
    }
}

/// Returns how sure an answer is that meets its optimality conditions up to this residual.
fn status(residual: f64) -> Status {
    if residual <= CERTIFIED { Status::Optimal } else { Status::NotCertified }
}

/// Returns the limits that a velocity breaks.
fn violations<'a>(problem: &'a Problem, joint_velocity: &'a Vector) -> impl Iterator<Item = LimitViolation> + 'a {
    let bounds = problem.limits.lower().as_slice().iter().zip(problem.limits.upper().as_slice());
    let broken = |(joint, (&value, (&lower, &upper))): (usize, (&f64, (&f64, &f64)))| {
        let (side, limit) = if value > upper { (Side::Upper, upper) } else { (Side::Lower, lower) };
        (value > upper || value < lower).then_some(LimitViolation { joint, side, limit, value })
    };
    joint_velocity.as_slice().iter().zip(bounds).enumerate().filter_map(broken)
}
