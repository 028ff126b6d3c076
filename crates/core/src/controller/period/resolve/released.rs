//! What the answer does with tasks that a retreat has released: they asked for nothing, and the answer tells how they move all the same.

use crate::arm_state::ArmState;
use crate::controller::config::ControllerConfig;
use crate::controller::period::aim::{Requests, write_jacobian};
use crate::linalg::{SingularValues, smallest_and_product, write_product};
use crate::resolution::{Problem, Resolution};
use crate::task::TaskError;
use crate::tolerances::TOLERANCES;

/// Restores the Jacobians of the tasks that a retreat has released, and overwrites their outcomes and the singularity of the answer.
pub(super) fn report(
    (config, arm, Requests { targets, moved, .. }): (&ControllerConfig, &ArmState, Requests),
    problem: &mut Problem,
    resolution: &mut Resolution,
    singular: &mut SingularValues,
) -> Result<(), TaskError> {
    let is_released = |k: usize| targets[k].released_by.is_some();
    if !(0..targets.len()).any(is_released) {
        return Ok(());
    }
    problem.tasks.overwrite_jacobians(|k, jacobian| {
        if is_released(k) {
            write_jacobian(k, &moved[k], (config, arm), jacobian);
        }
    })?;
    let Resolution { tasks: outcomes, joint_velocity, singularity, .. } = resolution;
    let tasks = problem.tasks.tasks();
    for (k, (outcome, task)) in outcomes.iter_mut().zip(tasks).enumerate() {
        if !is_released(k) {
            continue;
        }
        write_product(&task.jacobian, joint_velocity.as_slice(), outcome.achieved.as_mut_slice());
        outcome.residual_norm = outcome.achieved.norm();
        singular.decompose_matrix(&task.jacobian);
        outcome.rank = singular.count_from(TOLERANCES.rank * task.jacobian.norm());
    }
    singularity.set_rows(tasks, smallest_and_product);
    Ok(())
}
