//! A method as a list of hierarchical problems. This is the only place that knows the methods.
//!
//! The problems are solved in order, and each one starts from the answer q̇' of the one before, at first ζ̇:
//!
//! | method | problems |
//! |---|---|
//! | `strict_reverse_priority`, `task_priority` | one: the tasks as levels, with limits |
//! | `reverse_priority` | stages k = l … 1: task k, then the lower tasks at what q̇' achieved, then min ‖q̇ − q̇'‖; limits at stage 1 |
//! | `singularity_robust` | the same stages without the second level |
//! | `pseudoinverse`, `damped_least_squares` | one: all rows as one level, with limits |
//!
//! Hard inequalities are a level above the tasks wherever limits apply. Damping first gives the velocities that the tasks then
//! aim at (`targets`), or it is a part of a level: rows λ (q̇ − q̇') next to the rows of the level.

use revprio_problem::{ActiveSet, Bound, BoundId, Method, Problem, Task};

use super::level::{Hierarchy, Solution, WorkingSet, refill};
use crate::linalg::row_times;

/// One problem of a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// All rows are one level.
    OneLevel,
    /// Each task is a level, highest priority first.
    Levels,
    /// Task k, above the lower tasks if it disturbs them as little as possible.
    Stage {
        /// The task, 0 = highest priority.
        task: usize,
        /// Whether lower tasks are kept as far as possible.
        keeps_lower_tasks: bool,
    },
}

impl Step {
    /// Returns whether limits apply: they belong to the last problem of a plan.
    pub fn is_last(self) -> bool {
        !matches!(self, Self::Stage { task, .. } if task > 0)
    }

    /// Returns whether this problem is needed only for what the next one keeps of the lower tasks.
    pub fn only_keeps_lower_tasks(self) -> bool {
        matches!(self, Self::Stage { task, keeps_lower_tasks: true } if task > 0)
    }

    /// Returns whether this problem reaches for task k rather than keeping what it achieves.
    pub fn reaches(self, k: usize) -> bool {
        !matches!(self, Self::Stage { task, .. } if task != k)
    }
}

/// Returns the problems of the method for `tasks` tasks, in the order of solution.
pub fn steps(method: Method, tasks: usize) -> impl Iterator<Item = Step> {
    let stage = |keeps_lower_tasks| move |task| Step::Stage { task, keeps_lower_tasks };
    let (single, stages) = match method {
        Method::Pseudoinverse | Method::DampedLeastSquares => (Some(Step::OneLevel), None),
        Method::TaskPriority | Method::StrictReversePriority => (Some(Step::Levels), None),
        Method::SingularityRobust => (None, Some((0..tasks).rev().map(stage(false)))),
        Method::ReversePriority => (None, Some((0..tasks).rev().map(stage(true)))),
    };
    single.into_iter().chain(stages.into_iter().flatten())
}

/// Returns the problem whose equations show how near the tasks are to singularities: the last one, if it holds the rows of all
/// tasks.
pub fn examined_step(method: Method) -> Step {
    match method {
        Method::Pseudoinverse | Method::DampedLeastSquares => Step::OneLevel,
        Method::ReversePriority => Step::Stage { task: 0, keeps_lower_tasks: true },
        Method::TaskPriority | Method::StrictReversePriority | Method::SingularityRobust => Step::Levels,
    }
}

/// Returns whether a level that holds all rows is damped.
pub fn damps_one_level(method: Method) -> bool {
    method == Method::DampedLeastSquares
}

/// How a scaled task takes part.
#[derive(Debug, Clone, PartialEq)]
pub enum Scaling {
    /// As any other task: the limits do not cut it, or no scale keeps its direction.
    Off,
    /// Uᵀ(J q̇ − r d) = 0, then r → ‖ẋ‖.
    On {
        /// Uᵀ[J, −d], one row after the other.
        rows: Vec<f64>,
        /// ‖ẋ‖.
        speed: f64,
    },
}

/// One problem with the meaning of its rows.
#[derive(Debug, Clone, Default)]
pub struct PlannedProblem {
    /// The levels.
    pub levels: Hierarchy,
    /// Per row.
    pub origins: Vec<Option<BoundId>>,
    /// The unknown r of each scaled task, its speed along the request.
    pub scale_unknowns: Vec<Option<usize>>,
}

