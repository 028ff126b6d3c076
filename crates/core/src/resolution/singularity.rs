//! How near the tasks are to singularities, and how much damping that asks for.

use super::level::{Hierarchy, Solution, refill};
use super::solver::HierarchicalSolver;
use crate::linalg::{Damping, RANK_TOLERANCE, Triangle, write_singular_values};
use crate::task::{Task, TaskStack};

/// Fraction of ‖J‖ from which on a smallest singular value makes all rows certainly independent.
const INDEPENDENT: f64 = 1e-6;

/// Fraction of ‖J‖ from which on all methods that agree in exact arithmetic agree to nearly all digits.
const WELL_CONDITIONED: f64 = 1e-3;

/// How near the tasks are to singularities. Inequality tasks do not count.
#[derive(Debug, Clone, Default)]
pub struct Singularity {
    /// Product of the singular values of all rows together.
    pub manipulability: f64,
    /// Whether a task depends on lower ones although neither is singular by itself. Paper: Eq. (12).
    pub algorithmic: bool,
    /// σ_min where it is known; otherwise `triangle` has the singular values.
    known: Option<f64>,
    triangle: Triangle,
}

impl Singularity {
    /// Computes σ_min of all rows together; 0 without rows. No decision of the resolution needs the value where it is far from
    /// zero, so it is computed on demand.
    pub fn smallest_singular_value(&self) -> f64 {
        self.known.unwrap_or_else(|| self.triangle.smallest_singular_value())
    }

    /// Copies without giving up memory.
    pub(super) fn copy_from(&mut self, other: &Self) {
        (self.manipulability, self.algorithmic, self.known) = (other.manipulability, other.algorithmic, other.known);
        self.triangle.copy_from(&other.triangle);
    }
}

impl PartialEq for Singularity {
    fn eq(&self, other: &Self) -> bool {
        let values = |it: &Self| (it.manipulability, it.algorithmic, it.smallest_singular_value());
        values(self) == values(other)
    }
}

/// The singularities of one task, and the damping factors that they give.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TaskSingularity {
    /// ρ(J_k).
    pub rank: usize,
    /// ρ(J_k) + ρ(J_{k+1}^RP) > ρ(J_k^RP). Paper: Eq. (12).
    pub algorithmic: bool,
    /// μ_k from σ_min(J_k): the kinematic singularity of the task itself.
    pub mu: f64,
    /// λ_k from σ_min(J_k^RP): the conflict of the task with the lower ones.
    pub lambda: f64,
    /// Damping of the strict hierarchy, from σ_min of J_k in the null space of all higher tasks.
    pub strict: f64,
}

/// The singularities of all tasks at one posture.
#[derive(Debug, Default)]
pub struct Singularities {
    /// Per task, highest priority first.
    pub tasks: Vec<TaskSingularity>,
    /// Of all tasks together.
    pub all: Singularity,
    /// Whether all equations are independent and nothing is damped: then every method but `singularity_robust`, and
    /// `reverse_priority` with inequality tasks, ends at the same velocity, the solution of [`Self::unlimited`].
    pub is_regular: bool,
    /// Whether no task has inequality rows.
    pub has_only_equations: bool,
    /// All equations as a strict hierarchy without limits, and its solution.
    pub problem: Hierarchy,
    pub unlimited: Solution,
    block: Vec<f64>,
    sigma: Vec<f64>,
}

