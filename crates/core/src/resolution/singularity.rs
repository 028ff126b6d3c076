//! How near the tasks are to singularities, and how much damping that asks for.

use std::ops::Range;

use revprio_problem::{Damping, EquationRows, Problem, Singularity, Task, TaskStack};

use super::plan::uses_factors;
use super::solution::refill;
use super::solver::SizedSolver;
use crate::linalg::{
    DampingFactor, SingularValues, add_outer_square, distance_square, dot, eigenvalues_exceed, smallest_and_product,
};
use crate::tolerances::TOLERANCES;

/// Returns the singular value from which on no damping acts and all methods that agree in exact arithmetic agree to nearly all
/// digits, for rows of this Frobenius norm.
fn regular_from(damping: Option<Damping>, norm: f64) -> f64 {
    damping.map_or(0.0, |damping| damping.threshold()).max(TOLERANCES.well_conditioned * norm)
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
}

impl TaskSingularity {
    /// Returns that of a task whose rows are independent of each other and of all others.
    fn independent(task: &Task) -> Self {
        Self { rank: task.jacobian.nrows(), ..Self::default() }
    }
}

/// The singularities of all tasks at one posture.
#[derive(Debug, Default)]
pub struct Singularities {
    /// Per task, highest priority first.
    pub tasks: Vec<TaskSingularity>,
    /// Whether all equations are independent and nothing is damped: then every method but `singularity_robust`, and
    /// `reverse_priority` with inequality tasks, ends at the same velocity, the solution without limits.
    pub is_regular: bool,
    /// Whether rounding may have decided a rank.
    pub rank_uncertain: bool,
    singular: SingularValues,
    /// Whether they are those of all rows.
    knows_all: bool,
    gram: Vec<f64>,
    /// The rows that are examined, n entries each.
    rows: Vec<f64>,
    /// Rows of an earlier period whose smallest singular value is at least `reference_bound`.
    reference: EquationRows,
    reference_bound: f64,
    /// Their Frobenius norm.
    reference_norm: f64,
}

impl Singularities {
    /// Writes what was found of these tasks.
    pub fn write(&self, tasks: &TaskStack, singularity: &mut Singularity) {
        singularity.algorithmic = self.tasks.iter().any(|task| task.algorithmic);
        if self.knows_all {
            singularity.set(self.singular.smallest(), self.singular.product());
        } else {
            singularity.set_rows(tasks.tasks(), smallest_and_product);
        }
    }

    /// Returns whether all equations are certainly far from singular because those of an earlier period were: no singular value
    /// changes by more than the Frobenius norm of the change of the rows (Weyl). Sets what follows.
    ///
    /// 1/‖A⁺‖_F changes by no more than that either, and [`Self::examine`] compares it with the same number.
    pub fn remain_regular(&mut self, tasks: &TaskStack, damping: Option<Damping>) -> bool {
        let list = tasks.tasks();
        let Some(distance) = distance(&self.reference, list) else { return false };
        let least = regular_from(damping, self.reference_norm + distance) * (1.0 + TOLERANCES.singular_value_margin);
        if !(self.reference_bound - distance > least) {
            return false;
        }
        refill(&mut self.tasks, list.iter().map(TaskSingularity::independent));
        (self.is_regular, self.rank_uncertain, self.knows_all) = (true, false, false);
        true
    }

    /// Examines the singular values of all equations, which `solver` has factorised; `norm`: their Frobenius norm. `keep`: keeps a close bound of them for
    /// [`Self::remain_regular`] in later periods.
    pub fn examine(
        &mut self,
        problem: &Problem,
        norm: f64,
        solver: &mut dyn SizedSolver,
        has_only_equations: bool,
        keep: bool,
    ) {
        let (list, damping) = (problem.tasks.tasks(), problem.damping);
        self.rank_uncertain = solver.rank_uncertain();
        let threshold = damping.map_or(0.0, |damping| damping.threshold());
        let certain = TOLERANCES.certain_rank * norm;
        let regular = regular_from(damping, norm);
        let sure = if keep { f64::INFINITY } else { regular };
        let smallest = solver.bound_smallest(norm, sure, threshold.max(certain));
        self.is_regular = smallest >= regular;
        self.reference.clear();
        if keep && self.is_regular && has_only_equations {
            self.reference.set(list);
            (self.reference_bound, self.reference_norm) = (smallest, norm);
        }
        refill(&mut self.tasks, list.iter().map(TaskSingularity::independent));
        for (k, task) in list.iter().enumerate().filter(|(_, task)| !task.is_equation()) {
            self.gather(std::iter::once(task));
            self.tasks[k].rank = self.rank_and_factor(task.jacobian.ncols(), 0..task.jacobian.nrows(), None).0;
        }
        self.knows_all = false;
        let damping = damping.filter(|_| uses_factors(problem.method));
        let independent = damping.map_or(certain, |damping| damping.threshold().max(certain));
        if !(smallest >= independent) {
            self.examine_each(list, damping);
        }
    }