/// What the rows of the tasks aim at in one step.
pub struct Aim<'a> {
    /// The velocity of each row that is an equation, all tasks one after the other.
    pub targets: &'a [f64],
    /// q̇', the answer of the problem before; n.
    pub before: &'a [f64],
    /// Factor of the damping rows: of the one level, or of the lower tasks of a stage.
    pub damping: f64,
    /// Per task.
    pub scaling: &'a [Scaling],
    /// Whether q̇' meets every lower task, so that these are kept at their targets and q̇' itself need not be known: any
    /// velocity that differs from it by a combination of their rows serves as well, such as ζ̇.
    pub lower_tasks_are_met: bool,
}

impl PlannedProblem {
    /// Writes one problem of the plan.
    pub fn write(&mut self, problem: &Problem, step: Step, aim: &Aim) {
        self.start(problem, step, aim);
        let tasks = problem.tasks.tasks();
        match step {
            Step::OneLevel => {
                if let Some(scaled) = aim.scaling.iter().position(|scaling| *scaling != Scaling::Off) {
                    // A stack has one velocity, so that it is scaled as a whole.
                    for k in (0..tasks.len()).filter(|&k| !tasks[k].is_equation()) {
                        self.push_task(problem, k, aim);
                    }
                    self.push_scaled(problem, scaled, aim);
                } else {
                    (0..tasks.len()).for_each(|k| self.push_task(problem, k, aim));
                    self.push_damping(aim);
                    self.levels.end_level();
                }
            }
            Step::Levels => {
                for k in 0..tasks.len() {
                    self.push_level(problem, k, aim);
                }
            }
            Step::Stage { task, keeps_lower_tasks } => {
                self.push_level(problem, task, aim);
                if keeps_lower_tasks && task + 1 < tasks.len() {
                    for lower in task + 1..tasks.len() {
                        if aim.lower_tasks_are_met {
                            self.push_task(problem, lower, aim);
                        } else {
                            self.push_kept_task(problem, lower, aim.before);
                        }
                    }
                    self.push_damping(aim);
                    self.levels.end_level();
                }
            }
        }
    }

    /// Sets unknowns, limits and the hard inequalities.
    fn start(&mut self, problem: &Problem, step: Step, aim: &Aim) {
        self.levels.clear(aim.before);
        self.origins.clear();
        refill(&mut self.scale_unknowns, std::iter::repeat_n(None, aim.scaling.len()));
        if !step.is_last() {
            return;
        }
        self.levels.lower.copy_from_slice(problem.limits.lower().as_slice());
        self.levels.upper.copy_from_slice(problem.limits.upper().as_slice());
        for (scaling, unknown) in aim.scaling.iter().zip(&mut self.scale_unknowns) {
            if let Scaling::On { speed, .. } = scaling {
                *unknown = Some(self.levels.push_unknown(0.0, *speed));
            }
        }
        for (id, inequality) in problem.constraint_rows() {
            // Rows of length one: they are broken by the least joint speed.
            let norm = inequality.coefficients().norm();
            let norm = if norm > 0.0 { norm } else { 1.0 };
            let coefficients = inequality.coefficients().iter().map(|entry| entry / norm);
            self.push_row(Some(id), coefficients, f64::NEG_INFINITY, inequality.bound() / norm);
        }
        self.levels.end_level();
    }

    /// Adds a task as a level of its own, or as two where it is scaled.
    fn push_level(&mut self, problem: &Problem, k: usize, aim: &Aim) {
        if self.scale_unknowns[k].is_some() {
            self.push_scaled(problem, k, aim);
        } else {
            self.push_task(problem, k, aim);
            self.levels.end_level();
        }
    }

    /// Adds the two levels of a scaled task: its direction, then its speed r → ‖ẋ‖.
    fn push_scaled(&mut self, problem: &Problem, k: usize, aim: &Aim) {
        let (Some(unknown), Scaling::On { rows, speed }) = (self.scale_unknowns[k], &aim.scaling[k]) else { return };
        let (n, total) = (problem.tasks.joint_count(), self.levels.unknowns);
        for row in rows.chunks_exact(n + 1) {
            let entry = |j: usize| {
                if j < n {
                    row[j]
                } else if j == unknown {
                    row[n]
                } else {
                    0.0
                }
            };
            self.push_row(None, (0..total).map(entry), 0.0, 0.0);
        }
        self.levels.end_level();
        self.push_row(None, (0..total).map(|j| if j == unknown { 1.0 } else { 0.0 }), *speed, *speed);
        self.levels.end_level();
    }

