//! Ranks and smallest singular values of the tasks, and the damping factors that they give.

use revprio_problem::{Damping, Matrix, Task};

use crate::damping::factor;
use crate::svd::{RANK_TOLERANCE, Svd, UNCERTAIN_RANK, norm, stack};

/// What is known of one task.
#[derive(Debug, Clone, Copy, Default)]
pub struct TaskSingularity {
    /// ρ(J_k).
    pub rank: usize,
    /// ρ(J_k) + ρ(J_{k+1}^RP) > ρ(J_k^RP). Paper: Eq. (12).
    pub algorithmic: bool,
    /// μ_k from σ_min(J_k).
    pub mu: f64,
    /// λ_k from σ_min(J_k^RP).
    pub lambda: f64,
}

/// What is known of all tasks. Inequality tasks do not count for the others.
#[derive(Debug, Clone)]
pub struct Singularities {
    /// Per task, highest priority first.
    pub tasks: Vec<TaskSingularity>,
    /// σ_min of all rows together; 0 without rows.
    pub smallest: f64,
    /// Product of their singular values; 0 without rows.
    pub product: f64,
    /// Whether rounding may have decided a rank.
    pub rank_uncertain: bool,
}

impl Singularities {
    /// Examines the tasks from the lowest to the highest, each alone and together with the lower ones.
    pub fn new(tasks: &[Task], damping: Option<Damping>) -> Self {
        let n = tasks.first().map_or(0, |task| task.jacobian.ncols());
        let mut found = Self {
            tasks: vec![TaskSingularity::default(); tasks.len()],
            smallest: 0.0,
            product: 0.0,
            rank_uncertain: false,
        };
        let (mut below, mut rank_below) = (Matrix::zeros(0, n), 0);
        for (k, task) in tasks.iter().enumerate().rev() {
            let own = Svd::new(&task.jacobian);
            let rank = found.rank(&own, norm(&task.jacobian));
            if !task.is_equation() {
                found.tasks[k].rank = rank;
                continue;
            }
            let all_rows = stack(&task.jacobian, &below);
            let all = if below.nrows() == 0 { Svd::new(&task.jacobian) } else { Svd::new(&all_rows) };
            let rank_all = found.rank(&all, norm(&all_rows));
            found.tasks[k] = TaskSingularity {
                rank,
                algorithmic: rank + rank_below > rank_all,
                mu: factor(damping, own.smallest()),
                lambda: factor(damping, all.smallest()),
            };
            found.smallest = all.smallest();
            found.product = all.singular_values().iter().product();
            (below, rank_below) = (all_rows, rank_all);
        }
        found
    }

    fn rank(&mut self, svd: &Svd, norm: f64) -> usize {
        let mut relative = svd.singular_values().iter().map(|sigma| sigma / norm);
        self.rank_uncertain |= relative.any(|sigma| UNCERTAIN_RANK.contains(&sigma));
        svd.rank(RANK_TOLERANCE * norm)
    }
}
