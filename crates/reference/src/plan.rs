//! The problem of each step of a method, with its limits, inequalities and scaled tasks.

use revprio_problem::{BoundId, Matrix, Problem, Vector};

use crate::hierarchy::{Hierarchy, Level};
use crate::scaled::ScaledTask;
use crate::step::Step;

/// What a step aims at.
#[derive(Debug, Clone)]
pub struct Aim {
    /// The velocity of each equation row, per task.
    pub targets: Vec<Vector>,
    /// q̇'.
    pub before: Vector,
    /// λ of the damping rows: of the one level, or of the lower tasks of a stage.
    pub lambda: f64,
    /// The tasks that are slowed down in their direction.
    pub scaled: Vec<Option<ScaledTask>>,
}

impl Aim {
    /// Returns the aim of the first step: the requested velocities, from ζ̇.
    pub fn new(problem: &Problem) -> Self {
        let tasks = problem.tasks.tasks();
        let n = problem.tasks.joint_count();
        Self {
            targets: tasks.iter().map(|task| task.lower.clone()).collect(),
            before: problem.null_space_velocity.clone().unwrap_or_else(|| Vector::zeros(n)),
            lambda: 0.0,
            scaled: tasks.iter().map(|_| None).collect(),
        }
    }
}

/// Poses one step of a plan; `limits`: whether the limits and inequalities of the problem apply in the last step.
pub fn pose(problem: &Problem, step: Step, aim: &Aim, limits: bool) -> Hierarchy {
    let mut posed = Posed::new(problem, step, aim, limits);
    let tasks = problem.tasks.tasks();
    match step {
        Step::OneLevel => posed.push_one_level(),
        Step::Levels => (0..tasks.len()).for_each(|k| posed.push_task_level(k)),
        Step::Stage { task, keeps_lower_tasks } => {
            posed.push_task_level(task);
            if keeps_lower_tasks {
                posed.push_lower_tasks(task);
            }
        }
    }
    posed.hierarchy
}

/// A hierarchy while it is posed.
struct Posed<'a> {
    problem: &'a Problem,
    aim: &'a Aim,
    knows_inequalities: bool,
    /// The unknown r of each scaled task, its speed along the request.
    speeds: Vec<Option<usize>>,
    hierarchy: Hierarchy,
}

impl<'a> Posed<'a> {
    fn new(problem: &'a Problem, step: Step, aim: &'a Aim, limits: bool) -> Self {
        let mut hierarchy = Hierarchy::new(aim.before.clone());
        let mut speeds = vec![None; aim.scaled.len()];
        if limits && step.is_last() {
            hierarchy.lower = problem.limits.lower().as_slice().to_vec();
            hierarchy.upper = problem.limits.upper().as_slice().to_vec();
            for (k, scaled) in aim.scaled.iter().enumerate() {
                if let Some(scaled) = scaled {
                    speeds[k] = Some(hierarchy.lower.len());
                    hierarchy.lower.push(0.0);
                    hierarchy.upper.push(scaled.speed / scaled.unit);
                    hierarchy.reference = hierarchy.reference.push(0.0);
                }
            }
            push_inequalities(problem, &mut hierarchy);
        }
        Self { problem, aim, knows_inequalities: limits, speeds, hierarchy }
    }

    fn level(&self) -> Level {
        Level::new(self.hierarchy.unknowns())
    }

    fn push_one_level(&mut self) {
        let tasks = self.problem.tasks.tasks();
        let mut level = self.level();
        let scaled = self.speeds.iter().position(Option::is_some);
        for k in (0..tasks.len()).filter(|&k| scaled.is_none() || !tasks[k].is_equation()) {
            self.add_task(&mut level, k);
        }
        if let Some(k) = scaled {
            // A stack has one velocity, so that it is scaled as a whole.
            self.push_scaled(k, level);
        } else {
            level.push_damping(self.aim.lambda, &self.aim.before);
            self.hierarchy.push(level);
        }
    }

