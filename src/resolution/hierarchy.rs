//! The task stack with every decomposition that both ways of solving share.
#![allow(non_snake_case)]

use crate::linalg::{Damping, Matrix, Svd, SvdError, Vector, stack};
use crate::task::TaskStack;

/// How near the tasks are to singularities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Singularity {
    /// σ_min of all rows together.
    pub smallest_singular_value: f64,
    /// Product of the singular values of all rows together.
    pub manipulability: f64,
    /// Whether a task depends on lower ones although neither is singular by itself. Paper: Eq. (12).
    pub algorithmic: bool,
}

/// Stage k of the recursion: task k and everything below it.
pub struct Stage {
    /// J_k, m_k × n.
    pub J_k: Matrix,
    /// ẋ_k, m_k.
    pub xdot_k: Vector,
    /// Whether limits may slow the task down, but not bend it.
    pub scaled: bool,
    /// J_{k+1}^RP, the rows of all lower tasks, × n. Paper: Eq. (23).
    pub J_low: Matrix,
    /// Decomposition of J_k.
    pub svd: Svd,
    /// Decomposition of J_k^RP = [J_k; J_{k+1}^RP].
    pub svd_rp: Svd,
    /// μ_k, damping of the kinematic singularity of J_k.
    pub mu: f64,
    /// λ_k, damping of the conflict of task k with the lower ones.
    pub lambda: f64,
    /// ρ(J_k) + ρ(J_{k+1}^RP) > ρ(J_k^RP). Paper: Eq. (12).
    pub algorithmic: bool,
}

/// All stages, index 0 = highest priority.
pub struct Hierarchy {
    pub stages: Vec<Stage>,
}

impl Hierarchy {
    /// Decomposes every J_k and J_k^RP once.
    pub fn new(tasks: &TaskStack, damping: Option<Damping>) -> Result<Self, SvdError> {
        let mut stages: Vec<Stage> = Vec::with_capacity(tasks.tasks().len());
        let mut J_low = Matrix::zeros(0, tasks.joint_count());
        for task in tasks.tasks().iter().rev() {
            let J_rp = stack(&task.jacobian, &J_low);
            let svd = Svd::new(&task.jacobian)?;
            let svd_rp = Svd::new(&J_rp)?;
            let low_rank = stages.last().map_or(0, |stage| stage.svd_rp.rank());
            stages.push(Stage {
                mu: svd.damping_factor(damping),
                lambda: svd_rp.damping_factor(damping),
                algorithmic: svd.rank() + low_rank > svd_rp.rank(),
                J_k: task.jacobian.clone(),
                xdot_k: task.velocity.clone(),
                scaled: task.scaled,
                J_low,
                svd,
                svd_rp,
            });
            J_low = J_rp;
        }
        stages.reverse();
        Ok(Self { stages })
    }

    /// The same stages with nothing below them to spare: reverse priority on these is Eq. (13).
    pub fn sparing_nothing(mut self) -> Self {
        for stage in &mut self.stages {
            stage.J_low = Matrix::zeros(0, stage.J_low.ncols());
        }
        self
    }

    /// The highest stage, which contains all rows.
    pub fn top(&self) -> &Stage {
        &self.stages[0]
    }

    /// How near the tasks are to singularities.
    pub fn singularity(&self) -> Singularity {
        Singularity {
            smallest_singular_value: self.top().svd_rp.smallest(),
            manipulability: self.top().svd_rp.manipulability(),
            algorithmic: self.stages.iter().any(|stage| stage.algorithmic),
        }
    }
}
