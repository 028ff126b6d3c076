//! The task stack with every decomposition that both ways of solving share.
#![allow(non_snake_case)]

use crate::linalg::{Conditioning, Damping, Decomposition, TaskMatrix, TaskVector};
use crate::task::{Task, TaskStack};

/// How near the tasks are to singularities.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Singularity {
    /// σ_min of all rows together.
    pub smallest_singular_value: f64,
    /// Product of the singular values of all rows together.
    pub manipulability: f64,
    /// Whether a task depends on lower ones although neither is singular by itself. Paper: Eq. (12).
    pub algorithmic: bool,
}

/// Stage k of the recursion: task k and everything below it.
#[derive(Debug, Clone, Default)]
pub struct Stage {
    /// J_k, m_k × n.
    pub J_k: TaskMatrix,
    /// ẋ_k, m_k.
    pub xdot_k: TaskVector,
    /// ‖J_k‖.
    pub norm: f64,
    /// Whether limits may slow the task down, but not bend it.
    pub scaled: bool,
    /// J_{k+1}^RP, the rows of all lower tasks, × n. Paper: Eq. (23).
    pub J_low: TaskMatrix,
    /// ‖J_{k+1}^RP‖.
    pub norm_low: f64,
    /// Decomposition of J_k with the frame V = [V_r, N].
    pub own: Decomposition,
    /// J_{k+1}^RP V.
    pub J_low_V: TaskMatrix,
    /// Decomposition of J_{k+1}^RP N, in that frame.
    pub spare: Decomposition,
    /// ρ(J_k).
    pub rank: usize,
    /// ρ(J_k^RP) of J_k^RP = [J_k; J_{k+1}^RP].
    rank_all: usize,
    /// μ_k, damping of the kinematic singularity of J_k.
    pub mu: f64,
    /// λ_k, damping of the conflict of task k with the lower ones.
    pub lambda: f64,
    /// ρ(J_k) + ρ(J_{k+1}^RP) > ρ(J_k^RP). Paper: Eq. (12).
    pub algorithmic: bool,
}

impl Stage {
    /// Becomes the stage of `task` above `below`, regular until it is examined.
    fn take(&mut self, task: &Task, below: Option<&Self>) {
        self.J_k.copy_from_matrix(&task.jacobian);
        self.xdot_k.clone_from(&TaskVector::from(&task.velocity));
        self.scaled = task.scaled;
        self.norm = self.J_k.norm();
        self.J_low.reset(0, self.J_k.ncols());
        self.norm_low = 0.0;
        if let Some(below) = below {
            self.J_low.copy_from(&below.J_k);
            self.J_low.push_rows(&below.J_low);
            self.norm_low = below.norm.hypot(below.norm_low);
        }
        self.rank = self.J_k.nrows();
        (self.mu, self.lambda, self.algorithmic) = (0.0, 0.0, false);
    }

    /// Decomposes J_k, and finds out whether it is singular.
    fn decompose(&mut self, damping: Option<Damping>) {
        self.own.decompose(&self.J_k, 0, self.norm);
        self.mu = damp(&mut self.own, &self.J_k, self.norm, damping);
        self.rank = self.own.rank();
    }

    /// Decomposes what J_k leaves of the lower rows.
    fn spare_low(&mut self) {
        self.J_low_V.copy_from(&self.J_low);
        self.own.rows_to_frame(&mut self.J_low_V);
        self.J_low_V.without_rounding(self.own.rank(), &self.J_low);
        self.spare.decompose(&self.J_low_V, self.own.rank(), self.norm_low);
    }

    /// Leaves nothing below.
    fn spare_nothing(&mut self) {
        self.J_low.reset(0, self.J_k.ncols());
        self.norm_low = 0.0;
        self.spare_low();
    }

    /// Finds out what is singular here, above `below`, and damps it; `all`: of J_k^RP.
    fn examine(&mut self, all: &Conditioning, below: Option<&Self>, damping: Option<Damping>) {
        self.decompose(damping);
        self.rank_all = all.decomposition().rank();
        self.lambda = all.damping_factor(damping);
        self.spare_low();
        if self.lambda > 0.0 && below.is_some() {
            self.spare.decompose_singular(&self.J_low_V, self.own.rank(), self.norm_low);
        }
        self.algorithmic = below.is_some_and(|below| self.rank + below.rank_all > self.rank_all);
    }
}

/// μ of `J`, for which its decomposition turns to singular values where damping acts.
pub fn damp(decomposition: &mut Decomposition, J: &TaskMatrix, scale: f64, damping: Option<Damping>) -> f64 {
    let Some(damping) = damping.filter(|damping| !decomposition.exceeds(damping.threshold())) else { return 0.0 };
    decomposition.decompose_singular(J, 0, scale);
    damping.factor(decomposition.smallest())
}

/// Rows of one task after the other, highest priority on top.
#[derive(Debug, Clone, Default)]
pub struct Rows {
    /// J, Σm_k × n.
    pub J: TaskMatrix,
    /// ‖J‖.
    pub norm: f64,
    /// ẋ, Σm_k, m/s and rad/s.
    pub xdot: TaskVector,
}