    /// Adds a task as a level of its own, or as two where it is scaled.
    fn push_task_level(&mut self, k: usize) {
        let mut level = self.level();
        if self.speeds[k].is_some() {
            self.push_scaled(k, level);
        } else {
            self.add_task(&mut level, k);
            self.hierarchy.push(level);
        }
    }

    /// Adds the level of the tasks below task k at what q̇' achieved. An inequality row may move inside its bounds, and not
    /// further outside than it is.
    fn push_lower_tasks(&mut self, k: usize) {
        let tasks = self.problem.tasks.tasks();
        if k + 1 == tasks.len() {
            return;
        }
        let mut level = self.level();
        for (index, task) in tasks.iter().enumerate().skip(k + 1) {
            if !self.knows_inequalities && !task.is_equation() {
                continue;
            }
            let achieved = &task.jacobian * &self.aim.before;
            let rows = 0..achieved.len();
            let is_equation = |row: usize| task.lower[row] == task.upper[row];
            let lower: Vec<f64> = rows
                .clone()
                .map(|row| if is_equation(row) { achieved[row] } else { achieved[row].min(task.lower[row]) })
                .collect();
            let upper: Vec<f64> = rows
                .map(|row| if is_equation(row) { achieved[row] } else { achieved[row].max(task.upper[row]) })
                .collect();
            level.push(&task.jacobian, &lower, &upper, |row| Some(BoundId::Task { index, row }));
        }
        level.push_damping(self.aim.lambda, &self.aim.before);
        self.hierarchy.push(level);
    }

    /// Adds the rows of a task; its equations aim at their targets.
    fn add_task(&self, level: &mut Level, k: usize) {
        let task = &self.problem.tasks.tasks()[k];
        if !self.knows_inequalities && !task.is_equation() {
            return;
        }
        let bounds = |bounds: &Vector| -> Vec<f64> {
            let bound = |row: usize| {
                if task.lower[row] == task.upper[row] { self.aim.targets[k][row] } else { bounds[row] }
            };
            (0..bounds.len()).map(bound).collect()
        };
        let (lower, upper) = (bounds(&task.lower), bounds(&task.upper));
        level.push(&task.jacobian, &lower, &upper, |row| Some(BoundId::Task { index: k, row }));
    }

    /// Adds the two levels of a scaled task: its direction, with the rows of `level`, then its speed r ν → ‖ẋ‖.
    fn push_scaled(&mut self, k: usize, mut level: Level) {
        let (Some(unknown), Some(scaled)) = (self.speeds[k], &self.aim.scaled[k]) else { return };
        let (n, total) = (self.problem.tasks.joint_count(), self.hierarchy.unknowns());
        let count = scaled.rows.nrows();
        let mut direction = Matrix::zeros(count, total);
        direction.columns_mut(0, n).copy_from(&scaled.rows);
        direction.column_mut(unknown).copy_from(&scaled.direction);
        level.push(&direction, &vec![0.0; count], &vec![0.0; count], |_| None);
        self.hierarchy.push(level);
        let mut speed = Matrix::zeros(1, total);
        speed[(0, unknown)] = scaled.unit;
        let mut level = self.level();
        level.push(&speed, &[scaled.speed], &[scaled.speed], |_| None);
        self.hierarchy.push(level);
    }
}

/// Adds the levels of the hard inequalities, with rows of length one: they are violated by the least joint speed.
fn push_inequalities(problem: &Problem, hierarchy: &mut Hierarchy) {
    let mut levels: Vec<(u8, Level)> = Vec::new();
    for (id, inequality) in problem.constraint_rows() {
        if levels.last().is_none_or(|(above, _)| *above != inequality.level()) {
            levels.push((inequality.level(), Level::new(hierarchy.unknowns())));
        }
        let Some((_, level)) = levels.last_mut() else { continue };
        let norm = inequality.coefficients().norm();
        let norm = if norm > 0.0 { norm } else { 1.0 };
        let row = Matrix::from_row_slice(1, inequality.coefficients().len(), inequality.coefficients().as_slice());
        level.push(&(row / norm), &[f64::NEG_INFINITY], &[inequality.bound() / norm], |_| Some(id));
    }
    for (_, level) in levels {
        hierarchy.push(level);
    }
}
