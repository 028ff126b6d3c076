//! How near the tasks are to singularities, and how much damping that asks for.

use std::ops::Range;

use revprio_problem::{Damping, EquationRows, Problem, Singularity, Task, TaskStack};

use super::solution::refill;
use super::solver::SizedSolver;
use crate::linalg::{DampingFactor, SingularValues, distance_square, smallest_and_product};
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
    /// σ_min of all rows together and the product of their singular values, where a decision needed them.
    known: Option<(f64, f64)>,
    /// Whether all equations are independent and nothing is damped: then every method but `singularity_robust`, and
    /// `reverse_priority` with inequality tasks, ends at the same velocity, the solution without limits.
    pub is_regular: bool,
    /// Whether rounding may have decided a rank.
    pub rank_uncertain: bool,
    singular: SingularValues,
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
        match self.known {
            Some((smallest, product)) => singularity.set(smallest, product),
            None => singularity.set_rows(tasks.tasks(), smallest_and_product),
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
        (self.is_regular, self.rank_uncertain) = (true, false);
        self.known = None;
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
        let independent = threshold.max(TOLERANCES.certain_rank * norm);
        let regular = regular_from(damping, norm);
        let sure = if keep { f64::INFINITY } else { regular };
        let smallest = solver.bound_smallest(norm, sure, independent);
        self.is_regular = smallest >= regular;
        self.reference.clear();
        if keep && self.is_regular && has_only_equations {
            self.reference.set(list);
            (self.reference_bound, self.reference_norm) = (smallest, norm);
        }
        if smallest >= independent {
            self.known = None;
            refill(&mut self.tasks, list.iter().map(TaskSingularity::independent));
        } else {
            refill(&mut self.tasks, std::iter::repeat_n(TaskSingularity::default(), list.len()));
            self.examine_each(problem);
        }
        if has_only_equations {
            return;
        }
        for (k, task) in list.iter().enumerate().filter(|(_, task)| !task.is_equation()) {
            self.gather(std::iter::once(task));
            self.decompose(task.jacobian.ncols(), 0..task.jacobian.nrows());
            self.tasks[k].rank = self.rank(task.jacobian.norm());
        }
    }

    /// Examines each equation task alone and together with the lower ones, from the lowest to the highest.
    fn examine_each(&mut self, problem: &Problem) {
        let (tasks, damping) = (problem.tasks.tasks(), problem.damping);
        // The smallest singular value is only computed where it matters.
        let factor = |singular: &SingularValues| {
            damping
                .filter(|damping| !singular.is_above(damping.threshold()))
                .map_or(0.0, |damping| damping.factor(singular.smallest()))
        };
        let n = problem.tasks.joint_count();
        self.gather(tasks.iter().filter(|task| task.is_equation()));
        let end = self.rows.len() / n;
        let (mut start, mut norm_square, mut rank_below) = (end, 0.0, 0);
        self.decompose(n, end..end);
        for (k, task) in tasks.iter().enumerate().rev().filter(|(_, task)| task.is_equation()) {
            let own = start - task.jacobian.nrows()..start;
            start = own.start;
            let norm = task.jacobian.norm();
            self.decompose(n, own.clone());
            let (rank, mu) = (self.rank(norm), factor(&self.singular));
            norm_square += norm * norm;
            // The lowest task is alone already.
            if own.end < end {
                self.decompose(n, start..end);
            }
            let rank_all = self.rank(norm_square.sqrt());
            let algorithmic = rank + rank_below > rank_all;
            self.tasks[k] = TaskSingularity { rank, algorithmic, mu, lambda: factor(&self.singular) };
            rank_below = rank_all;
        }
        let product = if end == 0 { 0.0 } else { self.singular.product().min(f64::MAX) };
        self.known = Some((self.singular.smallest(), product));
    }

    /// Writes the rows of tasks one after the other.
    fn gather<'a>(&mut self, tasks: impl Iterator<Item = &'a Task>) {
        self.rows.clear();
        for task in tasks {
            let (m, entries) = (task.jacobian.nrows(), task.jacobian.as_slice());
            (0..m).for_each(|row| self.rows.extend(entries[row..].iter().step_by(m)));
        }
    }

    /// Decomposes a range of the gathered rows.
    fn decompose(&mut self, n: usize, range: Range<usize>) {
        let m = range.len();
        let rows = &self.rows[range.start * n..range.end * n];
        if m <= n {
            self.singular.decompose(n, rows.iter().copied());
        } else {
            self.singular.decompose(m, (0..n).flat_map(|j| rows[j..].iter().step_by(n).copied()));
        }
    }

    fn rank(&self, norm: f64) -> usize {
        self.singular.count_from(TOLERANCES.rank * norm)
    }
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
