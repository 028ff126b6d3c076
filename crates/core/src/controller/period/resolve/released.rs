//! What the answer does with tasks that a retreat has released: they asked for nothing, and the answer tells how they move all the same.

use super::super::aim::Contacts;
use crate::arm_state::ArmState;
use crate::controller::config::ControllerConfig;
use crate::linalg::{SingularValues, smallest_and_product, write_product};
use crate::resolution::{Problem, Resolution};
use crate::task::TaskError;
use crate::tolerances::TOLERANCES;

/// Restores the Jacobians of the tasks that a retreat has released, and overwrites their outcomes and the singularity of the answer.
pub(super) fn report(
    (config, arm, contacts): (&ControllerConfig, &ArmState, &Contacts),
    problem: &mut Problem,
    resolution: &mut Resolution,
    singular: &mut SingularValues,
) -> Result<(), TaskError> {
    let Some(retreat) = contacts.retreat() else { return Ok(()) };
    problem.tasks.overwrite_jacobians(|k, jacobian| {
        if k < retreat {
            config.tasks[k].rows.write_jacobian(arm.at_rest(), jacobian);
            config.weigh_jacobian(k, jacobian);
        }
    })?;
    let Resolution { tasks: outcomes, joint_velocity, singularity, .. } = resolution;
    let tasks = problem.tasks.tasks();
    for (outcome, task) in outcomes.iter_mut().zip(tasks).take(retreat) {
        write_product(&task.jacobian, joint_velocity.as_slice(), outcome.achieved.as_mut_slice());
        outcome.residual_norm = outcome.achieved.norm();
        singular.decompose_matrix(&task.jacobian);
        outcome.rank = singular.count_from(TOLERANCES.rank * task.jacobian.norm());
    }
    singularity.set_rows(tasks, smallest_and_product);
    Ok(())
}
