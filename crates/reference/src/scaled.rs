//! Tasks that are slowed down rather than bent: J_k q̇ = s ẋ_k with the largest s ≤ 1.
//!
//! With an orthonormal basis U of the velocities that J_k can reach next to the higher tasks without limits and
//! d = ẋ_k/‖ẋ_k‖, the unknowns (q̇, r) obey Uᵀ(J_k q̇ − r ν d) = 0 with ν = ‖UᵀJ_k‖, and then r ν = s ‖ẋ_k‖ is as large as
//! possible.

use revprio_problem::{Matrix, Problem, Task, Vector};

use crate::step::Step;
use crate::svd::{RANK_TOLERANCE, Svd, stack};

/// Residual, relative to the speed of the task, up to which its direction counts as kept.
const KEPT: f64 = 1e-9;

/// Residual, relative to the requested speed, that counts as kept where the task comes to rest.
const ROUNDING: f64 = 1e-13;

/// Smallest ν, relative to ‖ẋ‖: slower tasks count as stopped, and r stays a number that can be squared.
const LEAST_UNIT: f64 = 1e-9;

/// Joint speed that counts as rest, rad/s.
const NEGLIGIBLE_SPEED: f64 = 1e-2;

/// The rows Uᵀ[J, −ν d] of a scaled task.
#[derive(Debug, Clone)]
pub struct ScaledTask {
    /// UᵀJ.
    pub rows: Matrix,
    /// −ν Uᵀd.
    pub direction: Vector,
    /// ‖ẋ‖.
    pub speed: f64,
    /// ν.
    pub unit: f64,
    /// ‖J‖.
    norm: f64,
}

impl ScaledTask {
    /// Examines task k, all tasks together in a step of one level; `targets`: the velocities of the equation rows, per task.
    pub fn new(problem: &Problem, step: Step, k: usize, targets: &[Vector]) -> Self {
        let tasks = problem.tasks.tasks();
        let n = problem.tasks.joint_count();
        let own = if step == Step::OneLevel { 0..tasks.len() } else { k..k + 1 };
        let higher = if step == Step::Levels { 0..k } else { 0..0 };
        let jacobian = equation_rows(&tasks[own.clone()], n);
        let above = equation_rows(&tasks[higher], n);
        let velocity = own.filter(|&task| tasks[task].is_equation()).flat_map(|task| targets[task].iter().copied());
        let velocity = Vector::from_vec(velocity.collect());
        let (norm, speed) = (jacobian.norm(), velocity.norm());
        let svd = Svd::new(&above);
        let projector = svd.row_projector(svd.rank(RANK_TOLERANCE * above.norm()));
        let open = Svd::new(&(&jacobian - &jacobian * projector));
        let basis = open.range(open.rank(RANK_TOLERANCE * norm));
        let direction = if speed > 0.0 { velocity / speed } else { velocity };
        let rows = basis.tr_mul(&jacobian);
        let unit = rows.norm().max(LEAST_UNIT * speed);
        Self { rows, direction: basis.tr_mul(&direction) * -unit, speed, unit, norm }
    }

    /// Returns whether q̇ (the first entries of x) moves the task along its direction with the scale s.
    pub fn keeps_direction(&self, x: &Vector, scale: f64) -> bool {
        let qdot = x.rows(0, self.rows.ncols());
        let along = scale * self.speed;
        let unknown = if self.unit > 0.0 { along / self.unit } else { 0.0 };
        let off = &self.rows * qdot + &self.direction * unknown;
        off.amax()
            <= KEPT * (self.norm * qdot.norm() + along.abs()) + ROUNDING * (self.speed + self.norm * NEGLIGIBLE_SPEED)
    }
}

/// Returns the rows of the equations among tasks, highest priority on top.
fn equation_rows<'a>(tasks: impl IntoIterator<Item = &'a Task>, n: usize) -> Matrix {
    let equations = tasks.into_iter().filter(|task| task.is_equation());
    equations.fold(Matrix::zeros(0, n), |above, task| stack(&above, &task.jacobian))
}