    /// Adds the rows of a task.
    fn push_task(&mut self, problem: &Problem, k: usize, aim: &Aim) {
        let task = &problem.tasks.tasks()[k];
        let targets = &aim.targets[problem.tasks.first_row(k)..][..task.jacobian.nrows()];
        if task.is_equation() {
            self.levels.push_equations(&task.jacobian, targets);
            self.push_origins(task, k);
            return;
        }
        let bound = |row: usize, bound: f64| if task.lower[row] == task.upper[row] { targets[row] } else { bound };
        self.push_task_rows(task, k, |row| bound(row, task.lower[row]), |row| bound(row, task.upper[row]));
    }

    /// Adds the rows of a lower task at what `before` achieves. An inequality row may move inside its bounds, and not further
    /// outside than it is.
    fn push_kept_task(&mut self, problem: &Problem, k: usize, before: &[f64]) {
        let task = &problem.tasks.tasks()[k];
        let bounds = |row: usize| {
            let achieved = row_times(&task.jacobian, row, before);
            let (lower, upper) = (task.lower[row], task.upper[row]);
            if lower == upper { (achieved, achieved) } else { (lower.min(achieved), upper.max(achieved)) }
        };
        self.push_task_rows(task, k, |row| bounds(row).0, |row| bounds(row).1);
    }

    fn push_task_rows(&mut self, task: &Task, k: usize, lower: impl Fn(usize) -> f64, upper: impl Fn(usize) -> f64) {
        self.levels.push_matrix(&task.jacobian, lower, upper);
        self.push_origins(task, k);
    }

    fn push_origins(&mut self, task: &Task, k: usize) {
        self.origins.extend((0..task.jacobian.nrows()).map(|row| Some(BoundId::Task { index: k, row })));
    }

    /// Adds the rows λ q̇ = λ q̇'.
    fn push_damping(&mut self, aim: &Aim) {
        if aim.damping > 0.0 {
            for (i, &before) in aim.before.iter().enumerate() {
                let row = (0..aim.before.len()).map(|j| if i == j { aim.damping } else { 0.0 });
                self.push_row(None, row, aim.damping * before, aim.damping * before);
            }
        }
    }

    /// Adds a row with coefficients for the joints; those of other unknowns are zero.
    fn push_row(
        &mut self,
        origin: Option<BoundId>,
        coefficients: impl IntoIterator<Item = f64>,
        lower: f64,
        upper: f64,
    ) {
        self.levels.push_row(coefficients, lower, upper);
        self.origins.push(origin);
    }

    /// Returns J_k q̇ of all tasks in their order from a solution of this problem, if its rows are the `rows` of the tasks and no
    /// others; otherwise nothing.
    pub fn task_values<'a>(&self, rows: usize, solution: &'a Solution) -> &'a [f64] {
        let has_tasks_alone = self.origins.len() == rows
            && self.origins.iter().all(|origin| matches!(origin, Some(BoundId::Task { .. })));
        if has_tasks_alone { &solution.row_values } else { &[] }
    }

    /// Writes the working set that a guess means in this problem; bounds that it does not have are left out.
    pub fn write_guess(&self, guess: &[ActiveSet], set: &mut WorkingSet) {
        set.clear(self.levels.unknowns, self.levels.row_count());
        set.hold(guess);
        // Names ascend in a guess and in a problem, so that each search begins where the last one ended.
        let mut at = 0;
        for bound in guess.iter().flatten().filter(|bound| !matches!(bound.id, BoundId::Joint(_))) {
            let is_it = |origin: &Option<BoundId>| *origin == Some(bound.id);
            let found = self.origins[at..].iter().position(is_it).map(|after| at + after);
            if let Some(row) = found.or_else(|| self.origins[..at].iter().position(is_it)) {
                set.rows[row] = Some(bound.side);
                at = row;
            }
        }
    }

    /// Writes the active bounds of a working set for n joints, ascending.
    pub fn write_active_set(&self, n: usize, set: &WorkingSet, active: &mut ActiveSet) {
        let joints = set.unknowns[..n].iter().enumerate().map(|(joint, side)| (Some(BoundId::Joint(joint)), side));
        let rows = self.origins.iter().copied().zip(&set.rows);
        active.clear();
        active.extend(joints.chain(rows).filter_map(|(id, side)| Some(Bound { id: id?, side: (*side)? })));
    }
}
