//! A hierarchy as plain numbers: levels of rows with bounds, joint limits and a reference velocity.

use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Matrix, Vector};
use revprio_core::resolution::{ActiveSet, BoundId, Method, Problem, Resolution, resolve};
use revprio_core::task::{Task, TaskStack};

/// A row lower ≤ a·q̇ ≤ upper; an equation if both bounds are equal.
#[derive(Debug, Clone)]
pub struct Row {
    pub coefficients: Vec<f64>,
    pub lower: f64,
    pub upper: f64,
}

/// Levels of rows, highest priority first, joint limits, and the reference velocity ζ̇.
#[derive(Debug, Clone)]
pub struct Hierarchy {
    pub lower: Vec<f64>,
    pub upper: Vec<f64>,
    pub reference: Vec<f64>,
    pub levels: Vec<Vec<Row>>,
}

impl Row {
    /// Returns a·q̇.
    pub fn value(&self, velocity: &[f64]) -> f64 {
        self.coefficients.iter().zip(velocity).map(|(a, x)| a * x).sum()
    }

    /// Returns by how much a·q̇ is outside its bounds.
    pub fn slack(&self, velocity: &[f64]) -> f64 {
        let value = self.value(velocity);
        (value - self.upper).max(self.lower - value).max(0.0)
    }
}

impl Hierarchy {
    /// Returns the names of all bounds: those of the joints, then those of the rows.
    pub fn bound_ids(&self) -> impl Iterator<Item = BoundId> {
        let rows = self.levels.iter().enumerate();
        let rows = rows.flat_map(|(index, level)| (0..level.len()).map(move |row| BoundId::Task { index, row }));
        (0..self.joint_count()).map(BoundId::Joint).chain(rows)
    }

    pub fn joint_count(&self) -> usize {
        self.lower.len()
    }

    /// Returns the problem that the solver gets, with one task per level.
    pub fn problem(&self) -> Problem {
        let n = self.joint_count();
        let task = |(k, rows): (usize, &Vec<Row>)| {
            let jacobian = Matrix::from_fn(rows.len(), n, |i, j| rows[i].coefficients[j]);
            let bounds = |of: fn(&Row) -> f64| Vector::from_iterator(rows.len(), rows.iter().map(of));
            let (lower, upper) = (bounds(|row| row.lower), bounds(|row| row.upper));
            let name = format!("task {}", k + 1);
            if lower == upper { Task::new(name, jacobian, lower) } else { Task::between(name, jacobian, lower, upper) }
        };
        let tasks = TaskStack::new(self.levels.iter().enumerate().map(task).collect()).unwrap();
        let limits = VelocityBox::new(&self.lower, &self.upper).unwrap();
        let null_space_velocity = Some(Vector::from_row_slice(&self.reference));
        Problem { limits, method: Method::StrictReversePriority, null_space_velocity, ..Problem::new(tasks) }
    }

    /// Solves the problem from an initial working set, or from none.
    pub fn solve(&self, guess: &[ActiveSet]) -> Resolution {
        resolve(&self.problem(), guess).unwrap()
    }

    /// Returns ‖A_k‖, the Frobenius norm of a level.
    pub fn norm(&self, level: usize) -> f64 {
        self.levels[level].iter().flat_map(|row| &row.coefficients).map(|a| a * a).sum::<f64>().sqrt()
    }

    /// Returns ‖b_k‖ over the finite bounds of a level.
    fn bounds_norm(&self, level: usize) -> f64 {
        let size = |bound: f64| if bound.is_finite() { bound.abs() } else { 0.0 };
        self.levels[level].iter().map(|row| size(row.lower).max(size(row.upper)).powi(2)).sum::<f64>().sqrt()
    }

    /// Returns the joint speed that rows and reference ask for, to which errors of velocities are relative.
    pub fn speed(&self) -> f64 {
        let asked = |level| if self.norm(level) > 0.0 { self.bounds_norm(level) / self.norm(level) } else { 0.0 };
        (0..self.levels.len()).map(asked).fold(length(&self.reference), f64::max)
    }

    /// Returns the size of the numbers that a level subtracts, to which errors of its slack are relative.
    pub fn size(&self, level: usize, velocity: &[f64]) -> f64 {
        self.bounds_norm(level) + self.norm(level) * self.speed().max(length(velocity))
    }

    /// Returns the norm of the slack of each level.
    pub fn slacks(&self, velocity: &[f64]) -> Vec<f64> {
        let slack = |rows: &Vec<Row>| length(&rows.iter().map(|row| row.slack(velocity)).collect::<Vec<_>>());
        self.levels.iter().map(slack).collect()
    }

    /// Returns the distance from the reference.
    pub fn distance(&self, velocity: &[f64]) -> f64 {
        length(&velocity.iter().zip(&self.reference).map(|(x, reference)| x - reference).collect::<Vec<_>>())
    }
}

/// Returns the Euclidean norm.
pub fn length(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}
