//! Tasks that are slowed down rather than bent: J_k q̇ = s ẋ_k with the largest s ≤ 1.
//!
//! With an orthonormal basis U of the velocities that J_k can reach next to the higher tasks without limits and d = ẋ_k/‖ẋ_k‖,
//! the unknowns (q̇, r) obey Uᵀ(J_k q̇ − r ν d) = 0, and then r ν = s ‖ẋ_k‖ is as large as possible: two levels in place of one.
//! The unknown is a speed and not the scale, and ν = ‖UᵀJ_k‖, so that neither a large request nor the unit of the rows makes
//! them ill-conditioned.

use revprio_problem::Problem;

use super::plan::{Scaling, Step};
use crate::linalg::{Matrix, Svd, Vector, stack};
use crate::tolerances::TOLERANCES;

/// Smallest ν, relative to ‖ẋ‖: slower tasks count as stopped, and r stays a number that can be squared.
const LEAST_UNIT: f64 = 1e-9;

/// The direction rows of the task that was examined last.
#[derive(Default)]
pub struct ScaledTasks {
    /// Uᵀ[J, −ν d], row by row, n + 1 entries each.
    rows: Vec<f64>,
    columns: usize,
    /// ‖J‖, ‖ẋ‖ and ν.
    norm: f64,
    size: f64,
    unit: f64,
}

impl ScaledTasks {
    /// Examines task k.
    pub fn examine(&mut self, problem: &Problem, step: Step, k: usize, targets: &[f64]) {
        let tasks = problem.tasks.tasks();
        let n = problem.tasks.joint_count();
        let equations = |range: std::ops::Range<usize>| range.filter(|&task| tasks[task].is_equation());
        let (own, higher) = match step {
            Step::OneLevel => (0..tasks.len(), 0..0),
            Step::Levels => (k..k + 1, 0..k),
            Step::Stage { .. } => (k..k + 1, 0..0),
        };
        let rows_of = |tasks_of: std::ops::Range<usize>| {
            equations(tasks_of).fold(Matrix::zeros(0, n), |above, task| stack(&above, &tasks[task].jacobian))
        };
        let (jacobian, above) = (rows_of(own.clone()), rows_of(higher));
        let velocity = equations(own).flat_map(|task| {
            let first = problem.tasks.first_row(task);
            targets[first..first + tasks[task].jacobian.nrows()].iter().copied()
        });
        let velocity = Vector::from_vec(velocity.collect());
        self.norm = jacobian.norm();
        self.size = velocity.norm();
        let svd = Svd::new(&above);
        let rank = svd.rank(TOLERANCES.rank * above.norm());
        let open = &jacobian - &jacobian * svd.inverse(rank, 0.0) * &above;
        let open = Svd::new(&open);
        let basis = open.range(open.rank(TOLERANCES.rank * self.norm));
        let direction = if self.size > 0.0 { velocity / self.size } else { velocity };
        let rows = basis.tr_mul(&jacobian);
        self.unit = rows.norm().max(LEAST_UNIT * self.size);
        let last = basis.tr_mul(&direction) * -self.unit;
        self.columns = n + 1;
        self.rows.clear();
        for i in 0..rows.nrows() {
            self.rows.extend(rows.row(i).iter().copied().chain([last[i]]));
        }
    }

    /// Returns how the task is scaled; `Off` for a task at rest, which has no direction.
    pub fn scaling(&self) -> Scaling {
        if self.size > 0.0 {
            Scaling::On { rows: self.rows.clone(), speed: self.size, unit: self.unit }
        } else {
            Scaling::Off
        }
    }

    /// Returns whether q̇ (the first n entries of `x`) moves the task along its direction with the scale s.
    pub fn keeps_direction(&self, x: &[f64], scale: f64) -> bool {
        let (speed_along, unit) = (scale * self.size, self.unit);
        let qdot = &x[..self.columns - 1];
        let speed = qdot.iter().map(|x| x * x).sum::<f64>().sqrt();
        let unknown = if unit > 0.0 { speed_along / unit } else { 0.0 };
        let off = |row: &[f64]| row.iter().zip(qdot.iter().chain([&unknown])).map(|(a, x)| a * x).sum::<f64>().abs();
        let kept =
            TOLERANCES.scaled_direction * (self.norm * speed + speed_along.abs()) + TOLERANCES.scaled_rest * self.size;
        self.rows.chunks_exact(self.columns).all(|row| off(row) <= kept)
    }
}
