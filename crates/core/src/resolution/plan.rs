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
//! Hard inequalities are levels above the tasks wherever limits apply. Damping first gives the velocities that the tasks then
//! aim at (`targets`), or it is a part of a level: rows λ (q̇ − q̇') next to the rows of the level.

use revprio_problem::{BoundId, Method, Problem};

use super::hierarchy::{Demand, Hierarchy};
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
    let count = if matches!(step(method, 0), Step::Stage { .. }) { tasks } else { 1 };
    (0..count).rev().map(move |task| step(method, task))
}

/// Returns the problem of the method for task k; most methods have one problem for all tasks.
fn step(method: Method, task: usize) -> Step {
    match method {
        Method::Pseudoinverse | Method::DampedLeastSquares => Step::OneLevel,
        Method::TaskPriority | Method::StrictReversePriority => Step::Levels,
        Method::SingularityRobust => Step::Stage { task, keeps_lower_tasks: false },
        Method::ReversePriority => Step::Stage { task, keeps_lower_tasks: true },
    }
}

/// Returns the problem whose equations show how near the tasks are to singularities: the last one, if it holds the rows of all
/// tasks.
pub fn examined_step(method: Method) -> Step {
    if method == Method::SingularityRobust { Step::Levels } else { step(method, 0) }
}

/// Returns whether a level that holds all rows is damped.
pub fn damps_one_level(method: Method) -> bool {
    method == Method::DampedLeastSquares
}

/// Returns whether the damping of each task has a factor of its own, from the singular values of that task or of those below.
pub fn uses_factors(method: Method) -> bool {
    !matches!(step(method, 0), Step::Levels)
}

/// How a scaled task takes part.
#[derive(Debug, Clone, PartialEq)]
pub enum Scaling {
    /// As any other task: the limits do not cut it, or no scale keeps its direction.
    Off,
    /// Uᵀ(J q̇ − r ν d) = 0, then r ν → ‖ẋ‖.
    On {
        /// Uᵀ[J, −ν d], one row after the other.
        rows: Vec<f64>,
        /// ‖ẋ‖.
        speed: f64,
        /// ν > 0.
        unit: f64,
    },
}

/// What the rows of the tasks aim at in one step.
pub struct Aim<'a> {
    /// The velocity of each row that is an equation, all tasks one after the other.
    pub targets: &'a [f64],
    /// q̇', the answer of the problem before; n.
    pub before: &'a [f64],
    /// Factor of the damping rows: of the one level, or of the lower tasks of a stage.
    pub damping: f64,
    /// Per task; empty without scaled tasks.
    pub scaling: &'a [Scaling],
    /// Whether q̇' meets every lower task, so that these are kept at their targets and q̇' itself need not be known: any
    /// velocity that differs from it by a combination of their rows serves as well, such as ζ̇.
    pub lower_tasks_are_met: bool,
}

/// Writes one problem of the plan.
pub fn write(levels: &mut Hierarchy, problem: &Problem, step: Step, aim: &Aim) {
    let count = problem.tasks.tasks().len();
    let mut writer = Writer { levels, problem, aim };
    writer.start(step);
    match step {
        Step::OneLevel => {
            if let Some(scaled) = aim.scaling.iter().position(|scaling| *scaling != Scaling::Off) {
                // A stack has one velocity, so that it is scaled as a whole.
                for k in (0..count).filter(|&k| !problem.tasks.tasks()[k].is_equation()) {
                    writer.push_task(k);
                }
                writer.push_level(scaled);
            } else {
                (0..count).for_each(|k| writer.push_task(k));
                writer.end_damped_level();
            }
        }
        Step::Levels => (0..count).for_each(|k| writer.push_level(k)),
        Step::Stage { task, keeps_lower_tasks } => {
            writer.push_level(task);
            if keeps_lower_tasks && task + 1 < count {
                for lower in task + 1..count {
                    if aim.lower_tasks_are_met {
                        writer.push_task(lower);
                    } else {
                        writer.push_kept_task(lower);
                    }
                }
                writer.end_damped_level();
            }
        }
    }
}

