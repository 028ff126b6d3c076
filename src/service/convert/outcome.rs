//! The common parts of all answers with joint velocities.

use revprio_api::wire;
use revprio_core::resolution::Resolution;

use super::terms;

/// Converts a resolution to the parts of an answer.
pub struct Outcome<'a> {
    /// The resolution.
    pub resolution: &'a Resolution,
    /// Names of the joints, in order.
    pub joints: Vec<&'a str>,
}

impl Outcome<'_> {
    /// Joint velocities, n.
    pub fn joint_velocity(&self) -> Vec<f64> {
        self.resolution.joint_velocity.as_slice().to_vec()
    }

    /// Outcomes of the tasks. `describe` returns name, requested velocity and target force of a task.
    pub fn tasks(
        &self,
        describe: impl Fn(usize) -> (String, Vec<f64>, Option<Vec<Option<f64>>>),
    ) -> Vec<wire::TaskOutcome> {
        let outcome = |(k, outcome): (usize, &revprio_core::resolution::TaskOutcome)| {
            let (name, requested, target_force) = describe(k);
            wire::TaskOutcome {
                name,
                requested,
                achieved: outcome.achieved.as_slice().to_vec(),
                residual_norm: outcome.residual_norm,
                rank: outcome.rank,
                algorithmic: outcome.algorithmic,
                scale: outcome.scale,
                target_force,
            }
        };
        self.resolution.tasks.iter().enumerate().map(outcome).collect()
    }

    /// Active joint limits.
    pub fn active_limits(&self) -> Vec<wire::ActiveLimit> {
        let limit = |limit: &revprio_core::resolution::ActiveLimit| wire::ActiveLimit {
            joint: self.joints[limit.joint].to_owned(),
            side: terms::side_answer(limit.side),
            value: limit.value,
            multiplier: limit.multiplier,
        };
        self.resolution.active_limits.iter().map(limit).collect()
    }

    /// Violated joint limits.
    pub fn violated_limits(&self) -> Vec<wire::ViolatedLimit> {
        let violation = |violation: &revprio_core::resolution::LimitViolation| wire::ViolatedLimit {
            joint: self.joints[violation.joint].to_owned(),
            side: terms::side_answer(violation.side),
            limit: violation.limit,
            value: violation.value,
        };
        self.resolution.violated_limits.iter().map(violation).collect()
    }

    /// Active inequalities.
    pub fn active_inequalities(&self) -> Vec<wire::ActiveInequality> {
        let active = |active: &revprio_core::resolution::ActiveInequality| wire::ActiveInequality {
            name: active.name.clone(),
            bound: active.bound,
            multiplier: active.multiplier,
        };
        self.resolution.active_inequalities.iter().map(active).collect()
    }

    /// Violated inequalities.
    pub fn violated_inequalities(&self) -> Vec<wire::ViolatedInequality> {
        let violation = |violation: &revprio_core::resolution::InequalityViolation| wire::ViolatedInequality {
            name: violation.name.clone(),
            bound: violation.bound,
            value: violation.value,
        };
        self.resolution.violated_inequalities.iter().map(violation).collect()
    }

    /// Names of joints.
    pub fn names(&self, joints: &[usize]) -> Vec<String> {
        joints.iter().map(|&joint| self.joints[joint].to_owned()).collect()
    }

    /// Report of the solver.
    pub fn solver(&self) -> wire::SolverReport {
        let report = &self.resolution.solver;
        wire::SolverReport {
            path: terms::path_answer(report.path),
            status: terms::status_answer(report.status),
            iterations: report.iterations,
            failures: report.failures,
            kkt_residual: report.kkt_residual,
        }
    }

    /// Measures of the distance to singularities.
    pub fn singularity(&self) -> wire::Singularity {
        let singularity = &self.resolution.singularity;
        wire::Singularity {
            smallest_singular_value: singularity.smallest_singular_value,
            manipulability: singularity.manipulability,
            algorithmic: singularity.algorithmic,
        }
    }
}

/// Time since `start`, µs.
pub fn elapsed_us(start: std::time::Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e6
}