impl Singularities {
    /// Solves the equations without limits and examines their singular values.
    pub fn examine(
        &mut self,
        tasks: &TaskStack,
        zeta: &[f64],
        damping: Option<Damping>,
        solver: &mut HierarchicalSolver,
    ) {
        let list = tasks.tasks();
        self.problem.clear(zeta);
        for task in list.iter().filter(|task| task.is_equation()) {
            push_task(&mut self.problem, task);
            self.problem.end_level();
        }
        solver.of_width(self.problem.unknowns).solve_without_bounds(&self.problem, &mut self.unlimited);
        refill(&mut self.tasks, std::iter::repeat_n(TaskSingularity::default(), list.len()));
        self.has_only_equations = self.problem.level_ends.len() == list.len();
        let norm = solver.last().norm();
        let threshold = damping.map_or(0.0, |damping| damping.threshold());
        let rank: usize = self.unlimited.level_ranks.iter().sum();
        let is_full = rank == self.problem.row_count() && rank > 0;
        let independent = threshold.max(INDEPENDENT * norm);
        let smallest = if is_full { solver.last().bound_smallest(independent) } else { f64::NAN };
        self.is_regular = smallest >= threshold.max(WELL_CONDITIONED * norm);
        if smallest >= independent {
            self.all.manipulability = solver.last().pivot_product().min(f64::MAX);
            (self.all.algorithmic, self.all.known) = (false, None);
            solver.last().write_triangle(&mut self.all.triangle);
            for (known, task) in self.tasks.iter_mut().zip(list) {
                known.rank = task.jacobian.nrows();
            }
        } else {
            self.examine_each(list, damping, solver);
        }
        if self.has_only_equations {
            return;
        }
        for (k, task) in list.iter().enumerate().filter(|(_, task)| !task.is_equation()) {
            self.write_sigma(task.jacobian.ncols(), std::iter::once(task));
            self.tasks[k].rank = rank_of(&self.sigma, task.jacobian.norm());
        }
    }

    /// Evaluates the optimality conditions of [`Self::unlimited`] right after [`Self::examine`]; returns whether they hold.
    pub fn certify(&mut self, solver: &mut HierarchicalSolver) -> bool {
        solver.last().certify(&mut self.unlimited);
        self.unlimited.is_optimal
    }

    /// Examines each equation task alone and together with the lower ones, from the lowest to the highest.
    fn examine_each(&mut self, tasks: &[Task], damping: Option<Damping>, solver: &mut HierarchicalSolver) {
        let factor = |sigma: f64| damping.map_or(0.0, |damping| damping.factor(sigma));
        let n = self.problem.unknowns;
        let mut level = self.problem.level_ends.len();
        let (mut norm_square, mut rank_below) = (0.0, 0);
        self.all.algorithmic = false;
        self.sigma.clear();
        for k in (0..tasks.len()).rev().filter(|&k| tasks[k].is_equation()) {
            level -= 1;
            let norm = tasks[k].jacobian.norm();
            self.write_sigma(n, std::iter::once(&tasks[k]));
            let (rank, mu) = (rank_of(&self.sigma, norm), factor(smallest(&self.sigma)));
            norm_square += norm * norm;
            self.write_sigma(n, tasks[k..].iter().filter(|task| task.is_equation()));
            let rank_all = rank_of(&self.sigma, norm_square.sqrt());
            let algorithmic = rank + rank_below > rank_all;
            let strict = damping.map_or(0.0, |_| factor(solver.last().smallest_of_level(level)));
            self.tasks[k] = TaskSingularity { rank, algorithmic, mu, lambda: factor(smallest(&self.sigma)), strict };
            rank_below = rank_all;
            self.all.algorithmic |= algorithmic;
        }
        self.all.known = Some(smallest(&self.sigma));
        let product = self.sigma.iter().product::<f64>().min(f64::MAX);
        self.all.manipulability = if self.sigma.is_empty() { 0.0 } else { product };
    }

    /// Writes the min(m, n) singular values of the rows of these tasks.
    fn write_sigma<'a>(&mut self, n: usize, tasks: impl Iterator<Item = &'a Task> + Clone) {
        let m: usize = tasks.clone().map(|task| task.jacobian.nrows()).sum();
        self.block.clear();
        self.block.resize(m * n, 0.0);
        let mut row = 0;
        for task in tasks {
            for i in 0..task.jacobian.nrows() {
                for j in 0..n {
                    let place = if m <= n { row * n + j } else { j * m + row };
                    self.block[place] = task.jacobian[(i, j)];
                }
                row += 1;
            }
        }
        write_singular_values(&mut self.block, m.max(n), &mut self.sigma);
    }
}

/// Adds the rows of a task to the level that ends next.
pub fn push_task(problem: &mut Hierarchy, task: &Task) {
    problem.push_matrix(&task.jacobian, |row| task.lower[row], |row| task.upper[row]);
}

fn rank_of(sigma: &[f64], norm: f64) -> usize {
    sigma.iter().take_while(|&&sigma| sigma > RANK_TOLERANCE * norm).count()
}

fn smallest(sigma: &[f64]) -> f64 {
    sigma.last().copied().unwrap_or(0.0)
}
