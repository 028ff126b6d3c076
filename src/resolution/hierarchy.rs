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
    /// Of J_k^RP = [J_k; J_{k+1}^RP], at the top and where something may be singular.
    conditioning: Conditioning,
    /// ρ(J_k^RP).
    rank: usize,
    /// μ_k, damping of the kinematic singularity of J_k.
    pub mu: f64,
    /// λ_k, damping of the conflict of task k with the lower ones.
    pub lambda: f64,
    /// ρ(J_k) + ρ(J_{k+1}^RP) > ρ(J_k^RP). Paper: Eq. (12).
    pub algorithmic: bool,
}

impl Stage {
    /// Becomes the stage of `task` above `below`, undamped.
    fn take(&mut self, task: &Task, below: Option<&Self>) {
        self.J_k.copy_from_matrix(&task.jacobian);
        self.xdot_k.clone_from(&TaskVector::from(&task.velocity));
        self.scaled = task.scaled;
        self.norm = self.J_k.norm();
        self.own.decompose(&self.J_k, 0, self.norm);
        let Some(below) = below else { return self.spare_nothing() };
        self.J_low.copy_from(&below.J_k);
        self.J_low.push_rows(&below.J_low);
        self.norm_low = below.norm.hypot(below.norm_low);
        self.spare_low();
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

    fn condition(&mut self, damping: Option<Damping>) {
        let norm = self.norm.hypot(self.norm_low);
        self.conditioning.update([&self.J_k, &self.J_low], norm, &self.own, (&self.J_low_V, &self.spare), damping);
    }

    /// Nothing is singular: all rows are independent and nothing is damped.
    fn be_regular(&mut self) {
        self.rank = self.J_k.nrows() + self.J_low.nrows();
        (self.mu, self.lambda, self.algorithmic) = (0.0, 0.0, false);
    }

    /// Finds out what is singular here, above `below`, and damps it.
    fn examine(&mut self, below: Option<&Self>, damping: Option<Damping>) {
        self.mu = damp(&mut self.own, &self.J_k, self.norm, damping);
        let Some(below) = below else {
            // What holds of J_k holds of J_k^RP.
            (self.rank, self.lambda, self.algorithmic) = (self.own.rank(), self.mu, false);
            return self.spare_low();
        };
        self.spare_low();
        self.condition(damping);
        self.rank = self.conditioning.rank();
        self.lambda = self.conditioning.damping_factor(damping);
        if self.lambda > 0.0 {
            self.spare.decompose_singular(&self.J_low_V, self.own.rank(), self.norm_low);
        }
        self.algorithmic = self.own.rank() + below.rank > self.rank;
    }
}

/// μ of `J`, for which its decomposition turns to singular values where damping acts.
pub fn damp(decomposition: &mut Decomposition, J: &TaskMatrix, scale: f64, damping: Option<Damping>) -> f64 {
    let Some(damping) = damping.filter(|damping| !decomposition.exceeds(damping.threshold())) else { return 0.0 };
    decomposition.decompose_singular(J, 0, scale);
    damping.factor(decomposition.smallest())
}

/// All J_k, highest priority on top, Σm_k × n, which `J` becomes, and all ẋ_k, in the same order.
pub fn stacked(stages: &[Stage], J: &mut TaskMatrix) -> TaskVector {
    J.reset(0, stages[0].J_k.ncols());
    for stage in stages {
        J.push_rows(&stage.J_k);
    }
    stages.iter().fold(TaskVector::zeros(0), |above, stage| above.concatenated(&stage.xdot_k))
}

/// All stages, index 0 = highest priority.
#[derive(Debug, Clone, Default)]
pub struct Hierarchy {
    pub stages: Vec<Stage>,
}

impl Hierarchy {
    /// Decomposes every J_k and J_k^RP.
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
        let top = &mut self.stages[0];
        top.condition(damping);
        if top.conditioning.is_regular() {
            return self.stages.iter_mut().for_each(Stage::be_regular);
        }
        for k in (0..tasks.len()).rev() {
            let (upper, lower) = self.stages.split_at_mut(k + 1);
            upper[k].examine(lower.first(), damping);
        }
    }

    /// Leaves the same stages with nothing below them to spare: reverse priority on these is Eq. (13).
    pub fn spare_nothing(&mut self) {
        for stage in &mut self.stages {
            stage.spare_nothing();
        }
    }

    /// The highest stage, which contains all rows.
    pub fn top(&self) -> &Stage {
        &self.stages[0]
    }

    /// How near the tasks are to singularities.
    pub fn singularity(&mut self) -> Singularity {
        let algorithmic = self.stages.iter().any(|stage| stage.algorithmic);
        let all = &mut self.stages[0].conditioning;
        Singularity { smallest_singular_value: all.smallest(), manipulability: all.manipulability(), algorithmic }
    }
}