/// Returns the unknown r of the scaled task k, its speed along the request: those of all scaled tasks follow the n joints.
pub fn scale_unknown(n: usize, scaling: &[Scaling], k: usize) -> usize {
    n + scaling[..k].iter().filter(|scaling| **scaling != Scaling::Off).count()
}

struct Writer<'a> {
    levels: &'a mut Hierarchy,
    problem: &'a Problem,
    aim: &'a Aim<'a>,
}

impl Writer<'_> {
    /// Sets unknowns, limits and the hard inequalities.
    fn start(&mut self, step: Step) {
        let Self { levels, problem, aim } = self;
        levels.clear(aim.before);
        if !step.is_last() {
            return;
        }
        let n = levels.unknowns;
        levels.lower[..n].copy_from_slice(problem.limits.lower().as_slice());
        levels.upper[..n].copy_from_slice(problem.limits.upper().as_slice());
        for scaling in aim.scaling {
            if let Scaling::On { speed, unit, .. } = scaling {
                levels.push_unknown(0.0, speed / unit);
            }
        }
        let mut level = None;
        for (id, inequality) in problem.constraint_rows() {
            if level.replace(inequality.level()).is_some_and(|above| above != inequality.level()) {
                levels.end_level();
            }
            // Rows of length one: they are broken by the least joint speed.
            let norm = inequality.coefficients().norm();
            let norm = if norm > 0.0 { norm } else { 1.0 };
            let demand = Demand::between(f64::NEG_INFINITY, inequality.bound() / norm, Some(id));
            levels.push_row(inequality.coefficients().iter().map(|entry| entry / norm), demand);
        }
        levels.end_level();
    }

    /// Adds a task as a level of its own; a scaled task as two: its direction, then its speed r ν → ‖ẋ‖.
    fn push_level(&mut self, k: usize) {
        let Some(Scaling::On { rows, speed, unit }) = self.aim.scaling.get(k) else {
            self.push_task(k);
            self.levels.end_level();
            return;
        };
        let n = self.problem.tasks.joint_count();
        let unknown = scale_unknown(n, self.aim.scaling, k);
        let others = || std::iter::repeat_n(0.0, unknown - n);
        for row in rows.chunks_exact(n + 1) {
            self.levels.push_equation(row[..n].iter().copied().chain(others()).chain([row[n]]), 0.0);
        }
        self.levels.end_level();
        self.levels.push_equation(std::iter::repeat_n(0.0, unknown).chain([*unit]), *speed);
        self.levels.end_level();
    }

    /// Adds the rows of a task.
    fn push_task(&mut self, k: usize) {
        let Self { levels, problem, aim } = self;
        let task = &problem.tasks.tasks()[k];
        let (lower, upper) = (task.lower.as_slice(), task.upper.as_slice());
        let targets = &aim.targets[problem.tasks.first_row(k)..][..lower.len()];
        levels.push_matrix(&task.jacobian, |row| {
            let origin = Some(BoundId::Task { index: k, row });
            let (lower, upper, target) = (lower[row], upper[row], targets[row]);
            if lower == upper { Demand::equal(target, origin) } else { Demand::between(lower, upper, origin) }
        });
    }

    /// Adds the rows of a lower task at what q̇' achieves. An inequality row may move inside its bounds, and not further
    /// outside than it is.
    fn push_kept_task(&mut self, k: usize) {
        let task = &self.problem.tasks.tasks()[k];
        let before = self.aim.before;
        self.levels.push_matrix(&task.jacobian, |row| {
            let origin = Some(BoundId::Task { index: k, row });
            let achieved = row_times(&task.jacobian, row, before);
            let (lower, upper) = (task.lower[row], task.upper[row]);
            if lower == upper {
                Demand::equal(achieved, origin)
            } else {
                Demand::between(lower.min(achieved), upper.max(achieved), origin)
            }
        });
    }

    /// Adds the rows λ q̇ = λ q̇', and ends the level.
    fn end_damped_level(&mut self) {
        if self.aim.damping > 0.0 {
            self.levels.push_near(self.aim.damping, self.aim.before);
        }
        self.levels.end_level();
    }
}