impl Rows {
    /// Becomes those of these stages.
    pub fn stack(&mut self, stages: &[Stage]) {
        self.J.copy_from(&stages[0].J_k);
        self.xdot = stages[0].xdot_k.clone();
        for stage in &stages[1..] {
            self.J.push_rows(&stage.J_k);
            self.xdot = self.xdot.concatenated(&stage.xdot_k);
        }
        self.norm = self.J.norm();
    }
}

/// All stages.
#[derive(Debug, Clone, Default)]
pub struct Hierarchy {
    /// Index 0 = highest priority. They are decomposed unless `is_compatible`.
    pub stages: Vec<Stage>,
    /// The rows of all stages.
    pub all: Rows,
    /// Of these.
    pub conditioning: Conditioning,
    /// Whether no task gives way: all rows are independent, nothing is damped, and every stage spares the lower ones. Then
    /// all tasks are met, by the same vector in every hierarchy.
    pub is_compatible: bool,
    /// The rows from a lower stage on, and their conditioning: room to work in.
    lower: (Rows, Conditioning),
}

impl Hierarchy {
    /// Finds out what gives way, if anything, and decomposes every J_k and J_k^RP if so.
    ///
    /// Where all rows together are far from a singularity, so are those of each stage: taking rows away makes no singular
    /// value smaller than the smallest.
    pub fn update(&mut self, tasks: &TaskStack, damping: Option<Damping>) {
        let tasks = tasks.tasks();
        self.stages.resize_with(tasks.len(), Stage::default);
        for (k, task) in tasks.iter().enumerate().rev() {
            let (upper, lower) = self.stages.split_at_mut(k + 1);
            upper[k].take(task, lower.first());
        }
        self.all.stack(&self.stages);
        self.conditioning.update(&self.all.J, self.all.norm, damping);
        self.is_compatible = self.conditioning.is_regular();
        if !self.is_compatible {
            self.examine(damping);
        }
    }

    /// Decomposes every stage, from the lowest to the highest.
    fn examine(&mut self, damping: Option<Damping>) {
        let (rows, lower) = &mut self.lower;
        for k in (0..self.stages.len()).rev() {
            let all = if k == 0 {
                &self.conditioning
            } else {
                rows.stack(&self.stages[k..]);
                lower.update(&rows.J, rows.norm, damping);
                &*lower
            };
            let (upper, below) = self.stages.split_at_mut(k + 1);
            upper[k].examine(all, below.first(), damping);
        }
    }

    /// Leaves the same stages with nothing below them to spare, so that lower tasks disturb higher ones: reverse priority on
    /// these is Eq. (13).
    pub fn spare_nothing(&mut self, damping: Option<Damping>) {
        for stage in &mut self.stages {
            if self.is_compatible {
                stage.decompose(damping);
            }
            stage.spare_nothing();
        }
        self.is_compatible = false;
    }

    /// The highest stage, which contains all rows.
    pub fn top(&self) -> &Stage {
        &self.stages[0]
    }

    /// How near the tasks are to singularities.
    pub fn singularity(&mut self) -> Singularity {
        let algorithmic = self.stages.iter().any(|stage| stage.algorithmic);
        let all = &mut self.conditioning;
        Singularity { smallest_singular_value: all.smallest(), manipulability: all.manipulability(), algorithmic }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::linalg::{Matrix, Vector};
    use crate::resolution::closed_form::{Descent, least_squares, reverse_priority};

    proptest! {
        #[test]
        fn where_nothing_gives_way_every_hierarchy_ends_at_the_pseudo_inverse(
            entries in prop::collection::vec(-1.0..1.0_f64, 6 * 7 + 6 + 7),
        ) {
            let mut entries = entries.into_iter();
            let mut vector = |m: usize| Vector::from_iterator(m, entries.by_ref().take(m));
            let zeta = TaskVector::from(&vector(7));
            let mut any = |m: usize| Task::new("", Matrix::from_column_slice(m, 7, vector(m * 7).as_slice()), vector(m));
            let tasks = TaskStack::new(vec![any(1), any(3), any(2)]).unwrap();
            let mut hierarchy = Hierarchy::default();
            hierarchy.update(&tasks, Some(Damping::STANDARD));
            prop_assume!(hierarchy.is_compatible);
            let expected = least_squares(&hierarchy.all, hierarchy.conditioning.decomposition(), &zeta, 0.0);
            hierarchy.examine(Some(Damping::STANDARD));
            let recursion = reverse_priority(&hierarchy.stages, zeta.clone());
            let strict = Descent::default().strict_reverse_priority(&hierarchy.stages, None, &zeta);
            for found in [recursion, strict] {
                let error = (&found.joint_velocity - &expected.joint_velocity).norm();
                prop_assert!(error <= 1e-12 * expected.joint_velocity.norm(), "{error:e}");
            }
        }
    }
}