    /// Examines each equation task alone and together with the lower ones, from the lowest to the highest.
    fn examine_each(&mut self, tasks: &[Task], damping: Option<Damping>) {
        let n = tasks.first().map_or(0, |task| task.jacobian.ncols());
        self.gather(tasks.iter().filter(|task| task.is_equation()));
        let end = self.rows.len() / n.max(1);
        let (mut start, mut below) = (end, (0, 0.0));
        for (k, task) in tasks.iter().enumerate().rev().filter(|(_, task)| task.is_equation()) {
            let own = start - task.jacobian.nrows()..start;
            start = own.start;
            let (rank, mu) = self.rank_and_factor(n, own.clone(), damping);
            // The lowest task is alone already.
            let all = if own.end < end { self.rank_and_factor(n, start..end, damping) } else { (rank, mu) };
            let algorithmic = rank + below.0 > all.0;
            self.tasks[k] = TaskSingularity { rank, algorithmic, mu, lambda: all.1 };
            below = all;
        }
    }

    /// Writes the rows of tasks one after the other.
    fn gather<'a>(&mut self, tasks: impl Iterator<Item = &'a Task>) {
        self.rows.clear();
        for task in tasks {
            let (m, entries) = (task.jacobian.nrows(), task.jacobian.as_slice());
            (0..m).for_each(|row| self.rows.extend(entries[row..].iter().step_by(m)));
        }
    }

    /// Returns the rank of a range of the gathered rows, and the damping factor for their smallest singular value.
    fn rank_and_factor(&mut self, n: usize, range: Range<usize>, damping: Option<Damping>) -> (usize, f64) {
        let rows = &self.rows[range.start * n..range.end * n];
        let (m, square) = (range.len(), dot(rows, rows));
        let (short, norm) = (m.min(n), square.sqrt());
        let threshold = damping.map_or(0.0, |damping| damping.threshold());
        let is_far = exceeds(rows, n, threshold.max(TOLERANCES.certain_rank * norm), &mut self.gram);
        self.knows_all = !is_far && rows.len() == self.rows.len();
        if is_far {
            return (short, 0.0);
        }
        if m <= n {
            self.singular.decompose(n, rows.iter().copied());
        } else {
            self.singular.decompose(m, (0..n).flat_map(|j| rows[j..].iter().step_by(n).copied()));
        }
        let rank = self.singular.count_from(TOLERANCES.rank * norm);
        let damping = damping.filter(|damping| !self.singular.is_above(damping.threshold()));
        (rank, damping.map_or(0.0, |damping| damping.factor(self.singular.smallest())))
    }
}

/// Returns whether all singular values of a matrix certainly exceed `bound`; `rows`: n entries each, `gram`: scratch.
///
/// The product of the matrix with its transpose is exact to the rounding of its trace.
fn exceeds(rows: &[f64], n: usize, bound: f64, gram: &mut Vec<f64>) -> bool {
    let m = rows.len() / n;
    gram.clear();
    if m <= n {
        for row in rows.chunks_exact(n) {
            gram.extend(rows.chunks_exact(n).map(|other| dot(row, other)));
        }
    } else {
        gram.resize(n * n, 0.0);
        rows.chunks_exact(n).for_each(|row| add_outer_square(gram, row));
    }
    let size = m.min(n);
    let trace: f64 = gram.iter().step_by(size + 1).sum();
    let rounding = TOLERANCES.rounding * trace;
    // Squares that underflow decide nothing.
    (rounding.is_normal() || size == 0) && eigenvalues_exceed(gram, size, bound * bound + rounding)
}

/// Returns ‖A − A'‖_F for the rows A of the tasks and the rows A' of `other`; `None` if `other` has no rows, if the sizes
/// differ, or if a task is not an equation.
fn distance(other: &EquationRows, tasks: &[Task]) -> Option<f64> {
    let heights = tasks.iter().map(|task| if task.is_equation() { task.jacobian.nrows() } else { 0 });
    if other.heights().is_empty() || !heights.eq(other.heights().iter().copied()) {
        return None;
    }
    let (mut square, mut rest) = (0.0, other.entries());
    for task in tasks {
        let entries = task.jacobian.as_slice();
        square += distance_square(entries, rest.split_off(..entries.len())?);
    }
    rest.is_empty().then(|| f64::sqrt(square))
}
