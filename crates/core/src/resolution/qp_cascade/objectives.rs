//! Which least-squares problems the cascade solves, one after the other.
#![allow(non_snake_case)]

use std::ops::Deref;

use crate::linalg::{Damping, TaskMatrix, TaskVector};
use crate::resolution::certificate::relative;
use crate::resolution::closed_form::Descent;
use crate::resolution::hierarchy::{Hierarchy, Stage};

/// One level: minimise ‖A q̇ − b‖², then keep the first `kept` entries of A q̇.
#[derive(Default)]
pub struct Objective {
    /// A, m × n.
    pub A: TaskMatrix,
    /// ‖A‖.
    pub norm: f64,
    /// b, m.
    pub b: TaskVector,
    /// Rows of A whose value later levels must not change: all of them, or those that are not damping.
    pub kept: usize,
    /// Norm of these rows.
    pub norm_kept: f64,
    /// Whether limits may slow the task down, but not bend it.
    pub scaled: bool,
}

impl Objective {
    /// min ‖A q̇ − b‖².
    pub fn exact(A: TaskMatrix, b: TaskVector) -> Self {
        let mut objective = Self { A, ..Self::default() };
        objective.aim(b, false);
        objective
    }

    /// Becomes min ‖A q̇ − b‖² with the A that it has, or A q̇ = s b with the largest s ≤ 1 if the task is to be `scaled`.
    fn aim(&mut self, b: TaskVector, scaled: bool) {
        self.kept = self.A.nrows();
        self.norm = self.A.norm();
        self.norm_kept = self.norm;
        (self.b, self.scaled) = (b, scaled);
    }

    /// The same for A = J.
    fn reach(&mut self, J: &TaskMatrix, xdot: TaskVector, scaled: bool) {
        self.A.copy_from(J);
        self.aim(xdot, scaled);
    }

    /// Adds factor² ‖q̇ − reference‖².
    fn damp(&mut self, factor: f64, reference: &TaskVector) {
        if factor > 0.0 {
            self.A.push_rows(&(&TaskMatrix::identity(reference.len()) * factor));
            self.b = self.b.concatenated(&(reference * factor));
            self.norm = self.A.norm();
        }
    }

    /// Becomes min ‖q̇ − reference‖².
    fn stay_near(&mut self, reference: &TaskVector) {
        self.A.become_identity(reference.len());
        self.aim(reference.clone(), false);
    }

    /// The entries of A q̇ that later levels must not change.
    pub fn kept_value(&self, qdot: &TaskVector) -> TaskVector {
        let value = &self.A * qdot;
        if self.is_exact() { value } else { value.first(self.kept) }
    }

    /// How far later levels moved them from `value`, relative to the size of the level at velocities up to ‖q̇‖ = `speed`.
    pub fn drift(&self, value: &TaskVector, qdot: &TaskVector, speed: f64) -> f64 {
        relative((&self.kept_value(qdot) - value).amax(), self.norm * speed + self.b.norm())
    }

    /// Whether all of A q̇ is kept, so that the level's multipliers prove which limits stay active.
    pub fn is_exact(&self) -> bool {
        self.kept == self.A.nrows()
    }
}

/// The levels of a stage, highest first; those of earlier stages are overwritten.
#[derive(Default)]
pub struct Objectives {
    levels: Vec<Objective>,
    count: usize,
}

impl Deref for Objectives {
    type Target = [Objective];

    fn deref(&self) -> &[Objective] {
        &self.levels[..self.count]
    }
}

impl Objectives {
    /// One more level, to be overwritten.
    fn add(&mut self) -> &mut Objective {
        self.count += 1;
        if self.levels.len() < self.count {
            self.levels.push(Objective::default());
        }
        &mut self.levels[self.count - 1]
    }

    /// One stack: reach it, then stay near ζ̇.
    ///
    /// A stack of which a task is to be scaled is scaled as a whole: it has one velocity. Damping then forms that velocity
    /// first, J (ζ̇ + J^# (ẋ − J ζ̇)).
    pub fn become_stack(&mut self, hierarchy: &Hierarchy, factor: f64, zeta: &TaskVector) {
        self.count = 0;
        let Hierarchy { stages, all, conditioning, .. } = hierarchy;
        let reach = self.add();
        if stages.iter().any(|stage| stage.scaled) {
            let error = &all.xdot - &(&all.J * zeta);
            let given_up = conditioning.decomposition().damping_loss(&error, factor);
            reach.reach(&all.J, &all.xdot - &given_up, true);
        } else {
            reach.reach(&all.J, all.xdot.clone(), false);
            reach.damp(factor, zeta);
        }
        self.add().stay_near(zeta);
    }

    /// Stage k of reverse priority: reach what damping leaves of task k, spare what lies below, move least.
    ///
    /// Damping is a matter of the task's velocity, not of the limits: what it leaves, J_k (q̇_{k+1} + J_k^# e_k) up to an
    /// unreachable part, is formed without them and then reached as well as they allow. Were the damped problem itself
    /// solved within the limits, they would change it even where the stage's answer keeps them.
    ///
    /// `qdot_low`: q̇_{k+1}, n, rad/s.
    pub fn become_stage(&mut self, stage: &Stage, qdot_low: &TaskVector) {
        let Stage { J_k, xdot_k, scaled, J_low, own, mu, lambda, .. } = stage;
        self.count = 0;
        let mut xdot = xdot_k.clone();
        if *mu > 0.0 {
            xdot -= &own.damping_loss(&(xdot_k - &(J_k * qdot_low)), *mu);
        }
        self.add().reach(J_k, xdot, *scaled);
        if J_low.nrows() > 0 {
            let spare = self.add();
            spare.reach(J_low, J_low * qdot_low, false);
            spare.damp(*lambda, qdot_low);
        }
        self.add().stay_near(qdot_low);
    }

    /// The strict hierarchy: one level per task, damped before limits count, then stay near ζ̇.
    pub fn become_strict(
        &mut self,
        stages: &[Stage],
        damping: Option<Damping>,
        zeta: &TaskVector,
        descent: &mut Descent,
    ) {
        self.count = 0;
        for (stage, velocity) in stages.iter().zip(descent.damped_velocities(stages, damping)) {
            self.add().reach(&stage.J_k, velocity, stage.scaled);
        }
        self.add().stay_near(zeta);
    }
}
