//! How near the tasks are to singularities, and how much damping that asks for.

use super::level::{Hierarchy, Solution, refill};
use super::solver::HierarchicalSolver;
use crate::linalg::{Damping, RANK_TOLERANCE, SingularValues, Triangle};
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
    singular: SingularValues,
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
        let regular = threshold.max(WELL_CONDITIONED * norm);
        let smallest = if is_full { solver.last().bound_smallest(regular, independent) } else { f64::NAN };
        self.is_regular = smallest >= regular;
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
            self.decompose(task.jacobian.ncols(), std::slice::from_ref(task));
            self.tasks[k].rank = self.rank(task.jacobian.norm());
        }
    }

    /// Evaluates the optimality conditions of [`Self::unlimited`] right after [`Self::examine`]; returns whether they hold.
    pub fn certify(&mut self, solver: &mut HierarchicalSolver) -> bool {
        solver.last().certify(&mut self.unlimited);
        self.unlimited.is_optimal
    }

    /// Examines each equation task alone and together with the lower ones, from the lowest to the highest.
    fn examine_each(&mut self, tasks: &[Task], damping: Option<Damping>, solver: &mut HierarchicalSolver) {
        // The smallest singular value is only computed where it matters.
        let factor = |singular: &SingularValues| {
            damping
                .filter(|damping| !singular.is_above(damping.threshold()))
                .map_or(0.0, |damping| damping.factor(singular.smallest()))
        };
        let n = self.problem.unknowns;
        let mut level = self.problem.level_ends.len();
        let lowest = tasks.iter().rposition(Task::is_equation);
        let (mut norm_square, mut rank_below) = (0.0, 0);
        self.all.algorithmic = false;
        self.decompose(n, &[]);
        for k in (0..tasks.len()).rev().filter(|&k| tasks[k].is_equation()) {
            level -= 1;
            let norm = tasks[k].jacobian.norm();
            self.decompose(n, &tasks[k..=k]);
            let (rank, mu) = (self.rank(norm), factor(&self.singular));
            norm_square += norm * norm;
            // The lowest task is alone already.
            if Some(k) != lowest {
                self.decompose(n, &tasks[k..]);
            }
            let rank_all = self.rank(norm_square.sqrt());
            let algorithmic = rank + rank_below > rank_all;
            let strict = damping.map_or(0.0, |damping| damping.factor(solver.last().smallest_of_level(level)));
            self.tasks[k] = TaskSingularity { rank, algorithmic, mu, lambda: factor(&self.singular), strict };
            rank_below = rank_all;
            self.all.algorithmic |= algorithmic;
        }
        self.all.known = Some(self.singular.smallest());
        let product = self.singular.product().min(f64::MAX);
        self.all.manipulability = if lowest.is_none() { 0.0 } else { product };
    }

    /// Decomposes the rows of these tasks without inequality tasks, or of one task.
    fn decompose(&mut self, n: usize, tasks: &[Task]) {
        let own = |task: &&Task| tasks.len() == 1 || task.is_equation();
        let rows = || tasks.iter().filter(own).flat_map(|task| (0..task.jacobian.nrows()).map(move |row| (task, row)));
        let m = rows().count();
        if m <= n {
            self.singular.decompose(n, rows().flat_map(|(task, row)| (0..n).map(move |j| task.jacobian[(row, j)])));
        } else {
            self.singular.decompose(m, (0..n).flat_map(|j| rows().map(move |(task, row)| task.jacobian[(row, j)])));
        }
    }

    fn rank(&self, norm: f64) -> usize {
        self.singular.count_from(RANK_TOLERANCE * norm)
    }
}

/// Adds the rows of a task to the level that ends next.
pub fn push_task(problem: &mut Hierarchy, task: &Task) {
    problem.push_matrix(&task.jacobian, |row| task.lower[row], |row| task.upper[row]);
}
